//! Claims about `catena stress`: what survives, that every failure says when and why, and the files it writes.
//!
//! A reduced map, a few cells of each problem; `catena stress` draws the whole.

use crate::common::{command, scratch};
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use catena::study::chart::{Method as ChartMethod, Setting};
use catena::study::stress::cell::Cell;
use catena::study::stress::problem::{Truth, steps};
use catena::study::stress::table::write_csv;
use catena::study::stress::{Answer, Case, Ended, Map, Method, Problem, Verdict, report};
use std::collections::HashSet;
use std::path::Path;
use std::process::Output;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

/// Problem, and places of the difficulties in the reduced map.
const REDUCED: [(&str, &[usize]); 16] = [
    ("mass_ratio", &[0, 4]),
    ("chain_length", &[0, 2]),
    ("spin_rate", &[0, 4]),
    ("stiff_spring", &[0, 2]),
    ("stiff_damper", &[0, 3]),
    ("singular_positions", &[0, 1]),
    ("over_constraint", &[0, 1]),
    ("inertia", &[0, 4, 7]),
    ("gimbal_lock", &[0, 2]),
    ("inconsistent_start", &[3, 6]),
    ("joint_limits", &[0, 2]),
    ("dry_friction", &[1, 5]),
    ("motor_gain", &[1, 3]),
    ("impact_speed", &[0, 2, 5]),
    ("friction_cone", &[0, 3, 6]),
    ("contact_masses", &[0, 2]),
];

fn problem(name: &str) -> Problem {
    Problem::all().into_iter().find(|problem| problem.name == name).unwrap()
}

fn run(name: &str, places: &[usize], threads: usize) -> Map {
    let mut thinned = problem(name).thinned(1, 4);
    thinned.places = places.to_vec();
    // Forty columns are for pictures.
    thinned.problem.steps.truncate(3);
    Map::run(thinned, threads, &AtomicBool::new(false), &|_| ()).unwrap()
}

/// The reduced map, computed once.
fn reduced() -> &'static [Map] {
    static MAPS: OnceLock<Vec<Map>> = OnceLock::new();
    MAPS.get_or_init(|| REDUCED.map(|(name, places)| run(name, places, 2)).into())
}

fn words(map: &Map, cell: &Cell) -> String {
    let problem = &map.thinned.problem;
    format!("{} {}, {} {}: {cell:?}", problem.name, problem.difficulties[cell.place], cell.method.id(), cell.setting)
}

/// The number of a method's runs that came to an end that is of use, and of all its runs, in a row.
fn survivors(map: &Map, method: Method, place: usize) -> (usize, usize) {
    let cells: Vec<&Cell> = map.cells.iter().filter(|cell| cell.method == method && cell.place == place).collect();
    (cells.iter().filter(|cell| cell.verdict.survived()).count(), cells.len())
}

#[test]
fn no_run_of_ours_ends_in_numbers_that_mean_nothing_without_a_word() {
    for map in reduced() {
        let defects: Vec<String> = map.defects().map(|cell| words(map, cell)).collect();
        assert!(defects.is_empty(), "{defects:#?}");
        for cell in map.cells.iter().filter(|cell| cell.method.is_ours() && cell.ended == Ended::Survived) {
            let refused = map
                .answers
                .iter()
                .zip(&map.thinned.places)
                .any(|(answer, &place)| place == cell.place && answer.refusal.is_some());
            assert!(!refused, "invented an end: {}", words(map, cell));
            assert!(cell.energy_error.is_finite(), "{}", words(map, cell));
        }
    }
}

#[test]
fn every_failure_has_a_name_a_time_and_a_message() {
    for map in reduced() {
        for cell in &map.cells {
            let Ended::Failed(failure) = &cell.ended else { continue };
            assert!(failure.time.is_finite() && failure.name != "Panic", "{}", words(map, cell));
            // No joint, body or closure without a name.
            assert!(!failure.message.contains("\"\""), "{}", words(map, cell));
        }
    }
}

