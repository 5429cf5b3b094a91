//! Derivatives of runs by their start and their numbers, against closed forms and differences of runs.

use crate::{folder, robot};
use catena::prelude::*;
use catena::session::{Hold, Sensitivity};

fn oscillator() -> Model {
    Model::load(robot("damped_oscillator.toml")).expect("a model")
}

fn derivatives(simulation: Simulation, keys: &[&str]) -> Sensitivity {
    simulation.without_figures().sensitivity(keys).expect("derivatives")
}

/// ∂q/∂θ at the end.
fn last(run: &Sensitivity, freedom: usize, key: usize) -> f64 {
    run.dq.last().expect("steps")[(freedom, key)]
}

#[test]
fn a_damped_oscillator_has_the_derivatives_of_its_closed_form() {
    let keys = ["start.q", "start.v", "effort.slide", "spring.stiffness", "spring.damping"];
    let run = derivatives(Simulation::new(&oscillator()).fixed(9, 0.05).duration(1.0), &keys);
    assert_eq!(run.keys[0], "start.q.slide");
    // x = x₀ e^(−δt) (cos ωt + δ/ω sin ωt) + v₀/ω e^(−δt) sin ωt,  δ = c/2m,  ω² = k/m − δ²
    let x = |x0: f64, v0: f64, k: f64, c: f64| {
        let (delta, t) = (0.5 * c, 1.0_f64);
        let w = (k - delta * delta).sqrt();
        (-delta * t).exp() * (x0 * (w * t).cos() + (v0 + delta * x0) / w * (w * t).sin())
    };
    let difference = |of: &dyn Fn(f64) -> f64, width: f64| {
        let pair = |k: f64| of(k * width) - of(-k * width);
        (pair(1.0) * 672.0 - pair(2.0) * 168.0 + pair(3.0) * 32.0 - pair(4.0) * 3.0) / (840.0 * width)
    };
    let wanted = [
        x(1.0, 0.0, 100.0, 4.0),
        x(0.0, 1.0, 100.0, 4.0),
        (1.0 - x(1.0, 0.0, 100.0, 4.0)) / 100.0,
        difference(&|by| x(0.1, 0.0, 100.0 + by, 4.0), 0.5),
        difference(&|by| x(0.1, 0.0, 100.0, 4.0 + by), 0.05),
    ];
    for (index, wanted) in wanted.into_iter().enumerate() {
        let found = last(&run, 0, index);
        // Nine stages with h ω = 0.5 are exact to rounding, some 1e-15 a step of the largest motion.
        assert!((found - wanted).abs() < 1e-13, "{}: {found} and {wanted}", run.keys[index]);
    }
}

#[test]
fn derivatives_converge_with_the_order_of_the_scheme() {
    let error = |stages: usize, step: f64| {
        let at = |stages: usize, step: f64| {
            let model = Model::load(robot("double_pendulum.urdf")).expect("a model");
            derivatives(
                Simulation::new(&model).fixed(stages, step).duration(0.8),
                &["start.q.shoulder", "lower_arm.mass"],
            )
        };
        let (coarse, exact) = (at(stages, step), at(9, 0.05));
        let of = |run: &Sensitivity| run.dq.last().expect("steps").clone();
        (of(&coarse) - of(&exact)).amax()
    };
    for (stages, step) in [(2, 0.02), (3, 0.05), (5, 0.1)] {
        let order = (error(stages, step) / error(stages, 0.5 * step)).log2();
        // 2s − 2, and its next term.
        assert!((order - (2.0 * stages as f64 - 2.0)).abs() < 0.5, "{stages} stages: order {order}");
    }
}

/// Differences of whole runs with other numbers, of order eight, give the same derivatives by a key.
fn agrees_with_runs(model: &Model, key: &str, stages: usize, step: f64, time: f64, bound: f64) {
    let params = model.params().expect("numbers");
    let of = |name: &str| params.iter().find(|(own, _)| own == name || own.ends_with(&format!(".{name}")));
    let value = of(key).and_then(|(_, value)| *value).unwrap_or_else(|| panic!("{key} has a value"));
    let run = derivatives(Simulation::new(model).fixed(stages, step).duration(time), &[key]);
    let width = 4e-3 * if value == 0.0 { 1.0 } else { value };
    let at = |number: f64| {
        let model = model.with_params([(key, number)]).expect("another number");
        let mut run = Simulation::new(&model).fixed(stages, step).without_figures().duration(time);
        run.run().expect("a run");
        run.coordinates().expect("coordinates")
    };
    let pairs: Vec<_> = (1..=4).map(|k| (at(value + k as f64 * width), at(value - k as f64 * width))).collect();
    for freedom in 0..run.freedoms.len() {
        let pair = |k: usize| pairs[k].0.0[freedom] - pairs[k].1.0[freedom];
        let difference = (pair(0) * 672.0 - pair(1) * 168.0 + pair(2) * 32.0 - pair(3) * 3.0) / (840.0 * width);
        let found = last(&run, freedom, 0);
        let scale = run.dq.last().expect("steps").amax().max(1e-3);
        assert!((found - difference).abs() < bound * scale, "{key}, {freedom}: {found} and {difference}");
    }
}

