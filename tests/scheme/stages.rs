//! The number of stages that a tolerance is given.

use crate::closed::four_bars;
use crate::common::{accuracy_of, by_tolerance, run_until};
use crate::models;
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::forces::JointDamper;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::distance::{distance, probes};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::parallel::islands::Islands;
use catena::simulation::parallel::partition::Plan;
use catena::simulation::parallel::threads::Threads;
use catena::stepping::integrator::Lobatto;
use catena::stepping::length::stage_choice::StageChoice;
use nalgebra::Vector3;
use std::path::PathBuf;

/// A scene of `robots/`, assembled.
fn scene(name: &str) -> (Mechanism, State) {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("robots").join(format!("{name}.toml"));
    let scene = read_scene(&file, &PackagePath::default()).unwrap_or_else(|error| panic!("{error}"));
    let (model, start) = Model::from_scene(&scene).unwrap_or_else(|error| panic!("{error}"));
    let mut state = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    assemble(&model.mechanism, &mut state).unwrap();
    (model.mechanism, state)
}

/// Where the bodies are after a run from `start`.
fn end(mechanism: &Mechanism, start: &State, duration: f64, mut lobatto: Lobatto) -> Vec<Vector3<f64>> {
    let mut state = start.clone();
    run_until(mechanism, &mut state, &mut lobatto, start.time + duration);
    probes(mechanism, &state)
}

#[test]
fn loops_have_five_stages_down_to_a_micrometre_and_everything_else_nine_on_every_processor() {
    let (few, many) = (5, 9);
    let (rows_of_ten, _) = four_bars(10, 5);
    let (two, _) = four_bars(2, 5);
    let mut damped = rows_of_ten.clone();
    damped.forces.joint_dampers.push(JointDamper { freedom: 0, coefficient: 0.1 });
    let (in_space, _) = scene("slider_crank");
    let (pendulum, chain, flat) =
        (models::spatial_pendulum().mechanism, models::chain(4).mechanism, models::planar_chain(10).mechanism);
    let mut damped_pendulum = pendulum.clone();
    damped_pendulum.forces.joint_dampers.push(JointDamper { freedom: 0, coefficient: 0.1 });
    let two_bodies = models::double_pendulum().mechanism;
    let pendulum_in_a_plane = models::planar_chain(3).mechanism;
    for (name, mechanism, tolerance, expected) in [
        ("ten four-bars", &rows_of_ten, 1e-1, few),
        ("ten four-bars", &rows_of_ten, 1e-6, few),
        ("ten four-bars", &rows_of_ten, 1e-7, many),
        ("a loop in space", &in_space, 1e-3, few),
        ("a loop in space", &in_space, 1e-9, many),
        ("two four-bars", &two, 1e-3, many),
        ("loops with a damper", &damped, 1e-3, few),
        ("one body", &pendulum, 1e-1, many),
        ("one body", &pendulum, 1e-12, many),
        ("two bodies", &two_bodies, 1e-2, many),
        ("two bodies", &two_bodies, 1e-3, many),
        ("one body with a damper", &damped_pendulum, 1e-9, many),
        ("four bodies", &chain, 1e-5, many),
        ("four bodies", &chain, 1e-6, many),
        ("three bodies in a plane", &pendulum_in_a_plane, 1e-5, many),
        ("three bodies in a plane", &pendulum_in_a_plane, 1e-6, many),
        ("ten bodies in a plane", &flat, 1e-8, many),
        ("ten bodies in a plane", &flat, 1e-9, many),
    ] {
        let stages = StageChoice::of(mechanism, tolerance);
        assert_eq!(stages.count(), expected, "{name}, {tolerance:e}");
        let lobatto = Lobatto::adaptive(mechanism, tolerance);
        assert_eq!(lobatto.description().stages, stages.count(), "{name}, {tolerance:e}: the integrator");
    }
}

/// What is too long for the simplified iteration may converge by the exact Newton method, at ten times the price and for the next fifty
/// steps as well.
#[test]
fn steps_of_a_tree_that_do_not_converge_are_made_shorter_and_not_exact() {
    for links in [30, 200] {
        let model = models::chain(links);
        for stop in [1e-3, 1e-4, 1e-5] {
            let mut lobatto = Lobatto::adaptive_with_stages(&model.mechanism, 1e4 * stop, stop, StageChoice::Many);
            let mut state = model.state.clone();
            let summary = run_until(&model.mechanism, &mut state, &mut lobatto, 0.2);
            assert!(summary.cost.rejected.total() > 0, "{links} links, stop {stop:e}: nothing was too long");
            assert_eq!(summary.exact_steps, 0, "{links} links, stop {stop:e}");
        }
    }
}

