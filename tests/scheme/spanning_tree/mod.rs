//! The same mechanism on several spanning trees: the same motion, the same numbers under the same names, the same work.

mod driven;
mod kinds;
mod locked;
mod starts;

use crate::linkage::{Linkage, path};
use crate::{closed, common};
use catena::instant::exerting::reactions::Reactions;
use catena::lobatto::plan::elimination::Elimination;
use catena::lobatto::plan::spanning::spanning_tree;
use catena::mechanism::description::closure::{Coordinate, JointLimit, LoopKind};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::other_tree::OtherTree;
use catena::mechanism::structure::plane::Plane;
use catena::mechanism::structure::spanning_tree::{Edge, Graph, Hang, SpanningTree};
use catena::simulation::{Observer, ObserverError, Sample, Simulation, SimulationOptions, StepChoice};
use catena::stepping::integrator::Lobatto;
use catena::stepping::trees::other_tree::other_tree;
use nalgebra::{Rotation3, Vector3};

/// Where every body is, by name, and how it moves.
fn places(mechanism: &Mechanism, state: &State) -> Vec<(String, Vector3<f64>, Vector3<f64>)> {
    let bodies = mechanism.bodies.iter().zip(body_states(mechanism, state));
    let mut places: Vec<_> = bodies.map(|(body, at)| (body.name.clone(), at.position, at.velocity)).collect();
    places.sort_by(|a, b| a.0.cmp(&b.0));
    places
}

/// The largest difference of places (m) and velocities [m/s].
fn apart(one: (&Mechanism, &State), other: (&Mechanism, &State)) -> f64 {
    let pairs = places(one.0, one.1).into_iter().zip(places(other.0, other.1));
    pairs.fold(0.0, |most, (a, b)| {
        assert_eq!(a.0, b.0, "the same bodies");
        most.max((a.1 - b.1).norm()).max((a.2 - b.2).norm())
    })
}

/// Where a run in fixed steps ends, on the tree of the mechanism.
fn end(mechanism: &Mechanism, start: &State, step: f64, duration: f64) -> State {
    let mut lobatto = Lobatto::fixed(mechanism, 5, step).expect("five stages");
    let mut state = start.clone();
    while state.time < duration {
        lobatto.advance(mechanism, &mut state, duration).expect("a step");
    }
    state
}

/// A run with the tree of the program's choice, or with `kept` rules.
fn simulated(mechanism: &Mechanism, start: &State, (step, duration): (f64, f64), kept: &[Rule]) -> State {
    let steps = StepChoice::Fixed { stages: 5, step };
    let options = SimulationOptions { switched_off: kept, ..SimulationOptions::new(duration, steps) };
    let mut simulation = Simulation::new(mechanism, start.clone(), options).expect("a run");
    simulation.run().expect("steps");
    simulation.state().clone()
}

/// A random spanning tree, numbered depth first.
fn random_tree(mechanism: &Mechanism, plane: Option<&Plane>, numbers: &mut common::Numbers) -> SpanningTree {
    let graph = Graph::new(mechanism, plane);
    let mut edges: Vec<usize> = (0..graph.links.len()).filter(|&link| graph.links[link].edge.is_some()).collect();
    for last in (1..edges.len()).rev() {
        edges.swap(last, (numbers.next(0.0, last as f64 + 1.0) as usize).min(last));
    }
    edges.sort_by_key(|&link| !graph.links[link].fixed);
    let mut hangs: Vec<Option<Hang>> = vec![None; graph.bodies];
    let mut order: Vec<usize> = Vec::new();
    // What is reached grows by the first edge that leads out of it; the order is put right afterwards.
    while order.len() < graph.bodies {
        let reached = |end: Option<usize>| end.is_none_or(|body| hangs[body].is_some());
        let next = edges.iter().find(|&&link| reached(graph.links[link].ends[0]) != reached(graph.links[link].ends[1]));
        let link = &graph.links[*next.expect("a connected graph")];
        let backwards = reached(link.ends[1]);
        let (parent, body) = if backwards { (link.ends[1], link.ends[0]) } else { (link.ends[0], link.ends[1]) };
        let (body, by) = (body.expect("a body"), link.edge.expect("an edge"));
        hangs[body] = Some(Hang { parent, by, backwards });
        order.push(body);
    }
    let hangs: Vec<Hang> = hangs.into_iter().map(|hang| hang.expect("all bodies")).collect();
    let mut waiting: Vec<usize> = order.iter().copied().filter(|&body| hangs[body].parent.is_none()).collect();
    let mut depth_first = Vec::new();
    while let Some(body) = waiting.pop() {
        depth_first.push(body);
        waiting.extend(order.iter().copied().filter(|&child| hangs[child].parent == Some(body)));
    }
    SpanningTree { hangs, order: depth_first }
}

