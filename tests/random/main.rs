//! A generator of random scenes with events. Each is judged without a reference ([`judge`]); its seed decides all of it.
//!
//! ```text
//! cargo test --release --test random                                           200 scenes
//! cargo test --release --test random thousand -- --ignored --nocapture         5000 scenes
//! cargo test --release --test random crowds -- --ignored --nocapture           500 heaps and limp robots
//! cargo test --release --test random slopes -- --ignored --nocapture           derivatives of 1000 scenes
//! SEED=17..40 cargo test --release --test random seeds_move_alike -- --ignored   the scenes of these seeds, each in four ways
//! SEED=17 cargo test --release --test random one_seed -- --ignored --nocapture  the scene of seed 17, or 17..40; of crowds with CROWD=1
//! ```

#[path = "../shared/common/mod.rs"]
mod common;
#[path = "../shared/runge_kutta/mod.rs"]
mod runge_kutta;
#[path = "../shared/tipping/mod.rs"]
mod tipping;
#[path = "../shared/turning/mod.rs"]
mod turning;

mod alike;
mod crowd;
mod draw;
mod judge;
mod kinds;
mod overlap;
mod scene;
mod shapes;
mod slopes;
mod urdf;
mod watch;

use scene::Scene;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// The folder of a seed; tests that run side by side have their own.
fn folder(of: &str, seed: u64) -> PathBuf {
    std::env::temp_dir().join(format!("catena-{of}-{}-{seed}", std::process::id()))
}

/// How many sets of seeds have been judged: scenes and crowds have the same seeds.
static SETS: AtomicU64 = AtomicU64::new(0);

/// Judges all scenes of these seeds on as many threads as there are processors. Files of scenes that are right are removed.
fn judged(seeds: Range<u64>, of: fn(u64) -> Scene) -> BTreeMap<u64, Vec<judge::Fault>> {
    let set = format!("random-{}", SETS.fetch_add(1, Ordering::Relaxed));
    let (next, wrong) = (AtomicU64::new(seeds.start), Mutex::new(BTreeMap::new()));
    let work = || loop {
        let seed = next.fetch_add(1, Ordering::Relaxed);
        if seed >= seeds.end {
            break;
        }
        let (scene, folder) = (of(seed), folder(&set, seed));
        let faults = judge::judge(&scene, &folder);
        if faults.is_empty() {
            let _ = std::fs::remove_dir_all(&folder);
            continue;
        }
        for judge::Fault { verdict, words } in &faults {
            println!("{seed:6} {:<24} {verdict:<12} {words}", scene.kind);
        }
        println!("its files: {}", folder.display());
        wrong.lock().expect("the other threads have not panicked").insert(seed, faults);
    };
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let thread = std::thread::Builder::new().name("scenes".to_string());
            thread.spawn_scoped(scope, work).expect("a thread");
        }
    });
    wrong.into_inner().expect("no thread has panicked")
}

/// Says which seeds are wrong, shows the first scene, and fails if there are any.
fn assert_right(seeds: Range<u64>, of: fn(u64) -> Scene) {
    let count = seeds.end - seeds.start;
    let wrong = judged(seeds, of);
    let mut verdicts: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    for (seed, faults) in &wrong {
        faults.iter().for_each(|fault| verdicts.entry(fault.verdict).or_default().push(*seed));
    }
    for (verdict, seeds) in &verdicts {
        println!("{verdict}: {} ({seeds:?})", seeds.len());
    }
    println!("{} of {count} scenes are wrong", wrong.len());
    if let Some(seed) = wrong.keys().next() {
        println!("{}", of(*seed).listing());
        println!("again: SEED={seed} cargo test --release --test random one_seed -- --ignored --nocapture");
    }
    assert!(wrong.is_empty(), "{} of {count} scenes are wrong: seeds {:?}", wrong.len(), wrong.keys());
}

#[test]
fn two_hundred_random_scenes_with_events_keep_every_law() {
    assert_right(0..200, kinds::scene);
}

