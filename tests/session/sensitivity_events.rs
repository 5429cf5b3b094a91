//! Derivatives of runs through their events: limits, dry friction, motors at their bounds, contacts, against closed forms and differences of runs.

use crate::{folder, robot};
use catena::prelude::*;
use catena::session::{Backward, Lost, Samples, Sensitivity};
use std::path::PathBuf;

/// Differences of order eight.
pub fn difference(of: &dyn Fn(f64) -> f64, width: f64) -> f64 {
    let pair = |k: f64| of(k * width) - of(-k * width);
    (pair(1.0) * 672.0 - pair(2.0) * 168.0 + pair(3.0) * 32.0 - pair(4.0) * 3.0) / (840.0 * width)
}

pub fn derivatives(model: &Model, stages: usize, step: f64, time: f64, keys: &[&str]) -> Sensitivity {
    let run = Simulation::new(model).fixed(stages, step).duration(time).without_figures();
    run.sensitivity(keys).unwrap_or_else(|error| panic!("{keys:?}: {error}"))
}

/// ∂q/∂θ and ∂v/∂θ at the end.
pub fn last(run: &Sensitivity, freedom: usize, key: usize) -> [f64; 2] {
    [&run.dq, &run.dv].map(|of| of.last().expect("steps")[(freedom, key)])
}

pub fn scene(name: &str, text: &str) -> PathBuf {
    let file = folder("sensitivity_events").join(name);
    std::fs::write(&file, text).expect("a file");
    file
}

/// A mass of 2 kg on a vertical slide with a lower limit, which rebounds.
fn ball_on_a_slide() -> Model {
    let urdf = "<robot name='ball'><link name='base'/><link name='ball'><inertial><mass value='2'/>\
        <inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/></inertial></link>\
        <joint name='slide' type='prismatic'><parent link='base'/><child link='ball'/><axis xyz='0 0 1'/>\
        <limit lower='0' upper='100' effort='0' velocity='0'/></joint></robot>";
    let urdf = scene("ball.urdf", urdf);
    let text = format!(
        "[[robot]]\nname = \"ball\"\nurdf = {urdf:?}\npositions = {{ slide = 1.0 }}\n\
         [[joint]]\nname = \"slide\"\nlimit = [0.0, 100.0]\nrestitution = 0.8\n"
    );
    Model::load(scene("ball.toml", &text)).expect("a model")
}

/// Height and speed after a change of a number.
type Moved<'m> = &'m dyn Fn(f64) -> [f64; 2];

/// Height and speed of a ball let go at h over a floor at `floor`, after n bounces.
fn bounced(h: f64, v: f64, g: f64, e: f64, floor: f64, time: f64) -> [f64; 2] {
    let h = h - floor;
    let speed = (v * v + 2.0 * g * h).sqrt();
    let (mut at, mut up) = ((v + speed) / g, e * speed);
    while at + 2.0 * up / g < time {
        at += 2.0 * up / g;
        up *= e;
    }
    let since = time - at;
    [floor + up * since - 0.5 * g * since * since, up - g * since]
}

#[test]
fn a_bouncing_ball_has_the_derivatives_of_its_closed_form() {
    let model = ball_on_a_slide();
    let keys = ["start.q.slide", "start.v.slide", "gravity.z", "slide.restitution", "slide.limit.lower", "ball.mass"];
    // Three impacts, at 0.45, 1.17 and 1.75 s.
    let time = 1.9;
    let run = derivatives(&model, 9, 0.1, time, &keys);
    let at = |h: f64, v: f64, g: f64, e: f64, floor: f64| bounced(1.0 + h, v, 9.81 + g, 0.8 + e, floor, time);
    let wanted: [[f64; 2]; 6] = std::array::from_fn(|key| {
        [0, 1].map(|part| {
            let of = |by: f64| match key {
                0 => at(by, 0.0, 0.0, 0.0, 0.0)[part],
                1 => at(0.0, by, 0.0, 0.0, 0.0)[part],
                2 => at(0.0, 0.0, -by, 0.0, 0.0)[part],
                3 => at(0.0, 0.0, 0.0, by, 0.0)[part],
                4 => at(0.0, 0.0, 0.0, 0.0, by)[part],
                _ => 0.0,
            };
            difference(&of, 1e-3)
        })
    });
    for (key, wanted) in wanted.into_iter().enumerate() {
        let found = last(&run, 0, key);
        println!("{}: {found:?} for {wanted:?}", run.keys[key]);
        for part in 0..2 {
            // The closed form's differences over 1e-3 leave 1e-13 of velocities of 5 m/s.
            let off = (found[part] - wanted[part]).abs();
            assert!(off < 1e-11, "{}: {off:e}", run.keys[key]);
        }
    }
    assert_eq!(run.events.len(), 3, "{:?}", run.events);
}

