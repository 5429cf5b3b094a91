//! What scene files add acts in closed loops as in trees: a parallelogram of two cranks, and the same as one crank whose coupler follows it.
//!
//! ```text
//!     loop: cranks a and b, the coupler hinged on a, and its other end closed on b          q_b = q_a, the coupler keeps its direction
//!     tree: a crank of both masses, the coupler hinged on it with q_c = −q_a
//! ```
//!
//! Both have the same equation of motion. An arm that hangs on the coupler has a joint of its own in both.

use crate::common::scratch;
use crate::scene_files::{joint, report};
use catena::prelude::{Model, Simulation};
use catena::report::Report;
use std::path::PathBuf;

/// Two runs with tolerances of 1e-11 m, after blows and with forces that grow with the motion.
const BOUND: f64 = 1e-10;

fn link(name: &str, mass: f64, at: [f64; 3], moment: f64, shape: &str) -> String {
    let [x, y, z] = at;
    format!(
        "<link name='{name}'><inertial><origin xyz='{x} {y} {z}'/><mass value='{mass}'/><inertia ixx='{moment}' iyy='{moment}' izz='{moment}' ixy='0' \
         ixz='0' iyz='0'/></inertial>{shape}</link>"
    )
}

fn hinge(name: &str, parent: &str, child: &str, at: [f64; 3], more: &str) -> String {
    let [x, y, z] = at;
    format!(
        "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/><origin xyz='{x} {y} {z}'/><axis xyz='0 1 0'/>{more}</joint>"
    )
}

/// Cranks of 0.5 m and 1 kg, 0.6 m apart, a coupler of 2 kg with a foot 0.2 m below its first end, and an arm of 0.3 m and 0.5 kg below its middle; with
/// more tables.
fn parallelogram(folder: &str, looped: bool, more: &str) -> PathBuf {
    let folder = scratch(folder);
    let foot = "<collision><origin xyz='0 0 -0.2'/><geometry><sphere radius='0.05'/></geometry></collision>";
    let (mass, moment) = if looped { (1.0, 0.03) } else { (2.0, 0.06) };
    let mut urdf = String::from("<robot name='r'><link name='base'/>");
    urdf += &link("crank_a", mass, [0.0, 0.0, -0.25], moment, "");
    urdf += &link("coupler", 2.0, [0.3, 0.0, 0.1], 0.1, foot);
    urdf += &link("arm", 0.5, [0.0, 0.0, -0.3], 0.01, "");
    urdf += &hinge("a", "base", "crank_a", [0.0; 3], "");
    let follows = if looped { "" } else { "<mimic joint='a' multiplier='-1'/>" };
    urdf += &hinge("c", "crank_a", "coupler", [0.0, 0.0, -0.5], follows);
    urdf += &hinge("arm", "coupler", "arm", [0.3, 0.0, 0.0], "");
    let mut scene = String::from("[[robot]]\nname = \"r\"\nurdf = \"r.urdf\"\n");
    if looped {
        urdf += &link("crank_b", 1.0, [0.0, 0.0, -0.25], 0.03, "");
        urdf += &hinge("b", "base", "crank_b", [0.6, 0.0, 0.0], "");
        scene += "[[loop]]\nname = \"close\"\ntype = \"revolute\"\na = { link = \"coupler\", position = [0.6, 0, 0], axis = [0, 1, 0] }\n\
                  b = { link = \"crank_b\", position = [0, 0, -0.5], axis = [0, 1, 0] }\n";
    }
    std::fs::write(folder.join("r.urdf"), urdf + "</robot>").expect("a robot");
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene + more).expect("a scene");
    file
}

/// The loop and the tree at the end of the same run from an angle (rad), which keep their energy and end alike.
fn both(name: &str, angle: f64, more: &str) -> [Report; 2] {
    let start = |looped| {
        let mut start = vec![("a", angle)];
        // A joint that is moved starts where its motion has it.
        if !more.contains("[[motion]]") {
            start.push(("arm", 0.3));
        }
        if looped {
            start.extend([("c", -angle), ("b", angle)]);
        }
        start
    };
    let ends = [true, false].map(|looped| {
        let file = parallelogram(&format!("in_loops_{name}_{looped}"), looped, more);
        let end = report(&file, &start(looped), &[], Some(1.5), 1e-11);
        assert!(end.energy.max_relative_error < 1e-10, "{name}: {:?}", end.energy);
        assert!(end.constraint.max_position < 1e-13, "{name}: {:?}", end.constraint);
        end
    });
    for of in ["a", "arm"] {
        let ((q, v), (wanted_q, wanted_v)) = (joint(&ends[0], of), joint(&ends[1], of));
        assert!(
            (q - wanted_q).abs() < BOUND && (v - wanted_v).abs() < BOUND,
            "{name}, {of}: {q} {wanted_q}, {v} {wanted_v}"
        );
    }
    ends
}

fn near(what: &str, (is, wanted): (f64, f64)) {
    assert!((is - wanted).abs() < BOUND, "{what}: {is} instead of {wanted}");
}

