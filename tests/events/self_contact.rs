//! Links of one robot that touch each other, against conservation laws and closed forms.

use crate::common::scratch;
use crate::exact::near;
use catena::mechanism::description::contact::Collider;
use catena::mechanism::motion::energy::{energy, momentum};
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Finished, Simulation, SimulationOptions, StepChoice};
use nalgebra::Vector3;

/// A link with its centre of mass and its shape at a point (m), with a moment of inertia about all axes (kg m²).
fn link(name: &str, mass: f64, inertia: f64, at: [f64; 3], shape: &str) -> String {
    let origin = format!("<origin xyz=\"{} {} {}\"/>", at[0], at[1], at[2]);
    let shape = match shape {
        "" => String::new(),
        _ => format!("<collision>{origin}<geometry>{shape}</geometry></collision>"),
    };
    format!(
        "<link name=\"{name}\"><inertial>{origin}<mass value=\"{mass}\"/><inertia ixx=\"{inertia}\" iyy=\"{inertia}\" izz=\"{inertia}\" \
         ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{shape}</link>"
    )
}

fn joint(kind: &str, parent: &str, child: &str, at: [f64; 3], axis: &str, limit: f64) -> String {
    let [x, y, z] = at;
    format!(
        "<joint name=\"{child}_joint\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{x} {y} {z}\"/>\
         <axis xyz=\"{axis}\"/><limit lower=\"-{limit}\" upper=\"{limit}\" effort=\"0\" velocity=\"0\"/></joint>"
    )
}

