//! Derivatives of runs with contacts that stay closed: sliding, rolling, resting, and the events between them, against closed forms and differences of
//! runs.

use crate::robot;
use crate::sensitivity_events::{agrees_with_runs, derivatives, difference, last, scene};
use catena::prelude::*;
use catena::session::Sensitivity;

const RADIUS: f64 = 0.1;

/// A scene with one body on the floor z = 0 under gravity, which may be inclined, with friction μ.
fn on_the_floor(name: &str, shape: &str, inertia: f64, gravity: [f64; 3], start: &str, friction: f64) -> Model {
    let urdf = format!(
        "<robot name='body'><link name='body'><inertial><mass value='2'/><inertia ixx='{inertia}' ixy='0' ixz='0' iyy='{inertia}' iyz='0' \
         izz='{inertia}'/></inertial><collision><geometry>{shape}</geometry></collision></link></robot>"
    );
    let urdf = scene(&format!("{name}.urdf"), &urdf);
    let text = format!(
        "[scene]\ngravity = {gravity:?}\n[[robot]]\nname = \"body\"\nurdf = {urdf:?}\nbase = \"floating\"\n{start}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\", normal = [0, 0, 1] }}\nfriction = {friction}\n"
    );
    Model::load(scene(&format!("{name}.toml"), &text)).expect("a model")
}

fn ball(name: &str, gravity: [f64; 3], start: &str, friction: f64) -> Model {
    on_the_floor(name, "<sphere radius='0.1'/>", 0.008, gravity, start, friction)
}

fn column(run: &Sensitivity, name: &str) -> usize {
    run.keys.iter().position(|key| key.ends_with(name)).unwrap_or_else(|| panic!("{name} in {:?}", run.keys))
}

#[test]
fn a_box_that_slides_down_until_it_stops_has_the_derivatives_of_its_closed_form() {
    let (along, down, friction, speed) = (3.0_f64, 9.0_f64, 0.5_f64, 1.2_f64);
    let start = "pose = { position = [0, 0, 0.05] }\nvelocity = { linear = [1.2, 0, 0] }";
    let model = on_the_floor("sliding_box", "<box size='0.2 0.2 0.1'/>", 0.01, [along, 0.0, -down], start, friction);
    let keys = ["floor.friction", "gravity.x", "gravity.z", "velocity.linear.x", "body.mass"];
    // x = v t + (g_x − μ g_z) t²/2 until it stops at v/(μ g_z − g_x), 0.8 s.
    let moving = |v: f64, mu: f64, gx: f64, gz: f64, t: f64| v * t + 0.5 * (gx - mu * gz) * t * t;
    let stopped = |v: f64, mu: f64, gx: f64, gz: f64| 0.5 * v * v / (mu * gz - gx);
    for (time, slides) in [(0.5, true), (1.1, false)] {
        let run = derivatives(&model, 5, 0.05, time, &keys);
        let at = |dv: f64, dmu: f64, dx: f64, dz: f64| {
            let (v, mu, gx, gz) = (speed + dv, friction + dmu, along + dx, down + dz);
            if slides { moving(v, mu, gx, gz, time) } else { stopped(v, mu, gx, gz) }
        };
        let wanted = [
            difference(&|by| at(0.0, by, 0.0, 0.0), 1e-3),
            difference(&|by| at(0.0, 0.0, by, 0.0), 1e-3),
            difference(&|by| at(0.0, 0.0, 0.0, -by), 1e-3),
            difference(&|by| at(by, 0.0, 0.0, 0.0), 1e-3),
            0.0,
        ];
        for (key, wanted) in wanted.into_iter().enumerate() {
            let found = last(&run, 0, key)[0];
            println!("{time} s, {}: {found} for {wanted}, off {:e}", run.keys[key], (found - wanted).abs());
            // Motions of constant acceleration are exact; differences over 1e-3 leave 1e-13 of a metre, steps to events some more.
            assert!((found - wanted).abs() < 1e-10, "{}: {found} and {wanted}", run.keys[key]);
        }
        assert_eq!(run.events.len(), usize::from(!slides), "{:?}", run.events);
        assert!(run.warnings.is_empty(), "a straight slip stops with its order: {:?}", run.warnings);
        if let Some(event) = run.events.first() {
            // t = v/(μ g_z − g_x)
            let wanted = -speed * down / (friction * down - along).powi(2);
            assert!((event.by[0] - wanted).abs() < 1e-9, "{} and {wanted}", event.by[0]);
        }
    }
}

