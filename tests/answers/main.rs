//! Motions that something else knows: the comparator in joint coordinates, and answers of others.

#[path = "../shared/common/mod.rs"]
mod common;
#[path = "../shared/models/mod.rs"]
mod models;

mod against_reduced;
mod classics;
mod published;
mod reduced;
mod reference_answers;