#[test]
fn derivatives_by_numbers_of_every_kind_are_the_differences_of_whole_runs() {
    let pendulum = Model::load(robot("double_pendulum.urdf")).expect("a model");
    let keys: Vec<String> =
        pendulum.params().expect("numbers").into_iter().filter_map(|(key, value)| value.map(|_| key)).collect();
    let has =
        |part: &str| keys.iter().find(|key| key.contains(part)).unwrap_or_else(|| panic!("{part} in {keys:?}")).clone();
    for key in [has("lower_arm.mass"), has("lower_arm.inertia.iyy"), has("elbow.origin.x"), has("gravity.z")] {
        // Differences of runs leave 1e-14 over a width of 4e-3, and their ninth order.
        agrees_with_runs(&pendulum, &key, 5, 0.05, 0.5, 1e-9);
    }
}

#[test]
fn derivatives_of_an_arm_under_motors_are_the_differences_of_whole_runs() {
    let model = Model::load(crate::linear::driven_arm("arm_with_motors.toml", 80.0, 6.0)).expect("a model");
    agrees_with_runs(&model, "forearm.mass", 5, 0.01, 0.1, 1e-8);
}

#[test]
fn a_spinning_top_has_the_derivatives_of_its_runs_by_its_start() {
    let model = Model::load(robot("heavy_top_slow.toml")).expect("a model");
    let run = derivatives(Simulation::new(&model).fixed(6, 0.01).duration(0.2), &["start.v"]);
    let (_, v) = model.start().expect("a start");
    let joint = model.joint_names()[0].to_string();
    for (column, name) in run.keys.iter().enumerate() {
        let at = |by: f64| {
            let mut v = v.clone();
            v[column] += by;
            let mut run = Simulation::new(&model).fixed(6, 0.01).without_figures().duration(0.2);
            run = run.velocities([(joint.clone(), v)]).expect("a start");
            run.run().expect("a run");
            run.pose("top").expect("a link")
        };
        let h = 1e-3;
        // Turns are about the axes of the parent, the world.
        let turn = |by: f64| (at(by).rotation * at(0.0).rotation.inverse()).scaled_axis();
        let pair = |k: f64| turn(k * h) - turn(-k * h);
        let difference = (pair(1.0) * 45.0 - pair(2.0) * 9.0 + pair(3.0)) / (60.0 * h);
        for row in 0..3 {
            let found = last(&run, row, column);
            assert!((found - difference[row]).abs() < 1e-8, "{name}, {row}: {found} and {}", difference[row]);
        }
    }
}

#[test]
fn a_run_without_derivatives_is_refused_with_the_reason() {
    let _ = folder("sensitivity");
    let refused = |file: &str, key: &str| {
        let model = Model::load(robot(file)).expect("a model");
        Simulation::new(&model).duration(1.0).sensitivity(&[key]).expect_err("no derivatives").to_string()
    };
    assert!(refused("ball_rolls_to_rest.toml", "gravity.z").contains("do not know rolling and spinning friction"));
    assert!(refused("double_pendulum.urdf", "elbow.nonsense").contains("no parameter"));
    // A part that several key paths end with is none of them, as for --set.
    assert!(refused("double_pendulum.urdf", "inertia.ixx").contains("no parameter"));
}

/// A cart of 2 kg on a rail.
const CART: &str = "<robot name='cart'><link name='rail'/><link name='cart'><inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link> \
<joint name='slide' type='prismatic'><parent link='rail'/><child link='cart'/><axis xyz='1 0 0'/><limit lower='-9' upper='9' effort='inf' velocity='inf'/></joint></robot>";

#[test]
fn a_robot_that_is_held_from_the_start_has_the_derivatives_of_its_motors() {
    let path = folder("held").join("cart.urdf");
    std::fs::write(&path, CART).expect("written");
    let model = Model::loader().hold(Hold::default()).load(path).expect("a model");
    let simulation = Simulation::new(&model).fixed(9, 0.005).duration(0.05).start([("slide", 0.4)]).expect("a start");
    let run = derivatives(simulation, &["start.v"]);
    // Critically damped with ω = 20 π rad/s: x = x₀ + v₀ t e^(−ωt).
    let wanted = 0.05 * (-std::f64::consts::PI).exp();
    assert!((last(&run, 0, 0) - wanted).abs() < 1e-14, "{} and {wanted}", last(&run, 0, 0));
}
