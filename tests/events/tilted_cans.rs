//! Cans that stand on their ends up to roundings of their tilt: points on the rim stand for an end that is tilted by less than 1e-9 rad, and what lies
//! between these points is a little deeper. That overlap is put right by as much as it is, at starts and in steps of first order.

use crate::scene_files::{link, report, written};
use catena::prelude::*;
use catena::report::Report;
use std::path::PathBuf;

/// A can on a floor, 60 mm wide and 120 mm high, with these roll and pitch angles (rad) and spin [rad/s], and what else is in the scene.
fn scene(name: &str, [roll, pitch]: [f64; 2], spin: f64, other: &str) -> PathBuf {
    let text = format!(
        "[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\n[contact]\nfriction = 0.6\n\
         [[body]]\nname = \"can\"\nshape = {{ type = \"cylinder\", radius = 0.06, length = 0.12 }}\nmass = 0.5\n\
         pose = {{ position = [0, 0, 0.06], rpy = [{roll:e}, {pitch:e}, 0] }}\nvelocity = {{ angular = [0, 0, {spin}] }}\n{other}"
    );
    written(name, &text)
}

/// The height of the centre of a link at the end (m).
fn height(report: &Report, name: &str) -> f64 {
    link(report, name).center_of_mass[2]
}

#[test]
fn a_can_that_starts_tilted_by_roundings_starts_where_it_is() {
    // 1.5707963268 is 5e-12 more than a right angle. The overlap could not be seen by the points, the can was taken for wedged, and started 6 mm higher.
    for tilt in [1e-12, 5e-12, 1e-11, 1e-10, 9e-10, 1e-8] {
        for direction in [[1.0, 1.0], [1.0, -1.0], [0.4, 1.0]] {
            let file = scene("tilted_cans_start", direction.map(|along: f64| along * tilt), 0.0, "");
            let ended = report(&file, &[], &[], Some(1e-3), 1e-6);
            let moved = (height(&ended, "can") - 0.06).abs();
            // The rim is lifted by as much as it was below.
            assert!(moved <= 0.1 * tilt + 1e-14, "tilt {tilt:e}: moved by {moved:e} m");
        }
    }
}

#[test]
fn a_box_that_stops_a_spinning_can_stays_on_it_with_the_energy_of_both() {
    let other = "[[body]]\nname = \"box\"\nshape = { type = \"box\", size = [0.12, 0.12, 0.1] }\nmass = 3\n\
         pose = { position = [0.02, 0, 0.17], rpy = [0, 0, 0.3] }\n[simulation]\nestimate = false\n";
    let file = scene("tilted_cans_spin", [0.0, 0.0], 3.0, other);
    let ended = report(&file, &[], &[], Some(0.01), 1e-6);
    let heights = ["can", "box"].map(|name| height(&ended, name));
    println!("heights {heights:?}, energies {:?}", ended.energy);
    // Both were 6 and 14 mm higher in a step of a microsecond, with 100 times their kinetic energy.
    for (height, wanted) in heights.into_iter().zip([0.06, 0.17]) {
        assert!((height - wanted).abs() <= 1e-9, "{height} m");
    }
    assert!(ended.energy.max_relative_error <= 1e-6, "{:?}", ended.energy);
}

#[test]
fn an_impact_at_the_start_is_in_the_balance_of_a_first_step_of_first_order() {
    // A can that slides away below one that lies on it meets it at the start, and the first step is one of first order.
    let text = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n[contact]\nfriction = 0.6\n\
         [[body]]\nname = \"can\"\nshape = { type = \"cylinder\", radius = 0.06, length = 0.12 }\nmass = 3\n\
         pose = { position = [0, 0, 0.06] }\nvelocity = { linear = [0.7, 0, 0] }\n\
         [[body]]\nname = \"roll\"\nshape = { type = \"cylinder\", radius = 0.05, length = 0.3 }\nmass = 1\n\
         pose = { position = [-0.05, 0, 0.17], rpy = [0, 1.5707963267948966, 0] }\nvelocity = { linear = [0, 0.2, 0] }\n\
         [simulation]\nestimate = false\n";
    let file = written("tilted_cans_impact", text);
    let ended = report(&file, &[], &[], Some(1e-4), 1e-5);
    println!("{:?}", ended.energy);
    // 0.0688 J were lost one step later than the velocities changed, which is 9 % of the kinetic energy.
    assert!(ended.energy.max_relative_error <= 1e-9, "{:?}", ended.energy);
}

#[test]
fn a_run_whose_numbers_overflow_ends_with_an_error_that_names_the_joint() {
    let text = "[scene]\ngravity = [0, 0, -1e300]\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n\
         [[body]]\nname = \"can\"\nshape = { type = \"cylinder\", radius = 0.06, length = 0.12 }\nmass = 0.5\npose = { position = [0, 0, 5] }\n";
    let file = written("tilted_cans_overflow", text);
    let model = Model::load(&file).expect("a model");
    // Steps over events, and of the scheme: what is no number was reported, without an error.
    for simulation in [Simulation::new(&model).tolerance(1e-3), Simulation::new(&model).fixed(3, 1e-3)] {
        let failure = simulation.duration(1.0).run().expect_err("numbers that overflow").to_string();
        assert!(failure.contains("\"can\" is not finite"), "{failure}");
    }
}
