//! Plane mechanisms whose loops are closed by hinges: five equations of which the plane leaves three empty, up to roundings of their gradients.
//!
//! ```text
//!     crank A P, coupler P Q, rocker D Q, and from Q a rod Q R, and a lever E R
//!     closed at Q and R by hinges about y, or by balls: the same motion in the plane
//! ```
//!
//! An equation that is taken for one because its roundings are large beside themselves holds the whole mechanism: an impact on a limit then had an impulse
//! of 1e262 N m s.

use crate::common::scratch;
use crate::scene_files::{joint, report};
use catena::report::Report;
use std::path::PathBuf;

/// The two runs have an accuracy of 1e-9 m each, and meet limits at up to 7 rad/s in mechanisms of half a metre.
const BOUND: f64 = 1e-6;

/// A slender link of a mass (kg) along a vector (m) in its x-z plane from its hinge. Its principal axes are turned, so that axes are rounded.
fn link(name: &str, mass: f64, [x, z]: [f64; 2]) -> String {
    let moment = mass * (x * x + z * z) / 12.0;
    format!(
        "<link name='{name}'><inertial><origin xyz='{} 0 {}' rpy='0 {} 0'/><mass value='{mass}'/><inertia ixx='{}' iyy='{moment}' izz='{moment}' ixy='0' \
         ixz='0' iyz='0'/></inertial></link>",
        0.5 * x,
        0.5 * z,
        -z.atan2(x),
        0.01 * moment
    )
}

fn hinge(name: &str, parent: &str, child: &str, [x, z]: [f64; 2], limit: &str, friction: f64) -> String {
    let kind = if limit.is_empty() { "continuous" } else { "revolute" };
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><origin xyz='{x} 0 {z}'/><axis xyz='0 1 0'/>{limit}\
         <dynamics friction='{friction}'/></joint>"
    )
}

/// One of a family of six-bars with irregular numbers, whose rocker has limits and of which some cranks have dry friction, closed by hinges or balls.
fn six_bar(number: usize, closed_by: &str) -> PathBuf {
    let folder = scratch(&format!("hinged_loops_{number}_{closed_by}"));
    let part = |factor: f64| (factor * (number as f64 + 1.0)).sin();
    let crank = [0.08 + 0.02 * part(1.3), 0.1 + 0.02 * part(2.1)];
    let coupler = [0.3 + 0.05 * part(0.7), 0.2 + 0.05 * part(1.9)];
    let ground = [0.41 + 0.03 * part(2.9), 0.013 * part(0.3)];
    let rocker = [crank[0] + coupler[0] - ground[0], crank[1] + coupler[1] - ground[1]];
    let (rod, base) = ([0.2 + 0.03 * part(1.7), -0.12 + 0.03 * part(2.3)], [0.65 + 0.03 * part(0.5), 0.01 * part(3.1)]);
    let tip = [ground[0] + rocker[0], ground[1] + rocker[1]];
    let lever = [tip[0] + rod[0] - base[0], tip[1] + rod[1] - base[1]];
    let limit = format!(
        "<limit lower='{}' upper='{}' effort='99' velocity='99'/>",
        -0.2 + 0.05 * part(1.1),
        0.2 + 0.05 * part(3.3)
    );
    let mut urdf = String::from("<robot name='r'><link name='base'/>");
    urdf += &(link("crank", 0.8, crank) + &link("coupler", 0.9, coupler) + &link("rocker", 0.7, rocker));
    urdf += &hinge("a", "base", "crank", [0.0; 2], "", if number.is_multiple_of(2) { 0.02 } else { 0.0 });
    urdf += &hinge("b", "crank", "coupler", crank, "", 0.0);
    urdf += &hinge("c", "base", "rocker", ground, &limit, 0.0);
    urdf += &(link("rod", 0.4, rod) + &link("lever", 1.0, lever));
    urdf += &hinge("d", "rocker", "rod", rocker, "", 0.0);
    urdf += &hinge("e", "base", "lever", base, "", 0.0);
    std::fs::write(folder.join("r.urdf"), urdf + "</robot>").expect("a robot");
    let axis = if closed_by == "revolute" { ", axis = [0, 1, 0]" } else { "" };
    let end = |link: &str, [x, z]: [f64; 2]| format!("{{ link = \"{link}\", position = [{x}, 0, {z}]{axis} }}");
    let mut scene = format!("[[robot]]\nurdf = \"r.urdf\"\nvelocities = {{ a = {} }}\n", 3.0 + part(0.9));
    for ends in [[end("coupler", coupler), end("rocker", rocker)], [end("rod", rod), end("lever", lever)]] {
        scene += &format!("[[loop]]\ntype = \"{closed_by}\"\na = {}\nb = {}\n", ends[0], ends[1]);
    }
    scene += "[[joint]]\nname = \"c\"\nrestitution = 0.4\n";
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene).expect("a scene");
    file
}

#[test]
fn six_bars_that_hinges_close_keep_the_balance_of_energies_at_limits_and_with_friction_and_end_as_those_that_balls_close()
 {
    let mut impacts = 0;
    for number in 0..60 {
        let [hinged, with_ball] =
            ["revolute", "spherical"].map(|kind| report(&six_bar(number, kind), &[], &[], Some(1.0), 1e-9));
        let balance = |report: &Report| report.energy.max_relative_error;
        assert!(
            balance(&hinged) < 1e-9 && balance(&with_ball) < 1e-9,
            "{number}: {} {}",
            balance(&hinged),
            balance(&with_ball)
        );
        for of in ["a", "c", "e"] {
            let ((q, v), (wanted_q, wanted_v)) = (joint(&hinged, of), joint(&with_ball, of));
            assert!(
                (q - wanted_q).abs() < BOUND && (v - wanted_v).abs() < BOUND,
                "{number}, {of}: {q} {wanted_q}, {v} {wanted_v}"
            );
        }
        impacts += hinged.events.list.iter().filter(|event| event.kind == "limit_impact").count();
    }
    assert!(impacts > 40, "they meet their limits: {impacts} times");
}