#[test]
fn a_ball_that_bounces_on_the_floor_has_the_derivatives_of_its_closed_form() {
    let model = Model::load(robot("ball_dropped.toml")).expect("a model");
    let keys = ["start.q", "floor.restitution", "gravity.z", "ball.collision.1.radius", "floor.pose.position.z"];
    let time = 1.9;
    let run = derivatives(&model, 9, 0.1, time, &keys);
    let z = run.keys.iter().position(|key| key.ends_with(".z") && key.starts_with("start")).expect("a height");
    let at = |h: f64, g: f64, e: f64, floor: f64| bounced(1.1 + h, 0.0, 9.81 + g, 0.8 + e, 0.1 + floor, time);
    let wanted: [(usize, Moved); 5] = [
        (z, &|by| at(by, 0.0, 0.0, 0.0)),
        (6, &|by| at(0.0, 0.0, by, 0.0)),
        (7, &|by| at(0.0, -by, 0.0, 0.0)),
        (8, &|by| at(0.0, 0.0, 0.0, by)),
        (9, &|by| at(0.0, 0.0, 0.0, by)),
    ];
    for (key, of) in wanted {
        let found = last(&run, z, key);
        let wanted = [0, 1].map(|part| difference(&|by| of(by)[part], 1e-3));
        println!("{}: {found:?} for {wanted:?}", run.keys[key]);
        for part in 0..2 {
            let off = (found[part] - wanted[part]).abs();
            assert!(off < 1e-11, "{}: {off:e}", run.keys[key]);
        }
    }
}

/// Derivatives at the end against differences of order eight of whole runs, over this part of each number.
pub fn agrees_with_runs(model: &Model, keys: &[&str], (stages, step, time): (usize, f64, f64), width: f64, bound: f64) {
    let params = model.params().expect("numbers");
    let of = |name: &str| params.iter().find(|(own, _)| own == name || own.ends_with(&format!(".{name}")));
    let run = derivatives(model, stages, step, time, keys);
    for event in &run.events {
        println!("{:.6} s: {}", event.time, event.what);
    }
    for (column, key) in keys.iter().enumerate() {
        let value = of(key).and_then(|(_, value)| *value).unwrap_or_else(|| panic!("{key} has a value"));
        let width = width * if value == 0.0 { 1.0 } else { value.abs() };
        let at = |number: f64| {
            let model = model.with_params([(*key, number)]).expect("another number");
            let mut run = Simulation::new(&model).fixed(stages, step).without_figures().duration(time);
            run.run().expect("a run");
            run.coordinates().expect("coordinates")
        };
        let pairs: Vec<_> = (1..=4).map(|k| (at(value + k as f64 * width), at(value - k as f64 * width))).collect();
        println!("{key}: valid within {:.2e}, {}", run.valid_within[column], run.bounded_by[column]);
        // Turns of floating bodies are twists, and quaternions in the coordinates.
        let is_floating = run.q[0].len() != run.freedoms.len();
        for freedom in 0..run.freedoms.len() {
            let found = last(&run, freedom, column);
            for (part, found) in found.into_iter().enumerate().skip(usize::from(is_floating && freedom >= 3)) {
                let pair = |k: usize| {
                    let (one, other) = &pairs[k];
                    if part == 0 { one.0[freedom] - other.0[freedom] } else { one.1[freedom] - other.1[freedom] }
                };
                let wanted = (pair(0) * 672.0 - pair(1) * 168.0 + pair(2) * 32.0 - pair(3) * 3.0) / (840.0 * width);
                let scale = run.dq.last().expect("steps").amax().max(run.dv.last().expect("steps").amax()).max(1e-3);
                println!("{key}, {freedom}, {part}: {found} and {wanted}");
                assert!(
                    (found - wanted).abs() < bound * scale,
                    "{key}, {freedom}, {part}: {found} and {wanted}, {:e}",
                    (found - wanted).abs()
                );
            }
        }
    }
}

