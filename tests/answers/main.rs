//! Motions that something else knows: the comparator in joint coordinates, and answers of others.

// `models` names its mechanisms by this path, so that tests of single crates have it, too.
use catena::mechanism;

#[path = "../shared/common/mod.rs"]
mod common;
#[path = "../shared/models/mod.rs"]
mod models;

mod against_reduced;
mod classics;
mod published;
mod reduced;
mod reference_answers;