#[test]
fn a_mechanism_moves_the_same_on_random_spanning_trees_and_comes_back_in_the_coordinates_of_its_file() {
    let mut numbers = common::Numbers::new(36);
    let (bricard, at_rest) = closed::bricard();
    let (four_bars, moving) = closed::four_bars(3, 5);
    let (balls, rolling) = closed::four_bars(2, 3);
    let scissors = Linkage::scissors(3);
    let (scissors, swinging) = scissors.written(&scissors.first(&["top", "middle"]));
    // A loop joint does not mind whether its axes point the same way: one that points the other way is turned in the tree.
    let mut opposite = bricard.clone();
    for joint in &mut opposite.loops {
        let half = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        joint.b.frame = Pose::from_parts(joint.b.frame.translation, joint.b.frame.rotation * half);
    }
    let cases =
        [(bricard, &at_rest), (four_bars, &moving), (balls, &rolling), (scissors, &swinging), (opposite, &at_rest)];
    for (number, (mechanism, start)) in cases.iter().enumerate() {
        let expected = end(mechanism, start, 0.01, 0.3);
        let mut turned = 0;
        for plane in [Plane::of(mechanism), None] {
            for _ in 0..6 {
                let tree = random_tree(mechanism, plane.as_ref(), &mut numbers);
                turned += usize::from(tree.hangs.iter().any(|hang| hang.backwards && matches!(hang.by, Edge::Tree(_))));
                let mut other = OtherTree::new(mechanism, &tree, plane.as_ref(), start).expect("depth first");
                let mut own = State::zero(&other.mechanism);
                other.take(mechanism, start, &mut own);
                let begin = apart((mechanism, start), (&other.mechanism, &own));
                // Six bodies in a row, and what the closures of the start are off by.
                assert!(begin < 1e-13, "case {number}: {begin:e} off at the start");
                let own = end(&other.mechanism, &own, 0.01, 0.3);
                let off = apart((mechanism, &expected), (&other.mechanism, &own));
                // Thirty steps solved to rounding; roundings grow no faster than a hundredfold in 0.3 s.
                assert!(off < 1e-10, "case {number}: bodies are {off:e} m apart on {tree:?}");
                let mut back: State = (*start).clone();
                other.give(mechanism, &own, &mut back);
                let numbers = back.position.iter().zip(&expected.position);
                let numbers = numbers.chain(back.velocity.iter().zip(&expected.velocity));
                let off = numbers.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "case {number}: coordinates are {off:e} off");
            }
        }
        assert!(turned > 0, "case {number}: no joint has turned round");
    }
}

/// The work of an elimination in the plane on the tree that a run takes.
fn work(mechanism: &Mechanism) -> usize {
    let plane = Plane::of(mechanism).expect("a plane");
    let start = State::zero(mechanism);
    let tree = spanning_tree(&Graph::new(mechanism, Some(&plane)));
    let tree = tree.unwrap_or_else(|| SpanningTree::of_file(mechanism));
    let other = OtherTree::new(mechanism, &tree, Some(&plane), &start).expect("depth first");
    Elimination::new(&other.mechanism, 3, &vec![2; other.mechanism.loops.len()], false).work()
}

