//! The methods of a chart and the settings they are run at.
//!
//! On a mechanism with limits, dry friction or motors ours locate events, and so does DOP853, by the same code ([`crate::events`]); semi-implicit
//! Euler and RK4 have the usual regularisations ([`super::regularised`]), and DOP853 once more with these. Contacts between shapes are known to ours
//! alone, and so do steps over events, which solve all events of a step together, with first order.

use crate::chart::regularised::{Softness, regularised_system};
use crate::events::Eventful;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::state::State;
use crate::reduced::{Dop853, Euler, Rk4};
use crate::simulation::StepChoice;
use crate::simulation::tolerance::estimated_run::EstimatedRun;
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::integrator::Lobatto;
use crate::stepping::step_maker::PieceSteps;
use std::fmt;

/// A way of integrating, as a curve of the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Fixed steps over events, of motions that have them.
    OverEvents,
    /// The Lobatto scheme with this many stages and fixed steps.
    Lobatto(usize),
    /// The same, solved to 32 digits; for references, it is no curve.
    Precise(usize),
    /// The Lobatto scheme, stages and steps chosen from a tolerance.
    LobattoTolerance,
    /// The same without an estimate of the error at the end.
    LobattoUnestimated,
    /// Semi-implicit Euler in joint coordinates.
    Euler,
    /// The classical Runge–Kutta method in joint coordinates.
    Rk4,
    /// DOP853 with step control in joint coordinates; its steps end at events.
    Dop853,
    /// The same with limits, dry friction and motors as ordinary forces, of mechanisms that have them.
    Dop853Regularised,
}

/// The parameter of a method for one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// A fixed step (s).
    Step(f64),
    /// A tolerance [m, rad].
    Tolerance(f64),
}

