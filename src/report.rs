//! The report of a run: [`Report`] and its parts.

pub use crate::output::report::{
    AccuracyReport, ConstraintReport, ContactReport, ContactsReport, EnergyParts, EnergyReport, EventEntry,
    EventReport, FrequencyReport, IslandReport, JointReport, JointStatusReport, KindCounts, LinkReport, LoopReport,
    MethodReport, ModelReport, Numbers, Report, StepErrorReport,
};
