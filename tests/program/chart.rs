//! Claims about `catena chart`: the arithmetic of the ratios, the references, the files it writes.

use crate::common::command::run;
use crate::common::scratch;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::distance;
use catena::mechanism::motion::state::State;
use catena::model::{Model, ModelOptions};
use catena::scene::{PackagePath, read_scene, read_urdf};
use catena::study::chart::measure::Plan;
use catena::study::chart::ratio::{Comparison, Front, Reach};
use catena::study::chart::reference::reference;
use catena::study::chart::report::Report;
use catena::study::chart::table::parse_csv;
use catena::study::chart::{Ended, Measurement, Method, Scene, SceneChart, Setting, measure, read_csv, write_csv};
use catena::study::stress::Problem;
use nalgebra::{Translation3, Vector3};
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::AtomicBool;

fn measurement(method: Method, error: f64, cost: f64) -> Measurement {
    Measurement {
        scene: "scene".to_string(),
        method: method.id(),
        setting: Setting::Step(0.5).to_string(),
        error,
        cpu_seconds_per_simulated_second: cost,
        steps: Some(2),
        iterations: Some(24),
        rejected_steps: Some(0),
        energy_error: 1e-9,
        ended: Ended::Done,
    }
}

/// A rod of 1 m and 1 kg on a horizontal hinge, released from the horizontal.
fn pendulum(duration: f64) -> Scene {
    let hinge = Joint::new("hinge", JointKind::Revolute, Pose::identity(), Translation3::new(-0.5, 0.0, 0.0).into());
    let inertia = Vector3::new(0.0, 1.0 / 12.0, 1.0 / 12.0);
    let rod = Body { name: "rod".into(), parent: None, mass: 1.0, inertia, joint: hinge };
    let mechanism = Mechanism::new("pendulum", Vector3::new(0.0, -9.81, 0.0), vec![rod]).unwrap();
    Scene { name: "pendulum".into(), start: State::zero(&mechanism), mechanism, duration }
}

fn robot(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name)
}

fn catena(folder: &Path, arguments: &[&str]) -> Output {
    run(folder, &[&["chart"], arguments].concat())
}

#[test]
fn costs_between_two_runs_are_interpolated_on_logarithmic_axes() {
    // Two decades of error for one of cost: half way down the error, √10 up the cost.
    let front = Front::new([(1e-2, 1.0), (1e-4, 10.0), (1e-8, 100.0)]);
    let cost = |level: f64| match front.at(level) {
        Reach::Cost(cost) => cost,
        other => panic!("{other:?}"),
    };
    assert!((cost(1e-3) - 10_f64.sqrt()).abs() < 1e-12);
    assert!((cost(1e-4) - 10.0).abs() < 1e-12);
    assert!((cost(1e-7) - 10.0 * 10_f64.powf(0.75)).abs() < 1e-10);
    // Nothing is extrapolated: coarser costs what the cheapest run costs, finer is not reached.
    assert_eq!(front.at(1.0), Reach::Cost(1.0));
    assert_eq!(front.at(1e-9), Reach::Floor(1e-8));
    assert_eq!(Front::new([]).at(1e-3), Reach::Nothing);
}

#[test]
fn runs_that_another_run_beats_do_not_count() {
    // The second costs more for less; the last is at its rounding floor.
    let front = Front::new([(1e-2, 1.0), (1e-1, 3.0), (1e-4, 10.0), (2e-4, 1000.0)]);
    assert_eq!(front, Front::new([(1e-2, 1.0), (1e-4, 10.0)]));
}

