//! The tables and keys of a sweep file, as `serde` reads them; `definition.rs` gives their meaning.

use crate::scene::SimulationTable;
use toml::Spanned;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileTable {
    pub sweep: SweepTable,
    #[serde(default)]
    pub vary: Vec<Spanned<VaryTable>>,
    #[serde(default)]
    pub keep: KeepTable,
    pub simulation: Option<Spanned<SimulationTable>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepTable {
    pub scene: Spanned<String>,
    pub name: Option<String>,
    pub seed: Option<u64>,
    pub samples: Option<Spanned<u64>>,
    pub rows_per_file: Option<Spanned<u64>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VaryTable {
    pub key: Option<Spanned<String>>,
    pub keys: Option<Spanned<Vec<Spanned<String>>>>,
    #[serde(default)]
    pub relative: bool,
    pub linear: Option<Spanned<SpacingTable>>,
    pub logarithmic: Option<Spanned<SpacingTable>>,
    pub values: Option<Spanned<Vec<f64>>>,
    pub uniform: Option<Spanned<[f64; 2]>>,
    pub log_uniform: Option<Spanned<[f64; 2]>>,
    pub normal: Option<Spanned<[f64; 2]>>,
    pub csv: Option<Spanned<String>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpacingTable {
    pub from: f64,
    pub to: f64,
    pub count: u64,
}

/// The kept quantities of a run.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeepTable {
    pub end: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    pub curves: Vec<Spanned<String>>,
    #[serde(default)]
    pub extremes: Vec<Spanned<String>>,
    pub rate: Option<Spanned<f64>>,
    #[serde(default)]
    pub events: EventsKey,
}

/// The kept events of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum EventsKey {
    #[default]
    None,
    Counts,
    List,
}
