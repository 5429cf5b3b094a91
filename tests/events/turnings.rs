//! Rolling and spinning friction (`rolling_friction`, `spinning_friction`): balls and wheels that stop at located instants, stay at rest, and begin to
//! roll, against closed forms; with all heat accounted.
//!
//! A ball of mass m, radius r and moment of inertia I = 0.4 m r² that rolls on a plane of slope α with the length ρ has
//! `v̇ = −g (ρ cos α/r ± sin α)/1.4`, and its spin about the normal `ω̇ = −σ m g cos α/I`.

use crate::common::scratch;
use crate::scene_files::{link, report};
use catena::prelude::{Model, Simulation};
use catena::report::Report;

const GRAVITY: f64 = 9.81;
/// Closed forms are met to this (s, m, rad/s, J): tolerances of 1e-11 m and their factors of some ten in velocities and energies.
const BOUND: f64 = 1e-10;
const RADIUS: f64 = 0.1;

/// A ball of 1 kg on a floor of this slope about y (rad), with the keys of its start and of the floor.
fn ball(slope: f64, start: &str, floor: &str) -> String {
    let (sine, cosine) = slope.sin_cos();
    format!(
        "[[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = {RADIUS} }}\nmass = 1.0\n\
         pose.position = [{}, 0, {}]\n{start}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\", normal = [{sine:?}, 0, {cosine:?}] }}\nfriction = 0.5\n{floor}\n",
        RADIUS * sine,
        RADIUS * cosine,
    )
}

fn run(folder: &str, text: &str, duration: f64) -> Report {
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    let end = report(&file, &[], &[], Some(duration), 1e-11);
    assert!(end.energy.max_relative_error < 1e-12, "{:?}", end.energy);
    assert!(end.warnings.is_empty(), "{:?}", end.warnings);
    end
}

/// The kinds and times of the events (s).
fn events(report: &Report) -> Vec<(&str, f64)> {
    report.events.list.iter().map(|event| (event.kind.as_str(), event.time)).collect()
}

fn near(what: &str, (is, wanted): (f64, f64)) {
    assert!((is - wanted).abs() < BOUND, "{what}: {is} instead of {wanted}, off by {:.1e}", is - wanted);
}

#[test]
fn a_ball_rolls_to_rest_at_a_located_instant_and_stays_there() {
    let (rolling, speed) = (0.004, 1.0);
    let start = format!("velocity = {{ linear = [{speed}, 0, 0], angular = [0, {}, 0] }}", speed / RADIUS);
    let end = run("rolls_to_rest", &ball(0.0, &start, &format!("rolling_friction = {rolling}")), 6.0);
    let brake = rolling * GRAVITY / (1.4 * RADIUS);
    let all = events(&end);
    assert_eq!(all.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), ["stick"]);
    near("the stop", (all[0].1, speed / brake));
    near("x", (link(&end, "ball").position[0], 0.5 * speed * speed / brake));
    near("heat", (end.energy.friction, 0.7 * speed * speed));
    // It may still spin about the normal, by roundings of rates that were zero.
    let [v, w] = [link(&end, "ball").linear_velocity, link(&end, "ball").angular_velocity];
    assert!(v.iter().chain(&w).all(|rate| rate.abs() < 1e-20), "{v:?} {w:?}");
}

#[test]
fn a_ball_stays_on_a_slope_below_the_angle_of_its_rolling_friction_and_rolls_down_a_steeper_one() {
    let rolling = 0.004;
    let angle = f64::atan(rolling / RADIUS);
    let rests = run("below_the_angle", &ball(0.999 * angle, "", &format!("rolling_friction = {rolling}")), 3.0);
    let (sine, cosine) = (0.999 * angle).sin_cos();
    assert_eq!(link(&rests, "ball").position, [RADIUS * sine, 0.0, RADIUS * cosine]);
    let (sine, cosine) = (1.1 * angle).sin_cos();
    let rolls = run("above_the_angle", &ball(1.1 * angle, "", &format!("rolling_friction = {rolling}")), 3.0);
    let way = 0.5 * GRAVITY * (sine - rolling / RADIUS * cosine) / 1.4 * 9.0;
    let [x, _, z] = link(&rolls, "ball").position;
    near("x", (x, RADIUS * sine + way * cosine));
    near("z", (z, RADIUS * cosine - way * sine));
    near("heat", (rolls.energy.friction, rolling * GRAVITY * cosine * way / RADIUS));
}

