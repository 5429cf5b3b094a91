//! Contacts whose gaps closed loops alone keep at zero carry nothing: a mechanism moves as beside an obstacle a little farther away.
//!
//! ```text
//!     scissor lift:   two arms of 0.5 m crossed, one hinged on the ground, the other on a top that moves upwards; its lower end is a roller at the height 0
//!     slider crank:   a rod whose ball end moves along a line with its slider
//! ```

use crate::common::scratch;
use crate::scene_files::{apart, joint, report};
use catena::prelude::{Model, Simulation};
use catena::report::Report;
use std::path::{Path, PathBuf};

/// Two runs with tolerances of 1e-9 m, after blows.
const BOUND: f64 = 1e-7;

fn link(name: &str, mass: f64, at: f64, moment: f64, shape: &str) -> String {
    format!(
        "<link name='{name}'><inertial><origin xyz='{at} 0 0'/><mass value='{mass}'/><inertia ixx='{moment}' iyy='{moment}' izz='{moment}' ixy='0' \
         ixz='0' iyz='0'/></inertial>{shape}</link>"
    )
}

fn shape(at: [f64; 3], geometry: &str) -> String {
    let [x, y, z] = at;
    format!("<collision><origin xyz='{x} {y} {z}'/><geometry>{geometry}</geometry></collision>")
}

fn hinge(name: &str, parent: &str, child: &str, at: f64, kind: &str, axis: &str) -> String {
    format!(
        "<joint name='{name}' {kind}<parent link='{parent}'/><child link='{child}'/><origin xyz='{at} 0 0'/><axis xyz='{axis}'/></joint>"
    )
}

fn limited(kind: &str, lower: f64, upper: f64) -> String {
    format!("type='{kind}'><limit lower='{lower}' upper='{upper}' effort='0' velocity='100'/>")
}

const CONTINUOUS: &str = "type='continuous'>";

fn scene(folder: &str, urdf: &str, loop_at: f64, rod: &str, end: &str, more: &str) -> PathBuf {
    let folder = scratch(folder);
    std::fs::write(folder.join("r.urdf"), urdf).expect("a robot");
    let scene = format!(
        "[[robot]]\nname = \"r\"\nurdf = \"r.urdf\"\n[[loop]]\nname = \"close\"\ntype = \"revolute\"\n\
         a = {{ link = \"r/{rod}\", position = [{loop_at}, 0, 0], axis = [0, 1, 0] }}\nb = {{ link = \"r/{end}\", axis = [0, 1, 0] }}\n"
    );
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene + more).expect("a scene");
    file
}

/// A scissor lift whose roller, of 1 cm, glides along a floor at a gap (m); its arm is within −1.4 and −0.05 rad.
fn scissor(name: &str, gap: f64, more: &str) -> PathBuf {
    let roller = shape([0.25, 0.0, 0.0], "<sphere radius='0.01'/>");
    let plate = shape([0.25, 0.0, 0.01], "<box size='0.5 0.2 0.02'/>");
    let urdf = String::from("<robot name='r'><link name='ground'/>")
        + &link("arm", 0.3, 0.25, 0.00625, "")
        + &hinge("a", "ground", "arm", 0.0, &limited("revolute", -1.4, -0.05), "0 1 0")
        + &link("other", 0.3, 0.0, 0.006, &roller)
        + &hinge("b", "arm", "other", 0.25, CONTINUOUS, "0 1 0")
        + &link("top", 1.0, 0.0, 0.02, &plate)
        + &hinge("z", "ground", "top", 0.0, &limited("prismatic", 0.0, 1.0), "0 0 1")
        + "</robot>";
    let floor = format!(
        "[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\npose = {{ position = [0, 0, {}] }}\n",
        -0.01 - gap
    );
    scene(&format!("kept_{name}_{gap}"), &urdf, -0.25, "other", "top", &(floor + more))
}

fn of_scissor(angle: f64) -> Vec<(&'static str, f64)> {
    vec![("a", -angle), ("b", 2.0 * angle), ("z", 0.5 * angle.sin())]
}

const CRANK: f64 = 0.19;
const ROD: f64 = 0.46;

