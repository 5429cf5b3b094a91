//! What a step is written in: one number for each stage, vectors and matrices of them, rotations, and more digits where sixteen are too few.

pub mod algebra;
pub mod arithmetic;
pub mod double;
pub(crate) mod euclidean;
pub mod extended;
pub mod fused;
pub mod lane_arithmetic;
pub mod lanes;
pub mod mixing;
pub mod reductions;
pub mod rotations;
pub mod series;