impl Method {
    /// The methods of motions with events, ours first, in the order of the legend.
    pub const WITH_EVENTS: &'static [Method] = &[
        Method::OverEvents,
        Method::Lobatto(2),
        Method::Lobatto(3),
        Method::Lobatto(5),
        Method::Lobatto(9),
        Method::LobattoTolerance,
        Method::LobattoUnestimated,
        Method::Euler,
        Method::Rk4,
        Method::Dop853,
        Method::Dop853Regularised,
    ];
    /// The methods of smooth motions: all but the first and the last, which step over events and regularise them.
    pub const ALL: &'static [Method] = Method::WITH_EVENTS.split_at(Method::WITH_EVENTS.len() - 1).0.split_at(1).1;

    /// The methods for a mechanism: the ones that know all its elements.
    pub fn of(mechanism: &Mechanism) -> impl Iterator<Item = Method> {
        let all = if mechanism.nonsmooth.is_empty() { Method::ALL } else { Method::WITH_EVENTS };
        all.iter().copied().filter(|method| method.knows(mechanism))
    }

    /// The name in CSV files.
    pub fn id(self) -> String {
        match self {
            Method::OverEvents => "over-events".to_string(),
            Method::Lobatto(stages) => format!("lobatto-{stages}"),
            Method::Precise(stages) => format!("lobatto-{stages}-32-digits"),
            Method::LobattoTolerance => "lobatto-tolerance".to_string(),
            Method::LobattoUnestimated => "lobatto-unestimated".to_string(),
            Method::Euler => "euler".to_string(),
            Method::Rk4 => "rk4".to_string(),
            Method::Dop853 => "dop853".to_string(),
            Method::Dop853Regularised => "dop853-regularised".to_string(),
        }
    }

    /// The method with this name in CSV files.
    pub fn from_id(id: &str) -> Option<Self> {
        Method::WITH_EVENTS.iter().copied().find(|method| method.id() == id)
    }

    /// The name in legends and tables.
    pub fn label(self) -> String {
        match self {
            Method::OverEvents => "over events, order 1".to_string(),
            Method::Lobatto(stages) => format!("{stages} stages, order {}", 2 * stages - 2),
            Method::Precise(stages) => format!("{stages} stages, 32 digits"),
            Method::LobattoTolerance => "tolerance".to_string(),
            Method::LobattoUnestimated => "tolerance, no estimate".to_string(),
            Method::Euler => "semi-implicit Euler".to_string(),
            Method::Rk4 => "RK4".to_string(),
            Method::Dop853 => "DOP853, tolerance".to_string(),
            Method::Dop853Regularised => "DOP853, regularised".to_string(),
        }
    }

    /// Whether it is one of ours.
    pub fn is_ours(self) -> bool {
        matches!(
            self,
            Method::OverEvents
                | Method::Lobatto(_)
                | Method::Precise(_)
                | Method::LobattoTolerance
                | Method::LobattoUnestimated
        )
    }

    /// Whether it knows what this mechanism is made of; closed loops apart, that is all but contacts, which ours alone know.
    pub fn knows(self, mechanism: &Mechanism) -> bool {
        self.is_ours() || mechanism.nonsmooth.pairs.is_empty()
    }

    /// Whether the ratios are measured against it.
    pub fn is_rival(self) -> bool {
        matches!(self, Method::Rk4 | Method::Dop853 | Method::Dop853Regularised)
    }

    /// The integrator at a setting, for a run from `start`; `None` where a method does not know such a setting or mechanism. For a tolerance it makes
    /// the steps alone, without an estimate of their accuracy ([`Method::telling`]).
    pub fn integrator(self, mechanism: &Mechanism, start: &State, setting: Setting) -> Option<Box<dyn Integrator>> {
        if !self.knows(mechanism) {
            return None;
        }
        if !mechanism.nonsmooth.is_empty() {
            return self.with_events(mechanism, start, setting);
        }
        match (self, setting) {
            (Method::Lobatto(stages), Setting::Step(step)) => {
                Lobatto::fixed(mechanism, stages, step).ok().map(|lobatto| Box::new(lobatto) as Box<dyn Integrator>)
            }
            (Method::Precise(stages), Setting::Step(step)) => {
                Lobatto::precise(mechanism, stages, step).ok().map(|lobatto| Box::new(lobatto) as Box<dyn Integrator>)
            }
            (Method::LobattoTolerance | Method::LobattoUnestimated, Setting::Tolerance(tolerance)) => {
                Some(Box::new(Lobatto::adaptive(mechanism, tolerance)))
            }
            (Method::Euler, Setting::Step(step)) => Some(Box::new(Euler::new(mechanism, step))),
            (Method::Rk4, Setting::Step(step)) => Some(Box::new(Rk4::new(mechanism, step))),
            (Method::Dop853, Setting::Tolerance(tolerance)) => Some(Box::new(Dop853::new(mechanism, tolerance))),
            (Method::Dop853, Setting::Step(step)) => Some(Box::new(Dop853::with_fixed_step(mechanism, step))),
            _ => None,
        }
    }

    /// The maker of a run of `duration` (s) that estimates its own accuracy, and may restart: for the one method that does.
    pub fn telling(
        self,
        mechanism: &Mechanism,
        start: &State,
        duration: f64,
        setting: Setting,
    ) -> Option<EstimatedRun<'static>> {
        let Setting::Tolerance(tolerance) = setting else { return None };
        let estimate = match self {
            Method::LobattoTolerance => true,
            Method::LobattoUnestimated => false,
            _ => return None,
        };
        let terms = Terms {
            tolerance,
            start: start.time,
            end: start.time + duration,
            kept: Vec::new(),
            counted: None,
            interrupt: None,
            estimate,
            over_events: 1.0,
        };
        EstimatedRun::new(mechanism, terms).ok()
    }

    /// The same for a mechanism with limits, dry friction, motors or contacts.
    fn with_events(self, mechanism: &Mechanism, start: &State, setting: Setting) -> Option<Box<dyn Integrator>> {
        let ours = |steps: StepChoice| Some(steps.integrator(mechanism, &[]).ok()?.into_integrator());
        match (self, setting) {
            (Method::OverEvents, Setting::Step(step)) => {
                ours(StepChoice::Fixed { stages: StepChoice::OVER_EVENTS, step })
            }
            (Method::Lobatto(stages), Setting::Step(step)) => ours(StepChoice::Fixed { stages, step }),
            (Method::LobattoTolerance | Method::LobattoUnestimated, Setting::Tolerance(tolerance)) => {
                ours(StepChoice::Tolerance(tolerance))
            }
            (Method::Dop853, Setting::Tolerance(tolerance)) if !mechanism.has_closures() => {
                let make = |mechanism: &Mechanism, tolerance: f64| -> Box<dyn PieceSteps> {
                    Box::new(Dop853::new(mechanism, tolerance))
                };
                Some(Box::new(Eventful::between_steps_of(make, mechanism, tolerance).ok()?))
            }
            _ => self.regularised(mechanism, start, setting),
        }
    }

    /// The same with the usual regularisations.
    fn regularised(self, mechanism: &Mechanism, start: &State, setting: Setting) -> Option<Box<dyn Integrator>> {
        let softness = match setting {
            Setting::Step(step) => Softness::Step(step),
            Setting::Tolerance(tolerance) => Softness::Tolerance(tolerance),
        };
        let system = regularised_system(mechanism, start, softness)?;
        match (self, setting) {
            (Method::Euler, Setting::Step(step)) => Some(Box::new(Euler::of_system(mechanism, system, step))),
            (Method::Rk4, Setting::Step(step)) => Some(Box::new(Rk4::of_system(system, step))),
            (Method::Dop853Regularised, Setting::Tolerance(tolerance)) => {
                Some(Box::new(Dop853::of_system(system, tolerance)))
            }
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