/// A slider crank 0.3 m above a table's top at a gap (m) below the rod's shape.
fn crank(name: &str, gap: f64, limits: [f64; 2], of_rod: &str, more: &str) -> PathBuf {
    let kind = limited("revolute", limits[0], limits[1]);
    let urdf = String::from("<robot name='r'><link name='ground'/>")
        + &link("crank", 0.4, 0.095, 0.00127, "")
        + &hinge("a", "ground", "crank", 0.0, &kind, "0 1 0")
        + &link("rod", 0.4, 0.23, 0.003, of_rod)
        + &hinge("b", "crank", "rod", CRANK, CONTINUOUS, "0 1 0")
        + &link("slider", 0.6, 0.0, 0.01, "")
        + &hinge("s", "ground", "slider", 0.0, &limited("prismatic", -5.0, 5.0), "1 0 0")
        + "</robot>";
    let table = format!(
        "[[obstacle]]\nname = \"table\"\nshape = {{ type = \"box\", size = [4, 1, 0.2] }}\npose = {{ position = [0, 0, {}] }}\n",
        -0.13 - gap
    );
    scene(&format!("kept_{name}_{gap}"), &urdf, ROD, "rod", "slider", &(table + more))
}

fn of_crank(angle: f64) -> Vec<(&'static str, f64)> {
    let rises = -(CRANK * angle.sin() / ROD).asin();
    vec![("a", angle), ("b", rises - angle), ("s", CRANK * angle.cos() + ROD * rises.cos())]
}

fn ball(at: f64) -> String {
    shape([at, 0.0, 0.0], "<sphere radius='0.03'/>")
}

/// Both runs end alike, and keep their energy.
fn alike(name: &str, files: [&Path; 2], start: &[(&str, f64)], rates: &[(&str, f64)], duration: f64) -> [Report; 2] {
    let ends = files.map(|file| report(file, start, rates, Some(duration), 1e-9));
    for end in &ends {
        assert!(end.energy.max_relative_error < 1e-8, "{name}: {:?}", end.energy);
    }
    let [one, other] = &ends;
    println!("{name}: {:e} m apart, {:?}", apart(one, other), one.energy);
    assert!(apart(one, other) < BOUND, "{name}: {} m apart", apart(one, other));
    let impacts = [one, other].map(|end| end.energy.impacts);
    assert!((impacts[0] - impacts[1]).abs() < BOUND, "{name}: {impacts:?} J lost in impacts");
    assert!(one.energy.friction.abs() < BOUND, "{name}: friction of what presses nothing, {}", one.energy.friction);
    ends
}

#[test]
fn a_roller_that_a_scissor_lift_keeps_on_its_floor_does_not_change_how_the_lift_rebounds_from_its_limit() {
    for (name, friction, restitution) in [("rebounds", 0.057, 0.5), ("smooth", 0.0, 0.5), ("plastic", 0.3, 0.0)] {
        let more = format!(
            "[contact]\nfriction = {friction}\nrestitution = 0.3\n[[joint]]\nname = \"r/a\"\nrestitution = {restitution}\n"
        );
        let files = [0.0, 1e-4].map(|gap| scissor(name, gap, &more));
        let [end, _] = alike(name, [&files[0], &files[1]], &of_scissor(0.35), &[], 0.9);
        assert!(end.energy.impacts > 0.5, "{name}: it falls on its limit");
    }
}

#[test]
fn a_roller_of_a_lift_that_is_moved_in_time_is_kept_by_its_loop_alone() {
    // The motor of the motion carries all that the loop does not.
    let more = "[contact]\nfriction = 0.3\n[[motion]]\njoint = \"r/a\"\nposition = { formula = \"b + a*sin(w*t)^2\", a = -0.4, w = 3, b = -0.5 }\n";
    let files = [0.0, 1e-4].map(|gap| scissor("moved", gap, more));
    let start: Vec<(&str, f64)> = of_scissor(0.5).into_iter().filter(|(name, _)| *name != "a").collect();
    let [end, _] = alike("moved", [&files[0], &files[1]], &start, &[], 0.9);
    assert!(end.energy.work.abs() > 0.1, "the motion works: {} J", end.energy.work);
}