#[test]
fn a_pendulum_on_a_limit_has_the_derivatives_of_its_runs() {
    let model = Model::load(robot("bouncing_pendulum.toml")).expect("a model");
    let keys =
        ["positions.hinge", "rod.mass", "rod.inertia.iyy", "gravity.z", "hinge.limit.lower", "hinge.restitution"];
    // Runs are solved to 1e-14: over 1e-4 of a number their differences leave 1e-10.
    agrees_with_runs(&model, &keys, (9, 0.05, 1.5), 1e-3, 1e-9);
}

#[test]
fn a_pendulum_with_dry_friction_has_the_derivatives_of_its_runs_while_it_turns_and_after_it_sticks() {
    let model = Model::load(robot("friction_pendulum.toml")).expect("a model");
    let keys = ["positions.hinge", "rod.mass", "hinge.friction", "gravity.z"];
    agrees_with_runs(&model, &keys, (9, 0.05, 2.5), 1e-3, 1e-9);
    // It sticks at 6.03 s: a place that is a function of all numbers.
    agrees_with_runs(&model, &keys, (9, 0.05, 7.0), 1e-4, 1e-8);
}

#[test]
fn an_impact_that_passes_through_several_limits_has_the_derivatives_of_its_runs() {
    // The upper arm falls on its limit. The forearm lies on its own, and goes on: its blow throws the upper arm down again, in rounds of one impact.
    let link = |name: &str, mass: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.2 0 0.03'/><mass value='{mass}'/>\
             <inertia ixx='0.01' ixy='0.002' ixz='0' iyy='0.03' iyz='0' izz='0.03'/></inertial></link>"
        )
    };
    let urdf = format!(
        "<robot name='arm'><link name='base'/>{}{}\
         <joint name='shoulder' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 1 0'/>\
         <limit lower='-3' upper='0.4' effort='0' velocity='0'/></joint>\
         <joint name='elbow' type='revolute'><parent link='upper'/><child link='lower'/><origin xyz='0.4 0 0'/>\
         <axis xyz='0 0.8 0.6'/><limit lower='-3' upper='0.1' effort='0' velocity='0'/></joint></robot>",
        link("upper", 1.3),
        link("lower", 0.7)
    );
    let urdf = scene("two_limits.urdf", &urdf);
    let text = format!(
        "[[robot]]\nname = \"arm\"\nurdf = {urdf:?}\npositions = {{ shoulder = -0.2, elbow = 0.1 }}\n\
         [[joint]]\nname = \"shoulder\"\nrestitution = 0.7\n[[joint]]\nname = \"elbow\"\nrestitution = 0.6\n\
         [[spring]]\njoint = \"elbow\"\nstiffness = 6\nrest = 0.3\n"
    );
    let model = Model::load(scene("two_limits.toml", &text)).expect("a model");
    let keys = [
        "positions.shoulder",
        "upper.mass",
        "lower.mass",
        "lower.center_of_mass.x",
        "lower.inertia.iyy",
        "gravity.z",
        "shoulder.limit.upper",
        "shoulder.restitution",
        "elbow.restitution",
    ];
    // As for a pendulum on a limit.
    agrees_with_runs(&model, &keys, (9, 0.05, 0.4), 1e-3, 1e-9);
}

