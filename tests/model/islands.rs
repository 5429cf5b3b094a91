//! Islands: what nothing connects is simulated apart, as if it were alone, and what rests in equilibrium not at all.

use crate::common::Numbers;
use crate::common::command;
use crate::models::Model;
use crate::{closed, common, models};
use catena::forces::total::{Stored, stored};
use catena::forces::{Forces, JointLoad, PointSpring};
use catena::invariants::{energy, energy_with_forces};
use catena::islands::{Islands, Plan, Threads};
use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::model::{
    Attachment, Coordinate, Joint, JointKind, LoopJoint, LoopKind, Mechanism, Mimic, Pose, Rule, islands,
};
use catena::rest::is_at_rest;
use catena::simulation::{Observer, ObserverError, RunError, RunOptions, Sample, Summary, run};
use catena::state::State;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

/// All of them in one mechanism, one after the other.
fn side_by_side(parts: Vec<(Mechanism, State)>) -> Model {
    let mut bodies = Vec::new();
    let mut state = State { time: 0.0, position: vec![], compensation: vec![], velocity: vec![] };
    let (mut loops, mut forces) = (Vec::new(), Forces::default());
    for (part, own) in parts {
        let (first, freedom, position) = (bodies.len(), state.velocity.len(), state.position.len());
        let there = |end: Attachment| Attachment { body: end.body.map(|body| body + first), ..end };
        bodies.extend(part.bodies.into_iter().map(|mut body| {
            body.parent = body.parent.map(|parent| parent + first);
            body
        }));
        loops.extend(part.loops.into_iter().map(|joint| LoopJoint { a: there(joint.a), b: there(joint.b), ..joint }));
        let theirs = part.forces;
        forces.joint_dampers.extend(theirs.joint_dampers.into_iter().map(|mut damper| {
            damper.freedom += freedom;
            damper
        }));
        forces.joint_springs.extend(theirs.joint_springs.into_iter().map(|mut spring| {
            spring.coordinate.body += first;
            spring.coordinate.position += position;
            spring.coordinate.freedom += freedom;
            spring
        }));
        forces.joint_loads.extend(theirs.joint_loads.into_iter().map(|mut load| {
            load.freedom += freedom;
            load
        }));
        forces.wrenches.extend(theirs.wrenches.into_iter().map(|mut wrench| {
            wrench.body += first;
            wrench
        }));
        forces.point_springs.extend(theirs.point_springs.into_iter().map(|spring| PointSpring {
            a: there(spring.a),
            b: there(spring.b),
            ..spring
        }));
        state.position.extend(own.position);
        state.velocity.extend(own.velocity);
        state.compensation.extend(own.compensation);
    }
    let mut mechanism = Mechanism::new("side_by_side", models::gravity(), bodies).expect("depth first");
    (mechanism.loops, mechanism.forces) = (loops, forces);
    Model { mechanism, state }
}

fn parts(model: Model) -> (Mechanism, State) {
    (model.mechanism, model.state)
}

/// Trees, a tree with every force, and two four-bars with a loop each.
fn zoo() -> Model {
    let forced = models::floating_tree();
    let every = models::every_force(&forced.mechanism).pop().expect("all forces").1;
    side_by_side(vec![
        parts(models::double_pendulum()),
        parts(models::with_forces(forced, every)),
        closed::four_bars(1, 5),
        parts(models::chain(6)),
        parts(models::one_joint(JointKind::Spherical)),
    ])
}

fn spring_between(a: usize, b: usize) -> PointSpring {
    PointSpring {
        name: format!("spring {a} {b}"),
        a: models::point_of(Some(a), [0.1, 0.0, 0.2]),
        b: models::point_of(Some(b), [0.0, -0.1, 0.1]),
        stiffness: 30.0,
        damping: 0.3,
        rest_length: 0.4,
    }
}

