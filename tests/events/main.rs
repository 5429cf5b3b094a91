//! Limits, dry friction and motors against exact answers, and the laws they obey.

#[path = "../shared/common/mod.rs"]
mod common;

mod closed;
mod exact;
mod laws;
mod mechanisms;
mod motors;
mod orders;
mod pendulum;
mod reactions;
mod robots;
mod slides;