#[test]
fn a_ball_that_rolls_down_has_the_derivatives_of_its_closed_form() {
    let start = "pose = { position = [0, 0, 0.1] }\nvelocity = { linear = [0.5, 0, 0], angular = [0, 5, 0] }";
    let model = ball("rolling_ball", [3.0, 0.0, -9.0], start, 0.5);
    let keys = ["floor.friction", "gravity.x", "body.mass", "body.inertia.iyy"];
    let time = 0.6;
    let run = derivatives(&model, 5, 0.05, time, &keys);
    // x = v t + a t²/2, a = g_x/(1 + J/m r²)
    let at = |gx: f64, m: f64, j: f64| {
        0.5 * time + 0.5 * time * time * (3.0 + gx) / (1.0 + (0.008 + j) / (2.0 + m) / RADIUS.powi(2))
    };
    let wanted = [
        0.0,
        difference(&|by| at(by, 0.0, 0.0), 1e-3),
        difference(&|by| at(0.0, by, 0.0), 1e-3),
        difference(&|by| at(0.0, 0.0, by), 1e-4),
    ];
    for (key, wanted) in wanted.into_iter().enumerate() {
        let found = last(&run, 0, key)[0];
        println!("{}: {found} for {wanted}, off {:e}", run.keys[key], (found - wanted).abs());
        // The rotation matrix of five stages turns to 1e-10 in steps of 0.05 s at 15 rad/s.
        assert!((found - wanted).abs() < 1e-8 * wanted.abs().max(1.0), "{}: {found} and {wanted}", run.keys[key]);
    }
}

#[test]
fn derivatives_of_a_ball_that_slides_and_then_rolls_converge_with_the_order_of_the_scheme() {
    let start = "pose = { position = [0, 0, 0.1] }\nvelocity = { linear = [1, 0.3, 0], angular = [2, -4, 1] }";
    let model = ball("sliding_ball", [0.0, 0.0, -9.0], start, 0.2);
    let keys = ["floor.friction", "gravity.z", "velocity.linear.x", "body.mass"];
    let at = |stages: usize, step: f64| derivatives(&model, stages, step, 0.6, &keys).dq.last().expect("steps").clone();
    let exact = at(9, 0.02);
    for (stages, step) in [(3, 0.04), (5, 0.12)] {
        let errors = [step, 0.5 * step].map(|step| at(stages, step) - &exact);
        for (column, key) in keys.iter().enumerate() {
            let [one, two] = [0, 1].map(|which: usize| errors[which].column(column).amax());
            println!("{stages} stages, {key}: errors {one:e}, {two:e}, order {}", (one / two).log2());
        }
        let [one, two] = errors.map(|error| error.amax());
        // 2s − 2, and its next terms; the last step before an event has no fixed length.
        assert!((one / two).log2() > 2.0 * stages as f64 - 2.9, "{stages} stages: {one:e}, {two:e}");
    }
    agrees_with_runs(&model, &keys[..3], (9, 0.02, 0.6), 1e-3, 1e-8);
}

#[test]
fn a_slip_that_turns_until_it_stops_has_the_derivatives_of_its_runs() {
    let start = "pose = { position = [0, 0, 0.1] }\nvelocity = { linear = [1, 0.3, 0], angular = [2, -4, 1] }";
    let model = ball("turning_ball", [0.5, 0.0, -9.0], start, 0.2);
    let keys = ["floor.friction", "gravity.x", "velocity.linear.x"];
    agrees_with_runs(&model, &keys, (9, 0.01, 0.2), 1e-3, 1e-8);
    // A slip that turns while it stops has no order of its own, and says so: its direction turns ever faster.
    let run = derivatives(&model, 9, 0.01, 0.6, &keys);
    assert!(run.warnings.iter().any(|warning| warning.contains("its slip turns")), "{:?}", run.warnings);
    agrees_with_runs(&model, &keys, (9, 0.01, 0.6), 1e-3, 1e-3);
}

#[test]
fn a_ball_that_lands_without_rebound_and_rolls_on_has_the_derivatives_of_its_runs() {
    let start = "pose = { position = [0, 0, 0.25] }\nvelocity = { linear = [0.4, 0.1, 0], angular = [1, 3, 0.5] }";
    let model = ball("landing_ball", [1.0, 0.0, -9.0], start, 0.6);
    agrees_with_runs(
        &model,
        &["gravity.x", "body.mass", "pose.position.z", "body.inertia.iyy"],
        (9, 0.02, 0.6),
        1e-3,
        1e-8,
    );
}