#[test]
fn the_ratio_is_the_best_rival_over_our_best() {
    let runs = [
        measurement(Method::Lobatto(9), 1e-2, 1.0),
        measurement(Method::Lobatto(9), 1e-10, 3.0),
        measurement(Method::LobattoTolerance, 1e-5, 2.0),
        measurement(Method::LobattoUnestimated, 1e-7, 2.5),
        measurement(Method::Rk4, 1e-3, 4.0),
        measurement(Method::Rk4, 1e-6, 400.0),
        measurement(Method::Dop853, 1e-3, 5.0),
        measurement(Method::Dop853, 1e-7, 20.0),
        // Not among the rivals, however cheap.
        measurement(Method::Euler, 1e-12, 1e-3),
    ];
    let at = |level: f64| Comparison::at(&runs, level);
    let ours = 3_f64.powf(1.0 / 8.0);
    assert!((at(1e-3).ratio().unwrap() - 4.0 / ours).abs() < 1e-12);
    // Two runs of rivals: RK4 at 1e-3 m, and DOP853 at 1e-4 m on its way from 1e-3 to 1e-7.
    assert!((at(1e-3).tolerance_ratio().unwrap() - (4.0 + 5.0 * 4_f64.powf(0.25)) / 2.0).abs() < 1e-12);
    // One run of the best rival against one of ours without an estimate.
    assert!((at(1e-6).unestimated_ratio().unwrap() - 5.0 * 4_f64.powf(0.75) / 2.5).abs() < 1e-12);
    assert_eq!(at(1e-6).rival.unwrap().method, Method::Dop853);
    assert!((at(1e-6).ratio().unwrap() - 5.0 * 4_f64.powf(0.75) / 3_f64.powf(0.5)).abs() < 1e-12);
    assert_eq!(at(1e-6).tolerance_ratio(), None);
    assert_eq!(at(1e-9).ratio(), None);
    assert_eq!(at(1e-9).rival.unwrap().reach, Reach::Floor(1e-7));
}

#[test]
fn runs_that_failed_have_no_place_in_the_ratio() {
    let failed = Measurement { ended: Ended::Failed("NaN".into()), ..measurement(Method::Rk4, 1e-9, 1e-9) };
    assert_eq!(Comparison::at(&[failed], 1e-3).rival, None);
}

#[test]
fn both_references_agree_on_a_pendulum() {
    let scene = pendulum(2.0);
    let reference = reference(&scene, &AtomicBool::new(false), &mut |_| {}).unwrap();
    assert_eq!(reference.runs.len(), 6);
    assert!(reference.agreement.unwrap() < 1e-10, "{reference:?}");
    assert!(reference.scatter < 1e-12 && reference.scatter <= reference.vouched());
}

#[test]
fn the_reference_is_as_near_to_independent_answers_as_it_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/reference");
    // Double pendulum and arm, both with fixed bases; answers in long doubles by other codes.
    for name in ["pendulum3d_double_T3", "arm7_T1"] {
        let Ok(text) = std::fs::read_to_string(folder.join(format!("answers/{name}.json"))) else {
            eprintln!("skipped: no answers in {}", folder.display());
            return;
        };
        let answer: serde_json::Value = serde_json::from_str(&text).unwrap();
        let urdf = folder.join(format!("scenes/{name}.urdf"));
        let robot = read_urdf(&urdf, &PackagePath::from_environment(Vec::new())).unwrap();
        let model = Model::new(robot, &ModelOptions::default()).unwrap();
        let initial = answer["initial"].as_object().unwrap();
        let positions: Vec<(String, Vec<f64>)> =
            initial.iter().map(|(joint, one)| (joint.clone(), vec![one["position"].as_f64().unwrap()])).collect();
        let start = model.initial_state(&positions, &[], None).unwrap();
        let duration = answer["duration"].as_f64().unwrap();
        let scene = Scene { name: name.into(), mechanism: model.mechanism, start, duration };
        let reference = reference(&scene, &AtomicBool::new(false), &mut |_| {}).unwrap();
        let centres = answer["com"].as_array().unwrap().last().unwrap().as_array().unwrap();
        for (body, centre) in centres.iter().enumerate() {
            let expected = Vector3::from_fn(|axis, _| centre[axis].as_f64().unwrap());
            let off = (reference.probes[distance::PROBES * body] - expected).norm();
            assert!(off < 3.0 * reference.vouched(), "{name}, body {body}: {off:e} m off; {:?}", reference.runs);
        }
    }
}

#[test]
fn an_interrupted_reference_is_an_error_and_nothing_else() {
    let ended = measure(&pendulum(1.0), &Plan { quick: true, budget: 1.0 }, &AtomicBool::new(true), &mut |_, _| {});
    assert!(ended.is_err_and(|error| error.to_string().contains("interrupted")));
}