/// A forest of random trees with random couplings.
fn random_mechanism(numbers: &mut Numbers) -> Model {
    let count = numbers.next(1.0, 14.0) as usize;
    let mut bodies = Vec::new();
    let mut branch: Vec<usize> = Vec::new();
    for index in 0..count {
        let depth = numbers.next(0.0, 1.8 * branch.len() as f64 + 0.9) as usize;
        branch.truncate(depth);
        let kind = models::JOINT_KINDS[numbers.next(0.0, models::JOINT_KINDS.len() as f64) as usize];
        let place = Vector3::new(numbers.next(-1.0, 1.0), numbers.next(-1.0, 1.0), numbers.next(-1.0, 1.0));
        let joint =
            Joint::new(&format!("joint{index}"), kind, Pose::translation(place.x, place.y, place.z), Pose::identity());
        let inertia = Vector3::new(0.1, 0.2, 0.25);
        bodies.push(models::body(&format!("body{index}"), branch.last().copied(), 1.0, inertia, joint));
        branch.push(index);
    }
    let mut mechanism = Mechanism::new("random", models::gravity(), bodies).expect("depth first");
    let mut state = State::zero(&mechanism);
    let displaced: Vec<f64> = (0..mechanism.velocity_count).map(|_| numbers.next(-1.0, 1.0)).collect();
    state.displace(&mechanism, &displaced);
    state.velocity.iter_mut().for_each(|rate| *rate = numbers.next(-1.0, 1.0));
    let any = |numbers: &mut Numbers| numbers.next(0.0, count as f64) as usize;
    let scalar = |mechanism: &Mechanism, body: usize| {
        let joint = &mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    for _ in 0..numbers.next(0.0, 3.0) as usize {
        let (a, b) = (any(numbers), any(numbers));
        mechanism.forces.point_springs.push(spring_between(a, b));
        let world = if numbers.next(0.0, 1.0) < 0.5 { None } else { Some(any(numbers)) };
        let ends = (models::point_of(Some(any(numbers)), [0.1; 3]), models::point_of(world, [0.3; 3]));
        mechanism.loops.push(LoopJoint { name: "loop".into(), kind: LoopKind::Spherical, a: ends.0, b: ends.1 });
    }
    if numbers.next(0.0, 1.0) < 0.5 {
        let (follower, leader) = (scalar(&mechanism, any(numbers)), scalar(&mechanism, any(numbers)));
        mechanism.mimics.push(Mimic { name: "mimic".into(), follower, leader, multiplier: 2.0, offset: 0.0 });
    }
    let Forces { joint_dampers, joint_loads, wrenches, .. } = models::every_force(&mechanism).pop().expect("all").1;
    mechanism.forces = Forces { joint_dampers, joint_loads, wrenches, ..mechanism.forces };
    Model { mechanism, state }
}

/// Which bodies can be reached from each, by trying every edge again and again.
fn reachable(mechanism: &Mechanism) -> BTreeSet<BTreeSet<usize>> {
    let mut edges: Vec<(usize, usize)> = Vec::new();
    edges.extend(mechanism.bodies.iter().enumerate().filter_map(|(index, body)| Some((index, body.parent?))));
    edges.extend(mechanism.loops.iter().filter_map(|joint| joint.a.body.zip(joint.b.body)));
    edges.extend(mechanism.mimics.iter().map(|mimic| (mimic.follower.body, mimic.leader.body)));
    edges.extend(mechanism.forces.point_springs.iter().filter_map(|spring| spring.a.body.zip(spring.b.body)));
    let from = |body: usize| {
        let mut seen = BTreeSet::from([body]);
        for _ in 0..mechanism.bodies.len() {
            for &(a, b) in &edges {
                if seen.contains(&a) || seen.contains(&b) {
                    seen.extend([a, b]);
                }
            }
        }
        seen
    };
    (0..mechanism.bodies.len()).map(from).collect()
}

#[test]
fn islands_are_what_a_search_of_the_graph_finds_and_each_is_the_mechanism_it_would_be_alone() {
    let mut numbers = Numbers::new(6);
    let mut several = 0;
    for case in 0..300 {
        let Model { mechanism, state } = random_mechanism(&mut numbers);
        let found = islands(&mechanism);
        several += usize::from(found.len() > 1);
        let of = |island: &catena::model::Island| -> BTreeSet<usize> {
            island.pieces.iter().flat_map(|piece| piece.bodies.clone()).collect()
        };
        assert_eq!(found.iter().map(of).collect::<BTreeSet<_>>(), reachable(&mechanism), "case {case}");
        assert_eq!(found.iter().map(|island| of(island).len()).sum::<usize>(), mechanism.bodies.len(), "case {case}");

        let whole = body_states(&mechanism, &state);
        let Stored { spring, load } = stored(&mechanism, &state.position, &whole);
        let (mut springs, mut loads, mut rebuilt) = (0.0, 0.0, State::zero(&mechanism));
        for island in &found {
            let own = island.state(&state);
            let mut bodies = vec![catena::kinematics::WORLD; whole.len()];
            let alone = body_states(&island.mechanism, &own);
            island.put(&alone, &mut bodies, |piece| &piece.bodies);
            for body in of(island) {
                assert_eq!(bodies[body], whole[body], "case {case}: body {body} is elsewhere");
            }
            island.put(&own.position, &mut rebuilt.position, |piece| &piece.positions);
            island.put(&own.velocity, &mut rebuilt.velocity, |piece| &piece.velocities);
            let theirs = stored(&island.mechanism, &own.position, &alone);
            (springs, loads) = (springs + theirs.spring, loads + theirs.load);
        }
        assert_eq!(rebuilt, state, "case {case}");
        // Sums of a few numbers of order ten in another order.
        assert!((springs - spring).abs() < 1e-11 && (loads - load).abs() < 1e-11, "case {case}: forces got lost");
        let count =
            |what: &dyn Fn(&Mechanism) -> usize| found.iter().map(|island| what(&island.mechanism)).sum::<usize>();
        assert_eq!(count(&|part| part.loops.len()), mechanism.loops.len(), "case {case}");
        assert_eq!(count(&|part| part.mimics.len()), mechanism.mimics.len(), "case {case}");
        assert_eq!(count(&|part| part.forces.joint_dampers.len()), mechanism.forces.joint_dampers.len(), "case {case}");
    }
    assert!(several > 100, "only {several} cases have several islands");
}

#[test]
fn two_robots_with_a_spring_between_them_are_one_island() {
    let mut model =
        side_by_side(vec![parts(models::double_pendulum()), parts(models::chain(4)), parts(models::double_pendulum())]);
    assert_eq!(islands(&model.mechanism).len(), 3);
    model.mechanism.forces.point_springs.push(spring_between(1, 7));
    let found = islands(&model.mechanism);
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].pieces.len(), 2, "the first and the last robot, with another between them");
    assert_eq!(found[0].mechanism.bodies.len(), 4);
    // A spring to the world connects nobody.
    let to_world = PointSpring { b: models::point_of(None, [0.0; 3]), ..spring_between(3, 3) };
    model.mechanism.forces.point_springs.push(to_world);
    assert_eq!(islands(&model.mechanism).len(), 2);
}