/// Seeds of the five thousand that broke a law once.
const BROKEN_ONCE: [(&str, &[u64]); 14] = [
    ("impulses of 1e12 N s, which roundings of a singular mobility allow", &[2007, 2630]),
    ("impacts, steps and given steps in gimbal lock", &[2117, 3197, 3237, 3457, 5057, 5197, 5517, 5997]),
    (
        "rates of corners that slide beyond a rim, which were taken for rebounds too low to matter",
        &[1421, 1574, 1694, 1781],
    ),
    ("a first step after an event that is too long for a hard motor", &[1690]),
    ("a blow on others while a joint would still bounce, which decides what follows", &[4483]),
    (
        "limits that part by less than a rounding, and are met once more at the end of the next step, without end",
        &[343],
    ),
    ("a hardly stretched spring of a motor, whose error of energy was more than what it had stored allows", &[10602]),
    ("a joint that crosses the room between its limits within one short span between given instants", &[5215]),
    (
        "motors that are sampled and chatter, where a run and the motion beside it made the same errors",
        &[279, 2810, 7379],
    ),
    (
        "a short step in a jam, made again to end at a stop, that came out on another solution and gained energy",
        &[4673],
    ),
    ("steps near a gimbal lock, made again to end at limits, that were off by roundings of the rates", &[3357, 7097]),
    (
        "an impact in the first step after a corner of a target, with a part of what a hard damper was about to stop",
        &[15670],
    ),
    ("starts that are wedged, where no small motion moves shapes apart", &[8070, 8370]),
    ("given steps of light bodies that rebound at 150 rad/s, which were not said to be too long", &[22054, 22274]),
];

#[test]
fn scenes_that_broke_a_law_once_keep_it() {
    for (what, seeds) in BROKEN_ONCE {
        for seed in seeds {
            let faults = judged(*seed..seed + 1, kinds::scene);
            assert!(faults.is_empty(), "{what}: seed {seed}: {faults:?}");
        }
    }
}

/// A slide of a joint that ended where its step began, at 3 rad/s: its rate was set to zero alone, which gave 5 J of 27 J.
#[test]
fn a_limp_robot_whose_joints_stop_in_a_jam_gains_no_energy() {
    assert_right(257..258, kinds::crowd);
}

#[test]
fn twelve_random_scenes_move_alike_turned_scaled_and_in_another_order() {
    for seed in 0..12 {
        assert_eq!(alike::differs(seed, 1e-6), None, "seed {seed}");
    }
}

/// Two or three in a hundred are known to differ: boxes whose corners clatter, or that tip over an edge, with a tie in the order of their blows.
#[test]
#[ignore = "SEED=17..40 cargo test --release --test random seeds_move_alike -- --ignored --nocapture"]
fn seeds_move_alike() {
    let Some(seeds) = seeds_of_environment() else { return };
    let differs = |seed: u64| [1e-4, 1e-6].map(|tolerance| Some((seed, tolerance, alike::differs(seed, tolerance)?)));
    let wrong: Vec<(u64, f64, String)> = seeds.flat_map(differs).flatten().collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "some ten minutes: cargo test --release --test random thousand -- --ignored --nocapture"]
fn five_thousand_random_scenes_with_events_keep_every_law() {
    assert_right(1000..6000, kinds::scene);
}

#[test]
#[ignore = "some minutes: cargo test --release --test random crowds -- --ignored --nocapture"]
fn five_hundred_crowds_keep_every_law() {
    assert_right(0..500, kinds::crowd);
}

#[test]
#[ignore = "SEED=17 cargo test --release --test random one_seed -- --ignored --nocapture"]
fn one_seed() {
    let Some(seeds) = seeds_of_environment() else { return };
    let of = if std::env::var_os("CROWD").is_some() { kinds::crowd } else { kinds::scene };
    if seeds.end == seeds.start + 1 {
        println!("{}", of(seeds.start).listing());
    }
    assert_right(seeds, of);
}

