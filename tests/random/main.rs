//! A generator of random scenes with events. Each is judged without a reference ([`judge`]); its seed decides all of it.
//!
//! ```text
//! cargo test --release --test random                                           200 scenes
//! cargo test --release --test random thousand -- --ignored --nocapture         5000 scenes
//! cargo test --release --test random crowds -- --ignored --nocapture           500 heaps and limp robots
//! SEED=17..40 cargo test --release --test random seeds_move_alike -- --ignored   the scenes of these seeds, each in four ways
//! SEED=17 cargo test --release --test random one_seed -- --ignored --nocapture  the scene of seed 17, or 17..40; of crowds with CROWD=1
//! ```

#[path = "../shared/common/mod.rs"]
mod common;

mod alike;
mod crowd;
mod draw;
mod judge;
mod kinds;
mod overlap;
mod scene;
mod shapes;
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
        println!("its files: {}", folder("random", *seed).display());
        println!("again: SEED={seed} cargo test --release --test random one_seed -- --ignored --nocapture");
    }
    assert!(wrong.is_empty(), "{} of {count} scenes are wrong: seeds {:?}", wrong.len(), wrong.keys());
}

#[test]
fn two_hundred_random_scenes_with_events_keep_every_law() {
    assert_right(0..200, kinds::scene);
}

/// Seeds of the five thousand that broke a law once.
const BROKEN_ONCE: [(&str, &[u64]); 5] = [
    ("impulses of 1e12 N s, which roundings of a singular mobility allow", &[2007, 2630]),
    ("impacts, steps and given steps in gimbal lock", &[2117, 3197, 3237, 3457, 5057, 5197, 5517, 5997]),
    (
        "rates of corners that slide beyond a rim, which were taken for rebounds too low to matter",
        &[1421, 1574, 1694, 1781],
    ),
    ("a first step after an event that is too long for a hard motor", &[1690]),
    ("a blow on others while a joint would still bounce, which decides what follows", &[4483]),
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

/// The seeds that `SEED` names, if it is there.
fn seeds_of_environment() -> Option<Range<u64>> {
    let seeds = std::env::var("SEED").ok()?;
    let parsed = |text: &str| text.parse::<u64>().expect("SEED is a number, or a range as 10..20");
    Some(match seeds.split_once("..") {
        Some((from, to)) => parsed(from)..parsed(to),
        None => parsed(&seeds)..parsed(&seeds) + 1,
    })
}
