//! Bodies from links: rigid, tied, massless or constant parts are simulated no more than they need, each with its reason.

pub(crate) mod constant_followers;
pub(crate) mod joint_frame;
pub(crate) mod reduce;
pub(crate) mod rigid_groups;
pub(crate) mod tied_joints;