#[test]
fn the_distance_sees_a_rotation_about_the_centre_of_mass() {
    let mechanism = pendulum(1.0).mechanism;
    let mut turned = State::zero(&mechanism);
    turned.position[0] = 1e-6;
    let probes = |state: &State| distance::probes(&mechanism, state);
    // The centre of mass is 0.5 m from the hinge, the outer probe ρ = √(1/12) m further.
    let outer = 0.5 + (1.0_f64 / 12.0).sqrt();
    let seen = distance::distance(&probes(&State::zero(&mechanism)), &probes(&turned));
    assert!((seen - 1e-6 * outer).abs() < 1e-12, "{seen:e}");
}

#[test]
fn measurements_survive_the_way_through_a_csv_file() {
    let runs = vec![
        measurement(Method::Lobatto(9), 1.234_567_890_123_456_7e-13, 4.56e-6),
        Measurement { scene: "a, \"b\"\nc".into(), ..measurement(Method::Rk4, 0.1 + 0.2, 1.0 / 3.0) },
        Measurement { ended: Ended::Cut { time: 0.125 }, ..measurement(Method::Euler, 1.0, 1.0) },
        Measurement {
            ended: Ended::Failed("at t = 1 s, it blew up".into()),
            steps: None,
            ..measurement(Method::Dop853, 1.0, 1.0)
        },
    ];
    let file = scratch("round-trip").join("measurements.csv");
    std::fs::write(&file, write_csv(&runs)).unwrap();
    assert_eq!(read_csv(&file).unwrap(), runs);
}

#[test]
fn foreign_columns_may_come_in_any_order_and_wrong_ones_are_named() {
    let text = "\u{feff}error,cpu_seconds_per_simulated_second,note,scene,method\r\n1e-3,2e-5,x,dp,MuJoCo\r\n";
    let runs = parse_csv(text).unwrap();
    assert_eq!((runs[0].method.as_str(), runs[0].point()), ("MuJoCo", Some((1e-3, 2e-5))));
    let commented = text.replace("error,", "# mine\r\nerror,").replace("1e-3", "#1\r\n1e-3");
    assert_eq!(parse_csv(&commented).unwrap().len(), 1);
    let problem = |text: &str| parse_csv(text).unwrap_err();
    assert!(problem("scene,method,error\n").1.contains("cpu_seconds_per_simulated_second"));
    assert_eq!(problem("scene,method,error,cpu_seconds_per_simulated_second\na,b,c,1\n").0, 2);
    assert!(problem("scene,method,error,cpu_seconds_per_simulated_second\na,b,1\n").1.contains("3 fields"));
    assert!(problem("").1.contains("empty"));
}

/// Orders between neighbouring rungs of a method, where the error is neither coarse nor rounding.
fn orders(runs: &[Measurement], method: Method, range: std::ops::Range<f64>) -> Vec<f64> {
    let step = |run: &Measurement| run.setting.strip_prefix("step=").unwrap().parse::<f64>().unwrap();
    let inside: Vec<&Measurement> =
        runs.iter().filter(|run| run.method == method.id() && range.contains(&run.error)).collect();
    inside.windows(2).map(|pair| (pair[0].error / pair[1].error).ln() / (step(pair[0]) / step(pair[1])).ln()).collect()
}

#[test]
fn the_command_writes_pictures_numbers_and_a_page_and_the_numbers_show_the_orders() {
    let folder = scratch("command");
    let (input, output) = (robot("pendulum.urdf"), folder.join("chart"));
    // Another program's file, with a second scene that is not drawn.
    let foreign = folder.join("foreign.csv");
    let lines = "scene,method,error,cpu_seconds_per_simulated_second\npendulum,Peer <1>,1e-4,1e-4\nother,x,1,1\n";
    std::fs::write(&foreign, lines).unwrap();
    let arguments = [input.to_str().unwrap(), "-o", output.to_str().unwrap(), "--csv", foreign.to_str().unwrap()];
    let ended = catena(&folder, &[&arguments[..], &["--quick", "--duration", "2"]].concat());
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let mut files: Vec<String> =
        std::fs::read_dir(&output).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    let pictures = ["pendulum.png", "pendulum.svg", "pendulum_energy.png"];
    let others = ["pendulum_energy.svg"];
    assert_eq!(files, [&["index.html", "measurements.csv"][..], &pictures[..], &others[..]].concat());

    let png = std::fs::read(output.join(pictures[0])).unwrap();
    assert_eq!(&png[1..4], b"PNG");
    let svg = std::fs::read_to_string(output.join(pictures[1])).unwrap();
    roxmltree::Document::parse(&svg).unwrap();
    assert!(svg.contains("CPU seconds per simulated second") && svg.contains("Peer &lt;1&gt;"));
    let html = std::fs::read_to_string(output.join("index.html")).unwrap();
    assert_eq!(html.matches("<svg").count(), 2);
    assert!(html.contains("Peer &lt;1&gt;") && !html.contains("src=") && !html.contains("href="));

    let runs = read_csv(&output.join("measurements.csv")).unwrap();
    assert!(Method::ALL.iter().all(|method| runs.iter().any(|run| run.method == method.id())));
    let of_two = orders(&runs, Method::Lobatto(2), 1e-12..1e-3);
    assert!(of_two.len() >= 3 && of_two.iter().all(|order| (order - 2.0).abs() < 0.1), "{of_two:?}");
    // Order 16 shows over a few rungs only: above them the steps are coarse, below them is rounding.
    let of_nine = orders(&runs, Method::Lobatto(9), 1e-13..1e-5);
    assert!(of_nine.len() >= 2 && of_nine.iter().all(|order| (13.0..18.0).contains(order)), "{of_nine:?}");
}

