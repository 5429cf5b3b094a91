//! Many runs, compared: charts of speed against accuracy, maps of stability.

#[cfg(feature = "plot")]
pub mod chart;
#[cfg(feature = "plot")]
pub mod stress;