#[test]
fn loads_over_time_and_drag_act_in_a_loop_as_in_the_tree_that_moves_alike() {
    let loads = "[[load]]\njoint = \"a\"\neffort = 2\nfactor = [[0.2, 0], [0.5, 3], [0.9, -1]]\ninterpolation = \"linear\"\nuntil = 1.2\n\
                 [[load]]\nlink = \"coupler\"\nposition = [0.2, 0, 0.1]\nforce = [3, 0, 1]\nwave = { amplitude = 1, frequency = 9 }\n\
                 [[load]]\nlink = \"arm\"\nforce = [1, 0, 2]\nframe = \"link\"\nfactor = { formula = \"a*exp(-t/c)\", a = 2, c = 0.4 }\n";
    let [looped, tree] = both("loads", 0.7, loads);
    near("work", (looped.energy.work, tree.energy.work));
    assert!(looped.energy.work.abs() > 0.1, "the loads work: {} J", looped.energy.work);
    let drag = "[[drag]]\nlink = \"coupler\"\nposition = [0.1, 0, 0]\nlinear = 0.8\nquadratic = 0.5\n[[drag]]\nlink = \"arm\"\nangular = 0.02\n";
    let [looped, tree] = both("drag", 0.7, drag);
    near("heat", (looped.energy.dissipated, tree.energy.dissipated));
    assert!(looped.energy.dissipated > 0.5, "drag brakes: {} J", looped.energy.dissipated);
}

#[test]
fn a_rope_on_a_loop_and_a_winch_pull_as_on_the_tree_that_moves_alike() {
    let rope = "[[rope]]\nname = \"rope\"\npoints = [{ link = \"world\", position = [-0.5, 0, 0.1] }, { link = \"coupler\", position = [0.2, 0, 0] }]\n\
                length = 0.9\nrestitution = 0.4\n";
    let [looped, tree] = both("rope", 0.7, rope);
    near("blows", (looped.energy.impacts, tree.energy.impacts));
    assert!(looped.energy.impacts > 0.01, "it goes taut: {} J", looped.energy.impacts);
    let winch = "[[rope]]\nname = \"winch\"\npoints = [{ link = \"world\", position = [0.5, 0, 0.3] }, { link = \"coupler\", position = [0.2, 0, 0] }]\n\
                 length = { formula = \"l - v*t\", l = 0.95, v = 0.1 }\nlongest = 2\n";
    let [looped, tree] = both("winch", 0.7, winch);
    near("blows of the winch", (looped.energy.impacts, tree.energy.impacts));
}

#[test]
fn a_relation_of_two_joints_in_a_loop_and_a_rotor_are_those_of_the_tree_that_moves_alike() {
    both("coupling", 0.7, "[[coupling]]\nname = \"gear\"\njoints = { a = 2.0, arm = -1.0 }\noffset = 1.1\n");
    both(
        "rotor",
        0.7,
        "[[joint]]\nname = \"a\"\narmature = 0.2\nfriction = 0.3\n[[joint]]\nname = \"arm\"\narmature = 0.05\n",
    );
    both(
        "moved",
        0.7,
        "[[motion]]\njoint = \"arm\"\nposition = { formula = \"b + a*sin(w*t)^3\", a = 0.4, w = 5, b = 0.3 }\n",
    );
}

#[test]
fn a_foot_of_a_loop_meets_a_belt_as_the_foot_of_the_tree_that_moves_alike() {
    // The crank is steeper than the cone of friction, so that the belt cannot wedge the foot.
    let belt = "[[obstacle]]\nname = \"belt\"\nshape = { type = \"half_space\" }\npose = { position = [0, 0, -0.55] }\nfriction = 0.6\nrestitution = 0.4\n\
                surface_velocity = [-0.8, 0, 0]\nrolling_friction = 0.002\n[contact]\nself_contact = false\n";
    let [looped, tree] = both("belt", 1.2, belt);
    near("blows", (looped.energy.impacts, tree.energy.impacts));
    near("friction", (looped.energy.friction, tree.energy.friction));
    near("work of the belt", (looped.energy.work, tree.energy.work));
    assert!(looped.energy.impacts > 0.01, "the foot meets it: {} J", looped.energy.impacts);
}

#[test]
fn derivatives_refuse_what_they_do_not_know_in_one_line() {
    let rope =
        "[[rope]]\npoints = [{ link = \"world\", position = [0.5, 0, 0.1] }, { link = \"coupler\" }]\nlength = 0.9\n";
    let belt = "[[obstacle]]\nshape = { type = \"half_space\" }\npose = { position = [0, 0, -2] }\nsurface_velocity = [0.8, 0, 0]\n";
    for (name, more, said) in [
        ("rope", rope, "ropes"),
        ("belt", belt, "surfaces that move"),
        ("drag", "[[drag]]\nlink = \"arm\"\nlinear = 0.8\n", "drag and loads over time"),
        ("motion", "[[motion]]\njoint = \"arm\"\nposition = { formula = \"t^2\" }\n", "moved in time"),
    ] {
        let model = Model::load(parallelogram(&format!("underivable_{name}"), false, more)).expect("a model");
        let keys = ["link.arm.mass"];
        let error = Simulation::new(&model).duration(0.1).sensitivity(&keys).expect_err(name).to_string();
        assert!(error.contains(said) && error.lines().count() == 1, "{name}: {error}");
    }
}

#[test]
fn derivatives_by_a_number_of_a_belt_that_stands_are_refused_as_those_of_one_that_moves() {
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\npose = { position = [0, 0, -2] }\nfriction = 0.4\nrolling_friction = 0\n";
    let model = Model::load(parallelogram("underivable_numbers", false, floor)).expect("a model");
    let by = |key: &str| Simulation::new(&model).duration(0.1).sensitivity(&[key]);
    for (key, said) in [
        ("obstacle.floor.surface_velocity.x", "surfaces that move"),
        ("obstacle.floor.rolling_friction", "there is no derivative by it at 0"),
    ] {
        let error = by(key).expect_err(key).to_string();
        assert!(error.contains(said) && error.lines().count() == 1, "{key}: {error}");
    }
    assert!(by("obstacle.floor.friction").is_ok());
}