#[test]
fn work_grows_like_the_number_of_loops_whichever_way_a_row_or_a_ladder_is_written() {
    let row = |count| Linkage::four_bars(count, 1.0, false);
    let chained = |count| Linkage::four_bars(count, 1.0, true);
    let ladder = Linkage::scissors;
    type Ways<'w> = (&'w dyn Fn(usize) -> Linkage, [&'w [&'w str]; 3]);
    // As rows on the ground, as paths with loops to the ground, as they are listed; the ladder rail by rail, as a comb, rung by rung.
    let all: [Ways; 3] = [
        (&row, [&["pin", "elbow"], &["pin0", "elbow", "knee"], &[]]),
        (&chained, [&["pin", "knee"], &["pin0", "elbow", "knee"], &[]]),
        (&ladder, [&["top", "left", "right"], &["top", "middle", "left"], &["top", "middle", "right"]]),
    ];
    for (number, (linkage, ways)) in all.iter().enumerate() {
        let mut at_eighty = Vec::new();
        for way in ways {
            let works = [20, 40, 80].map(|count| {
                let linkage = linkage(count);
                work(&linkage.written(&linkage.first(way)).0) as f64
            });
            let powers = [(works[1] / works[0]).log2(), (works[2] / works[1]).log2()];
            assert!(powers.iter().all(|power| *power <= 1.1), "{number}: N^{powers:?} on {way:?}: {works:?}");
            at_eighty.push(works[2]);
        }
        let [least, most] = [f64::min, f64::max].map(|of| at_eighty.iter().copied().reduce(of).expect("three ways"));
        assert!(most <= 1.5 * least, "{number}: {at_eighty:?}");
    }
}

#[test]
fn a_row_that_is_written_as_a_path_moves_like_the_row_with_the_coordinates_of_its_file_and_every_turn() {
    // Cranks that go round two or three times in a second.
    let (mechanism, start) = path(10, 15.0);
    let (tree, _) = other_tree(&mechanism, &[], &[]).expect("another tree");
    assert_eq!(tree.hung_loops().count(), 10, "all cranks hang on the ground");
    assert!(other_tree(&mechanism, &[], &[Rule::Tree]).is_none(), "the rule can be switched off");
    let steps = (0.005, 1.0);
    let own = simulated(&mechanism, &start, steps, &[]);
    let kept = simulated(&mechanism, &start, steps, &[Rule::Tree]);
    assert!(kept.position.iter().any(|angle| angle.abs() > 12.0), "joints turn several times: {:?}", kept.position);
    let pairs = own.position.iter().zip(&kept.position).chain(own.velocity.iter().zip(&kept.velocity));
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Steps of a tenth of a radian with order eight, and roundings that singular positions amplify.
    assert!(off < 1e-6, "{off:e}");
    // And like the row that is written as a row.
    let row = Linkage::four_bars(10, 15.0, true);
    let (row, start) = row.written(&row.first(&["pin", "knee"]));
    let expected = simulated(&row, &start, steps, &[]);
    let off = apart((&mechanism, &own), (&row, &expected));
    assert!(off < 1e-6, "{off:e} m");
}

/// The samples of a run.
#[derive(Default)]
struct Seen(Vec<(f64, Vec<f64>, Vec<f64>)>);

impl Observer for Seen {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.0.push((sample.time, sample.position.to_vec(), sample.velocity.to_vec()));
        Ok(())
    }
}

