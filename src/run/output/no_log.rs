//! Replaces the log in builds without the feature `log`: a recorder that cannot be constructed. The same code makes runs with and without logs.

#[path = "log/encoding/ending.rs"]
mod ending;
#[path = "log/storage/error.rs"]
mod error;
#[path = "log/encoding/severity.rs"]
mod severity;

use crate::model::Model;
use crate::simulation::{Observer, ObserverError, Sample};
pub use ending::{Ending, Outcome};
pub use error::LogError;
pub use severity::Severity;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The options of a log, which do not exist in such a build.
#[derive(Clone, Debug)]
pub enum LogOptions {}

impl LogOptions {
    pub(crate) fn without(self, _: &str) -> Self {
        self
    }
}

/// Replaces the writer of a log.
pub enum Recorder {}

impl Recorder {
    pub(crate) fn create(
        _: &Path,
        _: &Model,
        _: BTreeMap<String, String>,
        options: &LogOptions,
    ) -> Result<Self, LogError> {
        match *options {}
    }

    pub(crate) fn create_for_restarts(
        path: &Path,
        model: &Model,
        simulation: BTreeMap<String, String>,
        options: &LogOptions,
    ) -> Result<Self, LogError> {
        Self::create(path, model, simulation, options)
    }

    pub(crate) fn heed(&mut self, _: &Arc<AtomicBool>) {
        match *self {}
    }

    pub(crate) fn say(&mut self, _: Severity, _: &str) {
        match *self {}
    }

    pub(crate) fn beside(&self) -> Option<&Path> {
        match *self {}
    }

    pub(crate) fn finish(self, _: Ending) -> Result<(), LogError> {
        match self {}
    }
}

impl Observer for Recorder {
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        match *self {}
    }
}
