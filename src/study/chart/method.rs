//! The methods of a chart and the settings they are run at.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::integrator::Integrator;
use crate::reduced::{Dop853, Euler, Rk4};
use crate::stepping::integrator::Lobatto;
use std::fmt;

/// A way of integrating, as a curve of the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// The Lobatto scheme with this many stages and fixed steps.
    Lobatto(usize),
    /// The same, solved to 32 digits; for references, it is no curve.
    Precise(usize),
    /// The Lobatto scheme, stages and steps chosen from a tolerance.
    LobattoTolerance,
    /// Semi-implicit Euler in joint coordinates.
    Euler,
    /// The classical Runge–Kutta method in joint coordinates.
    Rk4,
    /// DOP853 with step control in joint coordinates.
    Dop853,
}

/// What a method is told for one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// A fixed step (s).
    Step(f64),
    /// A tolerance [m, rad].
    Tolerance(f64),
}

impl Method {
    /// All methods of a chart, ours first, in the order of the legend.
    pub const ALL: [Method; 8] = [
        Method::Lobatto(2),
        Method::Lobatto(3),
        Method::Lobatto(5),
        Method::Lobatto(9),
        Method::LobattoTolerance,
        Method::Euler,
        Method::Rk4,
        Method::Dop853,
    ];

    /// The name in CSV files.
    pub fn id(self) -> String {
        match self {
            Method::Lobatto(stages) => format!("lobatto-{stages}"),
            Method::Precise(stages) => format!("lobatto-{stages}-32-digits"),
            Method::LobattoTolerance => "lobatto-tolerance".to_string(),
            Method::Euler => "euler".to_string(),
            Method::Rk4 => "rk4".to_string(),
            Method::Dop853 => "dop853".to_string(),
        }
    }

    /// The method with this name in CSV files.
    pub fn from_id(id: &str) -> Option<Self> {
        Method::ALL.into_iter().find(|method| method.id() == id)
    }

    /// The name in legends and tables.
    pub fn label(self) -> String {
        match self {
            Method::Lobatto(stages) => format!("{stages} stages, order {}", 2 * stages - 2),
            Method::Precise(stages) => format!("{stages} stages, 32 digits"),
            Method::LobattoTolerance => "tolerance".to_string(),
            Method::Euler => "semi-implicit Euler".to_string(),
            Method::Rk4 => "RK4".to_string(),
            Method::Dop853 => "DOP853, tolerance".to_string(),
        }
    }

    /// Whether it is one of ours.
    pub fn is_ours(self) -> bool {
        matches!(self, Method::Lobatto(_) | Method::Precise(_) | Method::LobattoTolerance)
    }

    /// Whether the ratios are measured against it.
    pub fn is_rival(self) -> bool {
        matches!(self, Method::Rk4 | Method::Dop853)
    }

    /// The integrator at a setting; `None` where a method does not know such a setting.
    pub fn integrator(self, mechanism: &Mechanism, setting: Setting) -> Option<Box<dyn Integrator>> {
        match (self, setting) {
            (Method::Lobatto(stages), Setting::Step(step)) => {
                Lobatto::fixed(mechanism, stages, step).ok().map(|lobatto| Box::new(lobatto) as Box<dyn Integrator>)
            }
            (Method::Precise(stages), Setting::Step(step)) => {
                Lobatto::precise(mechanism, stages, step).ok().map(|lobatto| Box::new(lobatto) as Box<dyn Integrator>)
            }
            (Method::LobattoTolerance, Setting::Tolerance(tolerance)) => {
                Some(Box::new(Lobatto::adaptive(mechanism, tolerance)))
            }
            (Method::Euler, Setting::Step(step)) => Some(Box::new(Euler::new(mechanism, step))),
            (Method::Rk4, Setting::Step(step)) => Some(Box::new(Rk4::new(mechanism, step))),
            (Method::Dop853, Setting::Tolerance(tolerance)) => Some(Box::new(Dop853::new(mechanism, tolerance))),
            (Method::Dop853, Setting::Step(step)) => Some(Box::new(Dop853::with_fixed_step(mechanism, step))),
            _ => None,
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Setting::Step(step) => write!(out, "step={step}"),
            Setting::Tolerance(tolerance) => write!(out, "tolerance={tolerance:e}"),
        }
    }
}
