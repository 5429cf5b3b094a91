//! Watching a run: an [`Observer`] receives samples at a fixed rate, the end of each step, events, contacts and the accuracy so far.

pub use crate::mechanism::forces::total::Exchange;
pub use crate::mechanism::motion::contact_point::ContactPoint;
pub use crate::mechanism::motion::energy::{Energy, Violation};
pub use crate::mechanism::motion::event::{Event, EventKind};
pub use crate::mechanism::motion::integrator::{MethodDescription, StepOutcome};
pub use crate::session::{Recording, SharedRecording};
pub use crate::simulation::{AccuracySoFar, Counts, Observer, ObserverError, Sample, StepEnd};