/// Time, positions and velocities of a sample.
type Sampled = (f64, Vec<f64>, Vec<f64>);

/// What an observer saw.
#[derive(Clone, Debug, Default, PartialEq)]
struct Seen {
    samples: Vec<Sampled>,
}

impl Observer for Seen {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.samples.push((sample.time, sample.position.to_vec(), sample.velocity.to_vec()));
        Ok(())
    }
}

/// How the islands of a test are integrated.
#[derive(Clone, Copy)]
enum Way {
    Fixed(usize, f64),
    Tolerance(f64),
}

impl Way {
    fn integrator(self, mechanism: &Mechanism, state: &State, duration: f64) -> Lobatto {
        match self {
            Way::Fixed(stages, step) => {
                Lobatto::fixed(mechanism, stages, step).expect("a number of stages from 2 to 16")
            }
            Way::Tolerance(tolerance) => common::by_tolerance(mechanism, state, duration, tolerance),
        }
    }
}

fn run_islands(model: &Model, way: Way, options: &RunOptions, threads: usize) -> (State, Summary, Seen) {
    let plan = Plan::new(&model.mechanism, &model.state, &[]);
    let make = |part: &Mechanism, state: &State| Ok::<_, ()>((way.integrator(part, state, options.duration), ()));
    let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(threads), 1.0, make).expect("integrators");
    let (mut state, mut seen) = (model.state.clone(), Seen::default());
    let (summary, ended) = all.run(&model.mechanism, &mut state, options, &mut [&mut seen]);
    ended.unwrap_or_else(|error| panic!("{error}"));
    (state, Summary { solve_cpu_seconds: 0.0, ..summary }, seen)
}

