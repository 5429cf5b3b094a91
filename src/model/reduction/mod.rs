//! From links to bodies: what is rigid, tied, massless or constant is simulated no more than it needs, each with its reason.

pub(crate) mod composite;
pub(crate) mod constant_followers;
pub(crate) mod joint_frame;
pub(crate) mod reduce;
pub(crate) mod rigid_groups;
pub(crate) mod tied_joints;