#[test]
fn a_robot_far_from_the_origin_has_the_derivatives_of_one_at_the_origin() {
    let arm = robot("arm7.urdf");
    let at = |name: &str, place: f64| {
        let text = format!(
            "[[robot]]\nurdf = {arm:?}\npose = {{ position = [{place}, {place}, 0] }}\n\
             positions = {{ joint2 = 0.3, joint4 = 0.6 }}\n[[spring]]\nname = \"band\"\nstiffness = 40\nrest_length = 0.2\n\
             a = {{ link = \"forearm\" }}\nb = {{ link = \"world\", position = [{}, {place}, 0.5] }}\n",
            place + 0.5
        );
        let model = Model::load(scene(name, &text)).expect("a model");
        derivatives(&model, 5, 0.05, 0.5, &["positions.joint2", "forearm.mass", "band.stiffness", "gravity.z"])
    };
    let [near, far] = [at("near.toml", 0.0), at("far.toml", 1e3)];
    for (near, far) in [(&near.dq, &far.dq), (&near.dv, &far.dv)] {
        let [near, far] = [near, far].map(|of| of.last().expect("steps"));
        // Positions in the world are rounded by 1e-13 m there, by which the band errs by 4e-12 N, and light links feel that.
        assert!((near - far).amax() < 1e-9 * near.amax(), "{:e} of {}", (near - far).amax(), near.amax());
    }
}

#[test]
fn a_linkage_with_closed_loops_has_the_derivatives_of_its_runs() {
    let model = Model::load(robot("four_bar_2.toml")).expect("a model");
    let key = |part: &str| {
        let keys = model.params().expect("numbers").into_iter();
        let mut keys = keys.filter_map(|(key, value)| value.filter(|value| *value != 0.0).map(|_| key));
        keys.find(|key| key.contains(part)).unwrap_or_else(|| panic!("{part}"))
    };
    let keys = [key("gravity"), key(".mass"), key("inertia")];
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    // Loops are solved to 1e-13; over 1e-2 of a number their differences leave 1e-11.
    agrees_with_runs(&model, &keys, (5, 0.02, 0.4), 1e-2, 1e-9);
}

/// A chain of three hinges with limits, dry friction and a motor, from a seed.
fn random_chain(seed: u64) -> PathBuf {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut between = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    let mut urdf = String::from("<robot name='chain'><link name='base'/>");
    let mut scene_text = String::new();
    for index in 0..3 {
        let parent = if index == 0 { "base".to_string() } else { format!("link{}", index - 1) };
        let axis = [between(-1.0, 1.0), between(0.5, 1.0), between(-1.0, 1.0)];
        let (mass, length) = (between(0.5, 2.0), between(0.2, 0.5));
        let inertia = mass * length * length / 10.0;
        urdf += &format!(
            "<link name='link{index}'><inertial><origin xyz='0 0 {}'/><mass value='{mass}'/><inertia ixx='{inertia}' ixy='0' ixz='0' \
             iyy='{}' iyz='0' izz='{}'/></inertial></link><joint name='joint{index}' type='revolute'><parent link='{parent}'/>\
             <child link='link{index}'/><origin xyz='0 0 {}'/><axis xyz='{} {} {}'/><limit lower='-9' upper='9' effort='0' velocity='0'/></joint>",
            -0.5 * length,
            1.1 * inertia,
            0.6 * inertia,
            if index == 0 { 0.0 } else { -length },
            axis[0],
            axis[1],
            axis[2],
        );
        let reach = between(0.4, 1.2);
        scene_text += &format!(
            "[[joint]]\nname = \"joint{index}\"\nlimit = [{}, {reach}]\nrestitution = {}\nfriction = {}\n",
            -reach,
            between(0.3, 0.9),
            between(0.005, 0.1)
        );
    }
    urdf += "</robot>";
    let file = scene(&format!("chain{seed}.urdf"), &urdf);
    let start: Vec<String> = (0..3).map(|index| format!("joint{index} = {}", between(-0.35, 0.35))).collect();
    let rates: Vec<String> = (0..3).map(|index| format!("joint{index} = {}", between(-3.0, 3.0))).collect();
    let motor = format!(
        "[[motor]]\njoint = \"joint1\"\nkind = \"position\"\ntarget = 0.2\nkp = {}\nkd = 0.3\nmax_effort = {}\n",
        between(2.0, 9.0),
        between(0.5, 2.0)
    );
    let text = format!(
        "[[robot]]\nname = \"chain\"\nurdf = {file:?}\npositions = {{ {} }}\nvelocities = {{ {} }}\n{scene_text}{motor}",
        start.join(", "),
        rates.join(", ")
    );
    scene(&format!("chain{seed}.toml"), &text)
}