/// Compares the derivatives of the scenes of these seeds with differences of runs, and counts what was found.
fn compared(seeds: Range<u64>) -> BTreeMap<slopes::Verdict, usize> {
    let (next, all) = (AtomicU64::new(seeds.start), Mutex::new(Vec::new()));
    let work = || loop {
        let seed = next.fetch_add(1, Ordering::Relaxed);
        if seed >= seeds.end {
            break;
        }
        let (scene, folder) = (kinds::scene(seed), folder("slopes", seed));
        let all_found = std::panic::catch_unwind(|| slopes::compare(&scene, seed, &folder));
        let panicked = |_| vec![slopes::Found { verdict: slopes::Verdict::Wrong, words: "a panic".to_string() }];
        for found in all_found.unwrap_or_else(panicked) {
            if std::env::var_os("SEED").is_some() || found.verdict > slopes::Verdict::Refused {
                println!("{seed:6} {:<24} {:?}: {}", scene.kind, found.verdict, found.words);
            }
            all.lock().expect("the other threads have not panicked").push((scene.kind, found));
        }
        let _ = std::fs::remove_dir_all(&folder);
    };
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    let (mut counts, mut reasons) = (BTreeMap::new(), BTreeMap::new());
    for (kind, found) in all.into_inner().expect("no thread has panicked") {
        *counts.entry(found.verdict).or_insert(0) += 1;
        let (count, kinds) = reasons
            .entry((
                found.verdict,
                if found.verdict < slopes::Verdict::Rough { slopes::reason(&found.words) } else { String::new() },
            ))
            .or_insert_with(|| (0, std::collections::BTreeSet::new()));
        *count += 1;
        kinds.insert(kind);
    }
    for ((verdict, reason), (count, kinds)) in reasons {
        println!("{count:5} {verdict:?}: {reason} {kinds:?}");
    }
    println!("{counts:?}");
    counts
}

#[test]
fn twenty_random_scenes_have_the_derivatives_of_their_runs() {
    let counts = compared(0..20);
    assert!(!counts.contains_key(&slopes::Verdict::Wrong), "{counts:?}");
    // Of three numbers in each; heaps and clatter are refused, and starts in touch have none.
    assert!(counts.get(&slopes::Verdict::Agrees).is_some_and(|count| *count > 40), "{counts:?}");
}

/// Seeds whose derivatives were wrong once.
const WRONG_ONCE: [(&str, &[u64]); 7] = [
    ("starts that other shapes pushed back while a number varied by the width of differences", &[72, 212]),
    ("the same by limits, on closed loops", &[95, 159]),
    ("instants of targets at which steps end, which move with their times", &[195, 275, 355]),
    ("a mechanism without a freedom that moves, which was a panic", &[235]),
    ("a start on a limit, which has a derivative on one side alone", &[375]),
    ("events that follow each other within a nanosecond", &[167]),
    ("a contact that begins to slide from rest, and turns its direction with a number", &[350]),
];

#[test]
fn random_scenes_whose_derivatives_were_wrong_once_have_those_of_their_runs() {
    for (what, seeds) in WRONG_ONCE {
        for seed in seeds {
            let counts = compared(*seed..seed + 1);
            assert!(!counts.contains_key(&slopes::Verdict::Wrong), "{what}: seed {seed}: {counts:?}");
        }
    }
}

/// Scenes in which a low impact kicks open what rests, and the run keeps that at rest: joints on limits, and boxes in a stack.
const KICKED: [u64; 5] = [44, 138, 143, 163, 263];

#[test]
fn impacts_that_kick_open_what_a_run_keeps_at_rest_have_the_derivatives_of_their_runs() {
    for seed in KICKED {
        let counts = compared(seed..seed + 1);
        assert!(counts.contains_key(&slopes::Verdict::Agrees), "seed {seed}: {counts:?}");
        let is_told = |verdict: &slopes::Verdict| matches!(verdict, slopes::Verdict::Agrees | slopes::Verdict::Near);
        assert!(counts.keys().all(is_told), "seed {seed}: {counts:?}");
    }
}

/// Derivatives that are known to be wrong in a thousand scenes without a word, of two scenes: one passes a gimbal lock (seed 337), and in one a sampled
/// motor chatters, which makes roundings as large as 1e-3 (seed 985).
const KNOWN_WRONG: usize = 2;

#[test]
#[ignore = "some ten minutes: cargo test --release --test random slopes -- --ignored --nocapture"]
fn slopes_of_a_thousand_random_scenes() {
    let counts = compared(seeds_of_environment().unwrap_or(0..1000));
    assert!(counts.get(&slopes::Verdict::Wrong).is_none_or(|count| *count <= KNOWN_WRONG), "{counts:?}");
}

/// The seeds that `SEED` names, if it is there.
fn seeds_of_environment() -> Option<Range<u64>> {
    let seeds = std::env::var("SEED").ok()?;
    let parsed = |text: &str| text.parse::<u64>().expect("SEED is a number, or a range as 10..20");
    Some(match seeds.split_once("..") {
        Some((from, to)) => parsed(from)..parsed(to),
        None => parsed(&seeds)..parsed(&seeds) + 1,
    })
}
