//! The nouns: a model with its records and frames, coordinates, errors, and which shapes can touch.

pub(crate) mod at_start;
pub(crate) mod chain_reach;
pub(crate) mod contact_pairs;
pub(crate) mod contact_reach;
pub(crate) mod coordinates;
pub(crate) mod coupling_error;
pub(crate) mod followers;
pub(crate) mod kinship;
pub(crate) mod model_error;
pub(crate) mod never_touch;
pub(crate) mod reported;
pub(crate) mod robot_model;
pub(crate) mod start_checks;
pub(crate) mod wheel;
pub(crate) mod without;