#[test]
fn a_spin_ends_while_the_ball_rolls_on_and_then_the_ball_stops() {
    let (rolling, spinning, speed, spin) = (0.004, 0.002, 1.0, 5.0);
    let start = format!("velocity = {{ linear = [0, {speed}, 0], angular = [{}, 0, {spin}] }}", -speed / RADIUS);
    let floor = format!("rolling_friction = {rolling}\nspinning_friction = {spinning}");
    let end = run("spin_ends", &ball(0.0, &start, &floor), 5.0);
    let (brake, turns) = (rolling * GRAVITY / (1.4 * RADIUS), spinning * GRAVITY / (0.4 * RADIUS * RADIUS));
    let all = events(&end);
    assert_eq!(all.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), ["stick", "stick"]);
    near("the end of the spin", (all[0].1, spin / turns));
    near("the stop", (all[1].1, speed / brake));
    near("y", (link(&end, "ball").position[1], 0.5 * speed * speed / brake));
    near("heat", (end.energy.friction, 0.7 * speed * speed + 0.2 * RADIUS * RADIUS * spin * spin));
}

#[test]
fn a_ball_that_slides_first_rolls_and_then_stops() {
    let (friction, rolling, speed) = (0.5, 0.01, 2.0);
    let start = format!("velocity = {{ linear = [{speed}, 0, 0], angular = [0, 0, 0] }}");
    let end = run("slides_first", &ball(0.0, &start, &format!("rolling_friction = {rolling}")), 4.0);
    // While it slides, v̇ = −μ g and ω̇ r = (μ − ρ/r) g/0.4.
    let rolls = speed / (friction * GRAVITY + (friction - rolling / RADIUS) * GRAVITY / 0.4);
    let slower = speed - friction * GRAVITY * rolls;
    let brake = rolling * GRAVITY / (1.4 * RADIUS);
    let all = events(&end);
    near("the end of the slip", (all[0].1, rolls));
    near("the stop", (all[1].1, rolls + slower / brake));
    let way = speed * rolls - 0.5 * friction * GRAVITY * rolls * rolls + 0.5 * slower * slower / brake;
    near("x", (link(&end, "ball").position[0], way));
    near("heat", (end.energy.friction, 0.5 * speed * speed));
}

#[test]
fn a_wheel_on_the_two_ends_of_its_line_of_contact_is_braked_as_one_body() {
    let (rolling, speed, length) = (0.004, 1.0, 0.05);
    let text = format!(
        "[[body]]\nname = \"wheel\"\nshape = {{ type = \"cylinder\", radius = {RADIUS}, length = {length} }}\nmass = 1.0\n\
         pose = {{ position = [0, 0, {RADIUS}], rpy = [\"90 deg\", 0, 0] }}\n\
         velocity = {{ linear = [{speed}, 0, 0], angular = [0, {}, 0] }}\nrolling_friction = {rolling}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.5\n",
        speed / RADIUS
    );
    let end = run("wheel_stops", &text, 5.0);
    let brake = rolling * GRAVITY / (1.5 * RADIUS);
    near("the stop", (events(&end)[0].1, speed / brake));
    near("x", (link(&end, "wheel").position[0], 0.5 * speed * speed / brake));
    near("heat", (end.energy.friction, 0.75 * speed * speed));
}

/// Its corners share the load in many ways: the law is solved all the same, and `run` asks that no warning says otherwise.
#[test]
fn a_box_that_slides_to_rest_on_rolling_and_spinning_friction_stops_where_dry_friction_stops_it() {
    let (friction, speed, sideways) = (0.4, 1.0, 0.2);
    let scene = |height: f64, [along, across]: [f64; 2]| {
        format!(
            "[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.4, 0.2, 0.1] }}\nmass = 4\npose.position = [0, 0, {height}]\n\
             velocity = {{ linear = [{along}, {across}, 0] }}\n\
             [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {friction}\n\
             rolling_friction = 0.002\nspinning_friction = 0.001\n"
        )
    };
    let end = run("box_slides", &scene(0.05, [speed, sideways]), 1.0);
    let way = (speed * speed + sideways * sideways) / (2.0 * friction * GRAVITY);
    let [x, y, _] = link(&end, "box").position;
    near("the way", (x.hypot(y), way));
    let end = run("box_drops", &scene(0.25, [0.0, 0.0]), 1.0);
    near("the height", (link(&end, "box").position[2], 0.05));
}

