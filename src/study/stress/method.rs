//! The methods of a map, and the settings they are run at.

use crate::chart::{Method as ChartMethod, Setting};
use crate::mechanism::description::mechanism::Mechanism;
use crate::stress::problem::Problem;

/// A panel of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// One of the methods of work–precision charts.
    Chart(ChartMethod),
    /// The constrained explicit integrator of the textbooks, in maximal coordinates.
    Baumgarte,
}

impl Method {
    /// The methods of smooth motions, ours first, in the order of the panels.
    pub const ALL: [Method; 9] = [
        Method::Chart(ChartMethod::Lobatto(2)),
        Method::Chart(ChartMethod::Lobatto(3)),
        Method::Chart(ChartMethod::Lobatto(5)),
        Method::Chart(ChartMethod::Lobatto(9)),
        Method::Chart(ChartMethod::LobattoTolerance),
        Method::Chart(ChartMethod::Euler),
        Method::Chart(ChartMethod::Rk4),
        Method::Chart(ChartMethod::Dop853),
        Method::Baumgarte,
    ];

    /// The methods for a mechanism. DOP853 locates the events of limits, dry friction and motors. The constrained integrator cannot represent
    /// these elements, so DOP853 with them as ordinary forces replaces it.
    pub fn of(mechanism: &Mechanism) -> [Method; Method::ALL.len()] {
        Method::ALL.map(|method| match method {
            Method::Baumgarte if !mechanism.nonsmooth.is_empty() => Method::Chart(ChartMethod::Dop853Regularised),
            known => known,
        })
    }

    /// The name in CSV files.
    pub fn id(self) -> String {
        match self {
            Method::Chart(method) => method.id(),
            Method::Baumgarte => "baumgarte-rk4".to_string(),
        }
    }

    /// The heading of the panel.
    pub fn label(self) -> String {
        match self {
            Method::Chart(ChartMethod::LobattoTolerance) => "catena, tolerance".to_string(),
            Method::Chart(method) if method.is_ours() => format!("catena, {}", method.label()),
            Method::Chart(method) => format!("{}, joint coordinates", method.label()).replace(", tolerance", ""),
            Method::Baumgarte => "RK4 with multipliers, Baumgarte".to_string(),
        }
    }

    /// Whether it is one of ours.
    pub fn is_ours(self) -> bool {
        matches!(self, Method::Chart(method) if method.is_ours())
    }

    /// Whether its steps are chosen from a tolerance.
    pub fn is_adaptive(self) -> bool {
        matches!(
            self,
            Method::Chart(ChartMethod::LobattoTolerance | ChartMethod::Dop853 | ChartMethod::Dop853Regularised)
        )
    }

    /// The columns of its panel.
    pub fn settings(self, problem: &Problem) -> Vec<Setting> {
        if self.is_adaptive() {
            // Written out, so that the file says 1e-3 and not 1.0000000000000002e-3.
            return [1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10].map(Setting::Tolerance).to_vec();
        }
        problem.steps.iter().copied().map(Setting::Step).collect()
    }
}
