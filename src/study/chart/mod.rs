//! Work–precision charts: CPU time against error, of catena and of the comparators, for any scene.
//!
//! A [`Scene`] is run by every [`Method`] down a ladder of settings ([`ladder`]); each run gives a [`Measurement`] of
//! CPU seconds per simulated second ([`timing`]) and of the distance of its end from a [`Reference`] that two
//! formulations agree on ([`crate::mechanism::motion::distance`], [`mod@reference`]). Out of the measurements come the ratios at fixed accuracies
//! ([`ratio`]), the pictures ([`work_precision`], [`energy`]), the CSV ([`table`]) and the page ([`page`]).
//!
//! ```text
//!     Scene → reference → measure (method × ladder → timing → distance) → ratio ─┐
//!                                    └→ energy                                   ├→ picture → SVG, PNG → page (HTML)
//!                                    └→ table (CSV) ← measurements of others ────┘
//! ```

pub mod energy;
mod files;
pub mod ladder;
pub mod measure;
pub mod method;
pub(crate) mod page;
pub mod ratio;
pub mod reference;
mod regularised;
pub mod report;
mod scene;
pub mod table;
pub mod timing;
pub mod work_precision;

pub use measure::{SceneChart, measure};
pub use method::{Method, Setting};
pub use reference::Reference;
pub use scene::Scene;
pub use table::{Measurement, read_csv, write_csv};
pub use timing::Ended;