#[test]
fn a_parameter_that_opens_a_closed_contact_is_valid_within_nothing() {
    let start = "pose = { position = [0, 0, 0.1] }\nvelocity = { linear = [0.5, 0, 0], angular = [0, 5, 0] }";
    let model = ball("opened_ball", [3.0, 0.0, -9.0], start, 0.5);
    let run = derivatives(&model, 5, 0.05, 0.2, &["start.q", "start.v", "gravity.x"]);
    for (name, ends) in
        [("start.q.base.z", true), ("start.v.base.z", true), ("start.v.base.x", true), ("start.q.base.x", false)]
    {
        let within = run.valid_within[column(&run, name)];
        assert_eq!(within == 0.0, ends, "{name}: {within}, {}", run.bounded_by[column(&run, name)]);
    }
    assert!(run.valid_within[column(&run, "gravity.x")] > 0.0);
    assert!(run.dq.iter().all(|dq| dq.iter().all(|entry| entry.is_finite())));
}

#[test]
fn a_box_that_spins_while_it_slides_on_four_corners_has_the_derivatives_of_its_runs() {
    // Pressures lie on a plane: they are as unequal as friction at the height of the centre makes them, and each corner slips in its own direction.
    for spin in [0.0, 2.0] {
        let start = format!(
            "pose = {{ position = [0, 0, 0.05] }}\nvelocity = {{ linear = [1.5, 0.3, 0], angular = [0, 0, {spin:?}] }}"
        );
        let name = format!("spinning_box_{spin}");
        let model = on_the_floor(&name, "<box size='0.2 0.3 0.1'/>", 0.02, [0.0, 0.0, -9.81], &start, 0.3);
        let keys = ["velocity.angular.z", "velocity.linear.x", "floor.friction"];
        agrees_with_runs(&model, &keys, (5, 0.02, 0.3), 1e-2, 1e-7);
        let run = derivatives(&model, 5, 0.02, 0.3, &keys);
        assert!(run.warnings.is_empty(), "the shares of one rigid body on a plane are constant: {:?}", run.warnings);
    }
}

#[test]
fn a_body_that_turns_while_all_its_slips_stop_is_warned_of() {
    let foot = |[x, y]: [f64; 2]| {
        format!("<collision><origin xyz='{x} {y} -0.05'/><geometry><sphere radius='0.03'/></geometry></collision>")
    };
    let feet: String = [[0.2, 0.0], [-0.1, 0.15], [-0.12, -0.17]].map(foot).concat();
    let urdf = scene(
        "tripod.urdf",
        &format!(
            "<robot name='tripod'><link name='tripod'><inertial><origin xyz='0.01 0.02 0.05'/><mass value='2'/><inertia ixx='.03' iyy='.04' \
             izz='.05' ixy='0.001' ixz='0' iyz='0'/></inertial>{feet}</link></robot>"
        ),
    );
    let text = format!(
        "[[robot]]\nurdf = {urdf:?}\nbase = \"floating\"\npose = {{ position = [0, 0, 0.08] }}\n\
         velocity = {{ linear = [0.6, 0.4, 0], angular = [0, 0, 2] }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.3\n"
    );
    let model = Model::load(scene("tripod.toml", &text)).expect("a model");
    let fixed = derivatives(&model, 5, 0.01, 0.5, &["floor.friction"]);
    assert!(fixed.events.iter().any(|event| event.what.contains("stops")), "{:?}", fixed.events);
    assert!(fixed.warnings.iter().any(|warning| warning.contains("turns by")), "{:?}", fixed.warnings);
    for tolerance in [1e-6, 1e-8, 1e-10] {
        let run = Simulation::new(&model).tolerance(tolerance).duration(0.5).without_figures();
        match run.sensitivity(&["floor.friction"]) {
            // Never a number without a word.
            Ok(run) => assert!(!run.warnings.is_empty(), "{tolerance}: {:?}", run.dq.last()),
            Err(error) => assert!(error.to_string().contains("could not be solved to rounding"), "{error}"),
        }
    }
}

#[test]
fn a_corner_that_strikes_while_another_one_rests_has_the_derivatives_of_its_runs() {
    // The first corner rests from 0.1617 s on, the second one strikes at 0.2023 s: the time of that event is of its own gap.
    let start = "pose = { position = [0, 0, 0.25], rpy = [0.3, 0.4, 0] }\nvelocity = { linear = [1.5, 0.3, 0], angular = [0, 0, 2] }";
    let model = on_the_floor("corners", "<box size='0.2 0.3 0.1'/>", 0.02, [0.0, 0.0, -9.81], start, 0.3);
    let keys = ["velocity.linear.z", "velocity.linear.x", "floor.friction"];
    let run = derivatives(&model, 5, 0.01, 0.21, &keys);
    let strikes = run.events.iter().filter(|event| event.what.contains("meets")).count();
    assert!(strikes >= 2 && run.warnings.is_empty(), "{:?} {:?}", run.events, run.warnings);
    agrees_with_runs(&model, &keys, (5, 0.01, 0.21), 1e-4, 1e-6);
}

