//! Many runs: charts of speed against accuracy, maps of stability, sweeps over the numbers of a scene.

pub mod chart;
pub mod stress;
pub mod sweep;
