//! Work–precision charts: CPU time against error, of catena and of the comparators, for any scene.
//!
//! Every [`Method`] runs a [`Scene`] with a range of settings ([`ladder`]). Each run gives a [`Measurement`] of CPU seconds per simulated second
//! ([`timing`]) and of the distance of its end from a [`Reference`] on which two formulations agree ([`crate::mechanism::motion::distance`],
//! [`mod@reference`]). The measurements give the ratios at fixed accuracies ([`ratio`]), the pictures ([`work_precision`], [`energy`]), the CSV
//! ([`table`]) and the page ([`page`]).
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
