//! Derivatives through events that follow each other at once, against an identity of motions without forces.

use crate::sensitivity_events::{derivatives, scene};
use catena::prelude::*;

/// Three hinged links without weight, of which two meet their upper limits.
fn struck_chain(second_limit: f64) -> Model {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.3 0.1 0'/><mass value='1.5'/>\
             <inertia ixx='0.02' ixy='0' ixz='0' iyy='0.03' iyz='0' izz='0.04'/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, axis: &str, upper: f64| {
        format!(
            "<joint name='{name}' type='revolute'><origin xyz='0.5 0 0'/><parent link='{parent}'/><child link='{child}'/><axis xyz='{axis}'/>\
             <limit lower='-3' upper='{upper}' effort='0' velocity='0'/></joint>"
        )
    };
    let urdf = format!(
        "<robot name='chain'><link name='base'/>{}{}{}{}{}{}</robot>",
        link("one"),
        link("two"),
        link("three"),
        joint("first", "base", "one", "0 0 1", 0.4),
        joint("second", "one", "two", "0 1 0.5", second_limit),
        joint("third", "two", "three", "1 0 1", 3.0),
    );
    let urdf = scene(&format!("struck{second_limit}.urdf"), &urdf);
    let text = format!(
        "[scene]\ngravity = [0, 0, 0]\n[[robot]]\nname = \"chain\"\nurdf = {urdf:?}\nvelocities = {{ first = 2.0, second = 1.0, third = -1.5 }}\n\
         [[joint]]\nname = \"first\"\nrestitution = 0.5\n[[joint]]\nname = \"second\"\nrestitution = 0.7\n"
    );
    Model::load(scene(&format!("struck{second_limit}.toml"), &text)).expect("a model")
}

#[test]
fn events_a_nanosecond_apart_have_the_derivatives_of_a_motion_that_is_made_faster() {
    let far = struck_chain(2.9);
    let first = derivatives(&far, 7, 0.01, 0.5, &["start.v"]).events[0].time;
    let beside = 1e-6;
    let mut run = Simulation::new(&far).fixed(7, 0.01).duration(first + beside).without_figures();
    run.run().expect("a run");
    let (q, v) = run.coordinates().expect("coordinates");
    assert!(v[1] > 0.1, "the second joint goes on to its limit: {v:?}");
    for apart in [1e-7, 1e-8, 1e-9] {
        let model = struck_chain(q[1] - v[1] * (beside - apart));
        let time = 0.5;
        let found = derivatives(&model, 7, 0.01, time, &["start.v"]);
        let between = found.events[1].time - found.events[0].time;
        assert!(between > 0.5 * apart && between < 2.0 * apart, "{between:e} for {apart:e}");
        // Without forces x(t; λ v₀) = x(λ t; v₀), also through impacts: ∂v/∂v₀ v₀ = v + t dv/dt, ∂q/∂v₀ v₀ = t v.
        let (q, v) = (found.q.last().expect("a row"), found.v.last().expect("a row"));
        let rates = model.forward_dynamics(q, v, &[0.0; 3]).expect("accelerations");
        for row in 0..3 {
            let start = [2.0, 1.0, -1.5];
            let sum = |of: &[nalgebra::DMatrix<f64>]| {
                (0..3).map(|column| of.last().expect("a row")[(row, column)] * start[column]).sum::<f64>()
            };
            let (moved, faster) = (sum(&found.dq), sum(&found.dv));
            let off = [(moved - time * v[row]).abs(), (faster - v[row] - time * rates[row]).abs()];
            println!("{apart:e}: off by {off:?}");
            // The truncation of seven stages over 0.01 s, and roundings of two over the short step.
            assert!(off[0].max(off[1]) < 1e-8, "{apart:e}, freedom {row}: off by {off:?}");
        }
    }
}