#[test]
fn samples_inside_steps_and_steps_after_a_pause_are_those_of_the_file() {
    // Cranks that go round: whole turns are counted inside steps, too.
    let (mechanism, start) = path(8, 15.0);
    let run = |kept: &[Rule]| {
        let steps = StepChoice::Fixed { stages: 5, step: 0.01 };
        let options = SimulationOptions { switched_off: kept, ..SimulationOptions::new(0.6, steps) };
        let mut seen = Seen::default();
        let mut simulation = Simulation::new(&mechanism, start.clone(), options).expect("a run");
        simulation.sample_at(170.0);
        simulation.observe(&mut seen);
        for time in [0.1, 0.257, 0.6] {
            simulation.step_to(time).expect("steps");
        }
        drop(simulation);
        seen.0
    };
    let (own, kept) = (run(&[]), run(&[Rule::Tree]));
    assert_eq!((own.len(), kept.len()), (103, 103), "0.6 s, and the start");
    let turned = kept.iter().flat_map(|(_, position, _)| position).fold(0.0_f64, |most, angle| most.max(angle.abs()));
    assert!(turned > std::f64::consts::TAU, "no joint turns by more than {turned} rad");
    for ((time, position, velocity), (_, wanted, rates)) in own.iter().zip(&kept) {
        let pairs = position.iter().zip(wanted).chain(velocity.iter().zip(rates));
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Dense output of order five in steps of 0.15 rad: rates of 15 rad/s are within 1e-5 of the motion.
        assert!(off < 1e-4, "at {time} s {off:e} off");
    }
}

#[test]
fn reactions_are_those_of_the_file_with_its_ends_and_signs() {
    let mut numbers = common::Numbers::new(5);
    for count in [6, 9] {
        let (mechanism, mut state) = path(count, 1.0);
        let turn = numbers.next(0.2, 0.9);
        // Still closed: cranks stay parallel, couplers level.
        for (body, own) in mechanism.bodies.iter().enumerate() {
            let above = own.parent.map_or("", |parent| &mechanism.bodies[parent].name);
            let down = |name: &str| if name.starts_with("crank") { turn } else { 0.0 };
            state.position[body] -= down(&own.name) - down(above);
        }
        let bodies = body_states(&mechanism, &state);
        let mut elsewhere = Reactions::new(&mechanism);
        let mut here = Reactions::on_its_tree(&mechanism);
        let accelerations = elsewhere.accelerations(&state.position, &state.velocity, &bodies).to_vec();
        let expected = here.accelerations(&state.position, &state.velocity, &bodies);
        let off = accelerations.iter().zip(expected).map(|(a, b)| (a.0 - b.0).norm() + (a.1 - b.1).norm());
        // Of accelerations of ten metres a second squared.
        assert!(off.fold(0.0, f64::max) < 1e-10);
        let (joints, loops) = elsewhere.of_placed(&state.position, &state.velocity, &bodies);
        let (expected_joints, expected_loops) = here.of_placed(&state.position, &state.velocity, &bodies);
        for (own, expected) in joints.iter().zip(expected_joints) {
            let off = (own.force - expected.force).norm() + (own.torque - expected.torque).norm();
            // Of forces of some ten newtons each, added up over twenty bodies.
            assert!(off < 1e-9 && (own.anchor - expected.anchor).norm() < 1e-12, "{own:?}, not {expected:?}");
        }
        for (own, expected) in loops.iter().zip(expected_loops) {
            assert!((own.force - expected.force).norm() < 1e-9, "{own:?}, not {expected:?}");
            assert!((own.torque - expected.torque).norm() < 1e-9, "{own:?}, not {expected:?}");
        }
    }
}

