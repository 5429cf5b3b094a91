//! Published benchmark problems, with their published or independently computed answers, by the scheme and by the comparator.
//!
//! The comment on each table names its source. Computed answers were refined until finer steps changed no printed digit.

mod pendula;
mod tops;

use crate::common::run_until;
use crate::models::Model;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::reduced::Dop853;
use catena::simulation::Summary;
use catena::stepping::integrator::Lobatto;

/// What moves a problem.
#[derive(Clone, Copy, Debug)]
enum Method {
    /// The scheme, in steps of nine stages and so many seconds.
    Scheme(f64),
    /// The comparator in joint coordinates, with a tolerance of 1e-13 a step.
    Comparator,
}

impl Method {
    fn integrator(self, mechanism: &Mechanism) -> Box<dyn Integrator> {
        match self {
            Method::Scheme(step) => Box::new(Lobatto::fixed(mechanism, 9, step).unwrap()),
            Method::Comparator => Box::new(Dop853::new(mechanism, 1e-13)),
        }
    }
}

/// Visits the bodies at each of the `times` of a run; returns the figures of the worst stretch.
fn visit(model: &Model, method: Method, times: &[f64], mut look: impl FnMut(usize, &[BodyState])) -> Summary {
    let mut state = model.state.clone();
    let mut integrator = method.integrator(&model.mechanism);
    let mut worst = Summary::default();
    for (index, &time) in times.iter().enumerate() {
        let summary = run_until(&model.mechanism, &mut state, integrator.as_mut(), time);
        worst.max_relative_energy_error = worst.max_relative_energy_error.max(summary.max_relative_energy_error);
        worst.cost.add(&summary.cost);
        look(index, &body_states(&model.mechanism, &state));
    }
    worst
}

fn assert_close(found: f64, expected: f64, bound: f64, what: &str) {
    let error = (found - expected).abs();
    println!("{what}: {error:.1e}");
    assert!(error <= bound, "{what}: {found} instead of {expected}, off by {error:.1e}");
}
