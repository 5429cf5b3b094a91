//! catena: rigid multibody dynamics by the constrained Lobatto IIIA–IIIB scheme in maximal coordinates.
//!
//! Data flows one way, and nothing imports anything to its right; what a mechanism is, how it moves and what acts on it ([`model`], [`state`],
//! [`kinematics`], [`closures`], [`forces`]) are one place here, which know each other:
//!
//! ```text
//!     URDF, scene file → scene → model (reduce) → mechanism → integrator → simulation → log | report | chart, stress
//!                                                     └→ reduced (joint coordinates: the comparator and a test oracle)
//! ```
//!
//! In reading order:
//!
//! | what | where |
//! |---|---|
//! | what the user wrote, validated | [`scene`] |
//! | what must be simulated, and what is left out | [`model`] |
//! | what pushes and pulls besides gravity | [`forces`] |
//! | what changes in time | [`state`], [`kinematics`], [`invariants`], [`closures`] |
//! | what an integrator is | [`integrator`] |
//! | the method | [`lobatto`] |
//! | the rival | [`reduced`] |
//! | the accuracy that a tolerance means | [`mod@distance`], [`calibration`] |
//! | what joints and loops carry | [`reactions`], [`snapshots`] |
//! | the loop and its observers | [`simulation`], [`log`], [`report`] |
//! | independent mechanisms, each with its own steps, and those that rest | [`islands`], [`rest`] |
//! | logs, looked at | [`inspection`] |
//! | speed against accuracy, drawn | [`chart`] |
//! | where which method fails, drawn | [`stress`] |
//! | numbers and nouns in sentences, for all of these | [`words`] |

// Allowed in one file: `lobatto/lanes/x86.rs`.
#![deny(unsafe_code)]

pub mod calibration;
pub mod chart;
pub mod closures;
pub mod distance;
pub mod forces;
pub mod inspection;
pub mod integrator;
pub mod invariants;
pub mod islands;
pub mod kinematics;
pub mod lobatto;
pub mod log;
pub mod model;
pub mod reactions;
pub mod reduced;
pub mod report;
pub mod rest;
pub mod scene;
pub mod simulation;
mod small;
pub mod snapshots;
pub mod state;
pub mod stress;
pub mod words;
