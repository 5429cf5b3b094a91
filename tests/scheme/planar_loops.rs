//! Closed loops in a plane: three coordinates a body say the same as six, step by step.

use crate::common::{Numbers, command};
use crate::in_plane::{place, random_tree};
use crate::models::Model;
use crate::{closed, models};
use catena::closures::{loop_gaps, mimic_gap};
use catena::islands::Plan as IslandPlan;
use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::lobatto::assembly::assemble;
use catena::lobatto::lanes::Isa;
use catena::lobatto::step::StopRule;
use catena::model::{Attachment, Coordinate, LoopJoint, LoopKind, Mechanism, Mimic, PlanarEquation, Plane, Pose, Rule};
use catena::simulation::{Integrator, StepOutcome};
use catena::state::State;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// How a joint frame lies in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lies {
    /// z along the normal, either way.
    Along,
    /// z in the plane.
    Across,
    /// Neither.
    Oblique,
}

/// A closure between two bodies where they are, or between a body and the world, which says nothing there yet: for some kinds with its
/// points at different heights.
fn closure(model: &Model, kind: LoopKind, lies: Lies, ends: [Option<usize>; 2], numbers: &mut Numbers) -> LoopJoint {
    let plane = Plane::of(&model.mechanism).expect("a plane");
    let bodies = body_states(&model.mechanism, &model.state);
    let upright = Rotation3::from_matrix(&nalgebra::Matrix3::from_columns(&plane.axes));
    let about_z = |angle| Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    let tilted = |angle| Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
    let tilt = match lies {
        Lies::Along => {
            if numbers.next(-1.0, 1.0) > 0.0 {
                0.0
            } else {
                PI
            }
        }
        Lies::Across => FRAC_PI_2,
        Lies::Oblique => 0.6,
    };
    let on_a = upright * about_z(numbers.next(-3.0, 3.0)) * tilted(tilt) * about_z(numbers.next(-3.0, 3.0));
    let on_b = match (kind, lies) {
        // z_b across z_a: in the plane too, or along the normal.
        (LoopKind::Universal, Lies::Across) => upright * about_z(FRAC_PI_2) * upright.inverse() * on_a,
        (LoopKind::Universal, _) => on_a * tilted(FRAC_PI_2) * about_z(0.3),
        // What only aligns the axes does not mind how the frames are turned about them.
        (LoopKind::Revolute | LoopKind::Cylindrical | LoopKind::Planar, _) => on_a * about_z(numbers.next(-3.0, 3.0)),
        (LoopKind::Spherical | LoopKind::Distance(_), _) => on_a * tilted(0.7),
        _ => on_a,
    };
    let at_a =
        ends.iter().flatten().map(|&body| bodies[body].position).sum::<Vector3<f64>>() * 0.5 + place(numbers, 0.3);
    let slid = match kind {
        LoopKind::Prismatic | LoopKind::Cylindrical => on_a * Vector3::new(0.0, 0.0, 0.4),
        LoopKind::Planar => on_a * Vector3::new(0.3, -0.2, 0.0),
        LoopKind::Distance(_) => upright * Vector3::new(0.5, 0.4, 0.3),
        _ => Vector3::zeros(),
    };
    let kind = if let LoopKind::Distance(_) = kind { LoopKind::Distance(slid.norm()) } else { kind };
    let attach = |body: Option<usize>, point: Vector3<f64>, frame: Rotation3<f64>| {
        let Some(body) = body else {
            return Attachment { body: None, frame: Pose::from_parts(point.into(), frame) };
        };
        let turned = Rotation3::from_matrix_unchecked(bodies[body].rotation);
        let point = turned.inverse() * (point - bodies[body].position);
        Attachment { body: Some(body), frame: Pose::from_parts(Translation3::from(point), turned.inverse() * frame) }
    };
    let (a, b) = (attach(ends[0], at_a, on_a), attach(ends[1], at_a + slid, on_b));
    LoopJoint { name: format!("{kind:?} {lies:?}"), kind, a, b }
}

