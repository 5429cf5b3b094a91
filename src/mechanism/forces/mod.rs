//! The equations of each force, and their sum ([`total`]). The data is in [`crate::description::forces`].

#[cfg(test)]
mod differences;
pub mod drag;
pub mod gravity_compensation;
pub mod joint_damper;
pub mod joint_load;
pub mod joint_spring;
pub mod line_of_action;
pub mod link_load;
pub mod point_spring;
pub mod total;
pub mod wrench;
