//! The mechanism as built: bodies, joints, closures and forces. All of it is constant during a run.

pub mod body_state;
pub mod closure;
pub mod contact;
pub mod contact_pairs;
pub mod course;
pub mod forces;
pub mod formula;
mod formula_text;
pub mod joint;
pub mod mechanism;
pub mod nonsmooth;
pub mod rules;
pub mod target;
