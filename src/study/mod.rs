//! Many runs, compared: charts of speed against accuracy, maps of stability.

pub mod chart;
pub mod stress;