/// All kinds, each as it allows motions in a plane, and the number of equations that it has there.
const KINDS: [(LoopKind, Lies, usize); 15] = [
    (LoopKind::Revolute, Lies::Along, 2),
    (LoopKind::Revolute, Lies::Across, 3),
    (LoopKind::Prismatic, Lies::Along, 3),
    (LoopKind::Prismatic, Lies::Across, 2),
    (LoopKind::Cylindrical, Lies::Along, 2),
    (LoopKind::Cylindrical, Lies::Across, 2),
    (LoopKind::Universal, Lies::Along, 2),
    (LoopKind::Universal, Lies::Across, 3),
    (LoopKind::Spherical, Lies::Oblique, 2),
    (LoopKind::Planar, Lies::Along, 0),
    (LoopKind::Planar, Lies::Across, 2),
    (LoopKind::Fixed, Lies::Along, 3),
    (LoopKind::Fixed, Lies::Across, 3),
    (LoopKind::Fixed, Lies::Oblique, 3),
    (LoopKind::Distance(1.0), Lies::Oblique, 1),
];

/// A tree in an inclined plane with closures in it, the first of them of this kind; on its closures in position and velocity.
fn random_loops(seed: u64, kind: LoopKind, lies: Lies) -> Model {
    let mut numbers = Numbers::new(seed + 1000);
    let mut model = random_tree(seed, 11, Vector3::new(0.3, -0.5, 0.7));
    // The closures are where zero displacement is not.
    let ends = [[Some(10), Some(4)], [Some(8), None], [Some(6), Some(9)]];
    let kinds = [(kind, lies), (LoopKind::Distance(1.0), Lies::Oblique), (LoopKind::Cylindrical, Lies::Across)];
    for ((kind, lies), ends) in kinds.into_iter().zip(ends) {
        let joint = closure(&model, kind, lies, ends, &mut numbers);
        model.mechanism.loops.push(joint);
    }
    assemble(&model.mechanism, &mut model.state).expect("closed where it was made");
    model
}

