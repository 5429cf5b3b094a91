//! Eleven classic experiments (`robots/classics`) give the number that theory gives.

use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, Scene, read_scene};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_6, PI, TAU};
use std::path::Path;

/// m/s².
const GRAVITY: f64 = 9.81;

/// An experiment that is run.
struct Experiment {
    model: &'static Model,
    simulation: Simulation<'static>,
    duration: f64,
}

impl Experiment {
    /// The scene of an experiment, with its tolerance.
    fn new(name: &str) -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/classics/{name}.toml"));
        let scene: Scene = read_scene(&file, &PackagePath::default()).expect("a scene");
        let (model, start) = Model::from_scene(&scene).expect("a model");
        // A run borrows its model; ten of them live as long as the tests.
        let model: &Model = Box::leak(Box::new(model));
        let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
        let duration = scene.simulation.duration.expect("a duration");
        let steps = StepChoice::Tolerance(scene.simulation.tolerance.expect("a tolerance"));
        let options = SimulationOptions::new(duration, steps);
        let simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
        Experiment { model, simulation, duration }
    }

    /// Goes on to a time (s).
    fn to(&mut self, time: f64) -> State {
        self.simulation.step_to(time).expect("steps");
        self.simulation.state().clone()
    }

    /// The state at the end.
    fn end(&mut self) -> State {
        self.to(self.duration)
    }

    /// The bodies in a state.
    fn bodies(&self, state: &State) -> Vec<BodyState> {
        body_states(&self.model.mechanism, state)
    }

    /// The events of the whole run.
    fn events(mut self) -> Vec<Event> {
        self.end();
        self.simulation.finish().events
    }
}

fn assert_near(found: f64, theory: f64, bound: f64) {
    println!("{found} for {theory}");
    assert!((found - theory).abs() <= bound, "{found} for {theory}: off by {:e}", found - theory);
}

/// The complete elliptic integral of the first kind, K(k) = π/(2 agm(1, √(1 − k²))).
fn elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    FRAC_PI_2 / a
}

#[test]
fn the_plane_of_foucaults_pendulum_turns_by_the_angle_of_the_planet_times_the_sine_of_the_latitude() {
    let mut foucault = Experiment::new("foucault");
    let state = foucault.end();
    let bodies = foucault.bodies(&state);
    let (earth, bob) = (&bodies[0], &bodies[1]);
    // Axes of the place, turning with the planet: x to the south, y to the east, z up.
    let up = Vector3::new(FRAC_PI_6.cos(), 0.0, FRAC_PI_6.sin());
    let (south, east) = (Vector3::new(up.z, 0.0, -up.x), Vector3::y());
    let pivot = earth.rotation * up * 1e4;
    let arm = bob.position - pivot;
    let rate = bob.velocity - earth.angular_velocity.cross(&bob.position);
    let along = |v: &Vector3<f64>| [v.dot(&(earth.rotation * south)), v.dot(&(earth.rotation * east))];
    let ([x, y], [u, v]) = (along(&arm), along(&rate).map(|rate| rate / (GRAVITY / 10.0).sqrt()));
    // The long axis of the ellipse through (x, y) with the velocity (u, v) at a phase of a quarter.
    let angle = 0.5 * (2.0 * (x * y + u * v)).atan2(x * x + u * u - y * y - v * v);
    // Seen from above, with the south to the right and the east up, clockwise is negative: on the northern half. The swing of 0.02 rad turns by 1e-4
    // of that angle, and the plumb line is off by 5e-5 m of 0.2 m: 2e-4 each.
    assert_near(angle, -1e-4 * FRAC_PI_6.sin() * 1e4, 5e-4);
}

#[test]
fn a_box_about_its_middle_axis_turns_over_after_the_time_of_eulers_equations() {
    let mut box_ = Experiment::new("dzhanibekov");
    let state = box_.end();
    let body = &box_.bodies(&state)[0];
    let spin = body.rotation.transpose() * body.angular_velocity;
    // Landau and Lifshitz, Mechanics, § 37, for an angular momentum below that about the middle axis.
    let moment = |a: f64, b: f64| (a * a + b * b) / 12.0;
    let [least, middle, most] = [moment(0.1, 0.2), moment(0.3, 0.1), moment(0.3, 0.2)];
    let energy = least * 0.01 + middle * 100.0;
    let square = (least * 0.1).powi(2) + (middle * 10.0).powi(2);
    let rate = ((least - middle) * (square - energy * most) / (least * middle * most)).sqrt();
    let modulus = ((middle - most) * (energy * least - square) / ((least - middle) * (square - energy * most))).sqrt();
    assert_near(box_.duration, 2.0 * elliptic(modulus) / rate, 1e-12);
    // Errors of 1e-8 rad grow by a factor of some hundred while it turns over.
    assert_near(spin.z, -10.0, 1e-6);
    assert_near(spin.x.abs(), 0.1, 1e-6);
    assert_near(spin.y, 0.0, 1e-5);
}