#[test]
fn every_island_moves_as_if_it_were_alone_bit_for_bit_on_any_number_of_threads() {
    let model = zoo();
    for way in [Way::Fixed(5, 0.01), Way::Tolerance(1e-6)] {
        let options = RunOptions { duration: 1.0, rate: Some(37.0), interrupt: None };
        let (state, summary, seen) = run_islands(&model, way, &options, 1);
        for threads in [2, 5] {
            assert_eq!(
                (state.clone(), summary, seen.clone()),
                run_islands(&model, way, &options, threads),
                "{threads}"
            );
        }
        let (mut steps, mut iterations) = (0, 0);
        for island in islands(&model.mechanism) {
            let (mut alone, mut seen_alone) = (island.state(&model.state), Seen::default());
            let mut integrator = way.integrator(&island.mechanism, &alone, 1.0);
            let (figures, ended) =
                run(&island.mechanism, &mut alone, &mut integrator, &options, &mut [&mut seen_alone]);
            ended.expect("a run");
            assert_eq!(alone, island.state(&state), "{:?}", island.roots().collect::<Vec<_>>());
            assert_eq!(seen.samples.len(), seen_alone.samples.len());
            for (whole, own) in seen.samples.iter().zip(&seen_alone.samples) {
                let mut expected = whole.clone();
                island.put(&own.1, &mut expected.1, |piece| &piece.positions);
                island.put(&own.2, &mut expected.2, |piece| &piece.velocities);
                assert_eq!(own.0, whole.0);
                assert_eq!(*whole, expected, "t = {}", whole.0);
            }
            (steps, iterations) = (steps + figures.steps, iterations + figures.iterations);
        }
        assert_eq!((steps, iterations), (summary.steps, summary.iterations));
    }
}

#[test]
fn the_figures_of_a_run_of_islands_are_those_of_the_whole() {
    let model = zoo();
    let options = RunOptions { duration: 1.0, rate: None, interrupt: None };
    let (_, apart, seen) = run_islands(&model, Way::Fixed(6, 0.01), &options, 2);
    assert_eq!(seen.samples.len(), 2, "without a rate only both ends are shown");
    let mut whole = model.state.clone();
    let mut lobatto = Lobatto::fixed(&model.mechanism, 6, 0.01).expect("six stages");
    let together = common::run_until(&model.mechanism, &mut whole, &mut lobatto, 1.0);
    assert_eq!(apart.steps, 5 * together.steps);
    // The same scheme solved to rounding; energies are of order 10 J.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    near(apart.initial_energy.total(), together.initial_energy.total());
    near(apart.final_energy.total(), together.final_energy.total());
    near(apart.exchange.dissipated, together.exchange.dissipated);
    near(apart.exchange.work, together.exchange.work);
    assert!(together.exchange.dissipated > 1e-3, "the zoo dissipates");
    // What is not accounted for is the error of the quadrature of the damping in both; kinetic energies are of common times.
    let ratio = apart.max_relative_energy_error / together.max_relative_energy_error;
    assert!((0.5..2.0).contains(&ratio), "{apart:?} {together:?}");
    assert!(apart.max_violation.position < 1e-12, "{apart:?}");
}

#[test]
fn a_run_taken_up_again_goes_on_as_if_it_had_not_stopped() {
    let model = zoo();
    let make = |part: &Mechanism, _: &State| Lobatto::fixed(part, 4, 0.01).map(|lobatto| (lobatto, ()));
    let ends = [vec![1.0], vec![0.25, 0.75]].map(|durations| {
        let plan = Plan::new(&model.mechanism, &model.state, &[]);
        let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(2), 0.0, make).expect("integrators");
        let mut state = model.state.clone();
        for duration in durations {
            let options = RunOptions { duration, rate: None, interrupt: None };
            all.run(&model.mechanism, &mut state, &options, &mut []).1.expect("a run");
        }
        state
    });
    assert_eq!(ends[0], ends[1]);
}

/// Sets the flag at a sample.
struct Stopper<'f> {
    flag: &'f AtomicBool,
    at: f64,
    last: f64,
}

impl Observer for Stopper<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.flag.store(sample.time >= self.at, Ordering::Relaxed);
        self.last = sample.time;
        Ok(())
    }
}

