//! The cost of events: attempts that end a step at an event are told from those that were thrown away, and each problem at an event is counted with the
//! solver that has solved it.

use crate::contacts::{ball, placed};
use crate::mechanisms::{GRAVITY, of_kind, run};
use crate::scene_files::{report, scene_of};
use catena::mechanism::motion::contact_solvers::{ContactSolver, ContactSolvers};
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::integrator::Rejected;
use catena::simulation::{Finished, StepChoice};
use nalgebra::Vector3;

/// A ball that falls 0.6 m onto a floor without friction, in steps for a tolerance of 1e-6 m.
fn fall(restitution: f64, duration: f64) -> Finished {
    let mechanism = ball(0.05, Vector3::new(0.0, 0.0, -GRAVITY), 0.0, restitution);
    let start = placed(&mechanism, Vector3::new(0.0, 0.0, 0.65), Vector3::zeros(), Vector3::zeros());
    run(&mechanism, &start, duration, StepChoice::Tolerance(1e-6))
}

/// These counts and no others.
fn solved(counts: &[(ContactSolver, usize)]) -> ContactSolvers {
    let mut all = ContactSolvers::default();
    for &(by, count) in counts {
        (0..count).for_each(|_| all.count(by));
    }
    all
}

#[test]
fn a_step_that_is_shortened_to_end_at_an_impact_is_not_a_rejected_one() {
    // It lands after 0.35 s. The fall is a parabola, which every step solves at once, and which the dense output gives exactly: one attempt ends the
    // step there.
    let finished = fall(0.0, 0.5);
    let cost = finished.summary.cost;
    assert_eq!(of_kind(&finished, EventKind::ContactImpact).len(), 1);
    assert_eq!((cost.rejected.total(), cost.located), (0, 1), "{cost:?}");
    // The impact is a problem, and the forces of the contact that stays closed are another.
    assert_eq!(finished.method.contact_solvers, solved(&[(ContactSolver::Cold, 2)]));
}

#[test]
fn every_impact_with_a_rebound_is_solved_once_without_it_and_once_more_from_that_answer() {
    // Impacts at 0.35, 0.84 and 1.18 s; the next one would be at 1.42 s.
    let finished = fall(0.7, 1.3);
    assert_eq!(of_kind(&finished, EventKind::ContactImpact).len(), 3);
    let counts = [(ContactSolver::Cold, 3), (ContactSolver::Warm, 3)];
    assert_eq!(finished.method.contact_solvers, solved(&counts));
}

/// A ball that rolls with 0.3 m/s along the side of a box with this yaw (rad), and touches it at 0.1 m before its middle; no force acts between them.
fn along_a_box(yaw: f64) -> (String, [f64; 3], [f64; 3]) {
    let (normal, along) = ([-yaw.cos(), -yaw.sin()], [yaw.sin(), -yaw.cos()]);
    let (radius, speed, apart) = (0.062, 0.3, 0.131 + 0.062);
    let at = |axis: usize| [0.4, 0.029][axis] + apart * normal[axis] - 0.1 * along[axis];
    let (start, velocity) = ([at(0), at(1), radius], [speed * along[0], speed * along[1], 0.0]);
    let spin = [-velocity[1] / radius, velocity[0] / radius, 0.0];
    let text = format!(
        "[contact]\nfriction = 0.29\n[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\n\
         [[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.262, 0.261, 0.174] }}\ndensity = 400\n\
         pose = {{ position = [0.4, 0.029, 0.087], rpy = [0, 0, {yaw}] }}\n\
         [[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = {radius} }}\ndensity = 700\n\
         pose = {{ position = {start:?} }}\nvelocity = {{ linear = {velocity:?}, angular = {spin:?} }}\n"
    );
    (text, start, velocity)
}

#[test]
fn a_ball_that_rolls_along_a_box_without_pressing_it_rolls_on_and_no_step_ends_at_roundings_of_its_force() {
    // 1e-15 N lie on either side of zero: 50 times as many steps ended at events of them, which left the mode as it was.
    for yaw in [-0.4, 0.3, 1.1] {
        let (text, start, velocity) = along_a_box(yaw);
        let file = scene_of(&format!("along_a_box_{yaw}"), "<link name='base'/>", &text);
        let found = report(&file, &[], &[], Some(0.6), 1e-6);
        let (_, ball) = found.links.iter().find(|(name, _)| name == "ball").expect("a ball");
        for axis in 0..3 {
            let wanted = start[axis] + 0.6 * velocity[axis];
            let off = (ball.center_of_mass[axis] - wanted).abs();
            assert!(off < 1e-9, "yaw {yaw}, axis {axis}: off by {off:e}");
        }
        assert_eq!((found.located_attempts, found.rejected_steps), (0, 0), "yaw {yaw}: {} steps", found.steps);
    }
}

#[test]
fn an_event_at_the_start_of_a_step_is_asked_of_one_short_step() {
    // A cylinder that stands on a table which is shaken: contacts of its rim that lose their force where it begins to slide. Steps of all lengths between
    // the first and the shortest were made, too: 32 attempts.
    let table = "<link name='w'/><link name='table'><inertial><mass value='5'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>\
        <collision><geometry><box size='1 1 0.1'/></geometry></collision></link>\
        <joint name='drive' type='prismatic'><parent link='w'/><child link='table'/><origin xyz='0 0 -0.05'/><axis xyz='1 0 0'/>\
        <limit lower='-10' upper='10' effort='0' velocity='0'/></joint>";
    let text = "[[robot]]\nname = \"t\"\nurdf = \"robot.urdf\"\n\
        [[motion]]\njoint = \"t/drive\"\nposition = { formula = \"a*(1-cos(2*pi*f*t))\", a = 0.001957850751091478, f = 8.990941358386326 }\n\
        [[body]]\nname = \"o\"\nshape = { type = \"cylinder\", radius = 0.03800212712618595, length = 0.1301441281196481 }\nmass = 2.700602304218933\n\
        pose = { position = [-0.0945757372413748, -0.1431131743258776, 0.06507206405982405] }\n";
    let found = report(&scene_of("shaken_cylinder", table, text), &[], &[], Some(0.5), 1e-6);
    let asked = found.rejected.0.of(Rejected::EventAtStart);
    let slips = found.events.list.iter().filter(|event| event.kind == "slip").count();
    assert!(asked > 0 && asked <= slips, "{asked} attempts, {slips} slips");
}
