//! Ropes through several points, against closed forms and independent integrations: two weights over eyelets, a movable pulley, a blow, a weight
//! that circles or swings while the rope runs through an eyelet, a tendon along an arm, three bodies on one rope in free flight, and winches.

use crate::common::scratch;
use crate::scene_files::{joint, report};
use catena::prelude::Model;
use catena::report::Report;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const GRAVITY: f64 = 9.81;
/// Closed forms are met to this (m, m/s, J, N): tolerances of 1e-11 m, and their factors of some ten in energies and tensions.
const BOUND: f64 = 1e-10;

fn near(what: &str, (is, wanted): (f64, f64)) {
    assert!((is - wanted).abs() < BOUND, "{what}: {is} instead of {wanted}, off by {:.1e}", is - wanted);
}

/// A ball: name, mass (kg), place (m) and velocity [m/s].
type Ball<'b> = (&'b str, f64, [f64; 3], [f64; 3]);

/// A scene of balls on a rope; a point is a ball, or `world` with a place (m). `more` comes before the rope.
fn scene(
    folder: &str,
    more: &str,
    balls: &[Ball],
    points: &[(&str, [f64; 3])],
    [length, restitution]: [f64; 2],
) -> PathBuf {
    let mut text = more.to_string();
    for (name, mass, place, velocity) in balls {
        let _ = write!(
            text,
            "[[body]]\nname = \"{name}\"\nshape = {{ type = \"sphere\", radius = 0.05 }}\nmass = {mass}\n\
             pose.position = {place:?}\nvelocity = {{ linear = {velocity:?}, angular = [0, 0, 0] }}\n"
        );
    }
    let points: Vec<String> =
        points.iter().map(|(link, place)| format!("{{ link = \"{link}\", position = {place:?} }}")).collect();
    let _ = write!(
        text,
        "[[rope]]\nname = \"rope\"\npoints = [{}]\nlength = {length}\nrestitution = {restitution}\n",
        points.join(", ")
    );
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

fn run(file: &Path, duration: f64) -> Report {
    let end = report(file, &[], &[], Some(duration), 1e-11);
    // Energies of some 100 J are sums of hundreds of roundings of 1e-14.
    assert!(end.energy.max_relative_error < 1e-12, "{:?}", end.energy);
    end
}

fn place(report: &Report, name: &str) -> [f64; 3] {
    report.links.iter().find(|(own, _)| own == name).expect("a link").1.position
}

fn velocity(report: &Report, name: &str) -> [f64; 3] {
    report.links.iter().find(|(own, _)| own == name).expect("a link").1.linear_velocity
}

/// The tension at the end of a run (N).
fn tension(report: &Report) -> f64 {
    let [point] = report.contact.points.as_slice() else { panic!("{:?}", report.contact.points) };
    point.force.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[test]
fn two_weights_over_two_eyelets_move_as_atwood_says_with_one_tension_in_the_whole_rope() {
    let (one, other) = (3.0, 2.0);
    let balls = [("one", one, [-0.5, 0.0, -1.0], [0.0; 3]), ("other", other, [0.5, 0.0, -1.5], [0.0; 3])];
    let points = [("one", [0.0; 3]), ("world", [-0.5, 0.0, 0.0]), ("world", [0.5, 0.0, 0.0]), ("other", [0.0; 3])];
    let time = 0.5;
    let end = run(&scene("atwood", "", &balls, &points, [3.5, 0.0]), time);
    let falls = GRAVITY * (one - other) / (one + other);
    near("fall", (place(&end, "one")[2], -1.0 - 0.5 * falls * time * time));
    near("rise", (place(&end, "other")[2], -1.5 + 0.5 * falls * time * time));
    near("speed", (velocity(&end, "one")[2], -falls * time));
    near("tension", (tension(&end), 2.0 * one * other * GRAVITY / (one + other)));
    assert!(end.events.list.is_empty(), "{:?}", end.events.list);
}

#[test]
fn a_weight_on_an_eyelet_that_the_rope_carries_is_pulled_twice() {
    let (weight, counter) = (5.0, 2.0);
    let balls = [("weight", weight, [0.0, 0.0, -1.0], [0.0; 3]), ("counter", counter, [0.5, 0.0, -2.0], [0.0; 3])];
    let above = [0.0; 3];
    let points =
        [("world", above), ("weight", above), ("world", above), ("world", [0.5, 0.0, 0.0]), ("counter", above)];
    let time = 0.6;
    let end = run(&scene("movable_pulley", "", &balls, &points, [4.5, 0.0]), time);
    // M a = M g − 2 T and 2 m a = T − m g.
    let falls = GRAVITY * (weight - 2.0 * counter) / (weight + 4.0 * counter);
    near("fall", (place(&end, "weight")[2], -1.0 - 0.5 * falls * time * time));
    near("rise", (place(&end, "counter")[2], -2.0 + falls * time * time));
    near("tension", (tension(&end), counter * (GRAVITY + 2.0 * falls)));
}

#[test]
fn a_block_and_tackle_of_six_parts_holds_six_times_the_pull_at_rest() {
    // The rope runs six times between the hook and the block, and the pull is one kilogram.
    let up = [0.0; 3];
    let balls = [("block", 6.0, [0.0, 0.0, -0.7], [0.0; 3]), ("pull", 1.0, [1.0, 0.0, -0.3], [0.0; 3])];
    let mut points = vec![("world", up)];
    for _ in 0..3 {
        points.extend([("block", up), ("world", up)]);
    }
    points.extend([("world", [1.0, 0.0, 0.0]), ("pull", up)]);
    let end = run(&scene("tackle", "", &balls, &points, [6.0 * 0.7 + 1.0 + 0.3, 0.0]), 2.0);
    near("rests", (place(&end, "block")[2], -0.7));
    near("tension", (tension(&end), GRAVITY));
}

#[test]
fn a_slack_rope_over_an_eyelet_goes_taut_with_one_blow_on_both_weights() {
    let (one, other, restitution) = (3.0, 2.0, 0.4);
    let balls = [("one", one, [-0.5, 0.0, -1.0], [0.0; 3]), ("other", other, [0.5, 0.0, -0.8], [0.0, 0.0, -0.7])];
    let points = [("one", [0.0; 3]), ("world", [-0.5, 0.0, 0.0]), ("world", [0.5, 0.0, 0.0]), ("other", [0.0; 3])];
    let length = 3.3;
    // Both fall freely until 1 + 0.8 + 0.7 t + g t² = L − 1.
    let slack = length - 2.8;
    let taut = (-0.7 + (0.49 + 4.0 * GRAVITY * slack).sqrt()) / (2.0 * GRAVITY);
    let speeds = [GRAVITY * taut, 0.7 + GRAVITY * taut];
    let closes = speeds[0] + speeds[1];
    let reduced = one * other / (one + other);
    let blow = (1.0 + restitution) * reduced * closes;
    let more = 0.05;
    let end = run(&scene("reeved_blow", "", &balls, &points, [length, restitution]), taut + more);
    near("loss", (end.energy.impacts, 0.5 * reduced * closes * closes * (1.0 - restitution * restitution)));
    for (name, mass, speed, start) in [("one", one, speeds[0], -1.0), ("other", other, speeds[1], -0.8)] {
        let begins = if name == "one" { 0.0 } else { 0.7 };
        let at_blow = start - begins * taut - 0.5 * GRAVITY * taut * taut;
        let after = -speed + blow / mass;
        near(name, (place(&end, name)[2], at_blow + after * more - 0.5 * GRAVITY * more * more));
    }
    let [event] = end.events.list.as_slice() else { panic!("{:?}", end.events.list) };
    near("instant", (event.time, taut));
}

/// The state after a time by the classical Runge–Kutta method, whose error is far below the bound with so many steps.
fn integrated<const N: usize>(rates: impl Fn(&[f64; N]) -> [f64; N], start: [f64; N], time: f64) -> [f64; N] {
    const STEPS: usize = 40_000;
    let step = time / STEPS as f64;
    let along = |state: &[f64; N], rate: &[f64; N], part: f64| {
        std::array::from_fn::<f64, N, _>(|index| state[index] + part * step * rate[index])
    };
    let mut state = start;
    for _ in 0..STEPS {
        let first = rates(&state);
        let second = rates(&along(&state, &first, 0.5));
        let third = rates(&along(&state, &second, 0.5));
        let fourth = rates(&along(&state, &third, 1.0));
        for index in 0..N {
            state[index] += step / 6.0 * (first[index] + 2.0 * (second[index] + third[index]) + fourth[index]);
        }
    }
    state
}

#[test]
fn a_mass_that_circles_about_an_eyelet_keeps_its_angular_momentum_while_the_rope_runs_through() {
    // Without gravity; a force of 6 N pulls the other end along the axis.
    let (circling, hanging, force) = (1.5, 2.0, 6.0);
    let (radius, speed) = (0.6, 1.3);
    let balls = [
        ("circling", circling, [radius, 0.0, 0.0], [0.2, speed, 0.0]),
        ("hanging", hanging, [0.0, 0.0, -0.9], [0.0, 0.0, 0.2]),
    ];
    let points = [("circling", [0.0; 3]), ("world", [0.0; 3]), ("hanging", [0.0; 3])];
    let more = format!("[scene]\ngravity = [0, 0, 0]\n[[load]]\nlink = \"hanging\"\nforce = [0, 0, -{force}]\n");
    let time = 3.0;
    let end = run(&scene("hole", &more, &balls, &points, [radius + 0.9, 0.0]), time);
    let momentum = radius * speed;
    // (m + M) r̈ = m h²/r³ − F and φ̇ = h/r².
    let rates = |[r, rate, _]: &[f64; 3]| {
        [*rate, (circling * momentum * momentum / r.powi(3) - force) / (circling + hanging), momentum / (r * r)]
    };
    let [r, rate, angle] = integrated(rates, [radius, 0.2, 0.0], time);
    let [x, y, z] = place(&end, "circling");
    near("x", (x, r * angle.cos()));
    near("y", (y, r * angle.sin()));
    near("z", (z, 0.0));
    near("hanging", (place(&end, "hanging")[2], r - radius - 0.9));
    near("rate", (velocity(&end, "hanging")[2], rate));
    let [along, across, _] = velocity(&end, "circling");
    near("angular momentum", (x * across - y * along, momentum));
}

#[test]
fn a_weight_that_swings_on_a_rope_over_an_eyelet_moves_as_the_equations_of_its_angle_and_its_length_say() {
    let (heavy, swinging) = (2.4, 1.0);
    let (length, begins) = (0.8, 1.1_f64);
    let balls = [
        ("heavy", heavy, [-0.5, 0.0, -1.0], [0.0; 3]),
        ("swinging", swinging, [0.5 + length * begins.sin(), 0.0, -length * begins.cos()], [0.0; 3]),
    ];
    let points = [("heavy", [0.0; 3]), ("world", [-0.5, 0.0, 0.0]), ("world", [0.5, 0.0, 0.0]), ("swinging", [0.0; 3])];
    let time = 0.7;
    let end = run(&scene("swinging_atwood", "", &balls, &points, [1.0 + 1.0 + length, 0.0]), time);
    let rates = |[r, rate, angle, turns]: &[f64; 4]| {
        let pulls = swinging * r * turns * turns + GRAVITY * (swinging * angle.cos() - heavy);
        [*rate, pulls / (heavy + swinging), *turns, -(2.0 * rate * turns + GRAVITY * angle.sin()) / r]
    };
    let [r, _, angle, _] = integrated(rates, [length, 0.0, begins, 0.0], time);
    let [x, _, z] = place(&end, "swinging");
    near("x", (x, 0.5 + r * angle.sin()));
    near("z", (z, -r * angle.cos()));
    near("heavy", (place(&end, "heavy")[2], -1.0 + r - length));
}

#[test]
fn three_bodies_on_one_rope_in_free_flight_keep_their_momenta_and_the_length_of_the_rope() {
    // The eyelet is off the centre of the middle body, which turns.
    let balls = [
        ("a", 1.0, [0.0, 0.0, 0.0], [0.3, -0.4, 0.1]),
        ("b", 2.0, [1.0, 0.2, 0.0], [0.0, 0.5, -0.2]),
        ("c", 1.5, [1.7, -0.6, 0.3], [-0.1, 0.2, 0.6]),
    ];
    let points = [("a", [0.01, 0.02, 0.0]), ("b", [0.0, 0.04, 0.02]), ("c", [0.0, 0.0, -0.03])];
    let at = |index: usize| [0, 1, 2].map(|axis: usize| balls[index].2[axis] + points[index].1[axis]);
    let apart = |[a, b]: [[f64; 3]; 2]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt();
    let length = apart([at(0), at(1)]) + apart([at(1), at(2)]) + 1e-3;
    let file = scene("three_on_a_rope", "[scene]\ngravity = [0, 0, 0]\n", &balls, &points, [length, 0.7]);
    let moments = |report: &Report| {
        let mut sums = [0.0; 6];
        for (name, mass, ..) in balls {
            let (_, link) = report.links.iter().find(|(own, _)| own == name).expect("a link");
            let (x, v, spin) = (link.position, link.linear_velocity, link.angular_velocity);
            let inertia = 0.4 * mass * 0.05 * 0.05;
            for axis in 0..3 {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                sums[axis] += mass * v[axis];
                sums[3 + axis] += mass * (x[next] * v[last] - x[last] * v[next]) + inertia * spin[axis];
            }
        }
        sums
    };
    let [start, end] = [1e-6, 4.0].map(|time| run(&file, time));
    assert!(end.energy.impacts > 0.0, "the rope goes taut: {:?}", end.energy);
    for (number, (before, after)) in moments(&start).into_iter().zip(moments(&end)).enumerate() {
        near(&format!("momentum {number}"), (after, before));
    }
    assert!(end.contact.max_penetration < BOUND, "{:e}", end.contact.max_penetration);
}

/// An arm of two links in a plane, with a tendon from the world through an eyelet on the upper link to the lower link.
fn arm_with_tendon(folder: &str) -> PathBuf {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 -0.5'/><mass value='1'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' \
             ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, at: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/><origin xyz='{at}'/>\
             <axis xyz='0 1 0'/></joint>"
        )
    };
    let (upper, lower) = (link("upper"), link("lower"));
    let (shoulder, elbow) = (joint("shoulder", "base", "upper", "0 0 0"), joint("elbow", "upper", "lower", "0 0 -1"));
    let folder = scratch(folder);
    let urdf = format!("<robot name='r'><link name='base'/>{upper}{lower}{shoulder}{elbow}</robot>");
    std::fs::write(folder.join("r.urdf"), urdf).expect("a robot");
    let file = folder.join("scene.toml");
    let length = tendon(0.2, 0.6);
    let text = format!(
        "[[robot]]\nurdf = \"r.urdf\"\n[[rope]]\npoints = [{{ link = \"world\", position = [-0.3, 0, 0.1] }}, \
         {{ link = \"upper\", position = [-0.1, 0, -0.8] }}, {{ link = \"lower\", position = [-0.05, 0, -0.6] }}]\nlength = {length:?}\n"
    );
    std::fs::write(&file, text).expect("a scene");
    file
}