#[test]
fn the_tolerance_mode_survives_whatever_any_method_survives() {
    let tolerance = Method::Chart(ChartMethod::LobattoTolerance);
    for map in reduced() {
        for (row, &place) in map.thinned.places.iter().enumerate() {
            let anybody = map.methods.into_iter().any(|method| survivors(map, method, place).0 > 0);
            let ours = survivors(map, tolerance, place);
            assert!(
                !anybody || ours.0 > 0,
                "{} {}: {}",
                map.thinned.problem.name,
                map.thinned.problem.difficulties[place],
                map.answers[row].source
            );
        }
    }
}

#[test]
fn loops_that_cannot_be_closed_are_refused_by_us_at_every_setting() {
    let map = reduced().iter().find(|map| map.thinned.problem.name == "inconsistent_start").unwrap();
    for cell in map.cells.iter().filter(|cell| cell.method.is_ours() && cell.place == 6) {
        assert!(matches!(&cell.ended, Ended::Failed(failure) if failure.name == "Open"), "{}", words(map, cell));
    }
}

#[test]
fn the_right_answers_are_those_of_a_formulation_that_shares_no_code() {
    let tightest = Setting::Tolerance(1e-10);
    for (name, place) in [
        ("mass_ratio", 0),
        ("chain_length", 2),
        ("spin_rate", 4),
        ("stiff_spring", 2),
        ("inertia", 7),
        ("motor_gain", 1),
    ] {
        let map = reduced().iter().find(|map| map.thinned.problem.name == name).unwrap();
        let rival = Method::Chart(ChartMethod::Dop853);
        let cell = map
            .cells
            .iter()
            .find(|cell| cell.method == rival && cell.place == place && cell.setting == tightest)
            .unwrap();
        // A tolerance of 1e-10 is amplified by these motions a hundredfold at most.
        assert!(cell.end_error < 1e-7, "{}", words(map, cell));
    }
}

#[test]
fn springs_as_limits_and_smooth_friction_tend_to_what_events_give() {
    // What a regularisation leaves is proportional to the tolerance, of which depth and creep are made.
    for (name, place, ends) in [("joint_limits", 0, [1e-4, 1e-6, 1e-8]), ("dry_friction", 5, [1e-2, 1e-3, 1e-4])] {
        let case = (problem(name).build)(place).unwrap();
        let interrupt = AtomicBool::new(false);
        let answer = Answer::of(&case, &interrupt).unwrap();
        let rival = Method::Chart(ChartMethod::Dop853Regularised);
        let error = |tolerance: f64| {
            let cell = Cell::run(&case, &answer, rival, Setting::Tolerance(tolerance), place, &interrupt).unwrap();
            assert_eq!(cell.ended, Ended::Survived, "{name}");
            cell.end_error / tolerance
        };
        let [coarse, middle, fine] = ends.map(error);
        let near = |ratio: f64| (0.3..3.0).contains(&ratio);
        assert!(near(coarse / middle) && near(middle / fine), "{name}: {coarse:e} {middle:e} {fine:e}");
    }
}

#[test]
fn a_method_that_needs_independent_equations_fails_where_they_are_not_and_ours_does_not() {
    let map = reduced().iter().find(|map| map.thinned.problem.name == "over_constraint").unwrap();
    for &place in &map.thinned.places {
        assert_eq!(survivors(map, Method::Baumgarte, place).0, 0);
        assert_eq!(survivors(map, Method::Chart(ChartMethod::LobattoTolerance), place), (6, 6));
    }
}

#[test]
fn a_picture_has_a_panel_for_each_method_that_can_run_any_of_it_and_names_the_others_below() {
    let folder = scratch("panels");
    report::write(reduced(), "a processor", &folder).unwrap();
    let mut left_out = 0;
    for map in reduced() {
        let svg = std::fs::read_to_string(folder.join(format!("{}.svg", map.thinned.problem.name))).unwrap();
        for method in map.methods {
            let is_able = map.cells.iter().any(|cell| cell.method == method && cell.verdict != Verdict::NotApplicable);
            left_out += usize::from(!is_able);
            // Every text of the picture is a line of the file.
            let label = method.label();
            let name = &map.thinned.problem.name;
            assert_eq!(svg.lines().any(|line| line == label), is_able, "{name}: {label}");
            assert!(svg.contains(&label), "{name}: {label}");
        }
    }
    // None of four knows contacts, of which there are three problems.
    assert!(left_out >= 12, "{left_out}");
}

