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

#[test]
fn a_wall_of_many_bricks_begins_in_steps_over_events_and_stays_at_rest() {
    let (wide, high) = (6, 6);
    let mut text = String::from(
        "[contact]\npairs = \"all\"\nfriction = 0.5\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n",
    );
    for (x, z) in (0..high).flat_map(|z| (0..wide).map(move |x| (x, z))) {
        let (along, up) = (0.4 * f64::from(x) + 0.2 * f64::from(z % 2), 0.1 + 0.2 * f64::from(z));
        text += &format!(
            "[[body]]\nname = \"b{x}_{z}\"\nshape = {{ type = \"box\", size = [0.4, 0.2, 0.2] }}\ndensity = 1000.0\n\
             pose = {{ position = [{along}, 0.0, {up}] }}\n"
        );
    }
    let file = scratch("wall_of_bricks").join("scene.toml");
    std::fs::write(&file, text).expect("a file");
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    let options =
        SimulationOptions { duration: 0.02, steps: StepChoice::Tolerance(1e-3), switched_off: &[], interrupt: None };
    let mut simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
    simulation.run().expect("it runs");
    let finished = simulation.finish();
    let (summary, method) = (&finished.summary, &finished.method);
    // A decision of the mode of its 364 contacts costs a minute; steps over events need none.
    assert!((method.first_order_time - 0.02).abs() < 1e-12, "{}", method.first_order_time);
    // Gaps that count as closed are at most this, and what rests does not move: its energies differ by roundings.
    assert!(summary.contact.penetration <= 1e-9, "{:?}", summary.contact);
    assert!(summary.max_relative_energy_error < 1e-12, "{}", summary.max_relative_energy_error);
}