#[test]
fn wrong_input_is_one_line_and_no_files() {
    let folder = scratch("wrong");
    let output = folder.join("chart");
    let good = robot("pendulum.urdf").to_str().unwrap().to_string();
    let bad_csv = folder.join("bad.csv");
    std::fs::write(&bad_csv, "scene,method\n").unwrap();
    let cases: [(&[&str], &str); 8] = [
        (&["no_such_file.urdf"], "no_such_file.urdf"),
        (&[&good, "no_such_file.urdf"], "no_such_file.urdf"),
        (&[&good, "--position", "elbow=1"], "elbow"),
        (&[&good, &good, "--position", "elbow=1"], "elbow"),
        (&[&good, "--duration", "0"], "--duration"),
        (&[&good, "--budget", "-1"], "--budget"),
        (&[&good, "--csv", bad_csv.to_str().unwrap()], "bad.csv:1"),
        (&[], "INPUT"),
    ];
    for (arguments, told) in cases {
        let ended = catena(&folder, &[arguments, &["-o", output.to_str().unwrap()]].concat());
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.contains(told) && !output.exists() && ended.stdout.is_empty(), "{arguments:?}: {said}");
    }
}

#[test]
fn a_file_in_the_place_of_the_folder_is_left_alone() {
    let folder = scratch("occupied");
    let occupied = folder.join("chart");
    std::fs::write(&occupied, "mine").unwrap();
    let ended = catena(&folder, &[robot("pendulum.urdf").to_str().unwrap(), "-o", occupied.to_str().unwrap()]);
    assert_eq!(ended.status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(&occupied).unwrap(), "mine");
}

#[test]
fn nobody_reaches_a_level_below_the_noise_of_the_reference() {
    let plan = Plan { quick: true, budget: 60.0 };
    let mut chart = measure(&pendulum(1.0), &plan, &AtomicBool::new(false), &mut |_, _| {}).unwrap();
    assert!(Comparison::of(&chart, 1e-6).ratio().is_some());
    chart.reference.scatter = 1e-5;
    assert_eq!(Comparison::of(&chart, 1e-6).ours.unwrap().reach, Reach::Floor(1e-5));
}

#[test]
fn a_budget_that_runs_out_is_said() {
    let plan = Plan { quick: true, budget: 1e-9 };
    let chart: SceneChart = measure(&pendulum(1.0), &plan, &AtomicBool::new(false), &mut |_, _| {}).unwrap();
    assert!(chart.out_of_budget && chart.measurements.len() < Method::ALL.len());
    let report = Report { scenes: vec![chart], ..Report::default() };
    assert!(report.summary().contains("the budget ran out"), "{}", report.summary());
}

/// A problem of the stress maps with limits, friction or motors, as a scene of a chart.
fn with_events(name: &str, place: usize) -> Scene {
    let problem = Problem::all().into_iter().find(|problem| problem.name == name).unwrap();
    let case = (problem.build)(place).unwrap();
    Scene { name: name.into(), mechanism: case.mechanism, start: case.start, duration: case.duration }
}