/// Five four-bars and the row of ten are the scenes where five stages come nearest to the tolerance: 0.4 of it, and with twice the
/// Legendre coefficient more than all of it.
#[test]
fn loops_with_five_stages_end_as_near_as_was_asked() {
    let five = four_bars(5, 5);
    let mut all = vec![("five four-bars", five, 3.0)];
    for (name, duration) in [
        ("four_bar_10", 3.0),
        ("four_bar_40", 2.0),
        ("ring_100", 0.2),
        ("strandbeest_leg", 3.0),
        ("andrews_squeezer", 0.03),
        ("slider_crank", 2.0),
        ("stewart_platform", 2.0),
        ("bricard", 3.6),
    ] {
        all.push((name, scene(name), duration));
    }
    for (name, (mechanism, start), duration) in all {
        let exact = Lobatto::adaptive_with_stages(&mechanism, 1e-9, 1e-16, StageChoice::Many);
        let truth = end(&mechanism, &start, duration, exact);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            assert_eq!(StageChoice::of(&mechanism, tolerance), StageChoice::Few, "{name}");
            let chosen = by_tolerance(&mechanism, &start, duration, tolerance);
            let error = distance(&end(&mechanism, &start, duration, chosen), &truth);
            println!("{name}, {tolerance:e}: {:.2} of it", error / tolerance);
            assert!(error < tolerance, "{name}: {error:e} instead of {tolerance:e}");
        }
    }
}

/// Runs of the ring that differ by 1 mm part within its first 1.6 seconds: those that do not have the steps of 1e-7 m.
#[test]
fn loops_that_restart_with_a_finer_stop_have_its_stages() {
    let (ring, start) = scene("ring_100");
    let [calm, chaotic] = [0.2, 1.6].map(|duration| accuracy_of(&ring, &start, duration, 1e-3));
    assert_eq!((calm.begun, calm.stages), (1, StageChoice::Few));
    assert!(chaotic.begun > 1 && chaotic.stages == StageChoice::Many, "{chaotic:?}");
}

/// The leaf springs of the first limit steps with five stages all along; the springs and dampers of the others do not.
#[test]
fn loops_whose_steps_stability_limits_are_run_with_nine_stages() {
    const FEW: [StageChoice; 3] = [StageChoice::Few; 3];
    for (name, duration, all) in [
        ("cassie_like_leg", 1.0, [StageChoice::Many; 3]),
        ("strandbeest_leg", 1.0, FEW),
        ("andrews_squeezer", 0.01, FEW),
        // Steps of 1e-6 m are so short at first that its springs bound one of them.
        ("stewart_platform", 5.0, [StageChoice::Few, StageChoice::Few, StageChoice::Many]),
    ] {
        let (mechanism, start) = scene(name);
        for (tolerance, expected) in [1e-2, 1e-4, 1e-6].into_iter().zip(all) {
            let found = accuracy_of(&mechanism, &start, duration, tolerance);
            println!("{name}, {tolerance:e}: {:?}, begun {} times", found.stages, found.begun);
            assert_eq!(StageChoice::of(&mechanism, tolerance), StageChoice::Few, "{name}, {tolerance:e}");
            assert_eq!(found.stages, expected, "{name}, {tolerance:e}");
        }
    }
}

#[test]
fn every_island_has_the_stages_of_its_own() {
    let (mut mechanism, mut state) = four_bars(10, 5);
    let chain = models::chain(10);
    let first = mechanism.bodies.len();
    let bodies = chain.mechanism.bodies.iter().cloned().map(|mut body| {
        body.parent = body.parent.map(|parent| parent + first);
        body
    });
    let all = mechanism.bodies.drain(..).chain(bodies).collect();
    let loops = std::mem::take(&mut mechanism.loops);
    mechanism = Mechanism::new("both", mechanism.gravity, all).expect("a mechanism");
    mechanism.loops = loops;
    state.position.extend(chain.state.position);
    state.compensation.extend(chain.state.compensation);
    state.velocity.extend(chain.state.velocity);
    let plan = Plan::new(&mechanism, &state, &[]);
    let (islands, _) = Islands::new(plan, &state, Threads::WherePaid, |part: &Mechanism, start: &State| {
        Ok::<_, ()>((by_tolerance(part, start, 0.1, 1e-4), ()))
    })
    .expect("integrators");
    let found: Vec<usize> = islands.figures().filter_map(|figures| Some(figures.method?.stages)).collect();
    assert_eq!(found, [StageChoice::Few, StageChoice::Many].map(|stages| stages.count()));
}