/// The model of a scene file around a robot of some links and joints, and its start.
fn model(name: &str, parts: &[String], scene: &str) -> (Model, State) {
    let folder = scratch(&format!("self_contact_{name}"));
    std::fs::write(folder.join("robot.urdf"), format!("<robot name=\"robot\">{}</robot>", parts.concat()))
        .expect("a file");
    let text = format!("[[robot]]\nurdf = \"robot.urdf\"\n{scene}");
    std::fs::write(folder.join("scene.toml"), text).expect("a file");
    let scene = read_scene(&folder.join("scene.toml"), &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    (model, start)
}

fn run(model: &Model, start: &State, duration: f64, tolerance: f64) -> Finished {
    let steps = StepChoice::Tolerance(tolerance);
    let options = SimulationOptions::new(duration, steps);
    let mut simulation = Simulation::new(&model.mechanism, start.clone(), options).expect("a run");
    simulation.step_to(duration).expect("steps");
    simulation.finish()
}

#[test]
fn two_fingers_on_one_hand_meet_as_two_free_bodies_do() {
    // Without gravity the hand does not move: fingers of 1 and 2 kg are free bodies on one line. They are 1 m apart and come with 1 m/s each, so that
    // they meet after 0.5 s. Then Newton's law and the momentum −1 kg m/s give both speeds.
    let hand = [
        link("hand", 3.0, 0.1, [0.0; 3], ""),
        link("one", 1.0, 0.1, [0.0; 3], "<sphere radius=\"0.1\"/>"),
        link("two", 2.0, 0.1, [0.0; 3], "<sphere radius=\"0.1\"/>"),
        joint("prismatic", "hand", "one", [0.0, 0.0, 0.5], "1 0 0", 5.0),
        joint("prismatic", "hand", "two", [0.0, 0.0, 0.5], "1 0 0", 5.0),
    ];
    for restitution in [0.0, 0.5, 1.0] {
        let scene = format!(
            "base = \"floating\"\npositions = {{ one_joint = -0.6, two_joint = 0.6 }}\nvelocities = {{ one_joint = 1.0, two_joint = -1.0 }}\n\
             [scene]\ngravity = [0, 0, 0]\n[contact]\nself_contact = true\nfriction = 0.3\nrestitution = {restitution}\n"
        );
        let (model, start) = model(&format!("fingers{restitution}"), &hand, &scene);
        let finished = run(&model, &start, 1.0, 1e-9);
        let impact = finished.events.iter().find(|event| event.kind == EventKind::ContactImpact).expect("an impact");
        // Rounding of a second.
        near(impact.time, 0.5, 1e-14);
        let common = -1.0 / 3.0;
        let speeds = [common - restitution * 2.0 * 2.0 / 3.0, common + restitution * 2.0 / 3.0];
        let body = |name: &str| model.mechanism.bodies.iter().position(|body| body.name == name).expect("a body");
        for (name, speed, at) in [("one", speeds[0], -0.1), ("two", speeds[1], 0.1)] {
            let coordinate = &model.mechanism.bodies[body(name)].joint;
            // Some roundings of a solution with three rows.
            near(finished.state.velocity[coordinate.velocity_index], speed, 1e-13);
            near(finished.state.position[coordinate.position_index], at + 0.5 * speed, 1e-13);
        }
    }
}

/// Three rods in a row that float without gravity, and fold up until the third one strikes the first one.
fn folding(name: &str, restitution: f64, friction: f64) -> (Model, State) {
    let rod = "<box size=\"0.9 0.1 0.1\"/>";
    let parts = [
        link("a", 1.0, 0.08, [0.5, 0.0, 0.0], rod),
        link("b", 1.2, 0.08, [0.5, 0.0, 0.0], rod),
        link("c", 1.5, 0.1, [0.5, 0.0, 0.0], "<sphere radius=\"0.3\"/>"),
        joint("continuous", "a", "b", [1.0, 0.0, 0.0], "0 0 1", 1e3),
        joint("continuous", "b", "c", [1.0, 0.0, 0.0], "0 0 1", 1e3),
    ];
    let scene = format!(
        "base = \"floating\"\npositions = {{ b_joint = 1.6, c_joint = 1.6 }}\nvelocities = {{ b_joint = 1.0, c_joint = 2.0 }}\n\
         [scene]\ngravity = [0, 0, 0]\n[contact]\nself_contact = true\nfriction = {friction}\nrestitution = {restitution}\n"
    );
    model(name, &parts, &scene)
}

#[test]
fn a_chain_that_strikes_itself_keeps_its_momenta_and_loses_the_energy_of_newtons_law() {
    for restitution in [0.0, 0.4, 1.0] {
        let (model, start) = folding(&format!("chain{restitution}"), restitution, 0.0);
        let mechanism = &model.mechanism;
        let momenta = |state: &State| momentum(mechanism, &body_states(mechanism, state));
        let kinetic = |state: &State| energy(mechanism, &body_states(mechanism, state)).kinetic;
        let first = run(&model, &start, 2.0, 1e-9);
        let impacts: Vec<_> = first.events.iter().filter(|event| event.kind == EventKind::ContactImpact).collect();
        assert!(!impacts.is_empty(), "{:?}", first.events);
        let at = impacts[0].time;
        let [before, after] = [-1e-6, 1e-6].map(|beside| run(&model, &start, at + beside, 1e-9).state);
        // Momenta of some kg m/s at a tolerance of 1e-9 m.
        for (kept, wanted) in [(momenta(&before), momenta(&start)), (momenta(&after), momenta(&start))] {
            assert!((kept.0 - wanted.0).norm() < 1e-8 && (kept.1 - wanted.1).norm() < 1e-8, "{kept:?} {wanted:?}");
        }
        // The gap of the ball and the box of a: their rates before and after obey Newton's law, and their mass m gives the loss
        // m (1 − e²) u²/2, with the impulse m (1 + e) u. Speeds change by 1e-5 m/s in 2e-6 s.
        let rate = |state: &State| {
            let bodies = body_states(mechanism, state);
            let (a, c) = (&bodies[0], &bodies[2]);
            let normal = a.rotation * (mechanism.nonsmooth.colliders[0].pose.rotation * Vector3::y());
            let center = c.position + c.rotation * mechanism.nonsmooth.colliders[2].pose.translation.vector;
            let normal = if normal.dot(&(center - a.position)) > 0.0 { normal } else { -normal };
            let point = center - normal * 0.3;
            let of_a = a.velocity + a.angular_velocity.cross(&(point - a.position));
            let of_c = c.velocity + c.angular_velocity.cross(&(point - c.position));
            normal.dot(&(of_c - of_a))
        };
        let (comes, goes) = (rate(&before), rate(&after));
        near(goes, -restitution * comes, 1e-4);
        let impulse = impacts[0].impulse.expect("an impulse");
        let lost = kinetic(&before) - kinetic(&after);
        near(lost, 0.5 * impulse * -comes * (1.0 - restitution), 1e-4);
        assert!(impulse * -comes > 0.1, "the blow is no graze: {impulse} N s at {comes} m/s");
    }
}

#[test]
fn a_limp_leg_that_falls_on_its_trunk_does_not_enter_it() {
    let parts = [
        link("trunk", 5.0, 0.1, [0.0; 3], "<box size=\"0.6 0.3 0.1\"/>"),
        link("thigh", 0.6, 0.004, [0.0, 0.0, 0.15], "<sphere radius=\"0.05\"/>"),
        link("shank", 0.5, 0.003, [0.0, 0.0, 0.2], "<sphere radius=\"0.06\"/>"),
        joint("revolute", "trunk", "thigh", [0.2, 0.0, 0.08], "0 1 0", 1.2),
        joint("revolute", "thigh", "shank", [0.0, 0.0, 0.3], "0 1 0", 3.0),
    ];
    let scene = "base = \"floating\"\npose = { position = [0, 0, 0.05] }\npositions = { thigh_joint = -0.1, shank_joint = 0.8 }\n[[obstacle]]\nshape = { type = \"half_space\" }\n\
                 [contact]\nfriction = 0.5\nrestitution = 0.3\n";
    let (model, start) = model("leg", &parts, scene);
    let mechanism = &model.mechanism;
    let colliders = &mechanism.nonsmooth.colliders;
    let name = |of: usize| colliders[of].name.as_str();
    let pairs: Vec<_> = mechanism.nonsmooth.pairs.iter().map(|pair| (name(pair.a), name(pair.b))).collect();
    let floor = "obstacle1";
    // Neighbours are left out.
    assert_eq!(pairs, [("trunk", "shank"), ("trunk", floor), ("thigh", floor), ("shank", floor)]);
    let options = SimulationOptions::new(2.0, StepChoice::Tolerance(1e-6));
    let mut simulation = Simulation::new(mechanism, start, options).expect("a run");
    let mut least = f64::INFINITY;
    for sample in 1..=400 {
        simulation.step_to(f64::from(sample) * 5e-3).expect("steps");
        let bodies = body_states(mechanism, simulation.state());
        let frame = |collider: &Collider| {
            let body = &bodies[collider.body.expect("a body")];
            (body.position + body.rotation * collider.pose.translation.vector, body.rotation * collider.pose.rotation)
        };
        let ((trunk, turn), (ball, _)) = (frame(&colliders[0]), frame(&colliders[2]));
        let beyond = (turn.transpose() * (ball - trunk)).abs() - Vector3::new(0.3, 0.15, 0.05);
        least = least.min(beyond.sup(&Vector3::zeros()).norm() - 0.06);
    }
    let finished = simulation.finish();
    println!("{least:e} m, {:?}", finished.summary.contact);
    // It lies on the trunk, to the rounding of a metre.
    assert!(least > -1e-12 && least < 1e-9, "{least:e} m");
    assert!(finished.summary.contact.penetration <= 1e-12, "{:?}", finished.summary.contact);
}

/// A cart of four ball wheels of 0.15 m, with their axles `along` before and behind its middle and `across` beside it (m), that rolls over a floor up a step.
/// Its halves are one chassis, or hang on a hinge about the vertical and are held by a rod.
fn cart(name: &str, along: f64, across: f64, rod: bool, more: &str) -> (Model, State) {
    let (ball, axle) = ("<sphere radius=\"0.15\"/>", "0 1 0");
    let mut parts = vec![link("front", 1.2, 0.03, [0.0; 3], "")];
    let mut rear = "front";
    if rod {
        rear = "rear";
        parts.extend([
            link("rear", 1.2, 0.03, [0.0; 3], ""),
            joint("continuous", "front", "rear", [0.0; 3], "0 0 1", 0.0),
        ]);
    }
    for (wheel, on, at) in [
        ("w0", "front", [along, across, 0.0]),
        ("w1", "front", [along, -across, 0.0]),
        ("w2", rear, [-along, across, 0.0]),
        ("w3", rear, [-along, -across, 0.0]),
    ] {
        parts.extend([link(wheel, 1.086, 0.0122, [0.0; 3], ball), joint("continuous", on, wheel, at, axle, 0.0)]);
    }
    let turns = 1.045 / 0.15;
    let held = "[[loop]]\nname = \"rod\"\ntype = \"distance\"\nlength = 0.2\n\
                a = { link = \"front\", position = [0.1, 0.1, 0.0] }\nb = { link = \"rear\", position = [0.1, -0.1, 0.0] }\n";
    let scene = format!(
        "base = \"floating\"\npose = {{ position = [3.1, 1.7, 0.15] }}\nvelocity = {{ linear = [1.045, 0.0, 0.0] }}\n\
         velocities = {{ w0_joint = {turns}, w1_joint = {turns}, w2_joint = {turns}, w3_joint = {turns} }}\n{}\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.85\n\
         [[obstacle]]\nname = \"step\"\nshape = {{ type = \"box\", size = [0.5, 2.0, 0.0646] }}\n\
         pose = {{ position = [3.85, 1.7, 0.0] }}\nfriction = 0.85\n{more}",
        if rod { held } else { "" }
    );
    model(name, &parts, &scene)
}

/// How far the cart has come after 0.4 s (m).
fn rolled(model: &Model, start: &State, steps: StepChoice) -> f64 {
    let mut simulation =
        Simulation::new(&model.mechanism, start.clone(), SimulationOptions::new(0.4, steps)).expect("a run");
    simulation.step_to(0.4).expect("steps");
    simulation.state().position[0]
}

const STEPS_OVER_EVENTS: StepChoice = StepChoice::Fixed { stages: StepChoice::OVER_EVENTS, step: 1e-3 };

#[test]
fn wheels_that_touch_on_their_axle_or_at_their_rims_roll_as_wheels_that_cannot_touch_do() {
    for (name, along, across) in [("axle", 0.2447, 0.15), ("rims", 0.15, 0.25), ("both", 0.15, 0.15)] {
        let apart = "[contact]\nself_contact = false\n";
        let [touching, free] = [("", "touching"), (apart, "free")]
            .map(|(more, kind)| cart(&format!("{name}_{kind}"), along, across, false, more));
        for steps in [StepChoice::Tolerance(1e-6), STEPS_OVER_EVENTS] {
            let [one, other] = [&touching, &free].map(|(model, start)| rolled(model, start, steps));
            // The cart is 1e-6 m exact, and rolls 0.3 m.
            assert!((one - other).abs() < 2e-6 && one > 3.3, "{name}: {one} m, not {other} m");
        }
    }
}

#[test]
fn wheels_whose_axles_a_rod_holds_apart_press_each_other_in_no_step_over_events() {
    let (model, start) = cart("rod", 0.15, 0.25, true, "");
    let [exact, over] = [StepChoice::Tolerance(1e-6), STEPS_OVER_EVENTS].map(|steps| rolled(&model, &start, steps));
    // Steps of a millisecond at 1 m/s, with an impact in one of them.
    assert!((exact - over).abs() < 5e-3, "{over} m, not {exact} m");
}