#[test]
fn two_formulations_that_locate_events_agree_on_where_limits_friction_and_motors_lead() {
    let mut bounded = with_events("motor_gain", 1);
    // Bounds that are reached, and a target with kinks: the saturation begins and ends within the run.
    for motor in &mut bounded.mechanism.nonsmooth.motors {
        motor.max_effort = 4.0;
        motor.target = Target::table(&[(0.0, 0.0), (0.2, 1.0), (0.4, -0.5)], Interpolation::Linear).unwrap();
    }
    for scene in [with_events("joint_limits", 0), with_events("dry_friction", 1), with_events("motor_gain", 2), bounded]
    {
        let found = reference(&scene, &AtomicBool::new(false), &mut |_| {}).unwrap();
        // Errors at 1e-14 are amplified by the events: by a few per impact, and by the sensitivity of the double pendulum.
        assert!(found.agreement.unwrap() < 1e-10, "{}: {:?}", scene.name, found);
    }
}

#[test]
fn a_chart_of_contacts_is_measured_against_our_own_refinement_and_says_who_is_left_out() {
    let folder = scratch("contact");
    let scene = robot("block_on_incline.toml");
    let ended = catena(&folder, &[scene.to_str().unwrap(), "-o", "chart", "--quick", "--duration", "1"]);
    assert!(ended.status.success());
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(said.contains("know no contacts and are left out"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    let runs = read_csv(&folder.join("chart/measurements.csv")).unwrap();
    let least = |method: Method| {
        runs.iter().filter(|run| run.method == method.id()).map(|run| run.error).fold(f64::INFINITY, f64::min)
    };
    for method in Method::WITH_EVENTS {
        assert_eq!(runs.iter().any(|run| run.method == method.id()), method.is_ours(), "{method:?}");
        // A block that slides straight to its stop is a parabola, which two stages have exactly, and the midpoint rule, too; steps over events find its forces
        // to 5e-9 of themselves.
        let bound = if *method == Method::OverEvents { 1e-8 } else { 1e-11 };
        assert!(!method.is_ours() || least(*method) < bound, "{method:?}: {:e}", least(*method));
    }
    // Where the block stops, and that nothing else was simulated.
    let (model, start) = Model::from_scene(&read_scene(&scene, &PackagePath::default()).unwrap()).unwrap();
    let start = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    let scene = Scene { name: "block".into(), start, mechanism: model.mechanism, duration: 1.0 };
    let found = reference(&scene, &AtomicBool::new(false), &mut |_| {}).unwrap();
    assert!(found.agreement.is_none() && found.scatter < 1e-12, "{found:?}");
    let (slope, friction) = (20_f64.to_radians(), 0.5);
    let distance = 0.5 / (9.81 * (friction * slope.cos() - slope.sin()));
    let wanted =
        Vector3::new(slope.sin(), 0.0, slope.cos()) * 0.05 + Vector3::new(slope.cos(), 0.0, -slope.sin()) * distance;
    assert!((found.probes[0] - wanted).norm() < 1e-10, "{} for {wanted}", found.probes[0]);
}

#[test]
fn a_chart_simulates_limits_and_friction_and_who_locates_events_gets_to_rounding() {
    let folder = scratch("nonsmooth");
    let urdf = r#"<robot name="r"><link name="base"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
        <limit lower="-0.5" upper="1" effort="1" velocity="9"/><dynamics friction="0.1"/></joint></robot>"#;
    std::fs::write(folder.join("rod.urdf"), urdf).unwrap();
    let arguments = ["rod.urdf", "-o", "chart", "--quick", "--duration", "1.5", "--position", "hinge=0.9"];
    let ended = catena(&folder, &arguments);
    assert!(ended.status.success());
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "");
    let runs = read_csv(&folder.join("chart/measurements.csv")).unwrap();
    assert!(Method::WITH_EVENTS.iter().all(|method| runs.iter().any(|run| run.method == method.id())));
    let least = |method: Method| {
        runs.iter().filter(|run| run.method == method.id()).map(|run| run.error).fold(f64::INFINITY, f64::min)
    };
    // What locates events gets to rounding, what has springs for limits does not.
    assert!(least(Method::Lobatto(9)) < 1e-11, "{:e}", least(Method::Lobatto(9)));
    assert!(least(Method::Dop853) < 1e-10, "{:e}", least(Method::Dop853));
    assert!(least(Method::Rk4) > 1e-7, "{:e}", least(Method::Rk4));
}
