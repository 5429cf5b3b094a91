//! The method: the constrained Lobatto IIIA–IIIB scheme (2.5.11) in maximal coordinates.
//!
//! In the order in which it reads best:
//!
//! | what | where |
//! |---|---|
//! | the loop of one step | [`tableau`] (coefficients), [`step`] (what the integrator sees), [`kernel`], [`iteration`] |
//! | poses of all stages | [`plan`] (what can be left out), [`start`], [`stage`], [`turns`] |
//! | the stage equations | [`rows`], [`row_geometry`], [`residual`], [`pivot`], [`tumbler`]; forces: [`applied_plan`], [`applied_motion`], [`applied`] |
//! | their solve | [`articulated`], [`sweeps`], [`chord`], [`first`], [`anderson`], [`predictor`] |
//! | the end of a step | [`momenta`], [`ending`], [`dense`] and [`sampling`] (between start and end) |
//! | the same otherwise | [`planar`] (in a plane), [`precise`] and [`extended`] (to 32 digits) |
//! | how long a step is | [`fixed`], [`control`], [`reversible`]; how many stages: [`stage_choice`] |
//! | what steers that | [`stability`], [`watch`], [`modes`], [`fastest`], [`dynamics`], [`linearised`] |
//! | steps strung together | [`stepper`], [`integrator`] |
//! | closed loops, stiff springs | [`newton`], [`coupled`], [`closure`], [`elimination`], [`front`], [`projection`], [`closing`], [`assembly`], [`limits`] |
//! | samples of a motion | [`instants`] |
//! | the oracle of the tests | [`literal`], the scheme word for word |
//! | SIMD underneath | [`lanes`], [`numbers`], [`algebra`], [`dispatch`] |

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