#[test]
fn derivatives_refuse_rolling_friction() {
    let file = scratch("rolling_derivatives").join("scene.toml");
    std::fs::write(&file, ball(0.0, "", "rolling_friction = 0.01")).expect("a scene");
    let model = Model::load(&file).expect("a model");
    let asked = Simulation::new(&model).duration(1.0).sensitivity(&["obstacle.floor.friction"]);
    let refused = asked.expect_err("no derivatives").to_string();
    assert!(refused.contains("rolling and spinning friction"), "{refused}");
}

#[test]
fn a_ball_that_rolling_friction_has_stopped_on_a_slope_stays_where_it_stopped() {
    // Up a slope of 0.2 rad, rolling at 1.5 m/s: it stops after 0.43 s, and ρ = 0.03 m holds more than the 0.02 m that the slope needs.
    let [sine, cosine] = [0.2_f64.sin(), 0.2_f64.cos()];
    let scene = format!(
        "[[body]]\nname = \"b\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 2\n\
         pose = {{ position = [{}, 0, {}] }}\nvelocity = {{ linear = [{}, 0, {}], angular = [0, 15, 0] }}\nrolling_friction = 0.03\n\
         [[obstacle]]\nname = \"f\"\nshape = {{ type = \"half_space\", normal = [{}, 0, {cosine}] }}\nfriction = 0.8\nrolling_friction = 0.03\n",
        -0.1 * sine,
        0.1 * cosine,
        1.5 * cosine,
        1.5 * sine,
        -sine
    );
    let file = crate::common::scratch("ball_stops").join("ball.toml");
    std::fs::write(&file, scene).expect("a scene");
    let ends = [0.5, 3.0].map(|duration| crate::scene_files::report(&file, &[], &[], Some(duration), 1e-6));
    for end in &ends {
        let ball = &end.links.iter().find(|(name, _)| name == "b").expect("a ball").1;
        assert_eq!((ball.linear_velocity, ball.angular_velocity), ([0.0; 3], [0.0; 3]));
        assert_eq!(ball.position, ends[0].links[0].1.position);
        assert_eq!(end.events.list.len(), 1, "{:?}", end.events.list);
    }
}

/// A pushed body that rolling friction holds in its place, while it spins about the normal without friction at this rate [rad/s].
fn spins_in_its_place(folder: &str, text: &str, body: &str, [place, spin, speed]: [[f64; 3]; 3]) {
    let end = run(folder, text, 1.0);
    let own = link(&end, body);
    let moved = [(own.position, place), (own.angular_velocity, spin), (own.linear_velocity, speed)];
    for (name, (is, wanted)) in ["position", "spin", "speed"].into_iter().zip(moved) {
        is.iter().zip(wanted).for_each(|(is, wanted)| near(&format!("{folder}: {name}"), (*is, wanted)));
    }
    // No step ends beside the rest, which would change the energy.
    assert_eq!((end.rejected_steps, end.method.crowd.steps), (0, 0), "{folder}: {:?}", end.rejected);
    assert!(end.events.list.is_empty(), "{folder}: {:?}", end.events.list);
}

