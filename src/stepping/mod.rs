//! Steps strung together: how long each is, whether it is kept, and what is looked at on the way.
//!
//! | what | where |
//! |---|---|
//! | the integrator | [`integrator`], [`stepper`] |
//! | the length of a step | [`fixed`], [`control`] and [`acceptance`], [`reversible`]; how many stages: [`stage_choice`] |
//! | what is looked at now and then | [`watch`], [`modes`], [`fastest_mode`], [`dynamics`], [`jerks`], [`linearised`] |
//! | instants inside a step | [`sampling`] |

pub mod acceptance;
pub mod control;
pub mod dynamics;
pub mod fastest_mode;
pub mod fixed;
pub mod integrator;
pub mod jerks;
pub mod linearised;
pub mod modes;
pub mod pace;
pub mod reversible;
pub mod sampling;
pub mod stage_choice;
pub mod stepper;
pub mod watch;

pub use integrator::Lobatto;