#[test]
fn whoever_drives_joints_that_are_cut_moves_them_as_on_the_tree_of_the_file() {
    let (mechanism, start) = path(8, 1.0);
    let run = |kept: &[Rule]| {
        let steps = StepChoice::Fixed { stages: 5, step: 0.02 };
        let options = SimulationOptions { switched_off: kept, ..SimulationOptions::new(0.4, steps) };
        let mut simulation = Simulation::new(&mechanism, start.clone(), options).expect("a run");
        simulation.step_to(0.2).expect("steps");
        simulation.set_efforts(&vec![0.7; mechanism.velocity_count]).expect("one effort a joint");
        simulation.step_to(0.4).expect("steps");
        simulation.state().clone()
    };
    let (own, kept, undriven) = (run(&[]), run(&[Rule::Tree]), simulated(&mechanism, &start, (0.02, 0.4), &[]));
    let off = |other: &State| own.position.iter().zip(&other.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off(&kept) < 1e-9 && off(&undriven) > 1e-3, "{:e} and {:e}", off(&kept), off(&undriven));
}

#[test]
fn joints_with_springs_dampers_and_loads_of_their_own_are_not_cut() {
    let (mut mechanism, start) = path(8, 1.0);
    // All but the loops act along coordinates: nothing can be cut.
    for freedom in 0..mechanism.velocity_count {
        let damper = catena::mechanism::description::forces::JointDamper { freedom, coefficient: 0.1 };
        mechanism.forces.joint_dampers.push(damper);
    }
    assert!(other_tree(&mechanism, &[], &[]).is_none());
    // On the knees alone: the others are enough, and the dampers are where they were.
    let knees: Vec<bool> = mechanism.bodies.iter().map(|body| body.joint.name.starts_with("knee")).collect();
    mechanism.forces.joint_dampers.retain(|damper| knees[damper.freedom]);
    let (tree, _) = other_tree(&mechanism, &[], &[]).expect("another tree");
    assert!(tree.cut_joints().all(|body| !knees[body]));
    let [own, kept] = [&[][..], &[Rule::Tree]].map(|kept| simulated(&mechanism, &start, (0.02, 1.0), kept));
    let off = own.position.iter().zip(&kept.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn loop_joints_that_no_tree_joint_is_like_stay_loops() {
    let (mut mechanism, _) = path(8, 1.0);
    for joint in &mut mechanism.loops {
        joint.kind = LoopKind::Cylindrical;
    }
    assert!(other_tree(&mechanism, &[], &[]).is_none());
}

#[test]
fn limits_are_hit_at_the_same_instants_whichever_joints_are_cut() {
    let (mut mechanism, start) = path(8, 3.0);
    // A crank that carries no other in the file, and the first: both are met, one of them on a joint that is cut.
    let tree = other_tree(&mechanism, &[], &[]).expect("another tree").0;
    let cut = tree.cut_joints().next().expect("a joint that is cut");
    for body in [0, cut] {
        let joint = &mechanism.bodies[body].joint;
        let coordinate = Coordinate { body, position: joint.position_index, freedom: joint.velocity_index };
        let at = start.position[body];
        let limit = JointLimit { coordinate, lower: at - 0.4, upper: at + 0.5, restitution: 0.6 };
        mechanism.nonsmooth.limits.push(limit);
    }
    let run = |kept: &[Rule]| {
        let steps = StepChoice::Fixed { stages: 5, step: 0.01 };
        let options = SimulationOptions { switched_off: kept, ..SimulationOptions::new(0.8, steps) };
        let mut simulation = Simulation::new(&mechanism, start.clone(), options).expect("a run");
        simulation.run().expect("steps");
        let finished = simulation.finish();
        (finished.state, finished.events)
    };
    let ((own, happened), (kept, expected)) = (run(&[]), run(&[Rule::Tree]));
    assert!(!expected.is_empty() && happened.len() == expected.len(), "{happened:?}, not {expected:?}");
    for (own, expected) in happened.iter().zip(&expected) {
        assert_eq!((own.kind, own.body), (expected.kind, expected.body));
        // Located to rounding in steps that agree to rounding; impacts amplify it some hundredfold.
        assert!((own.time - expected.time).abs() < 1e-10, "{own:?}, not {expected:?}");
    }
    let off = own.position.iter().zip(&kept.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-8, "{off:e}");
}