/// The length of the tendon for the angles of the shoulder and of the elbow (m).
fn tendon(shoulder: f64, elbow: f64) -> f64 {
    let turned = |angle: f64, [x, z]: [f64; 2]| [angle.cos() * x + angle.sin() * z, -angle.sin() * x + angle.cos() * z];
    let eyelet = turned(shoulder, [-0.1, -0.8]);
    let (knee, rest) = (turned(shoulder, [0.0, -1.0]), turned(shoulder + elbow, [-0.05, -0.6]));
    let end = [knee[0] + rest[0], knee[1] + rest[1]];
    (eyelet[0] + 0.3).hypot(eyelet[1] - 0.1) + (end[0] - eyelet[0]).hypot(end[1] - eyelet[1])
}

#[test]
fn a_tendon_through_an_eyelet_of_an_arm_ties_its_joints_as_their_reduced_equation_says() {
    let file = arm_with_tendon("arm_tendon");
    let time = 0.25;
    let start = [("shoulder", 0.2), ("elbow", 0.6)];
    let end = report(&file, &start, &[], Some(time), 1e-11);
    // At rest the joints are assembled on the taut rope to 1e-11 m, or 2e-10 J of 18.
    assert!(end.energy.max_relative_error < 1e-11, "{:?}", end.energy);
    assert_eq!(end.contact.points.len(), 1, "the tendon is taut all the time");
    // The elbow as a function of the shoulder, by Newton's method, and its derivatives by differences of fourth order.
    let elbow_of = |shoulder: f64| {
        let length = tendon(0.2, 0.6);
        let mut elbow = 0.6;
        for _ in 0..60 {
            let slope = (tendon(shoulder, elbow + 1e-6) - tendon(shoulder, elbow - 1e-6)) / 2e-6;
            elbow -= (tendon(shoulder, elbow) - length) / slope;
        }
        elbow
    };
    let slope_of = |shoulder: f64| {
        let [by_one, by_two] = [1e-3, 2e-3].map(|h| elbow_of(shoulder + h) - elbow_of(shoulder - h));
        (8.0 * by_one - by_two) / 12e-3
    };
    // One degree of freedom: ½ M(s) ṡ² + V(s) is its energy.
    let inertia = |shoulder: f64| {
        let (elbow, slope) = (elbow_of(shoulder), slope_of(shoulder));
        let both = 1.0 + slope;
        1.0 * 0.25 + 0.02 + 1.0 + (0.25 + 0.02) * both * both + elbow.cos() * both
    };
    let height = |shoulder: f64| -1.5 * shoulder.cos() - 0.5 * (shoulder + elbow_of(shoulder)).cos();
    let (s, rate) = joint(&end, "shoulder");
    let energy = 0.5 * inertia(s) * rate * rate + GRAVITY * (height(s) - height(0.2));
    // The slope has the error of a difference of fourth order, 1e-12.
    near("energy of the reduced equation", (energy, 0.0));
    near("elbow", (joint(&end, "elbow").0, elbow_of(s)));
    // The time from the start: t = ∫ ds/ṡ with s = s₀ + (s − s₀) u², which has no singularity at rest; Simpson's rule.
    let (first, count) = (0.2, 400);
    let integrand = |u: f64| {
        let u = u.max(1e-3);
        let at = first + (s - first) * u * u;
        2.0 * u * (s - first).abs() / (2.0 * GRAVITY * (height(first) - height(at)) / inertia(at)).sqrt()
    };
    let weight = |number: usize| match number {
        0 => 1.0,
        number if number == count => 1.0,
        number => [2.0, 4.0][number % 2],
    };
    let sum: f64 = (0..=count).map(|number| weight(number) * integrand(number as f64 / count as f64)).sum();
    let took = sum / (3.0 * count as f64);
    // Near rest the energy is a difference of heights, so that this check has fewer digits.
    assert!((took - time).abs() < 1e-7, "{took} s instead of {time} s");
}

