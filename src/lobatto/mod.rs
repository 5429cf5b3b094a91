//! The method: the constrained Lobatto IIIA–IIIB scheme (2.5.11) in maximal coordinates.
//!
//! Reading order: [`tableau`] (coefficients), [`step`] (the loop of one step), [`start`], [`stage`] (poses of all
//! stages), [`residual`], [`articulated`] and [`sweeps`] (the stage equations and their solve), [`anderson`], [`predictor`],
//! [`dense`], [`control`] and [`reversible`] (step length), [`stability`] and [`dynamics`] (what they need to know), [`integrator`] (steps strung together); [`literal`] is the scheme word for word,
//! the oracle of the tests; [`lanes`], [`algebra`] and [`dispatch`] are the SIMD underneath.

pub mod algebra;
pub mod anderson;
pub mod articulated;
pub mod control;
pub mod dense;
pub mod dispatch;
pub mod dynamics;
mod extended;
pub mod integrator;
pub mod lanes;
pub mod literal;
pub mod predictor;
pub mod residual;
pub mod reversible;
pub mod stability;
pub mod stage;
pub mod start;
pub mod step;
pub mod sweeps;
pub mod tableau;

pub use integrator::Lobatto;