#[test]
fn what_rolling_friction_holds_keeps_its_spin_about_the_normal_and_turns_about_no_other_axis() {
    // 0.0199 m of 0.03 m hold a ball on a slope of 0.2 rad. Before, ω_y grew to 1e-3 rad/s within a second.
    let (sine, cosine) = 0.2_f64.sin_cos();
    let spin = [5.0 * sine, 0.0, 5.0 * cosine];
    let floor = "rolling_friction = 0.03";
    let start = format!("velocity = {{ linear = [0, 0, 0], angular = [{:?}, 0, {:?}] }}", spin[0], spin[2]);
    let place = [RADIUS * sine, 0.0, RADIUS * cosine];
    spins_in_its_place("ball_spins_on_a_slope", &ball(0.2, &start, floor), "ball", [place, spin, [0.0; 3]]);

    // Ellipsoids on their shortest axis, of revolution and not, under a weight that leans by 0.2.
    for radii in ["0.2, 0.2, 0.1", "0.2, 0.15, 0.1"] {
        let text = format!(
            "[scene]\ngravity = [2, 0, -9.81]\n\
             [[body]]\nname = \"stone\"\nshape = {{ type = \"ellipsoid\", radii = [{radii}] }}\nmass = 2\npose.position = [0, 0, 0.1]\n\
             velocity.angular = [0, 0, 5]\nrolling_friction = 0.05\n\
             [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.8\nrolling_friction = 0.05\n"
        );
        let still = [[0.0, 0.0, 0.1], [0.0, 0.0, 5.0], [0.0; 3]];
        spins_in_its_place("stone_spins", &text, "stone", still);
    }

    // A plank slides to (1 − μ g t, …) and carries a ball, which spins.
    let plank = "[[body]]\nname = \"plank\"\nshape = { type = \"box\", size = [2, 1, 0.1] }\nmass = 3\npose.position = [0, 0, 0.05]\n\
         velocity.linear = [2, 0, 0]\nfriction = 0.8\n\
         [[body]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 2\npose.position = [0, 0, 0.2]\n\
         velocity = { linear = [2, 0, 0], angular = [0, 0, 5] }\nfriction = 0.8\nrolling_friction = 0.03\n\
         [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n\
         [[contact.pair]]\na = \"plank\"\nb = \"floor\"\nfriction = 0.1\n";
    let brake = 0.1 * GRAVITY;
    let carried = [[2.0 - 0.5 * brake, 0.0, 0.2], [0.0, 0.0, 5.0], [2.0 - brake, 0.0, 0.0]];
    spins_in_its_place("ball_spins_on_a_plank", plank, "ball", carried);
}

#[test]
fn a_ball_that_a_moved_table_carries_keeps_its_spin_about_the_normal() {
    let folder = scratch("ball_spins_on_a_table");
    let table = "<robot name=\"table\"><link name=\"base\"/><link name=\"top\">\
         <inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\
         <collision><geometry><box size=\"2 2 0.1\"/></geometry></collision></link>\
         <joint name=\"slide\" type=\"prismatic\"><parent link=\"base\"/><child link=\"top\"/><axis xyz=\"1 0 0\"/>\
         <limit lower=\"-9\" upper=\"9\" effort=\"1000\" velocity=\"10\"/></joint></robot>";
    std::fs::write(folder.join("table.urdf"), table).expect("a table");
    let scene = "[[robot]]\nname = \"table\"\nurdf = \"table.urdf\"\n\
         [[motion]]\njoint = \"slide\"\nposition = { formula = \"0.05*(1-cos(2*t))\" }\n\
         [[body]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 2\npose.position = [0, 0, 0.15]\n\
         velocity.angular = [0, 0, 5]\nfriction = 0.8\nrolling_friction = 0.03\n";
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene).expect("a scene");
    let end = report(&file, &[], &[], Some(2.0), 1e-11);
    let own = link(&end, "ball");
    near("x", (own.position[0], 0.05 * (1.0 - 4.0_f64.cos())));
    near("speed", (own.linear_velocity[0], 0.1 * 4.0_f64.sin()));
    own.angular_velocity.iter().zip([0.0, 0.0, 5.0]).for_each(|(is, wanted)| near("spin", (*is, wanted)));
    assert_eq!(end.rejected_steps, 0, "{:?}", end.rejected);
}

#[test]
fn a_flat_end_that_slides_stands_on_its_points_where_rolling_friction_holds_it_too() {
    // The points hold the turning that rolling friction holds. A disc that spins and slides: the run without rolling friction is the same.
    let disc = |floor: &str| {
        format!(
            "[[body]]\nname = \"disc\"\nshape = {{ type = \"cylinder\", radius = 0.1, length = 0.1 }}\nmass = 2\npose.position = [0, 0, 0.05]\n\
             velocity = {{ linear = [1, 0.3, 0], angular = [0, 0, 3] }}\n\
             [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.2\n{floor}\n"
        )
    };
    let ends = ["rolling_friction = 0.004", ""].map(|floor| {
        let file = scratch("disc_slides").join("scene.toml");
        std::fs::write(&file, disc(floor)).expect("a scene");
        report(&file, &[], &[], Some(1.0), 1e-6)
    });
    for end in &ends {
        assert!(end.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached), "{:?}", end.accuracy);
        assert_eq!(end.method.crowd.steps, 0);
    }
    let [held, free] = ends.map(|end| *link(&end, "disc"));
    held.position
        .into_iter()
        .zip(free.position)
        .for_each(|(held, free)| assert!((held - free).abs() <= 1e-6, "{held} {free}"));
}