#[test]
fn an_interrupted_run_ends_at_a_sample_that_all_islands_have_reached() {
    let model = zoo();
    let flag = AtomicBool::new(false);
    let plan = Plan::new(&model.mechanism, &model.state, &[]);
    let make = |part: &Mechanism, _: &State| Lobatto::fixed(part, 5, 0.01).map(|lobatto| (lobatto, ()));
    let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(2), 0.0, make).expect("integrators");
    let mut state = model.state.clone();
    let mut stopper = Stopper { flag: &flag, at: 0.3, last: 0.0 };
    let options = RunOptions { duration: 1e6, rate: Some(20.0), interrupt: Some(&flag) };
    let (summary, ended) = all.run(&model.mechanism, &mut state, &options, &mut [&mut stopper]);
    assert!(matches!(ended, Err(RunError::Interrupted { time }) if time == state.time), "{ended:?}");
    assert!(state.time >= 0.3 && state.time == stopper.last, "{} {}", state.time, stopper.last);
    assert!(state.time < 1e6 && summary.steps > 0);
    // All islands are at that instant: the zoo run to there by itself agrees as well as dense output does at this step.
    let mut exact = model.state.clone();
    let mut lobatto = Lobatto::fixed(&model.mechanism, 5, 0.01).expect("five stages");
    let _ = common::run_until(&model.mechanism, &mut exact, &mut lobatto, state.time);
    let distance =
        models::pose_distance(&body_states(&model.mechanism, &state), &body_states(&model.mechanism, &exact));
    assert!(distance < 1e-6, "{distance:.1e}");
}

#[test]
fn the_first_failure_ends_the_run_there_whatever_the_number_of_threads() {
    // A spring beyond what the step is stable for: the second island fails after some steps, the first would go on.
    let mut stiff = models::one_joint(JointKind::Prismatic);
    stiff.mechanism.forces = models::point_springs(&stiff.mechanism);
    stiff.mechanism.forces.point_springs[0].stiffness = 3e5;
    let model = side_by_side(vec![parts(models::chain(5)), parts(stiff)]);
    let ends: Vec<(State, Summary, String, usize)> = [1, 2]
        .map(|threads| {
            let plan = Plan::new(&model.mechanism, &model.state, &[]);
            let make = |part: &Mechanism, _: &State| Lobatto::fixed(part, 2, 0.02).map(|lobatto| (lobatto, ()));
            let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(threads), 0.0, make).expect("made");
            let (mut state, mut seen) = (model.state.clone(), Seen::default());
            let options = RunOptions { duration: 20.0, rate: Some(1000.0), interrupt: None };
            let (summary, ended) = all.run(&model.mechanism, &mut state, &options, &mut [&mut seen]);
            let error = ended.expect_err("too stiff").to_string();
            (state, Summary { solve_cpu_seconds: 0.0, ..summary }, error, seen.samples.len())
        })
        .into();
    println!("{}, {} samples", ends[0].2, ends[0].3);
    // What grew beyond all bounds is not a number, and equal to nothing but in print.
    assert_eq!(format!("{:?}", ends[0]), format!("{:?}", ends[1]));
    assert!(ends[0].0.time < 20.0 && ends[0].3 > 0);
}

/// A box on a hinge about y, its centre of mass 0.5 m below it at zero.
fn pendulum(angle: f64) -> (Mechanism, State) {
    let joint = Joint::new(
        "hinge",
        JointKind::Revolute,
        models::frame(Vector3::zeros(), Vector3::y()),
        models::frame(Vector3::new(0.0, 0.0, 0.5), Vector3::y()),
    );
    let inertia = models::box_inertia(1.0, Vector3::new(0.1, 0.1, 1.0));
    let mechanism = Mechanism::new("pendulum", models::gravity(), vec![models::body("rod", None, 1.0, inertia, joint)])
        .expect("one");
    let mut state = State::zero(&mechanism);
    state.position[0] = angle;
    (mechanism, state)
}