#[test]
fn a_winch_is_a_slide_that_a_motion_moves_and_its_work_is_the_tension_times_its_way() {
    let folder = scratch("winch");
    let urdf = "<robot name='winch'><link name='base'/><link name='drum'><inertial><mass value='0.1'/>\
                <inertia ixx='0.001' iyy='0.001' izz='0.001' ixy='0' ixz='0' iyz='0'/></inertial></link>\
                <joint name='wind' type='prismatic'><parent link='base'/><child link='drum'/><axis xyz='-1 0 0'/>\
                <limit lower='-9' upper='9' effort='0' velocity='0'/></joint></robot>";
    std::fs::write(folder.join("winch.urdf"), urdf).expect("a robot");
    let (mass, speed, time) = (4.0, 0.3, 1.5);
    let text = format!(
        "[[robot]]\nurdf = \"winch.urdf\"\npose.position = [-0.5, 0, 2]\n\
         [[motion]]\njoint = \"wind\"\nposition = {{ formula = \"v*t\", v = {speed} }}\n\
         [[body]]\nname = \"load\"\nshape = {{ type = \"sphere\", radius = 0.05 }}\nmass = {mass}\npose.position = [0, 0, 1]\n\
         velocity = {{ linear = [0, 0, {speed}], angular = [0, 0, 0] }}\n\
         [[rope]]\npoints = [{{ link = \"drum\" }}, {{ link = \"world\", position = [0, 0, 2] }}, {{ link = \"load\" }}]\nlength = 1.5\n"
    );
    let file = folder.join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    let end = run(&file, time);
    near("height", (place(&end, "load")[2], 1.0 + speed * time));
    near("tension", (tension(&end), mass * GRAVITY));
    near("work", (end.energy.work, mass * GRAVITY * speed * time));
}

