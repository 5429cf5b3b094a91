//! Starts at which dry friction leaves derivatives on one side alone: they say so, and on which side.

use crate::sensitivity_events::{derivatives, last, scene};
use catena::prelude::*;
use catena::session::{Backward, Lost, Samples};

/// A mass of 2 kg on a slide, which gravity pulls with −20 N against a friction of 4 N.
fn slider(speed: f64) -> Model {
    let urdf = "<robot name='slider'><link name='base'/><link name='mass'><inertial><mass value='2'/>\
        <inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/></inertial></link>\
        <joint name='slide' type='prismatic'><parent link='base'/><child link='mass'/><axis xyz='1 0 0'/>\
        <limit lower='-100' upper='100' effort='0' velocity='0'/></joint></robot>";
    let urdf = scene("braked_slider.urdf", urdf);
    let text = format!(
        "[scene]\ngravity = [-10, 0, 0]\n[[robot]]\nname = \"slider\"\nurdf = {urdf:?}\nvelocities = {{ slide = {speed} }}\n\
         [[joint]]\nname = \"slide\"\nfriction = 4.0\n"
    );
    Model::load(scene(&format!("braked_slider{speed}.toml"), &text)).expect("a model")
}

#[test]
fn a_joint_that_starts_to_slide_from_rest_has_the_derivative_of_one_side_and_names_it() {
    let keys = ["start.v.slide", "start.q.slide", "mass.mass"];
    let run = derivatives(&slider(0.0), 5, 0.1, 0.5, &keys);
    // Thrown along its way by δ it is faster by δ; against it, by (F − μ)/(F + μ) δ = 2/3 δ.
    let [moved, faster] = last(&run, 0, 0);
    assert!((moved - 0.5).abs() < 1e-14 && (faster - 1.0).abs() < 1e-14, "{moved} {faster}");
    let end = |speed: f64| {
        let mut run = Simulation::new(&slider(0.0)).fixed(5, 0.1).duration(0.5);
        run = run.velocities([("slide", speed)]).expect("a start");
        run.run().expect("a run");
        run.coordinates().expect("coordinates").1[0]
    };
    let sides = [-1e-3, 1e-3].map(|speed| (end(speed) - end(0.0)) / speed);
    assert!((sides[0] - 1.0).abs() < 1e-9 && (sides[1] - 2.0 / 3.0).abs() < 1e-9, "{sides:?}");
    assert_eq!(run.valid_within[0], 0.0);
    let cause = &run.bounded_by[0];
    assert!(cause.contains("joint \"slide\"") && cause.contains("for a smaller value alone"), "{cause}");
    assert!(run.valid_within[1..].iter().all(|within| *within > 1.0), "{:?} {:?}", run.valid_within, run.bounded_by);
}

#[test]
fn a_joint_that_moves_already_keeps_its_derivative_up_to_the_change_that_turns_it() {
    let run = derivatives(&slider(-0.2), 5, 0.1, 0.5, &["start.v.slide"]);
    assert!((run.valid_within[0] - 0.2).abs() < 1e-12, "{:?} {:?}", run.valid_within, run.bounded_by);
    assert!(run.bounded_by[0].contains("another way"), "{:?}", run.bounded_by);
}

#[test]
fn a_gradient_names_a_start_at_which_it_holds_on_one_side() {
    let loss = |samples: &Samples| {
        let value = samples.v[0][0];
        Lost { value, by_q: vec![vec![0.0]], by_v: vec![vec![1.0]], by_events: Vec::new() }
    };
    let asked = Backward { keys: &["start.v.slide", "mass.mass"], times: &[0.5], every: 1 };
    let run = Simulation::new(&slider(0.0)).fixed(5, 0.1).duration(0.5);
    let found = run.gradient(&asked, loss).expect("a gradient");
    assert_eq!(found.warnings.len(), 1, "{:?}", found.warnings);
    assert!(
        found.warnings[0].starts_with("start.v.slide: ") && found.warnings[0].ends_with("for a smaller value alone")
    );
}

#[test]
fn a_block_that_starts_to_slide_from_rest_says_on_which_side_its_derivatives_hold() {
    let text = "[scene]\ngravity = [8, 0, -10]\n[[body]]\nname = \"block\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 1\n\
                pose = { position = [0, 0, 0.1] }\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.1\n";
    let model = Model::load(scene("block_from_rest.toml", text)).expect("a model");
    let run = derivatives(&model, 5, 0.1, 0.3, &["start.v", "block.mass"]);
    let cause = |key: &str| {
        let column = run.keys.iter().position(|own| own == key).unwrap_or_else(|| panic!("{key} in {:?}", run.keys));
        (run.valid_within[column], run.bounded_by[column].as_str())
    };
    let (along, aside, mass) = (cause("start.v.block.x"), cause("start.v.block.y"), cause("block.mass"));
    assert!(along.0 == 0.0 && along.1.ends_with("for a larger value alone"), "{along:?}");
    assert!(aside.0 == 0.0 && aside.1.contains("on no side"), "{aside:?}");
    assert!(mass.0 > 0.0, "{mass:?}");
}
