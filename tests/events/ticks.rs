//! Ticks of sampled motors: a mode goes on over them while its forces stay in their sets, and ends at the tick at which one leaves.

use crate::exact::near;
use crate::mechanisms::*;
use catena::mechanism::description::contact::{Collider, ContactPair, Shape};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::nonsmooth::{Motor, MotorLaw};
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::contact_point::ContactPoint;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::session;
use catena::simulation::{Finished, Observer, ObserverError, Sample, Simulation, SimulationOptions, StepChoice};
use nalgebra::Vector3;
use std::ops::Range;
use std::path::Path;

/// A motor pushes a slider of 1.5 kg with 3 t N, as sampled every 10 ms; dry friction bears 2.4 N.
fn pushed(steps: StepChoice) -> Finished {
    let mut mechanism = mechanism(vec![slide("rail", Vector3::x(), 1.5)]);
    friction(&mut mechanism, 0, 2.4);
    let ramp = Target::table(&[(0.0, 0.0), (2.0, 6.0)], Interpolation::Linear).expect("a target");
    motor(&mut mechanism, 0, MotorLaw::Effort, ramp, f64::INFINITY, 0.01);
    run(&mechanism, &at_rest(&mechanism, &[0.0]), 1.5, steps)
}

#[test]
fn a_joint_that_sticks_slips_at_the_tick_whose_effort_friction_cannot_bear_and_at_no_other() {
    for steps in [fixed(9, 0.05), fixed(3, 0.013), StepChoice::Tolerance(1e-6), StepChoice::Unestimated(1e-6)] {
        let done = pushed(steps);
        // 3 t > 2.4 for the first time at the tick 0.81 s, since 0.8 s gives 2.4 N but for rounding.
        assert_eq!(done.events.len(), 1, "{steps:?} {:?}", done.events);
        assert_eq!(done.events[0].kind, EventKind::Slip);
        let tick = done.events[0].time;
        assert!((tick - 0.80).abs() < 1e-12 || (tick - 0.81).abs() < 1e-12, "{tick}");
        let [place, rate] = from_tick_to_tick(0.0, 81..150, |time| (3.0 * time - 2.4) / 1.5);
        near(done.state.position[0], place, 1e-13);
        near(done.state.velocity[0], rate, 1e-13);
    }
}

/// The quadruped of `robots/`, whose motors are sampled every millisecond, and its start.
fn sampled_quadruped() -> (Model, State) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/quadruped_dropped.toml");
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (mut model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    for motor in &mut model.mechanism.nonsmooth.motors {
        motor.period = 1e-3;
        // Softer than in the file: there a sampled damper is unstable, and every difference grows.
        motor.law = MotorLaw::Position { kp: 60.0, kd: 0.6 };
    }
    (model, start)
}

/// The same after 0.3 s. Pairs that are far apart are looked at seldom: each step is asked at many instants whether they are.
fn standing(steps: StepChoice) -> Finished {
    let (model, start) = sampled_quadruped();
    run(&model.mechanism, &start, 0.3, steps)
}

/// Place and rate after motions from tick to tick, 10 ms apart, under accelerations that are constant between them, from a place and rest.
fn from_tick_to_tick(mut place: f64, ticks: Range<i32>, acceleration: impl Fn(f64) -> f64) -> [f64; 2] {
    let (mut rate, period) = (0.0, 0.01);
    for tick in ticks {
        let acceleration = acceleration(period * f64::from(tick));
        place += rate * period + 0.5 * acceleration * period * period;
        rate += acceleration * period;
    }
    [place, rate]
}

#[test]
fn spans_between_ticks_have_few_stages_and_end_within_the_tolerance_of_steps_of_nine() {
    let exact = standing(fixed(9, 1e-3));
    assert_eq!(exact.method.few_stage_steps, 0, "given steps are as given");
    for (tolerance, least) in [(1e-3, 250), (1e-6, 250), (1e-9, 150)] {
        let found = standing(StepChoice::Unestimated(tolerance));
        let off = found.state.position.iter().zip(&exact.state.position).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        println!("{tolerance:e}: {off:e}, {} of {} steps", found.method.few_stage_steps, found.summary.steps);
        assert!(off < tolerance, "{tolerance:e}: {off:e}");
        assert_eq!(found.summary.events, exact.summary.events, "{tolerance:e}");
        assert!(found.summary.contact.penetration <= 1e-12);
        // 300 ticks and some events. While the robot lands, fine tolerances leave spans to five stages that three refuse.
        assert!(found.method.few_stage_steps >= least, "{}", found.method.few_stage_steps);
    }
}

