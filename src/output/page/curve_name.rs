//! The name of a curve in a page, with its group and its unit.

use serde::Serialize;

/// The name of a curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct CurveName {
    /// As in tables: `elbow.position`, `energy.total`.
    pub name: String,
    /// The kind of curves that it belongs to, for people.
    pub group: &'static str,
    /// Its unit; empty for numbers without.
    pub unit: &'static str,
    /// Whether it is drawn on a logarithmic axis.
    pub logarithmic: bool,
    /// The column with its standard deviation, if the log tells it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<usize>,
}