/// A tree in a plane in which a hinge follows another, and a slide a hinge.
fn geared() -> Model {
    let mut model = random_tree(7, 9, Vector3::new(0.1, 0.2, 0.9));
    let coordinate = |body: usize| {
        let joint = &model.mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    let mimic = |name: &str, follower, leader, multiplier| Mimic {
        name: name.into(),
        follower: coordinate(follower),
        leader: coordinate(leader),
        multiplier,
        offset: 0.2,
    };
    model.mechanism.mimics = vec![mimic("hinge", 6, 1, -1.7), mimic("slide", 3, 0, 0.4)];
    assemble(&model.mechanism, &mut model.state).expect("mimics can always be followed");
    model
}

/// With every kind of force.
fn forced(mut model: Model) -> Model {
    let all = models::every_force(&model.mechanism).pop().expect("all forces").1;
    model.mechanism.forces = all;
    model
}

fn everything() -> Vec<(String, Model)> {
    let bars = |count, rows| {
        let (mechanism, state) = closed::four_bars(count, rows);
        Model { mechanism, state }
    };
    let mut all = vec![
        ("four-bar".to_string(), bars(1, 5)),
        ("two four-bars with balls".to_string(), bars(2, 3)),
        ("mimics".to_string(), geared()),
        ("four-bar with forces".to_string(), forced(bars(1, 5))),
        ("mimics with forces".to_string(), forced(geared())),
    ];
    for (seed, (kind, lies, _)) in KINDS.into_iter().enumerate() {
        let model = random_loops(seed as u64, kind, lies);
        all.push((format!("{kind:?} {lies:?}"), if seed % 3 == 1 { forced(model) } else { model }));
    }
    all
}

/// Largest difference of positions and velocities.
fn apart(a: &State, b: &State) -> f64 {
    let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    differences(&a.position, &b.position).max(differences(&a.velocity, &b.velocity))
}

/// Largest gap of any closure.
fn gap(mechanism: &Mechanism, state: &State) -> f64 {
    let bodies = body_states(mechanism, state);
    let loops = mechanism.loops.iter().map(|joint| loop_gaps(joint, &bodies).largest().0);
    let mimics = mechanism.mimics.iter().map(|mimic| mimic_gap(mimic, state).0.abs());
    loops.chain(mimics).fold(0.0, f64::max)
}

/// The run in the plane, and that of the full model: the states at the end, and what the steps did.
fn both(model: &Model, make: impl Fn() -> Lobatto, until: f64) -> [(State, Vec<StepOutcome>); 2] {
    assert!(Plane::of(&model.mechanism).is_some(), "no plane");
    [&[][..], &[Rule::Planar]].map(|kept| {
        let mut lobatto = make().keeping(&model.mechanism, kept);
        let (mut state, mut outcomes) = (model.state.clone(), Vec::new());
        while state.time < until {
            outcomes.push(lobatto.advance(&model.mechanism, &mut state, until).expect("a step"));
        }
        (state, outcomes)
    })
}

#[test]
fn fixed_steps_of_closed_loops_in_the_plane_are_those_in_space() {
    for (name, model) in everything() {
        for stages in 2..=9 {
            let step = if stages < 4 { 0.002 } else { 0.01 };
            let make = || Lobatto::fixed(&model.mechanism, stages, step).expect("stages");
            let [(flat, ours), (full, theirs)] = both(&model, make, 10.0 * step);
            let difference = apart(&flat, &full);
            // Both round, and closures of short levers amplify it.
            assert!(difference < 1e-11, "{name}, {stages} stages: {difference:e}");
            // The same matrix, but for rows that say nothing: as many iterations, and one more or less a step at rounding.
            let iterations = |outcomes: &[StepOutcome]| outcomes.iter().map(|one| one.iterations).sum::<usize>();
            let (count, expected) = (iterations(&ours), iterations(&theirs));
            assert!(count <= expected + ours.len(), "{name}, {stages} stages: {count} iterations, not {expected}");
            // Some metres, rounded.
            assert!(gap(&model.mechanism, &flat) < 3e-14, "{name}: {:e}", gap(&model.mechanism, &flat));
            let sums = |outcomes: &[StepOutcome]| {
                outcomes
                    .iter()
                    .fold((0.0, 0.0), |sum, one| (sum.0 + one.exchange.dissipated, sum.1 + one.exchange.work))
            };
            let ((lost, put_in), (expected, work)) = (sums(&ours), sums(&theirs));
            assert!(
                (lost - expected).abs() <= 1e-11 && (put_in - work).abs() <= 1e-11,
                "{name}: {lost} J, {expected} J"
            );
            assert_eq!(expected != 0.0, !model.mechanism.forces.is_empty(), "{name}");
        }
    }
}

#[test]
fn chosen_steps_of_closed_loops_in_the_plane_are_those_in_space() {
    for (name, model) in everything() {
        for (tolerance, stop) in [(1e-3, 1e-7), (1e-6, 1e-10), (1e-9, 1e-13)] {
            let make = || Lobatto::adaptive_with_stop(&model.mechanism, tolerance, stop);
            let [(flat, ours), (full, theirs)] = both(&model, make, 0.5);
            // The steps of a motion that is amplified differ by shares of their errors: the change of the energy, of which the last digits
            // are rounding, and the iterates, of which six coordinates a body have others, have a say in their lengths.
            assert!(ours.len().abs_diff(theirs.len()) <= 1, "{name}, {tolerance:e}: {} {}", ours.len(), theirs.len());
            let difference = apart(&flat, &full);
            assert!(difference < tolerance, "{name}, {tolerance:e}: {difference:e}");
        }
    }
}

#[test]
fn every_vector_type_makes_the_same_steps_of_closed_loops_in_the_plane() {
    for (name, model) in everything().into_iter().take(6) {
        for stages in [2, 3, 5, 6, 9, 10] {
            let ends = [Isa::Portable, Isa::Avx2, Isa::Avx512].map(|isa| {
                let mut state = model.state.clone();
                let mut lobatto =
                    Lobatto::fixed_with(&model.mechanism, stages, 0.002, StopRule::ROUNDING, isa).expect("stages");
                while state.time < 0.02 {
                    lobatto.advance(&model.mechanism, &mut state, 0.02).expect("a step");
                }
                state
            });
            for other in &ends[1..] {
                assert!(apart(&ends[0], other) < 1e-12, "{name}, {stages} stages: {:e}", apart(&ends[0], other));
            }
        }
    }
}

#[test]
fn what_is_interpolated_in_the_plane_is_on_the_loops_and_what_it_is_in_space() {
    for (name, model) in everything() {
        let [flat, full] = [&[][..], &[Rule::Planar]].map(|kept| {
            let mut lobatto =
                Lobatto::fixed(&model.mechanism, 5, 0.05).expect("stages").keeping(&model.mechanism, kept);
            let (mut state, mut inside) = (model.state.clone(), model.state.clone());
            lobatto.advance(&model.mechanism, &mut state, 0.05).expect("a step");
            [0.013, 0.021, 0.047].map(|time| {
                lobatto.dense(&model.mechanism, time, &mut inside.position, &mut inside.velocity);
                inside.clone()
            })
        });
        for (flat, full) in flat.iter().zip(&full) {
            let difference = apart(flat, full);
            assert!(difference < 1e-11, "{name}: {difference:e}");
            assert!(gap(&model.mechanism, flat) < 3e-14, "{name}: {:e}", gap(&model.mechanism, flat));
        }
    }
}

#[test]
fn singular_positions_are_seen_in_the_plane_as_in_space() {
    let (mechanism, mut beside) = closed::four_bars(1, 5);
    let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.01).expect("stages");
    while beside.time < 0.7 {
        lobatto.advance(&mechanism, &mut beside, 0.7).expect("a step");
    }
    let [flat, full] = [&[][..], &[Rule::Planar]].map(|kept| {
        // All rods lie in one line near 0.708 s, and steps of 1e-4 rad do not miss it.
        let mut lobatto = Lobatto::fixed(&mechanism, 3, 2e-5).expect("stages").keeping(&mechanism, kept);
        let mut state = beside.clone();
        while state.time < 0.72 {
            lobatto.advance(&mechanism, &mut state, 0.72).expect("a step");
        }
        lobatto.description().singular
    });
    assert!(flat.is_some_and(|seen| seen.extra == 1 && (seen.time - 0.708).abs() < 1e-3), "{flat:?}");
    assert_eq!(flat, full);
}

