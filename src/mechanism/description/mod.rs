//! The mechanism as it was built: bodies, joints, closures and forces. All of it is constant.

pub mod body_state;
pub mod closure;
pub mod contact;
pub mod forces;
pub mod joint;
pub mod mechanism;
pub mod nonsmooth;
pub mod rules;
pub mod target;
