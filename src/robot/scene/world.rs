//! The fixed world.

/// The name of the link that stands for the fixed world when it is the root, declared or not.
pub const WORLD_LINK: &str = "world";