#[test]
fn redundant_equations_vanish_in_the_plane() {
    for (seed, (kind, lies, rows)) in KINDS.into_iter().enumerate() {
        let model = random_loops(seed as u64, kind, lies);
        let plane = Plane::of(&model.mechanism).expect("a plane");
        let zero = body_states(&model.mechanism, &State::zero(&model.mechanism));
        let equations = plane.equations(&model.mechanism.loops[0], &zero).expect("fits");
        assert_eq!(equations.len(), rows, "{kind:?} {lies:?}: {equations:?}");
        for equation in equations {
            let directions = match equation {
                PlanarEquation::Slide(along) => vec![along],
                PlanarEquation::Square(on_a, on_b) => vec![on_a, on_b],
                PlanarEquation::Distance { .. } => vec![],
            };
            for direction in directions {
                assert!((direction.norm() - 1.0).abs() < 1e-14 && direction.dot(&plane.normal()).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn closures_that_leave_the_plane_have_none() {
    let tree = random_tree(3, 8, Vector3::new(0.3, -0.5, 0.7));
    let mut numbers = Numbers::new(5);
    let ends = [Some(7), Some(2)];
    let has = |joint: LoopJoint| Plane::of(&Mechanism { loops: vec![joint], ..tree.mechanism.clone() }).is_some();
    let oblique =
        [LoopKind::Revolute, LoopKind::Prismatic, LoopKind::Cylindrical, LoopKind::Universal, LoopKind::Planar];
    for kind in oblique {
        assert!(!has(closure(&tree, kind, Lies::Oblique, ends, &mut numbers)), "{kind:?}");
    }
    let level = [
        (LoopKind::Revolute, Lies::Along),
        (LoopKind::Universal, Lies::Across),
        (LoopKind::Spherical, Lies::Oblique),
        (LoopKind::Fixed, Lies::Oblique),
        (LoopKind::Prismatic, Lies::Across),
        (LoopKind::Cylindrical, Lies::Across),
        (LoopKind::Planar, Lies::Along),
    ];
    let normal = Plane::of(&tree.mechanism).expect("a plane").normal();
    let bodies = body_states(&tree.mechanism, &tree.state);
    for (kind, lies) in level {
        let joint = closure(&tree, kind, lies, ends, &mut numbers);
        assert!(has(joint.clone()), "{kind:?} {lies:?}");
        // One end higher than the other, by more than rounding.
        let mut uneven = joint.clone();
        uneven.a.frame.translation.vector += bodies[7].rotation.transpose() * normal * 1e-9;
        assert!(!has(uneven), "{kind:?} {lies:?} at different heights");
        let mut leaning = joint;
        leaning.a.frame.rotation *= Rotation3::new(Vector3::new(1e-9, 2e-9, 0.0));
        assert_eq!(has(leaning), kind == LoopKind::Spherical, "{kind:?} {lies:?} with axes that are off");
    }
    for (kind, lies) in
        [(LoopKind::Prismatic, Lies::Along), (LoopKind::Cylindrical, Lies::Along), (LoopKind::Planar, Lies::Across)]
    {
        let mut joint = closure(&tree, kind, lies, ends, &mut numbers);
        joint.a.frame.translation.vector += bodies[7].rotation.transpose() * normal * 0.3;
        assert!(has(joint), "{kind:?} {lies:?} slides along the normal");
    }
}

#[test]
fn closed_loops_are_put_together_with_each_other_and_not_with_trees() {
    // Four-bars and swings in the same plane, in turns; three bodies each.
    let (mut bodies, mut loops) = (Vec::new(), Vec::new());
    for part in 0..8 {
        let (mechanism, _) = closed::four_bars(1, 5);
        let first = bodies.len();
        let shifted = |body: Option<usize>| body.map(|body| body + first);
        loops.extend(mechanism.loops.into_iter().filter(|_| part % 2 == 0).map(|mut joint| {
            (joint.a.body, joint.b.body) = (shifted(joint.a.body), shifted(joint.b.body));
            joint
        }));
        let moved = mechanism.bodies.into_iter().map(|mut body| {
            body.parent = shifted(body.parent);
            body
        });
        bodies.extend(moved.collect::<Vec<_>>());
    }
    let mut mechanism = Mechanism::new("bars and swings", models::gravity(), bodies).expect("depth first");
    mechanism.loops = loops;
    let mut state = State::zero(&mechanism);
    state.velocity.fill(0.3);
    let plan = IslandPlan::new(&mechanism, &state, &[]).grouped(&mechanism, 6);
    let groups: Vec<_> = plan.islands.iter().map(|(island, _)| &island.mechanism).collect();
    for group in &groups {
        assert!(Plane::of(group).is_some());
        assert!(group.loops.is_empty() || group.loops.len() * 3 == group.bodies.len(), "trees and loops in one group");
    }
    assert_eq!(groups.iter().map(|group| group.loops.len()).sum::<usize>(), 4);
    assert!(groups.len() < 8, "nothing was put together");
}

#[test]
fn the_rule_covers_closed_loops_and_is_switched_off_by_name() {
    let folder = command::folder("planar_loops");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/four_bar_2.toml");
    let count = |arguments: &[&str]| -> serde_json::Value {
        let output = command::run(&folder, &[&["model", scene, "--json"], arguments].concat());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let rules = json["rules"].as_array().expect("an array").clone();
        rules.into_iter().find(|rule| rule["name"] == "planar").expect("the rule is named")
    };
    assert_eq!((&count(&[])["count"], &count(&[])["kept"]), (&5.into(), &false.into()));
    assert_eq!(count(&["--keep", "planar"])["kept"], true);
    let report = |arguments: &[&str]| -> serde_json::Value {
        let always = ["simulate", scene, "--no-log", "--json", "--duration", "1", "--stages", "5", "--step", "0.01"];
        let output = command::run(&folder, &[&always[..], arguments].concat());
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let (flat, full) = (report(&[]), report(&["--keep", "planar"]));
    // What joints and loops carry is worked out in space for both; of some 90 N, rounded.
    for part in ["joints", "loops"] {
        let (flat, full) = (numbers(&flat[part]), numbers(&full[part]));
        assert!(flat.len() > 10 && flat.len() == full.len(), "{part}");
        for (flat, full) in flat.into_iter().zip(full) {
            assert!((flat - full).abs() < 1e-10, "{part}: {flat} {full}");
        }
    }
}

/// All numbers of a report, in its order.
fn numbers(report: &serde_json::Value) -> Vec<f64> {
    match report {
        serde_json::Value::Object(entries) => entries.values().flat_map(numbers).collect(),
        serde_json::Value::Array(entries) => entries.iter().flat_map(numbers).collect(),
        number => number.as_f64().into_iter().collect(),
    }
}