#[test]
fn a_box_that_falls_on_a_scissor_lift_is_met_and_carried_while_its_roller_is_kept_on_the_floor() {
    for (name, friction) in [("load", 0.0), ("load_with_friction", 0.4)] {
        let top = 0.5 * 0.6_f64.sin() + 0.02;
        let more = format!(
            "[contact]\nfriction = {friction}\n[[body]]\nname = \"load\"\nshape = {{ type = \"box\", size = [0.1, 0.1, 0.1] }}\nmass = 0.8\n\
             pose = {{ position = [0.2, 0, {}] }}\n",
            top + 0.05 + 0.02
        );
        let motor = "[[motor]]\njoint = \"r/z\"\nkind = \"position\"\nkp = 2000\nkd = 60\ntarget = 0.28\n";
        let files = [0.0, 2e-3].map(|gap| scissor(name, gap, &(more.clone() + motor)));
        let [end, _] = alike(name, [&files[0], &files[1]], &of_scissor(0.6), &[], 0.8);
        let (height, _) = joint(&end, "z");
        let (_, load) = end.links.iter().find(|(of, _)| of == "load").expect("the load");
        assert!((load.center_of_mass[2] - height - 0.07).abs() < 1e-9, "{name}: {:?} on {height}", load.center_of_mass);
        assert!(end.energy.impacts > 1e-3, "{name}: the box falls on it");
    }
}

#[test]
fn a_ball_that_a_slider_crank_moves_along_a_table_does_not_change_its_motion() {
    let scenes: [(&str, f64, [f64; 2], f64, f64); 4] = [
        ("limited", 0.0, [-1.12, -0.32], -0.62, -0.58),
        ("rubs", 0.53, [-1.2, -0.3], -0.74, -2.5),
        ("free", 0.0, [-50.0, 50.0], -0.62, 1.0),
        ("turns", 0.3, [-50.0, 50.0], -1.04, 9.0),
    ];
    for (name, friction, limits, angle, rate) in scenes {
        let more = format!(
            "[contact]\nfriction = {friction}\nrestitution = 0.4\n[[joint]]\nname = \"r/a\"\nrestitution = 0.5\n"
        );
        let files = [0.0, 1e-3].map(|gap| crank(name, gap, limits, &ball(ROD), &more));
        alike(name, [&files[0], &files[1]], &of_crank(angle), &[("a", rate)], 0.8);
    }
}

#[test]
fn the_other_end_of_a_capsule_that_glides_along_a_table_meets_it() {
    // The pin of the crank falls until the rod lies on the table: as with a ball at the pin alone.
    let capsule = "<capsule radius='0.03' length='0.46'/>";
    let lies = format!(
        "<collision><origin xyz='0.23 0 0' rpy='0 {} 0'/><geometry>{capsule}</geometry></collision>",
        std::f64::consts::FRAC_PI_2
    );
    let more = "[contact]\nrestitution = 0.5\n";
    let limits = [-50.0, 50.0];
    let files = [("capsule", lies), ("pin", ball(0.0))].map(|(name, of_rod)| crank(name, 0.0, limits, &of_rod, more));
    let [end, _] = alike("capsule", [&files[0], &files[1]], &of_crank(-0.7), &[], 0.6);
    assert!(end.energy.impacts > 0.1, "the pin meets the table");
}

#[test]
fn a_slider_that_touches_a_wall_at_the_dead_point_of_its_crank_moves_on_as_without_it() {
    // The wall is at the farthest that the slider comes.
    let ball = shape([0.0, 0.0, 0.0], "<sphere radius='0.03'/>");
    let wall = |name: &str, place: f64| {
        let more = format!(
            "[[obstacle]]\nname = \"wall\"\nshape = {{ type = \"box\", size = [0.2, 1, 1] }}\npose = {{ position = [{}, 0, 0] }}\n",
            CRANK + ROD + 0.13 + place
        );
        let file = crank(name, 0.5, [-50.0, 50.0], "", &more);
        let urdf = file.with_file_name("r.urdf");
        let text = std::fs::read_to_string(&urdf).expect("a robot");
        let at = text.find("<link name='slider'>").expect("a slider") + "<link name='slider'>".len();
        std::fs::write(&urdf, text[..at].to_owned() + &ball + &text[at..]).expect("a robot");
        let model = Model::load(&file).expect("a scene");
        let start = of_crank(0.0);
        let simulation = Simulation::new(&model).tolerance(1e-9).duration(1.2);
        let simulation = simulation.start(start.iter().copied()).expect("a start");
        let mut simulation = simulation.velocities([("a", 6.0)]).expect("rates");
        simulation.run().expect("a run");
        simulation.finish().expect("a report")
    };
    let [touched, far] = [("touched", 0.0), ("far", 1e-2)].map(|(name, place)| wall(name, place));
    assert!(apart(&touched, &far) < BOUND, "{} m apart", apart(&touched, &far));
    assert!(touched.energy.impacts.abs() < BOUND, "{:?}", touched.energy);
}