#[test]
fn random_chains_with_limits_friction_and_a_bounded_motor_have_the_derivatives_of_their_runs() {
    let keys = ["link1.mass", "joint1.friction", "joint0.restitution", "joint2.limit.upper", "positions.joint0"];
    let (mut compared, mut close, mut refused, mut events) = (0, 0, 0, 0);
    let mut worst = 0.0_f64;
    for seed in 1..=12 {
        let model = Model::load(random_chain(seed)).expect("a model");
        let run = |model: &Model| Simulation::new(model).fixed(7, 0.02).duration(0.7).without_figures();
        let found = match run(&model).sensitivity(&keys) {
            Ok(found) => found,
            Err(error) => {
                println!("{seed}: {error}");
                refused += 1;
                continue;
            }
        };
        events += found.events.len();
        let params = model.params().expect("numbers");
        for (column, key) in keys.iter().enumerate() {
            let value = params.iter().find(|(own, _)| own.ends_with(&format!(".{key}"))).and_then(|(_, value)| *value);
            let value = value.unwrap_or_else(|| panic!("{key} has a value"));
            // Four widths are a twenty-fifth of the size to which the derivative holds: differences of order eight leave 1e-10.
            let width = (0.01 * found.valid_within[column]).min(2e-4);
            if width < 1e-6 {
                close += 1;
                continue;
            }
            let at = |by: f64| {
                let mut run = run(&model.with_params([(*key, value + by)]).expect("another number"));
                run.run().expect("a run");
                run.coordinates().expect("coordinates")
            };
            let pairs: Vec<_> = (1..=4).map(|k| (at(k as f64 * width), at(-(k as f64) * width))).collect();
            let scale = found.dq.last().expect("steps").column(column).amax().max(1e-2);
            for freedom in 0..3 {
                let pair = |k: usize| pairs[k].0.0[freedom] - pairs[k].1.0[freedom];
                let wanted = (pair(0) * 672.0 - pair(1) * 168.0 + pair(2) * 32.0 - pair(3) * 3.0) / (840.0 * width);
                let off = (last(&found, freedom, column)[0] - wanted).abs() / scale;
                compared += 1;
                if off > 1e-7 {
                    println!("{seed} {key} {freedom}: off by {off:e}, width {width:e}, {}", found.bounded_by[column]);
                    for event in &found.events {
                        println!(
                            "    {:.6} s: {}, rate {:.3e}, dt {:.3e}",
                            event.time, event.what, event.rate, event.by[column]
                        );
                    }
                }
                worst = worst.max(off);
            }
        }
    }
    println!(
        "{compared} compared over {events} events, worst {worst:e}; {close} too close to another event, {refused} refused"
    );
    // Runs are solved to some 1e-14, which impacts amplify; over 1e-6 of a number that leaves 1e-8.
    assert!(worst < 1e-7, "{worst:e}");
    assert!(compared > 100 && refused < 3, "{compared} compared, {refused} refused");
}

