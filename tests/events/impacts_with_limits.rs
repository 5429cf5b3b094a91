//! Bodies that lie on a link whose joint meets its limit.

use crate::scene_files::scene_of;
use catena::prelude::{Model, Simulation};
use catena::report::Report;

/// A plank of 3 m on a pivot whose limits have the restitution 0.4, with a heavy box on one arm and a light one on the other.
const SEESAW: &str = "<link name='base'/><link name='plank'><inertial><mass value='11.3'/>\
    <inertia ixx='0.08' ixy='0' ixz='0' iyy='8.6' iyz='0' izz='8.65'/></inertial><collision><geometry><box size='3.0 0.3 0.06'/></geometry>\
    </collision></link><joint name='pivot' type='revolute'><origin xyz='0 0 0.6'/><parent link='base'/><child link='plank'/><axis xyz='0 1 0'/>\
    <limit lower='-0.35' upper='0.35' effort='0' velocity='100'/></joint>";
const BOXES: &str = "[[robot]]\nurdf = \"robot.urdf\"\n[[joint]]\nname = \"pivot\"\nrestitution = 0.4\n\
    [[body]]\nname = \"heavy\"\nshape = { type = \"box\", size = [0.25, 0.2, 0.31] }\nmass = 6.1\npose = { position = [1.23, 0, 0.785] }\n\
    [[body]]\nname = \"light\"\nshape = { type = \"box\", size = [0.2, 0.2, 0.2] }\nmass = 4.3\npose = { position = [-1.17, 0, 0.73] }\n\
    [contact]\nfriction = 0.47\n";

/// The report, the velocities of both boxes (m/s), and the rate of the plank (rad/s) after a time (s).
fn after(time: f64, tolerance: f64) -> (Report, [[f64; 3]; 2], f64) {
    let file = scene_of("seesaw_meets_its_limit", SEESAW, BOXES);
    let model = Model::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&model).tolerance(tolerance).duration(time);
    simulation.run().unwrap_or_else(|error| panic!("{error}"));
    let velocity = |link: &str| simulation.link(link).expect("a link").linear_velocity.into();
    let (velocities, rate) = (["heavy", "light"].map(velocity), simulation.velocity("pivot").expect("a joint")[0]);
    (simulation.finish().expect("a report"), velocities, rate)
}

#[test]
fn a_box_on_the_rising_arm_of_a_seesaw_flies_on_when_the_plank_meets_its_limit() {
    // The limit is met at 0.819975 s. The rounds between limit, plank and heavy box take all their motion, as long as the plank gives back less than
    // the box brings; nothing can hold the light box, which flies on. Between both instants gravity
    // and friction change velocities by 1e-4 m/s.
    for tolerance in [1e-3, 1e-6, 1e-8] {
        let (_, [_, before], rate) = after(0.81997, tolerance);
        assert!(rate > 0.8, "{rate}");
        let (report, [heavy, light], rate) = after(0.81998, tolerance);
        let [along, _, up] = light;
        println!("{tolerance:e}: {heavy:?}, {before:?}, {light:?}, {rate}");
        assert!((along - before[0]).abs() < 2e-4 && (up - before[2]).abs() < 2e-4, "{before:?}, {light:?}");
        assert!(up > 0.9, "{light:?}");
        // A plank and a box that rest on each other and on the limit: what is left is less than the rate from which rounds do not go on, 1e-10.
        assert!(rate.abs() < 1e-3 && heavy.iter().all(|rate| rate.abs() < 1e-3), "{rate}, {heavy:?}");
        assert!(
            !report.warnings.iter().any(|warning| warning.contains("could not be solved")),
            "{:?}",
            report.warnings
        );
    }
}

#[test]
fn a_seesaw_with_two_boxes_loses_the_same_energy_at_every_tolerance() {
    let lost = [1e-3, 1e-6, 1e-8].map(|tolerance| {
        let (report, ..) = after(1.7, tolerance);
        (report.energy.impacts, report.energy.friction)
    });
    println!("{lost:?}");
    // The estimates of the three runs are below 1 mm: weights of 100 N times that.
    for (impacts, friction) in &lost[1..] {
        assert!((impacts - lost[0].0).abs() < 0.1 && (friction - lost[0].1).abs() < 0.1, "{lost:?}");
    }
}