/// Both fingers strike with four corners each, which are more than their velocities need, and hold the box by friction then.
#[test]
fn a_box_that_is_gripped_at_eight_corners_has_the_derivatives_of_its_fall() {
    let model = Model::load(robot("gripper_holds_box.toml")).expect("a model");
    let run = |model: &Model| Simulation::new(model).duration(1.0).without_figures();
    let found = run(&model).sensitivity(&["gravity.z"]).expect("derivatives");
    let height = |by: f64| {
        let mut run = run(&model.with_params([("gravity.z", -9.81 + by)]).expect("another number"));
        run.run().expect("a run");
        run.coordinates().expect("coordinates").0[4]
    };
    let wanted = difference(&height, 1e-2);
    let at = last(&found, 4, 0)[0];
    // Runs are solved to 1e-15 m; over 1e-2 of a number their differences leave 1e-13.
    assert!((at - wanted).abs() < 1e-11 && wanted > 2e-4, "{at} and {wanted}");
}

/// A ball that bounces ever lower, and rests: rebounds too low to matter are left out, and so are their derivatives.
#[test]
fn the_end_of_rebounds_is_told() {
    let start = "pose = { position = [0, 0, 0.2] }\nvelocity = { linear = [0.3, 0, 0] }\n[contact]\nrestitution = 0.5";
    let model = ball("ends_to_bounce", [0.0, 0.0, -9.81], start, 0.1);
    // It bounces until 0.43 s.
    for (time, told) in [(0.3, 0), (0.6, 1)] {
        let run = derivatives(&model, 9, 0.05, time, &["velocity.linear.x"]);
        let words = run.warnings.iter().filter(|warning| warning.contains("the rebounds of")).count();
        assert_eq!(words, told, "{time} s: {:?}", run.warnings);
    }
}

#[test]
fn a_can_that_strikes_with_its_rim_and_one_that_rolls_on_it_have_the_derivatives_of_their_runs_by_their_sizes() {
    for (name, restitution, time) in [("struck_can", 0.5, 0.2), ("rolling_can", 0.0, 0.25)] {
        let text = format!(
            "[[body]]\nname = \"can\"\nshape = {{ type = \"cylinder\", radius = 0.1, length = 0.3 }}\nmass = 2\n\
             pose = {{ position = [0, 0, 0.25], rpy = [0.4, 0.2, 0] }}\nvelocity = {{ linear = [0.1, 0, -1], angular = [0.5, 1, 2] }}\n\
             [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.8\nrestitution = {restitution}\n"
        );
        let model = Model::load(scene(&format!("{name}.toml"), &text)).expect("a model");
        // Differences of order eight over a thousandth of a size, and runs that are solved to 1e-12.
        agrees_with_runs(&model, &["body.can.shape.radius", "body.can.shape.length"], (7, 0.01, time), 1e-4, 1e-7);
    }
}

#[test]
fn a_ball_that_begins_to_slide_from_rest_has_the_derivatives_of_its_direction() {
    let (gravity, friction, time) = ([8.0, 1.5, -10.0], 0.1, 0.4);
    let model = ball("turned_start", gravity, "pose = { position = [0, 0, 0.1] }", friction);
    let run = derivatives(&model, 5, 0.1, time, &["gravity.x", "gravity.y", "gravity.z", "floor.friction"]);
    // x = (|g_T| − μ g_z) t²/2 along g_T.
    let at = |axis: usize, by: [f64; 4]| {
        let (x, y) = (gravity[0] + by[0], gravity[1] + by[1]);
        let size = x.hypot(y);
        let speeds_up = size - (friction + by[3]) * (10.0 - by[2]);
        0.5 * speeds_up * time * time * [x, y][axis] / size
    };
    for axis in [0, 1] {
        for key in 0..4 {
            let of = |by: f64| at(axis, std::array::from_fn(|own| if own == key { by } else { 0.0 }));
            let (found, wanted) = (last(&run, axis, key)[0], difference(&of, 1e-3));
            println!("{axis}, {}: {found} for {wanted}, off {:e}", run.keys[key], (found - wanted).abs());
            // Motions of constant acceleration are exact; differences over 1e-3 leave 1e-13 of a metre.
            assert!((found - wanted).abs() < 1e-10, "{axis}, {}: {found} for {wanted}", run.keys[key]);
        }
    }
}
