//! The options of a log.

use crate::output::log::messages::sensitivities::Derivatives;
use crate::output::log::messages::topics::Topics;
use std::sync::Arc;

/// The place of the geometry of mesh files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Meshes {
    /// In the log, as triangles; Collada and OBJ files also as GLB files in a folder beside it, which its description names.
    #[default]
    Embed,
    /// In the mesh files, whose addresses are in the log.
    Link,
    /// It is left out: the log has no `/visual_markers`.
    None,
}

/// The options of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogOptions {
    /// The topics that it has.
    pub topics: Topics,
    /// The place of the geometry of mesh files.
    pub meshes: Meshes,
    /// Whether Zstandard compresses samples, and not only their repetitions. Content that never changes is always compressed by Zstandard.
    pub compress: bool,
    /// The time of the log at the start of the run, in nanoseconds since 1970.
    pub start: u64,
    /// Derivatives of the run, which are known before it.
    pub derivatives: Option<Arc<Derivatives>>,
}

impl LogOptions {
    /// The same but for this topic, which is named with its slash.
    #[must_use]
    pub(crate) fn without(self, topic: &str) -> Self {
        LogOptions { topics: self.topics.without(topic), ..self }
    }
}
