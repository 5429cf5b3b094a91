//! The equations for mechanisms that move in a plane: three coordinates per body instead of six.
//!
//! The kernel ([`crate::step::kernel`]), the exact Newton method ([`crate::coupled::newton`]), projections, loops ([`crate::equations::loops`]) and
//! springs ([`crate::equations::springs`]) are the same code in space and in a plane. This folder has the algorithms that differ:
//!
//! | here | in space | what differs |
//! |---|---|---|
//! | [`sweeps`] | [`crate::equations::residual`], [`crate::solve::sweeps`] | mixes 2 numbers a body and row instead of 12 |
//! | [`articulated`] | [`crate::stages::articulated`] | 6 numbers an inertia instead of 21, of which a hinge without forces leaves 3 |
//! | [`kept_factors`] | [`crate::solve::kept_factors`] | reads the paths of [`sweeps`]; axes of hinges never turn |
//! | [`start`] | [`crate::stages::start`] | a cosine and a sine a body instead of a rotation matrix |
//! | [`forces`] | [`crate::equations::forces`] | no ball joints; power from one angular velocity |
//!
//! The table has the CPU time of a run in space (`--keep planar`) over the time in the plane;
//! `catena simulate ROBOT --stages 9 --step 0.02 --no-log`, smallest of five runs in turns, AVX-512:
//!
//! | robot | space / plane |
//! |---|---|
//! | pendulum.urdf | 1.15 |
//! | two links, hinges along y (`make_chain.py --links 2 --axes y --length 1`) | 1.62 |
//! | ten links, the same | 1.93 |
//! | four_bar_1.toml | 3.5 |
//! | four_bar_10.toml | 4.9 |
//! | four_bar_40.toml | 5.3 |

pub mod algebra;
pub mod articulated;
pub mod body;
pub mod force_plan;
pub mod forces;
pub mod geometry;
pub mod kept_factors;
pub mod loops;
pub mod start;
pub mod sweeps;
pub mod workspace;