#[test]
fn a_gyroscope_in_steady_precession_is_where_it_was_after_one_turn() {
    let mut gyroscope = Experiment::new("gyroscope");
    let (tilt, spin, mass, length, about_pivot, own) = (1.0_f64, 100.0, 1.0, 0.2, 0.05, 0.01);
    let momentum: f64 = own * spin;
    let of_fall = 4.0 * about_pivot * tilt.cos() * mass * GRAVITY * length;
    let precession = (momentum - (momentum * momentum - of_fall).sqrt()) / (2.0 * about_pivot * tilt.cos());
    let turn = TAU / precession;
    assert_near(gyroscope.duration, turn, 1e-12);
    for quarter in 1..=4 {
        let state = gyroscope.to(turn * f64::from(quarter) / 4.0);
        let axis = gyroscope.bodies(&state)[0].position / length;
        let angle = FRAC_PI_2 * f64::from(quarter);
        let theory = Vector3::new(tilt.sin() * angle.cos(), tilt.sin() * angle.sin(), tilt.cos());
        // The tolerance of 1e-8 m over 0.2 m.
        assert!((axis - theory).norm() < 1e-7, "{axis} for {theory}");
    }
}

#[test]
fn a_chaotic_double_pendulum_does_not_turn_over_below_the_energy_that_this_takes() {
    let mut chaos = Experiment::new("chaos");
    let (mut upper, mut lower) = (0.0_f64, 0.0_f64);
    for sample in 1..=6000 {
        let state = chaos.to(chaos.duration * f64::from(sample) / 6000.0);
        upper = upper.max(state.position[0].abs());
        lower = lower.max((state.position[0] + state.position[1]).abs());
    }
    println!("{upper} {lower} rad");
    // 2 cos θ₁ + cos θ₂ is at least 1.05, by the energy.
    assert!(upper <= f64::acos(0.025) + 1e-6, "{upper} rad");
    assert!(lower <= f64::acos(-0.95) + 1e-6, "{lower} rad");
    // It comes near to turning over.
    assert!(lower > 2.6, "{lower} rad");
}

#[test]
fn the_last_ball_of_a_cradle_rises_as_far_as_the_first_one_fell() {
    let mut cradle = Experiment::new("cradle");
    // Balls of 0.2 kg and 5 cm on rods of 1 m without mass.
    let inertia = 1.0 + 0.4 * 0.05 * 0.05;
    let half_period = 2.0 * elliptic(0.25_f64.sin()) * (inertia / GRAVITY).sqrt();
    assert_near(cradle.duration, half_period, 1e-12);
    let state = cradle.end();
    for (ball, theory) in [0.0, 0.0, 0.0, 0.0, -0.5].into_iter().enumerate() {
        assert_near(state.position[ball], theory, 1e-8);
    }
}

#[test]
fn a_block_slides_and_a_ball_rolls_down_an_incline_as_far_as_theory_says() {
    let mut inclines = Experiment::new("inclines");
    let start = inclines.bodies(inclines.simulation.state());
    let state = inclines.end();
    let end = inclines.bodies(&state);
    let gone = |body: usize| (end[body].position - start[body].position).norm();
    let slope = FRAC_PI_6;
    assert_near(gone(0), 0.5 * GRAVITY * (slope.sin() - 0.2 * slope.cos()), 1e-7);
    assert_near(gone(1), 5.0 / 14.0 * GRAVITY * slope.sin(), 1e-7);
}

#[test]
fn a_ladder_leaves_the_wall_at_two_thirds_of_its_height() {
    let ladder = Experiment::new("ladder");
    let body = &ladder.model.mechanism.bodies[0];
    // Its ends are 2 m apart: θ̇² = c (sin θ₀ − sin θ), with a moment of inertia about its middle of a capsule.
    let c = 2.0 * body.mass * GRAVITY / (body.inertia.max() + body.mass);
    let (start, leaves) = (FRAC_PI_3, (2.0 / 3.0 * FRAC_PI_3.sin()).asin());
    // θ = θ₀ − w², by Simpson's rule.
    let slowness = |w: f64| match w > 1e-6 {
        true => 2.0 * w / (c * (start.sin() - (start - w * w).sin())).sqrt(),
        false => 2.0 / (c * start.cos()).sqrt(),
    };
    let (parts, end) = (2000, (start - leaves).sqrt());
    let sum: f64 = (0..=parts)
        .map(|part| {
            let weight = if part == 0 || part == parts { 1.0 } else { f64::from(2 + 2 * (part % 2)) };
            weight * slowness(end * f64::from(part) / f64::from(parts))
        })
        .sum();
    let theory = sum * end / (3.0 * f64::from(parts));
    let events = ladder.events();
    let release = events.iter().find(|event| event.kind == EventKind::Release).expect("it leaves the wall");
    assert_near(release.time, theory, 1e-8);
}

