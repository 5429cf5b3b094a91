//! Plans that depend only on the mechanism, made once before its first step.
//!
//! ```text
//!     tree           for every body: parent, first freedom, which terms of its equations vanish       [`tree`]
//!     forces         what acts, sorted by what it needs                                               [`forces`]
//!     elimination    the order in which freedoms and multipliers of the exact Newton step go          [`elimination`], [`planner`]
//!     spanning       which joints are cut                                                             [`spanning`]
//! ```

pub mod elimination;
pub mod forces;
pub mod planner;
pub mod spanning;
pub mod tree;
