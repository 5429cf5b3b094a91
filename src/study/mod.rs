//! Many runs: charts of speed against accuracy, maps of stability, sweeps over the numbers of a scene.

#[cfg(feature = "plot")]
pub mod chart;
#[cfg(feature = "plot")]
pub mod stress;
#[cfg(feature = "scene")]
pub mod sweep;