#[test]
fn a_bouncing_ball_rests_after_the_sum_of_its_bounces() {
    let events = Experiment::new("bouncing_ball").events();
    let rest = events.iter().find(|event| event.kind == EventKind::Rest).expect("it comes to rest");
    let fall = (2.0 / GRAVITY).sqrt();
    // Bounces below 1e-4 of the tolerance are left out: √(1e-10 m) of time.
    assert_near(rest.time, fall * 1.7 / 0.3, 1e-5);
}

#[test]
fn the_heavy_mass_of_atwoods_machine_falls_with_the_part_of_the_masses() {
    let mut atwood = Experiment::new("atwood");
    let state = atwood.end();
    assert_near(state.position[0], 0.5 * GRAVITY * 0.2 / 2.2, 1e-12);
    assert_near(state.position[1], -0.5 * GRAVITY * 0.2 / 2.2, 1e-12);
}

#[test]
fn coupled_oscillators_hand_over_their_motion_in_half_a_beat() {
    let mut oscillators = Experiment::new("coupled_oscillators");
    let (slow, fast) = (40_f64.sqrt(), 7.0);
    let time = PI / (fast - slow);
    assert_near(oscillators.duration, time, 1e-12);
    let state = oscillators.end();
    let theory = [1.0, -1.0].map(|sign| 0.05 * ((slow * time).cos() + sign * (fast * time).cos()));
    assert_near(state.position[0], theory[0], 1e-8);
    assert_near(state.position[1], theory[1], 1e-8);
    // The motion of the first one is the part (ω₂ − ω₁)/(ω₂ + ω₁) of that of the second one.
    let part = (fast - slow) / (fast + slow);
    assert!(state.velocity[0].abs() <= 1.01 * part * state.velocity[1].abs().max(0.6), "{:?}", state.velocity);
}

/// The spin of the rattleback about the vertical after each step of `step` s, by its own equations: with the normal n, the spin ω and the moments I
/// in the axes of the body, an ellipsoid of the semi-axes A that rolls on a plane touches it at `r = −A² n/√(nᵀ A² n)`, and
///
/// ```text
///     ṅ = −ω × n,   v = −ω × r,   (I + m (|r|² − r rᵀ)) ω̇ = −ω × I ω + m r × (ω × v − ω × ṙ + g n)
/// ```
///
/// by Runge's and Kutta's method of order four.
fn rolling_spins(duration: f64, step: f64) -> Vec<f64> {
    let squares = Matrix3::from_diagonal(&Vector3::new(0.01, 4e-4, 4e-4));
    let (sine, cosine) = 5_f64.to_radians().sin_cos();
    let turn = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
    let moments = turn * Matrix3::from_diagonal(&Vector3::new(3e-5, 5e-4, 5.2e-4)) * turn.transpose();
    let mass = 0.2;
    let rates = |(n, spin): (Vector3<f64>, Vector3<f64>)| {
        let turned = -spin.cross(&n);
        let size = n.dot(&(squares * n)).sqrt();
        let r = -squares * n / size;
        let moved = -squares * turned / size + squares * n * n.dot(&(squares * turned)) / size.powi(3);
        let velocity = -spin.cross(&r);
        let about = moments + mass * (Matrix3::identity() * r.norm_squared() - r * r.transpose());
        let pull = spin.cross(&velocity) - spin.cross(&moved) + GRAVITY * n;
        let torque = mass * r.cross(&pull) - spin.cross(&(moments * spin));
        (turned, about.try_inverse().expect("positive definite") * torque)
    };
    let (mut n, mut spin) = (Vector3::z(), Vector3::new(0.01, 0.02, -5.0));
    let steps = (duration / step).round() as usize;
    (0..steps)
        .map(|_| {
            let (a, b) = rates((n, spin));
            let (c, d) = rates((n + a * (step / 2.0), spin + b * (step / 2.0)));
            let (e, f) = rates((n + c * (step / 2.0), spin + d * (step / 2.0)));
            let (g, h) = rates((n + e * step, spin + f * step));
            n += (a + (c + e) * 2.0 + g) * (step / 6.0);
            spin += (b + (d + f) * 2.0 + h) * (step / 6.0);
            n.dot(&spin)
        })
        .collect()
}

#[test]
fn a_rattleback_turns_its_spin_round_as_the_equations_of_a_rolling_body_say() {
    let mut rattleback = Experiment::new("rattleback");
    let spins = rolling_spins(rattleback.duration, 1e-4);
    let turned = spins.iter().position(|spin| *spin > 0.0).expect("it turns round") + 1;
    println!("it turns round after {} s", turned as f64 * 1e-4);
    assert_eq!(turned, 22309);
    // Runge's and Kutta's method is off by 1e-9 rad/s there, as half its step shows, and the tolerance is 1e-8 m of a stone of 0.1 m in a motion of
    // some rad/s: 1e-7 rad/s.
    for (at, bound) in [(5000, 1e-7), (turned, 1e-7), (spins.len(), 1e-7)] {
        let state = rattleback.to(at as f64 * 1e-4);
        let spin = rattleback.bodies(&state)[0].angular_velocity.z;
        assert_near(spin, spins[at - 1], bound);
    }
    assert!(spins[spins.len() - 1] > 4.9);
}