/// The largest force of all contacts at all samples (N), and by how much one was outside its cone (N).
#[derive(Default)]
struct Cones {
    samples: usize,
    largest: f64,
    outside: f64,
}

impl Observer for Cones {
    fn sample(&mut self, _sample: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.samples += usize::from(points.len() > 3);
        for point in points {
            self.largest = self.largest.max(point.force.norm());
            self.outside = self.outside.max(point.cone_violation(0.6));
        }
    }
}

#[test]
fn forces_that_are_known_to_hold_a_box_at_ticks_are_inside_their_cones_where_they_are_worked_out() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/gripper_holds_box.toml");
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (mut model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    model.mechanism.nonsmooth.motors.iter_mut().for_each(|motor| motor.period = 1e-3);
    let found = [None, Some(1e3)].map(|rate| {
        let options = SimulationOptions::new(0.1, StepChoice::Unestimated(1e-6));
        let mut simulation = Simulation::new(&model.mechanism, start.clone(), options).expect("a run");
        let mut cones = Cones::default();
        if let Some(rate) = rate {
            simulation.sample_at(rate);
            simulation.observe(&mut cones);
        }
        simulation.run().expect("it runs");
        let done = simulation.finish();
        (done.state, done.summary.contact, cones)
    });
    let [(state, figures, _), (sampled, same, cones)] = found;
    assert_eq!((state, figures.cone_violation), (sampled, same.cone_violation));
    println!("{figures:?}, {} samples, {} N, outside by {:e} N", cones.samples, cones.largest, cones.outside);
    // Two faces of fingers against two of the box: eight forces, of which the law leaves many free. The fingers close within 25 ticks.
    assert!(cones.samples >= 75 && cones.largest > 2.0);
    assert!(cones.outside <= 1e-9 * cones.largest && figures.cone_violation <= 1e-9 * cones.largest);
}

#[test]
fn a_run_without_an_estimate_makes_the_steps_of_one_with_it() {
    let [with, without] = [StepChoice::Tolerance(1e-6), StepChoice::Unestimated(1e-6)].map(|steps| {
        let mechanism = double_pendulum(0.5);
        let options = SimulationOptions::new(1.0, steps);
        let start = at_rest(&mechanism, &[0.7, 0.4]);
        let mut simulation = Simulation::new(&mechanism, start, options).expect("a run");
        simulation.run().expect("it runs");
        simulation.finish()
    });
    assert!(with.accuracy[0].is_ok());
    assert!(without.accuracy[0].is_err());
    assert_eq!(with.state.position, without.state.position);
    assert_eq!(with.summary.steps, without.summary.steps);
}

/// A humanoid of 26 joints on its feet, whose hard motors are sampled every millisecond: the light hands shake, more than three stages can follow.
fn shaking(steps: StepChoice, duration: f64) -> Finished {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/humanoid.urdf");
    let loader = session::Model::loader().floating().base_pose([0.0, 0.0, 0.888, 0.0, 0.0, 0.0]).floor(0.0);
    let model = loader.load(&file).expect("a model").description().clone();
    let mut mechanism = model.mechanism.clone();
    for limit in model.mechanism.nonsmooth.limits.clone() {
        mechanism.nonsmooth.motors.push(Motor {
            coordinate: limit.coordinate,
            law: MotorLaw::Position { kp: 200.0, kd: 5.0 },
            target: Target::constant(0.0),
            max_effort: 20.0,
            period: 1e-3,
            held: None,
        });
    }
    let start = model.initial_state(&[], &[], None).expect("a start");
    let options = SimulationOptions::new(duration, steps);
    let mut simulation = Simulation::new(&mechanism, start, options).expect("a run");
    simulation.run().expect("it runs");
    simulation.finish()
}