/// A load of 4 kg at rest, 1 m under a winch that pays out `length` over an eyelet 0.5 m beside it.
fn lift(folder: &str, length: &str) -> PathBuf {
    let text = format!(
        "[[body]]\nname = \"load\"\nshape = {{ type = \"sphere\", radius = 0.05 }}\nmass = 4.0\npose.position = [0.5, 0, -1]\n\
         [[rope]]\nname = \"cable\"\npoints = [{{ link = \"world\" }}, {{ link = \"world\", position = [0.5, 0, 0] }}, {{ link = \"load\" }}]\n\
         length = {length}\n"
    );
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

#[test]
fn a_length_in_time_lifts_with_the_tension_and_the_work_of_the_acceleration_and_slackens_when_it_outruns_the_fall() {
    let (rises, time) = (2.5, 0.6);
    let file = lift("lift", &format!("{{ formula = \"1.5 - a*t^2/2\", a = {rises} }}"));
    let up = run(&file, time);
    let way = 0.5 * rises * time * time;
    near("height", (place(&up, "load")[2], way - 1.0));
    near("paid out", (joint(&up, "cable/length").0, 1.5 - way));
    near("tension", (tension(&up), 4.0 * (GRAVITY + rises)));
    near("work", (up.energy.work, 4.0 * (GRAVITY + rises) * way));
    // Paid out at 15 m/s², faster than the fall; the winch then stops at its own longest, where the rope goes taut again.
    let outruns = lift("outruns", "{ formula = \"1.5 - a*t^2/2\", a = -15 }\nlongest = 9");
    let free = run(&outruns, time);
    near("fall", (place(&free, "load")[2], -1.0 - 0.5 * GRAVITY * time * time));
    near("work without tension", (free.energy.work, 0.0));
    assert!(free.contact.points.is_empty(), "{:?}", free.contact.points);
    // A table of times and lengths: at rest at both ends.
    let by_table = report(&lift("table", "[[0, 1.5], [0.5, 1.2], [1, 1.0]]"), &[], &[], Some(1.5), 1e-11);
    // Third derivatives of a spline jump inside steps, which keep to the tolerance.
    assert!(by_table.energy.max_relative_error < 1e-11, "{:?}", by_table.energy);
    near("height by a table", (place(&by_table, "load")[2], -0.5));
    near("work by a table", (by_table.energy.work, 4.0 * GRAVITY * 0.5));
}

#[test]
fn a_winch_pays_out_no_more_than_its_longest_stands_in_the_world_and_has_key_paths() {
    use catena::prelude::Simulation;
    let file = lift("longest", "{ formula = \"1.5 + v*t\", v = 0.2 }\nlongest = 1.7");
    let model = Model::load(&file).expect("a model");
    let mut simulation = Simulation::new(&model).duration(2.0);
    let error = simulation.run().expect_err("no more rope").to_string();
    assert!(error.contains("cable/length") && error.contains("longest") && error.contains("t = 1"), "{error}");
    let moved = Model::loader().set("rope.cable.length.v", -0.1).set("rope.cable.points.2.position.x", 0.6).load(&file);
    let mut simulation = Simulation::new(&moved.expect("a model")).duration(1.0);
    simulation.run().expect("a run");
    let end = simulation.finish().expect("a report");
    near("paid out", (joint(&end, "cable/length").0, 1.4));
    let text = std::fs::read_to_string(&file).expect("a scene");
    for (from, to, said) in [
        ("points = [{ link = \"world\" }", "points = [{ link = \"load\" }", "stands in the world"),
        ("{ formula = \"1.5 + v*t\", v = 0.2 }", "1.5", "longest"),
        ("{ formula = \"1.5 + v*t\", v = 0.2 }", "-1.5", "greater than zero"),
        ("\"cable\"", "\"load\"", "no robot has"),
    ] {
        std::fs::write(&file, text.replace(from, to)).expect("a scene");
        let error = Model::load(&file).expect_err("an error").to_string();
        assert!(error.contains(said), "{to}: {error}");
    }
}

#[test]
fn ropes_through_points_that_do_not_move_are_refused() {
    let balls = [("ball", 1.0, [0.0, 0.0, -1.0], [0.0; 3])];
    let points = [("ball", [0.0; 3]), ("ball", [0.01, 0.0, 0.0]), ("ball", [0.0, 0.02, 0.0])];
    let error = Model::load(&scene("reeved_idle", "", &balls, &points, [1.0, 0.0])).expect_err("an error").to_string();
    assert!(error.contains("rope \"rope\"") && error.contains("leave it out"), "{error}");
    let error =
        Model::load(&scene("reeved_one", "", &balls, &points[..1], [1.0, 0.0])).expect_err("an error").to_string();
    assert!(error.contains("rope \"rope\"") && error.contains("two points or more"), "{error}");
}