#[test]
fn rest_in_equilibrium_is_known_stable_or_not_and_nothing_else_is() {
    let rests = |(mechanism, state): (Mechanism, State)| is_at_rest(&mechanism, &state);
    assert!(rests(pendulum(0.0)), "hanging");
    assert!(rests(pendulum(std::f64::consts::PI)), "exactly upright, which π is to rounding");
    assert!(!rests(pendulum(1e-9)) && !rests(pendulum(std::f64::consts::PI - 1e-9)), "beside an equilibrium");
    assert!(!rests(pendulum(std::f64::consts::FRAC_PI_2)), "horizontal");
    let (mechanism, mut moving) = pendulum(0.0);
    moving.velocity[0] = 1e-300;
    assert!(!is_at_rest(&mechanism, &moving), "on its way through the equilibrium");

    let mut hanging = pendulum(0.0);
    hanging.0.forces.point_springs.push(PointSpring { rest_length: 1.0, damping: 0.0, ..spring_between(0, 0) });
    hanging.0.forces.point_springs[0].a = models::point_of(None, [0.0, 0.0, -3.0]);
    hanging.0.forces.point_springs[0].b = models::point_of(Some(0), [0.0, 0.0, -0.5]);
    assert!(rests(hanging.clone()), "pulled straight down");
    hanging.0.forces.point_springs[0].a = models::point_of(None, [0.1, 0.0, -3.0]);
    assert!(!rests(hanging), "pulled aside");

    let mut free = parts(models::free_body());
    free.1.velocity.fill(0.0);
    assert!(!rests(free.clone()), "falling");
    free.0.gravity = Vector3::zeros();
    assert!(rests(free.clone()), "in empty space");
    let turned = models::wrenches(&free.0).wrenches[0];
    free.0.forces.wrenches = vec![catena::forces::Wrench { force: Vector3::zeros(), ..turned }];
    assert!(!rests(free), "turned by a torque");

    // A square four-bar is in equilibrium when it hangs straight down, loops and all, and not when it leans.
    let lean = |angle: f64| {
        let (mechanism, mut state) = closed::four_bars(1, 5);
        state.velocity.fill(0.0);
        state.position.copy_from_slice(&[-angle, angle, -angle]);
        (mechanism, state)
    };
    assert!(rests(lean(std::f64::consts::FRAC_PI_2)), "hanging four-bar");
    assert!(!rests(lean(1.0)), "leaning four-bar");
}

#[test]
fn what_has_inertia_but_no_mass_is_at_rest_only_where_nothing_turns_it() {
    let (mut mechanism, state) = pendulum(0.0);
    mechanism.bodies[0].mass = 0.0;
    assert!(is_at_rest(&mechanism, &state), "without effort");
    mechanism.forces.joint_loads.push(JointLoad { freedom: 0, effort: 1e-20 });
    assert!(!is_at_rest(&mechanism, &state), "a driven rotor");
}

#[test]
fn no_gravity_is_so_strong_or_weak_that_what_it_pulls_aside_is_at_rest() {
    // The squares of these are infinite and zero.
    for pull in [1e200, 1e-200] {
        let (mut mechanism, state) = pendulum(0.0);
        mechanism.gravity = Vector3::new(pull, 0.0, 0.0);
        assert!(!is_at_rest(&mechanism, &state), "{pull} m/s²");
    }
}

#[test]
fn a_sleeping_island_stays_exactly_where_it_is_and_the_others_do_not_notice() {
    let model = side_by_side(vec![
        pendulum(0.0),
        parts(models::double_pendulum()),
        pendulum(std::f64::consts::PI),
        parts(models::chain(3)),
    ]);
    let plan = Plan::new(&model.mechanism, &model.state, &[]);
    assert_eq!((plan.islands.len(), plan.sleeping()), (4, 2));
    let options = RunOptions { duration: 1.0, rate: Some(50.0), interrupt: None };
    let (state, summary, seen) = run_islands(&model, Way::Fixed(5, 0.01), &options, 2);
    assert_eq!(summary.steps, 200, "two of four make steps");
    assert_eq!((state.position[0], state.position[3]), (0.0, std::f64::consts::PI));
    assert_eq!(seen.samples.len(), 51);
    for (time, position, velocity) in &seen.samples {
        assert_eq!((position[0], velocity[0], position[3]), (0.0, 0.0, std::f64::consts::PI), "t = {time}");
    }
    let mut alone = models::double_pendulum();
    let mut lobatto = Lobatto::fixed(&alone.mechanism, 5, 0.01).expect("five stages");
    common::run_until(&alone.mechanism, &mut alone.state, &mut lobatto, 1.0);
    assert_eq!(state.position[1..3], alone.state.position);
    let bodies = body_states(&model.mechanism, &state);
    assert_eq!(summary.final_energy, energy_with_forces(&model.mechanism, &state.position, &bodies));
    assert_eq!(summary.final_energy, energy(&model.mechanism, &bodies));
}