#[test]
fn costly_spans_that_three_stages_cannot_make_are_stepped_over_where_the_tolerance_allows_it_and_late_where_an_error_is_estimated()
 {
    let duration = 0.1;
    let exact = shaking(StepChoice::Unestimated(1e-6), duration);
    let coarse = shaking(StepChoice::Unestimated(1e-3), duration);
    let told = shaking(StepChoice::Tolerance(1e-3), duration);
    let apart = |axis: usize| (coarse.state.position[axis] - exact.state.position[axis]).abs();
    let off = (0..3).map(apart).fold(0.0, f64::max);
    let times = [&exact, &coarse, &told].map(|run| run.method.first_order_time);
    println!("{times:?} s of first order, the pelvis {off:e} m off, {:?}", coarse.summary.contact);
    // The feet land after 10 ms, and jam for a microsecond.
    assert!(times[0] <= 1e-5 && times[1] > 0.8 * duration);
    // The smear of the landing is 0.3 · 0.1 m/s · 1 ms.
    assert!(off < 1e-4, "{off:e}");
    assert!(coarse.summary.contact.penetration <= 1e-9);
    // Ten milliseconds are looked at before a crowd begins, and the estimate looks 32 times: at least one look of 3 ms later. Up to the instant until which
    // the tolerance holds there is the jam alone.
    let told_until = told.accuracy[0].as_ref().expect("an estimate").holds_until;
    assert!(times[2] <= times[0] + duration - told_until && times[2] < times[1] - 3e-3, "{told_until}");
}

/// A ball of 1.5 kg on the floor of a vertical rail, whose motor lifts with 20 t N, as sampled every 10 ms.
fn lifted(steps: StepChoice) -> Finished {
    let mut mechanism = mechanism(vec![slide("rail", Vector3::z(), 1.5)]);
    let nonsmooth = &mut mechanism.nonsmooth;
    nonsmooth.colliders.push(Collider::still("floor", None, Pose::identity(), Shape::HalfSpace));
    nonsmooth.colliders.push(Collider::still("ball", Some(0), Pose::identity(), Shape::Sphere { radius: 0.1 }));
    nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 0.0, 0.0));
    let ramp = Target::table(&[(0.0, 0.0), (2.0, 40.0)], Interpolation::Linear).expect("a target");
    motor(&mut mechanism, 0, MotorLaw::Effort, ramp, f64::INFINITY, 0.01);
    run(&mechanism, &at_rest(&mechanism, &[0.1]), 1.0, steps)
}

#[test]
fn a_ball_whose_pressure_falls_from_tick_to_tick_parts_at_the_first_that_lifts_it() {
    for steps in [fixed(9, 0.05), fixed(3, 0.013), StepChoice::Tolerance(1e-6), StepChoice::Unestimated(1e-3)] {
        let done = lifted(steps);
        // 20 t > 1.5 · 9.81 for the first time at the tick 0.74 s. The pressure there before is 0.115 N, less than the jump of 0.2 N.
        let all: Vec<_> = done.events.iter().map(|event| event.kind).collect();
        assert_eq!(all, [EventKind::Release], "{steps:?}");
        near(done.events[0].time, 0.74, 1e-12);
        let [height, rate] = from_tick_to_tick(0.1, 74..100, |time| 20.0 * time / 1.5 - GRAVITY);
        near(done.state.position[0], height, 1e-13);
        near(done.state.velocity[0], rate, 1e-13);
    }
}

#[test]
fn legs_that_stand_and_are_told_to_jump_at_a_tick_leave_the_floor_as_in_steps_whose_forces_are_looked_at() {
    // The multipliers of the steps show that the mode lasts up to the tick at 0.25 s, whose efforts are others by far. Coarser tolerances meet a
    // seventh impact, too, of a foot that rebounds by less than they resolve.
    let jumping = |steps: StepChoice| {
        let (mut model, start) = sampled_quadruped();
        for motor in &mut model.mechanism.nonsmooth.motors {
            let rest = motor.target.value(0.0);
            motor.target =
                Target::table(&[(0.25, rest), (0.2501, 0.3 * rest)], Interpolation::Linear).expect("a target");
        }
        run(&model.mechanism, &start, 0.32, steps)
    };
    let (seen, exact) = (jumping(StepChoice::Unestimated(1e-8)), jumping(fixed(9, 1e-3)));
    println!("{:?}", exact.summary.events);
    assert_eq!(seen.summary.events, exact.summary.events);
    let late = |done: &Finished| {
        done.events.iter().filter(|event| event.time > 0.25).map(|event| event.time).collect::<Vec<_>>()
    };
    assert!(!late(&exact).is_empty());
    for (own, other) in late(&seen).into_iter().zip(late(&exact)) {
        near(own, other, 1e-7);
    }
    let off = seen.state.position.iter().zip(&exact.state.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6, "{off:e}");
}
