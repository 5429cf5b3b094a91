//! catena: rigid multibody dynamics by the constrained Lobatto IIIA–IIIB scheme in maximal coordinates.

pub mod chart;
pub mod invariants;
pub mod kinematics;
pub mod lobatto;
pub mod log;
pub mod model;
pub mod reduced;
pub mod report;
pub mod scene;
pub mod simulation;
pub mod state;
