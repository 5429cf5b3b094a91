//! A rod with round ends that falls on a rough floor: it sticks, slips, turns its slip round, and jams (Painlevé).
//!
//! Centre z = l cos θ + r, slip of the lower end ẋ − (l cos θ + r) θ̇.

use crate::contacts::over_floor;
use crate::exact::{answer, near};
use crate::loose::{DOWN, put};
use crate::mechanisms::{fixed, of_kind, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

/// Half the length of the rod, and the radius of its ends (m).
const HALF: f64 = 0.5;
const RADIUS: f64 = 0.01;

/// The rod of C6; its upper end meets the floor only if `both`.
pub fn rod(friction: f64, both: bool) -> Mechanism {
    let end = |z: f64| (Shape::Sphere { radius: RADIUS }, Pose::translation(0.0, 0.0, z));
    let ends = if both { vec![end(-HALF), end(HALF)] } else { vec![end(-HALF)] };
    let about = HALF * HALF / 3.0;
    over_floor(1.0, Vector3::new(about, about, 1e-3), ends, DOWN, friction, 0.0)
}

/// The rod leaning by an angle, with its lower end on the floor and a velocity of its centre.
pub fn leaning(rod: &Mechanism, angle: f64, velocity: f64) -> State {
    let mut state = State::zero(rod);
    let at = Vector3::new(0.0, 0.0, HALF * angle.cos() + RADIUS);
    let (turned, velocity) = (Vector3::y() * angle, Vector3::x() * velocity);
    put(rod, &mut state, 0, [at, turned, velocity, Vector3::zeros()]);
    state
}

/// θ and its rate, x and ẋ.
pub fn seen(state: &State) -> [f64; 4] {
    let angle = 2.0 * state.position[5].atan2(state.position[3]);
    [angle, state.velocity[4], state.position[0], state.velocity[0]]
}

/// What the rod does between its start and lying down, one line of the answer each.
struct Case {
    /// μ, the angle and the velocity that it starts with.
    start: [f64; 3],
    /// The first of its lines in the answer after its heading and, from rest, its first force.
    first: usize,
    /// What the lines are, without the last.
    events: &'static [EventKind],
}

/// The cases of C6.
const CASES: [Case; 5] = [
    Case { start: [0.2, 0.3, 0.0], first: 2, events: &[EventKind::Reversal] },
    Case { start: [0.35, 0.3, 0.0], first: 6, events: &[EventKind::Slip, EventKind::Reversal] },
    Case { start: [0.6, 0.3, 0.0], first: 11, events: &[EventKind::Slip] },
    Case { start: [0.3, 0.5, 1.0], first: 14, events: &[EventKind::Reversal, EventKind::Reversal] },
    Case { start: [0.3, 0.5, -1.0], first: 18, events: &[] },
];

#[test]
fn a_falling_rod_sticks_slips_and_turns_its_slip_round_when_the_answer_says() {
    let Some(lines) = answer("C6") else { return };
    for Case { start: [friction, angle, velocity], first, events } in CASES {
        let both = rod(friction, true);
        let start = leaning(&both, angle, velocity);
        let lies = &lines[first + events.len()];
        let finished = run(&both, &start, lies[0] + 0.01, fixed(9, 0.05));
        println!("mu {friction}: {:?}", finished.events);
        let mut found = finished.events.iter().filter(|event| event.time > 0.0);
        for (&kind, line) in events.iter().zip(&lines[first..]) {
            let event = found.next().expect("an event");
            assert_eq!(event.kind, kind, "mu {friction}: {event:?} for {line:?}");
            near(event.time, line[0], 1e-10);
            let there = run(&both, &start, line[0], fixed(9, 0.05)).state;
            let [turned, rate, x, _] = seen(&there);
            near(turned, line[1], 1e-10);
            near(rate, line[2], 1e-10);
            near(x, line[3], 1e-10);
        }
        let lands = found.next().expect("the other end meets the floor");
        assert_eq!((lands.kind, lands.pair), (EventKind::ContactImpact, Some(1)), "mu {friction}: {lands:?}");
        near(lands.time, lies[0], 1e-10);
    }
}

#[test]
fn a_falling_rod_lies_down_with_the_velocities_and_the_force_of_the_answer() {
    let Some(lines) = answer("C6") else { return };
    for Case { start: [friction, angle, velocity], first, events } in CASES {
        // The other end passes the floor, so that the instant is one without an event.
        let one = rod(friction, false);
        let lies = &lines[first + events.len()];
        let finished = run(&one, &leaning(&one, angle, velocity), lies[0], fixed(9, 0.05));
        let [turned, rate, x, along] = seen(&finished.state);
        near(turned, std::f64::consts::FRAC_PI_2, 1e-10);
        near(rate, lies[1], 1e-10);
        near(along, lies[2], 1e-10);
        near(x, lies[3], 1e-10);
        near(finished.state.position[2], RADIUS, 1e-12);
        assert_eq!(finished.contacts.len(), 1, "mu {friction}");
        // The force is one of accelerations, some hundred times as large as what they are of.
        near(finished.contacts[0].force.z.abs(), lies[4], 1e-9);
    }
}

#[test]
fn a_rod_that_no_acceleration_fits_is_stopped_by_an_impulse_within_the_cone() {
    let Some(lines) = answer("C7") else { return };
    let rod = rod(2.0, true);
    let start = leaning(&rod, 0.6, -1.0);
    let (impulse, next, later) = (&lines[1], &lines[3], &lines[4]);
    let soon = run(&rod, &start, 1e-9, fixed(9, 0.05));
    println!("{:?} {:?}", soon.events, soon.summary.exchange);
    let [_, rate, _, along] = seen(&soon.state);
    // After 1 ns at accelerations below 50 rad/s² and m/s².
    near(rate, impulse[3], 5e-8);
    near(along, impulse[4], 5e-8);
    near(soon.state.velocity[2], impulse[5], 5e-8);
    near(soon.summary.exchange.impacts, -impulse[6], 1e-12);
    assert!(soon.contacts.len() == 1 && soon.contacts[0].sticks, "{:?}", soon.contacts);
    // The force falls by its rate times 1 ns.
    near(soon.contacts[0].force.z.abs(), lines[2][1], 1e-6);
    let finished = run(&rod, &start, 0.6, fixed(9, 0.05));
    println!("{:?}", finished.events);
    let slips = of_kind(&finished, EventKind::Slip);
    near(slips[0].time, next[0], 1e-10);
    let there = seen(&run(&rod, &start, next[0], fixed(9, 0.05)).state);
    near(there[0], next[1], 1e-10);
    near(there[1], next[2], 1e-10);
    let there = seen(&run(&rod, &start, 0.2, fixed(9, 0.05)).state);
    near(there[2], later[0], 1e-10);
    near(there[0], later[1], 1e-10);
    near(there[1], later[2], 1e-10);
}

#[test]
fn a_jam_at_the_start_is_an_impact_whose_impulse_the_report_has() {
    let file = crate::common::scratch("jam_at_start").join("jam.toml");
    let scene = "[[body]]\nname = \"b\"\nshape = { type = \"box\", size = [0.02, 0.1, 1.0] }\nmass = 1.0\n\
         pose = { position = [0.23093694368319778, 0, 0.44358553633122844], rpy = [0, 0.5, 0] }\nvelocity.linear = [-2, 0, 0]\n\
         [[obstacle]]\nname = \"f\"\nshape = { type = \"half_space\" }\nfriction = 5.0\n";
    std::fs::write(&file, scene).expect("a scene");
    let end = crate::scene_files::report(&file, &[], &[], Some(1e-9), 1e-6);
    let impulse: f64 = end.events.list.iter().filter_map(|event| event.impulse).sum();
    let names: Vec<_> = end.events.list.iter().map(|event| (event.time, event.kind.as_str())).collect();
    assert!(names.contains(&(0.0, "contact_impact")), "{names:?}");
    // P = m v: forces of some 10 N add 1e-8 N s in the nanosecond.
    let lifted = end.links[0].1.linear_velocity[2];
    assert!(impulse > 0.1 && (impulse - lifted).abs() <= 1e-7, "{impulse} N s, {lifted} m/s");
    assert!(end.energy.impacts > 0.1, "{:?}", end.energy);
}