#[test]
fn small_islands_are_run_together_and_move_as_if_they_were_one_mechanism() {
    let model = side_by_side(vec![
        parts(models::double_pendulum()),
        parts(models::chain(9)),
        pendulum(0.0),
        parts(models::chain(3)),
        parts(models::one_joint(JointKind::Revolute)),
    ]);
    let plan = || Plan::new(&model.mechanism, &model.state, &[]);
    let sizes = |smallest: usize| {
        let grouped = plan().grouped(&model.mechanism, smallest);
        grouped.islands.iter().map(|(island, _)| island.mechanism.bodies.len()).collect::<Vec<_>>()
    };
    assert_eq!(sizes(1), [2, 9, 1, 3, 2]);
    assert_eq!(sizes(4), [7, 9, 1], "two and three, and the two left over");
    assert_eq!(sizes(100), [16, 1], "what sleeps stays apart");
    let grouped = plan().grouped(&model.mechanism, 4);
    let fixed = |part: &Mechanism, _: &State| Lobatto::fixed(part, 5, 0.01).map(|lobatto| (lobatto, ()));
    let group = &grouped.islands[0].0;
    let (mechanism, mut alone) = (group.mechanism.clone(), group.state(&model.state));
    let group = group.clone();
    let (mut all, _) = Islands::new(grouped, &model.state, Threads::Exactly(2), 0.0, fixed).expect("integrators");
    let mut state = model.state.clone();
    let options = RunOptions { duration: 1.0, rate: None, interrupt: None };
    all.run(&model.mechanism, &mut state, &options, &mut []).1.expect("a run");
    let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.01).expect("five stages");
    common::run_until(&mechanism, &mut alone, &mut lobatto, 1.0);
    assert_eq!(group.state(&state), alone);
    // The whole makes the same steps until one of them fails: then all of it halves, and here only the group that has to.
    let (mut apart, mut whole) = (model.state.clone(), model.state.clone());
    let options = RunOptions { duration: 0.3, rate: None, interrupt: None };
    let plan = plan().grouped(&model.mechanism, 4);
    let (mut all, _) = Islands::new(plan, &apart, Threads::Exactly(1), 0.0, fixed).expect("integrators");
    all.run(&model.mechanism, &mut apart, &options, &mut []).1.expect("a run");
    let mut lobatto = Lobatto::fixed(&model.mechanism, 5, 0.01).expect("five stages");
    assert_eq!(common::run_until(&model.mechanism, &mut whole, &mut lobatto, 0.3).rejected_steps, 0);
    let distance =
        models::pose_distance(&body_states(&model.mechanism, &apart), &body_states(&model.mechanism, &whole));
    // Roundings, which this fall amplifies a hundredfold.
    assert!(distance < 1e-11, "{distance:.1e}");
}

#[test]
fn what_sleeps_altogether_is_shown_all_the_same() {
    let model = side_by_side(vec![pendulum(0.0), pendulum(0.0)]);
    for (rate, expected) in [(Some(10.0), 21), (None, 2)] {
        let options = RunOptions { duration: 2.0, rate, interrupt: None };
        let (state, summary, seen) = run_islands(&model, Way::Tolerance(1e-6), &options, 2);
        assert_eq!((summary.steps, state.time, seen.samples.len()), (0, 2.0, expected));
        assert_eq!(seen.samples[expected - 1].0, 2.0);
    }
}

#[test]
fn a_rule_that_is_switched_off_does_not_apply() {
    let model = side_by_side(vec![pendulum(0.0), parts(models::double_pendulum())]);
    let counts = |kept: &[Rule]| {
        let plan = Plan::new(&model.mechanism, &model.state, kept);
        (plan.islands.len(), plan.sleeping(), plan.is_whole())
    };
    assert_eq!(counts(&[]), (2, 1, false));
    assert_eq!(counts(&[Rule::Sleep]), (2, 0, false));
    assert_eq!(counts(&[Rule::Islands]), (1, 0, true), "the whole moves");
    let Model { mechanism, state } = models::double_pendulum();
    assert!(Plan::new(&mechanism, &state, &[]).is_whole(), "one robot that moves is run as it always was");
}

