//! The options of a log: its topics, its meshes, its size and its clock.

use catena::output::log::{LogOptions, Meshes, Topics, nanoseconds};
use clap::{Args, ValueEnum};
use std::time::{SystemTime, UNIX_EPOCH};

/// The options of a log.
#[derive(Args, Debug)]
#[command(next_help_heading = "Log")]
pub struct LogArgs {
    /// Where viewers find the geometry of mesh files
    #[arg(long, value_enum, default_value_t, value_name = "WHERE")]
    meshes: MeshPlace,

    /// Write these topics only, with commas between [default: all]
    #[arg(long, value_name = "TOPIC,…")]
    topics: Option<Topics>,

    /// Compress the samples more: smaller logs, slower runs
    #[arg(long)]
    compress: bool,

    /// Time in the log at the start of the run: seconds since 1970, or `now`
    #[arg(long, value_name = "S|now", default_value = "0", allow_hyphen_values = true, value_parser = start_time)]
    start_time: u64,
}

/// The place in which viewers find the geometry of mesh files.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum MeshPlace {
    /// In the log
    #[default]
    Embed,
    /// In the files, whose addresses are in the log
    Link,
    /// Nowhere: the log has no geometry
    None,
}

impl LogArgs {
    /// The options of the log.
    pub fn options(&self) -> LogOptions {
        let meshes = match self.meshes {
            MeshPlace::Embed => Meshes::Embed,
            MeshPlace::Link => Meshes::Link,
            MeshPlace::None => Meshes::None,
        };
        let topics = self.topics.clone().unwrap_or_default();
        LogOptions { topics, meshes, compress: self.compress, start: self.start_time, derivatives: None }
    }
}

/// Nanoseconds since 1970.
fn start_time(text: &str) -> Result<u64, String> {
    if text == "now" {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).map_err(|_| "the clock is before 1970".to_string())?;
        return u64::try_from(since.as_nanos()).map_err(|_| "the clock is too far from 1970".to_string());
    }
    let seconds: f64 = text.parse().map_err(|_| "give seconds since 1970, or `now`".to_string())?;
    // The seconds of ROS messages have 31 bits. Their fraction apart, because all nanoseconds since 1970 do not fit into a double.
    if (0.0..f64::from(i32::MAX)).contains(&seconds) {
        Ok(seconds.trunc() as u64 * 1_000_000_000 + nanoseconds(seconds.fract()))
    } else {
        Err(format!("it is not from 0 to {} s", i32::MAX))
    }
}