#[test]
fn a_limit_that_a_joint_just_misses_bounds_the_change_of_its_start() {
    // x = x₀ cos 3 t turns back before its limit 0.1 by a gap g, with ∂x/∂x₀ = −1: the limit is met if x₀ changes by more than g.
    let urdf = scene(
        "just_misses.urdf",
        "<robot name='o'><link name='b'/><link name='m'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>\
         </inertial></link><joint name='x' type='prismatic'><parent link='b'/><child link='m'/><axis xyz='1 0 0'/>\
         <limit lower='-9' upper='0.1' effort='99' velocity='99'/></joint></robot>",
    );
    for gap in [1e-3, 1e-5, 1e-9] {
        let text = format!(
            "[[robot]]\nurdf = {urdf:?}\npositions = {{ x = {:?} }}\n[[joint]]\nname = \"x\"\nrestitution = 0.5\n\
             [[spring]]\njoint = \"x\"\nstiffness = 9.0\n",
            gap - 0.1
        );
        let model = Model::load(scene("just_misses.toml", &text)).expect("a model");
        for (stages, step) in [(5, 0.02), (9, 0.3)] {
            let run = derivatives(&model, stages, step, 1.5, &["start.q"]);
            // The derivative inside of a step is a cubic, a part in a hundred off in a step of 0.3 s; the gap has roundings of 1e-12.
            let off = (run.valid_within[0] - gap).abs() / gap;
            assert!(off < 2e-2, "{gap}, {step} s: {:e}, {}", run.valid_within[0], run.bounded_by[0]);
            assert!(run.bounded_by[0].contains("near 1.047"), "{}", run.bounded_by[0]);
        }
    }
}

#[test]
fn how_far_derivatives_hold_does_not_depend_on_the_samples_at_which_steps_end() {
    let model = Model::load(robot("bouncing_pendulum.toml")).expect("a model");
    let keys = ["positions.hinge", "rod.mass", "gravity.z", "hinge.limit.lower"];
    let run = || Simulation::new(&model).duration(1.5).without_figures();
    let times: Vec<f64> = (1..30).map(|count| 0.05 * f64::from(count)).collect();
    let alone = run().sensitivity(&keys).expect("derivatives");
    let sampled = run().sensitivity_at(&keys, &times).expect("derivatives");
    assert_eq!(alone.bounded_by, sampled.bounded_by);
    for (one, other) in alone.valid_within.iter().zip(&sampled.valid_within) {
        // Steps of other lengths have errors of 1e-6 of the motion.
        assert!((one - other).abs() <= 1e-5 * one, "{:?} and {:?}", alone.valid_within, sampled.valid_within);
    }
}

#[test]
fn samples_beside_an_event_have_the_derivatives_from_before_it_and_leave_those_after_it_as_they_are() {
    let (model, keys) = (ball_on_a_slide(), ["start.q"]);
    let run = || Simulation::new(&model).fixed(5, 0.05).duration(0.6).without_figures();
    let alone = run().sensitivity(&keys).expect("derivatives");
    let (impact, speed) = (alone.events[0].time, (2.0 * 9.81_f64).sqrt());
    for off in [0.0, 1e-13, -1e-13, 1e-9, -1e-9, 1e-7, -1e-7] {
        let sampled = run().sensitivity_at(&keys, &[impact + off]).expect("derivatives");
        let row = sampled.times.iter().position(|time| *time == impact + off).expect("the sample");
        // z = h − g t²/2: ∂z/∂h = 1 and ∂v/∂h = 0 at a fixed time.
        assert!((sampled.q[row][0] + speed * off).abs() < 1e-12, "{off:e}: {}", sampled.q[row][0]);
        assert!((sampled.dq[row][(0, 0)] - 1.0).abs() < 1e-10, "{off:e}: {}", sampled.dq[row][(0, 0)]);
        assert!(sampled.dv[row][(0, 0)].abs() < 1e-9, "{off:e}: {}", sampled.dv[row][(0, 0)]);
        assert_eq!(sampled.dq.last(), alone.dq.last(), "{off:e}");
        // Against time: the sum of both samples, of q and v.
        let asked = Backward { keys: &keys, times: &[impact + off, 0.6], every: 1 };
        let loss = |samples: &Samples| {
            assert_eq!(samples.times, asked.times);
            Lost { value: 0.0, by_q: vec![vec![1.0], vec![1.0]], by_v: vec![vec![2.0], vec![0.0]], by_events: vec![] }
        };
        let by = run().gradient(&asked, loss).expect("a gradient").by[0];
        let wanted = sampled.dq[row][(0, 0)] + 2.0 * sampled.dv[row][(0, 0)] + last(&alone, 0, 0)[0];
        assert!((by - wanted).abs() < 1e-9, "{off:e}: {by} for {wanted}");
    }
}