const SCENE: &str = r#"
[scene]
name = "three"
[[robot]]
name = "slow"
urdf = "pendulum.urdf"
positions = { hinge = 0.5 }
[[robot]]
name = "fast"
urdf = "pendulum.urdf"
pose = { position = [0, 2, 0] }
velocities = { hinge = 9.0 }
[[robot]]
name = "still"
urdf = "pendulum.urdf"
pose = { position = [0, 4, 0] }
[simulation]
duration = 2.0
"#;

/// Runs the command line in a folder with the scene; returns exit code, standard output and standard error.
fn catena(test: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    let folder = command::folder(test);
    std::fs::write(folder.join("scene.toml"), SCENE).expect("written");
    let output = command::run(&folder, arguments);
    (output.status.code(), command::text(&output.stdout).to_string(), command::text(&output.stderr).to_string())
}

fn report(test: &str, arguments: &[&str]) -> serde_json::Value {
    let (code, out, err) = catena(test, arguments);
    assert_eq!(code, Some(0), "{err}");
    serde_json::from_str(&out).expect("one JSON object")
}

#[test]
fn the_report_says_which_islands_there_are_and_what_each_cost() {
    let apart = report("report", &["simulate", "scene.toml", "--json"]);
    assert_eq!((&apart["model"]["islands"], &apart["model"]["sleeping_islands"]), (&3.into(), &1.into()));
    let all = apart["islands"].as_array().expect("an array");
    assert_eq!(all.iter().map(|one| one["asleep"] == true).collect::<Vec<_>>(), [false, true], "small ones together");
    assert_eq!(all[0]["roots"], serde_json::json!(["slow/rod", "fast/rod"]));
    assert_eq!(all[1]["roots"][0], "still/rod");
    assert!(all[0]["steps"].as_u64() > Some(0) && all[1]["steps"] == 0, "{apart}");
    let together = report("report", &["simulate", "scene.toml", "--json", "--keep", "islands", "--keep", "sleep"]);
    assert_eq!((&together["model"]["islands"], together.get("islands")), (&1.into(), None));
    for joint in ["slow/hinge", "fast/hinge", "still/hinge"] {
        let position = |report: &serde_json::Value| report["joints"][joint]["position"].as_f64().expect("an angle");
        // Both are within the default tolerance of 1e-6 m, on rods of 0.6 m at most.
        assert!((position(&apart) - position(&together)).abs() < 4e-6, "{joint}");
    }
    let (_, text, _) = catena("report", &["simulate", "scene.toml", "--no-log"]);
    assert!(text.contains("islands     3, of which 1 at rest in equilibrium: not simulated"), "{text}");
}

#[test]
fn the_model_verb_shows_every_rule_with_its_condition_and_what_it_saves() {
    let (code, text, _) = catena("model", &["model", "scene.toml"]);
    assert_eq!(code, Some(0));
    for part in
        ["fixed_base", "3 links are no bodies", "3 islands", "--keep islands", "1 body, not simulated", "at rest"]
    {
        assert!(text.contains(part), "{part:?} in {text}");
    }
    let json = report("model", &["model", "scene.toml", "--json", "--keep", "sleep"]);
    let rules = json["rules"].as_array().expect("an array");
    let kept = |name: &str| rules.iter().find(|rule| rule["name"] == name).map(|rule| rule["kept"] == true);
    assert_eq!((kept("islands"), kept("sleep"), kept("fixed_base")), (Some(false), Some(true), Some(false)));
    assert_eq!(json["model"]["sleeping_islands"], 0);
}

#[test]
fn a_rule_that_does_not_exist_is_refused_with_the_list() {
    for verb in ["simulate", "model"] {
        for name in ["planet", "fixed_base", ""] {
            let (code, out, err) = catena("unknown", &[verb, "scene.toml", "--keep", name]);
            assert_eq!((code, out.as_str()), (Some(2), ""), "{err}");
            assert!(err.contains("islands, sleep") && err.trim_end().lines().count() == 1, "{err}");
        }
    }
}
