//! A crank with a slider pushes a box over a rough floor up to its dead centre, where the slider turns round and leaves the box.
//!
//! ```text
//!     x = r cos θ + √(l² − r² sin² θ),  sin φ = −(r/l) sin θ                                 about a vertical axis: no weight does work
//!     ½ M(θ) θ̇² = τ (θ − θ₀) − (F + μ m g) (x(0) − x(θ₀)) − F (x(0) − x(θ)),   M = I + m_r |c'|² + I_r φ'² + m_s x'²          θ₀ < 0 < θ
//! ```
//!
//! r, l: the crank and the rod (m); τ: the effort at the crank (N m); F: friction of the slide (N); μ, m: friction below the box, and its mass (kg);
//! I, I_r: inertias of the crank and the rod (kg m²); m_r, m_s: masses of the rod and the slider (kg); c: the centre of the rod (m).

use crate::scene_files::{joint, report, scene_of};
use catena::report::Report;

const GRAVITY: f64 = 9.81;
const CRANK: f64 = 0.1;
const ROD: f64 = 0.3;
/// Half the length of the slider and of the box along the slide (m).
const HALF: f64 = 0.04;

/// One scene: τ, F, μ, m, the friction between slider and box, the shape of the slider, and θ₀.
#[derive(Clone, Copy, Debug)]
struct Scene {
    effort: f64,
    slide: f64,
    floor: f64,
    box_mass: f64,
    face: f64,
    shape: &'static str,
    start: f64,
}

/// x and x' at an angle (m).
fn slider(angle: f64) -> (f64, f64) {
    let across = CRANK * angle.sin();
    let along = (ROD * ROD - across * across).sqrt();
    (CRANK * angle.cos() + along, -across - across * CRANK * angle.cos() / along)
}

/// φ and φ' at an angle.
fn rod(angle: f64) -> (f64, f64) {
    let turned = -(CRANK * angle.sin() / ROD).asin();
    (turned, -CRANK * angle.cos() / (ROD * turned.cos()))
}

/// θ̇ at an angle behind the dead centre (rad/s).
fn rate(scene: &Scene, angle: f64) -> f64 {
    let ((turned, turning), (place, moving)) = (rod(angle), slider(angle));
    let centre = [
        -CRANK * angle.sin() - 0.5 * ROD * turned.sin() * turning,
        CRANK * angle.cos() + 0.5 * ROD * turned.cos() * turning,
    ];
    let mass =
        0.05 + 0.5 * (centre[0] * centre[0] + centre[1] * centre[1]) + 0.004 * turning * turning + moving * moving;
    let pushed = scene.slide + scene.floor * scene.box_mass * GRAVITY;
    let (first, dead) = (slider(scene.start).0, slider(0.0).0);
    let work = scene.effort * (angle - scene.start) - pushed * (dead - first) - scene.slide * (dead - place);
    (2.0 * work / mass).sqrt()
}

fn run(folder: &str, scene: &Scene, tolerance: f64) -> Report {
    let link = |name: &str, mass: f64, centre: f64, inertia: f64, more: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{centre} 0 0'/><mass value='{mass}'/>\
             <inertia ixx='{inertia}' ixy='0' ixz='0' iyy='{inertia}' iyz='0' izz='{inertia}'/></inertial>{more}</link>"
        )
    };
    let shape = format!("<collision><geometry>{}</geometry></collision>", scene.shape);
    let links = [
        link("crank", 0.5, 0.0, 0.05, ""),
        link("rod", 0.5, 0.5 * ROD, 0.004, ""),
        link("slider", 1.0, 0.0, 0.01, &shape),
    ];
    let robot = format!(
        "<link name='base'/>{}\
         <joint name='c' type='continuous'><origin xyz='0 0 0.05'/><parent link='base'/><child link='crank'/><axis xyz='0 0 1'/></joint>\
         <joint name='r' type='continuous'><origin xyz='{CRANK} 0 0'/><parent link='crank'/><child link='rod'/><axis xyz='0 0 1'/></joint>\
         <joint name='s' type='prismatic'><origin xyz='0 0 0.05'/><parent link='base'/><child link='slider'/><axis xyz='1 0 0'/>\
         <limit lower='-2' upper='2' effort='0' velocity='99'/><dynamics friction='{}'/></joint>",
        links.concat(),
        scene.slide
    );
    let (place, _) = slider(scene.start);
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\npositions = {{ c = {:?}, r = {:?}, s = {place:?} }}\n\
         [[loop]]\ntype = \"revolute\"\na = {{ link = \"rod\", position = [{ROD}, 0, 0], axis = [0, 0, 1] }}\n\
         b = {{ link = \"slider\", position = [0, 0, 0], axis = [0, 0, 1] }}\n\
         [[motor]]\njoint = \"c\"\nkind = \"effort\"\ntarget = {}\n\
         [[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [{}, 0.2, 0.1] }}\nmass = {}\npose.position = [{:?}, 0, 0.05]\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {}\n[contact]\nfriction = {}\n\
         [[contact.pair]]\na = \"slider\"\nb = \"floor\"\nignore = true\n",
        scene.start,
        rod(scene.start).0 - scene.start,
        scene.effort,
        2.0 * HALF,
        scene.box_mass,
        place + 2.0 * HALF,
        scene.floor,
        scene.face
    );
    report(&scene_of(folder, &robot, &text), &[], &[], Some(0.8), tolerance)
}

