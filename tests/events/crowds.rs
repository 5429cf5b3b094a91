//! Robots that collapse limp: steps over crowds of events.

use crate::common::scratch;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use std::path::Path;

#[test]
fn robots_that_collapse_limp_neither_overlap_the_floor_nor_gain_energy() {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    for name in ["humanoid", "quadruped"] {
        let text = format!(
            "[[robot]]\nname = \"r\"\nurdf = {:?}\nbase = \"floating\"\npose = {{ position = [0, 0, 1.2], rpy = [0.1, 0.05, 0] }}\n\
             [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.5\n",
            robots.join(format!("{name}.urdf"))
        );
        let file = scratch(&format!("limp_{name}")).join("scene.toml");
        std::fs::write(&file, text).expect("a file");
        let scene = read_scene(&file, &PackagePath::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (model, start) = Model::from_scene(&scene).unwrap_or_else(|error| panic!("{name}: {error}"));
        let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
        let steps = StepChoice::Tolerance(1e-3);
        let options = SimulationOptions { duration: 1.0, steps, switched_off: &[], interrupt: None };
        let mut simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
        simulation.run().unwrap_or_else(|error| panic!("{name}: {error}"));
        let finished = simulation.finish();
        let (summary, method) = (&finished.summary, &finished.method);
        println!("{name}: {} steps, {} of first order, {:?}", summary.steps, method.first_order_steps, summary.contact);
        // A step that would overlap by more is made shorter.
        assert!(method.first_order_lift <= 1e-4, "{name}: {:?}", method.first_order_lift);
        // They fall for 0.3 s with few events, and lie on the floor from then on.
        assert!(method.first_order_steps > 100, "{name}: {}", method.first_order_steps);
        // The largest length of these steps is 2 ms, and the exact steps are not more.
        assert!(summary.steps < 3000, "{name}: {}", summary.steps);
        // Six rounds of moving apart leave this of an overlap of shapes that turn.
        assert!(summary.contact.penetration <= 1e-7, "{name}: {:?}", summary.contact);
        // Losses are booked. Trial runs stay together with steps whose stop is 3 % of the tolerance of 1e-3 m; this is the error of those before the collapse.
        assert!(summary.max_relative_energy_error < 1e-7, "{name}: {}", summary.max_relative_energy_error);
    }
}