#[test]
fn the_textbook_method_is_right_where_the_textbook_says_so() {
    // A tree, moderate motion: a fourth-order method at 1e-3 s, whose constraints drift little in 2 s.
    let case = (problem("mass_ratio").build)(0).unwrap();
    let interrupt = AtomicBool::new(false);
    let answer = Answer::of(&case, &interrupt).unwrap();
    let error = |step: f64| {
        let cell = Cell::run(&case, &answer, Method::Baumgarte, Setting::Step(step), 0, &interrupt).unwrap();
        assert_eq!(cell.ended, Ended::Survived);
        cell.end_error
    };
    let (coarse, fine) = (error(0.01), error(0.005));
    // 16 for order four, but for the next order's share.
    assert!(fine < 1e-4 && (8.0..32.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

#[test]
fn maps_do_not_depend_on_the_number_of_threads() {
    let told = |threads| {
        let map = run("inertia", &[0, 4], threads);
        let mut maps = vec![map];
        maps[0].cells.iter_mut().for_each(|cell| cell.cpu_seconds = 0.0);
        write_csv(&maps)
    };
    assert_eq!(told(1), told(3));
}

#[test]
fn every_cell_is_counted_under_one_verdict() {
    for map in reduced() {
        let counted: usize =
            map.methods.into_iter().flat_map(|method| Verdict::ALL.map(|verdict| map.count(method, verdict))).sum();
        assert_eq!(counted, map.cells.len(), "{}", map.thinned.problem.name);
    }
}

#[test]
fn an_interrupted_map_is_none() {
    let thinned = problem("long_time").thinned(1, 1);
    assert!(Map::run(thinned, 2, &AtomicBool::new(true), &|_| ()).is_err());
}

#[test]
fn every_case_can_be_built_and_its_loops_say_whether_they_close() {
    for problem in Problem::all() {
        for (place, label) in problem.difficulties.iter().enumerate() {
            let Case { mechanism, start, duration, watched, .. } = (problem.build)(place).unwrap();
            assert_eq!(start.velocity.len(), mechanism.velocity_count, "{} {label}", problem.name);
            assert!(duration > 0.0 && (1..=mechanism.bodies.len()).contains(&watched));
        }
        let names: HashSet<&str> = problem.difficulties.iter().copied().collect();
        assert_eq!(names.len(), problem.difficulties.len(), "{}", problem.name);
    }
}

#[test]
fn steps_of_a_map_are_evenly_spaced_on_a_logarithmic_scale() {
    let steps = steps(0.1, 0.01, 40);
    assert!((steps[0] - 0.1).abs() < 1e-15 && (steps[39] - 0.01).abs() < 1e-15 && steps.is_sorted_by(|a, b| a > b));
    assert!(steps.windows(2).all(|pair| (pair[0] / pair[1] - 10_f64.powf(1.0 / 39.0)).abs() < 1e-14));
}

fn catena(folder: &Path, arguments: &[&str]) -> Output {
    command::run(folder, &[&["stress"], arguments].concat())
}

#[test]
fn pictures_numbers_and_the_page_are_written_whole() {
    let folder = scratch("files");
    report::write(&reduced()[..2], "a processor", &folder).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let csv = read("cells.csv");
    let cells: usize = reduced()[..2].iter().map(|map| map.cells.len()).sum();
    assert_eq!(csv.lines().count(), cells + 1);
    assert!(!csv.contains("NaN") && !csv.contains("inf,"));
    let page = read("index.html");
    assert_eq!(page.matches("<svg").count(), 2);
    assert!(!page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org").count());
    for name in ["mass_ratio", "chain_length"] {
        assert!(read(&format!("{name}.svg")).contains("catena, tolerance"));
        assert!(std::fs::metadata(folder.join(format!("{name}.png"))).unwrap().len() > 10_000);
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 6);
}

#[test]
fn wrong_usage_is_one_line_and_touches_nothing() {
    let folder = scratch("usage");
    std::fs::write(folder.join("file"), "").unwrap();
    for (arguments, said) in [
        (vec!["-o", "out", "--only", "mass"], "there is no problem \"mass\"; there are mass_ratio, chain_length"),
        (vec!["-o", "file"], "it is not a folder"),
        (vec![], "--output <DIR>"),
    ] {
        let output = catena(&folder, &arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(said) && error.lines().count() == 1, "{error}");
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn the_help_names_every_problem() {
    let help = String::from_utf8(catena(&scratch("help"), &["--help"]).stdout).unwrap();
    let words: HashSet<&str> = help.split(|letter: char| letter != '_' && !letter.is_ascii_lowercase()).collect();
    let missing: Vec<&str> =
        Problem::all().iter().map(|problem| problem.name).filter(|name| !words.contains(name)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn one_problem_can_be_mapped_alone() {
    let folder = scratch("only");
    let output = catena(&folder, &["-o", "out", "--only", "gimbal_lock", "--quick"]);
    assert!(output.status.success(), "{output:?}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.lines().filter(|line| line.starts_with("gimbal_lock")).count() == Method::ALL.len(), "{told}");
    assert!(Verdict::ALL.iter().all(|verdict| told.contains(verdict.word())));
    assert!(folder.join("out/gimbal_lock.png").is_file() && folder.join("out/index.html").is_file());
}

/// A run of a difficulty of the gimbals to its end, or where it fails; how far from the motion on a ball joint it ends.
fn gimbals(label: &str, tolerance: f64, faster: f64) -> Result<f64, String> {
    let problem = Problem::all().into_iter().find(|problem| problem.name == "gimbal_lock").unwrap();
    let place = problem.difficulties.iter().position(|&difficulty| difficulty == label).unwrap();
    let case = (problem.build)(place).unwrap();
    let top = |mechanism: &Mechanism, state: &State| *body_states(mechanism, state).last().unwrap();
    let run = |mechanism: &Mechanism, mut state: State, tolerance: f64| {
        let mut lobatto = Lobatto::adaptive(mechanism, tolerance);
        while state.time < case.duration {
            lobatto
                .advance(mechanism, &mut state, case.duration)
                .map_err(|error| format!("{label}, {tolerance:e}, {faster} faster: {error}"))?;
        }
        Ok::<BodyState, String>(top(mechanism, &state))
    };
    let mut start = case.start.clone();
    start.velocity.iter_mut().for_each(|rate| *rate *= 1.0 + faster);
    let Truth::Same(on_ball) = &case.truth else { panic!("the same motion on a ball joint") };
    let (ball, mut free) = (&on_ball.0, on_ball.1.clone());
    let begins = top(&case.mechanism, &start);
    free.velocity.copy_from_slice((begins.rotation.transpose() * begins.angular_velocity).as_slice());
    let ended = run(&case.mechanism, start, tolerance)?;
    let right = run(ball, free, 1e-11)?;
    Ok((ended.position - right.position).norm().max((ended.rotation - right.rotation).norm()))
}

#[test]
fn a_tight_tolerance_passes_gimbals_near_lock_where_rates_are_ten_thousand_times_those_of_the_body() {
    // Roundings there change the energy by more than the tolerance allows a step, however short; and a lock that doubles cannot resolve is
    // passed in one step.
    for (label, tolerance) in [
        ("10⁻²", 1e-10),
        ("10⁻³", 1e-6),
        ("10⁻³", 1e-10),
        ("10⁻⁴", 1e-6),
        ("10⁻⁴", 1e-10),
        ("10⁻⁶", 1e-6),
        ("10⁻⁶", 1e-10),
    ] {
        for faster in 0..10 {
            let off = gimbals(label, tolerance, 1e-3 * faster as f64).unwrap();
            // What rounding leaves where two axes are 2e-8 rad apart: of 1200 such runs the worst was off by 1.6e-6.
            assert!(off < 5e-6, "{label}, {tolerance:e}, {faster}: off by {off:.1e}");
        }
    }
}

#[test]
fn a_lock_that_joint_coordinates_cannot_resolve_is_passed_in_one_step_where_the_energy_allows_it() {
    // E grows as steps become shorter there, and steps that follow it come so near that the rates are rounding.
    for faster in 0..20 {
        let off = gimbals("10⁻⁴", 1e-3, 1e-3 * faster as f64).unwrap();
        // Of sixty the worst was off by 3e-9.
        assert!(off < 1e-7, "{faster}: off by {off:.1e}");
    }
}
