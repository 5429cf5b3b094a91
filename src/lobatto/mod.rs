//! The method: the constrained Lobatto IIIA–IIIB scheme (2.5.11) in maximal coordinates.
//!
//! Reading order: [`tableau`] (coefficients), [`step`], [`kernel`] and [`iteration`] (the loop of one step), [`plan`], [`start`], [`stage`] and [`turns`] (poses
//! of all stages), [`rows`], [`row_geometry`], [`residual`], [`pivot`], [`applied_plan`], [`applied_motion`] and [`applied`] (forces), [`articulated`], [`sweeps`], [`chord`] and [`first`]
//! (the stage equations and their solve), [`momenta`] and [`ending`] (the velocities at the end), [`planar`] (the same in a plane), [`precise`] (the same to 32 digits),
//! [`anderson`], [`predictor`], [`dense`], [`fixed`], [`control`] and [`reversible`]
//! (step length), [`stage_choice`] (how many stages), [`stability`], [`watch`], [`modes`], [`fastest`], [`dynamics`] and [`linearised`] (what they need
//! to know), [`stepper`] and [`integrator`] (steps strung together); for closed loops [`newton`], [`coupled`], [`closure`],
//! [`elimination`], [`front`], [`projection`], [`closing`] and [`assembly`]; [`instants`] are samples of a motion, in lanes;
//! [`literal`] is the scheme word for word, the oracle of the tests; [`lanes`], [`numbers`], [`algebra`] and [`dispatch`] are the SIMD underneath.

pub mod algebra;
pub mod anderson;
pub mod applied;
mod applied_motion;
pub mod applied_plan;
pub mod articulated;
pub mod assembly;
pub mod chord;
mod closing;
pub mod closure;
pub mod control;
pub mod coupled;
pub mod dense;
pub mod dispatch;
pub mod dynamics;
pub mod elimination;
mod ending;
mod extended;
pub mod fastest;
mod first;
mod fixed;
pub mod front;
pub mod instants;
pub mod integrator;
mod iteration;
pub mod kernel;
pub mod lanes;
pub mod limits;
pub mod linearised;
pub mod literal;
mod literal_constraints;
mod literal_forces;
mod literal_newton;
pub mod modes;
mod momenta;
pub mod newton;
pub mod numbers;
pub mod pivot;
pub mod plan;
pub mod planar;
pub mod precise;
pub mod predictor;
pub mod projection;
pub mod residual;
pub mod reversible;
pub mod row_geometry;
pub mod rows;
mod sampling;
pub mod stability;
pub mod stage;
pub mod stage_choice;
pub mod start;
pub mod step;
mod stepper;
pub mod sweeps;
pub mod tableau;
pub mod tumbler;
pub mod turns;
pub mod watch;

pub use integrator::Lobatto;