#[test]
fn a_crank_that_pushes_a_box_passes_its_dead_centre_without_a_blow() {
    for shape in ["<sphere radius='0.04'/>", "<box size='0.08 0.1 0.06'/>"] {
        for case in 0..8 {
            let part = f64::from(case) / 8.0;
            let scene = Scene {
                effort: 0.6 + 0.1 * part,
                slide: 0.2 + 1.5 * part,
                floor: 0.3 + 0.2 * part,
                box_mass: 1.0 - 0.5 * part,
                face: if case % 2 == 0 { 0.0 } else { 0.3 },
                shape,
                start: -1.2 + 0.3 * part,
            };
            for tolerance in [1e-3, 1e-6, 1e-8] {
                let found = run("crank_and_box", &scene, tolerance);
                let (angle, turning) = joint(&found, "c");
                let off = turning - rate(&scene, angle);
                let (_, end) = found.links.iter().find(|(name, _)| name == "box").expect("a box");
                let beside = end.center_of_mass[0] - slider(0.0).0 - 2.0 * HALF;
                let lost = found.energy.impacts;
                let case = format!("{scene:?}, {tolerance:e}: {off:e} rad/s, box {beside:e} m, {lost:e} J in blows");
                assert!(angle > 0.1 && off.abs() * CRANK <= tolerance, "{case}");
                // The box stops where the slider turns round, and nothing strikes.
                assert!(beside.abs() <= tolerance, "{case}");
                // No more than what pushes the box does over the tolerance.
                assert!(lost.abs() <= tolerance * (scene.slide + scene.floor * scene.box_mass * GRAVITY), "{case}");
                assert!(found.events.list.iter().all(|event| event.impulse.is_none()), "{case}");
            }
        }
    }
}

/// A vertical crank of a random scene whose slider is put on its dead centre to the last bit, in steps of 1e-8 m; its box is struck before.
const STRIKES: [&str; 2] = [
    "<link name='base'/><link name='crank'><inertial><origin xyz='0.04662621345889165 0 0'/><mass value='0.5449224684171702'/>\
     <inertia ixx='0.002' iyy='0.002' izz='0.002' ixy='0' ixz='0' iyz='0'/></inertial></link>\
     <link name='rod'><inertial><origin xyz='0.13844685578135807 0 0'/><mass value='0.3383247479539436'/>\
     <inertia ixx='0.004' iyy='0.004' izz='0.004' ixy='0' ixz='0' iyz='0'/></inertial></link>\
     <link name='slider'><inertial><origin xyz='0 0 0'/><mass value='1.1045348913273416'/>\
     <inertia ixx='0.002' iyy='0.002' izz='0.002' ixy='0' ixz='0' iyz='0'/></inertial>\
     <collision><origin xyz='0 0 0'/><geometry><box size='0.08 0.1 0.1'/></geometry></collision></link>\
     <joint name='c' type='continuous'><parent link='base'/><child link='crank'/><origin xyz='0 0 0.06'/><axis xyz='0 -1 0'/>\
     <dynamics friction='0.0' damping='0.01'/></joint>\
     <joint name='r' type='continuous'><parent link='crank'/><child link='rod'/><origin xyz='0.0932524269177833 0 0'/><axis xyz='0 -1 0'/></joint>\
     <joint name='s' type='prismatic'><parent link='base'/><child link='slider'/><origin xyz='0 0 0.06'/><axis xyz='1 0 0'/>\
     <limit lower='-2' upper='2' effort='0' velocity='100'/><dynamics friction='0.23015876424689496'/></joint>",
    "[[robot]]\nurdf = \"robot.urdf\"\n\
     positions = { c = 4.188928121114041, r = -3.8929414416532944, s = 0.21823786075675786 }\n\
     [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.22938554471107522\nrestitution = 0.0\n\
     [[motor]]\njoint = \"c\"\nkind = \"velocity\"\nkd = 4.36158720087759\ntarget = 3.0169621931197206\nmax_effort = 5.248796970312766\n\
     [[loop]]\ntype = \"revolute\"\na = { link = \"rod\", position = [0.27689371156271614, 0.0, 0.0], axis = [0.0, 1.0, 0.0] }\n\
     b = { link = \"slider\", position = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0] }\n\
     [[body]]\nname = \"box\"\nshape = { type = \"box\", size = [0.060685127402374, 0.12579549587609903, 0.07501376243798616] }\n\
     mass = 1.0165090193358977\npose.position = [0.3843111112684183, 0.01710066803489305, 0.03750688121899308]\n\
     [contact]\nrestitution = 0.3\nfriction = 0.3682041896218001\n\
     [[contact.pair]]\na = \"slider\"\nb = \"floor\"\nignore = true\n",
];

#[test]
fn rates_that_are_roundings_at_a_dead_centre_give_no_energy_to_the_crank() {
    let file = scene_of("strikes", STRIKES[0], STRIKES[1]);
    let [wanted, found] = [1e-6, 1e-8].map(|tolerance| report(&file, &[], &[], Some(1.2), tolerance));
    let ([angle, other], lost) = ([&wanted, &found].map(|run| joint(run, "c").0), found.energy.impacts);
    assert!((other - angle).abs() < 1e-6, "{other} instead of {angle}");
    assert!((lost - wanted.energy.impacts).abs() < 1e-6, "{lost} J instead of {} J", wanted.energy.impacts);
}
