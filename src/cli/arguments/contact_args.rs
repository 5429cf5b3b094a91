//! The options of contact: `--floor` and `--contact`.

use crate::cli::arguments::numbers::finite;
use catena::scene::Touching;
use std::ffi::OsString;

/// The floor, and which shapes may touch.
#[derive(Clone, Debug, clap::Args)]
pub struct ContactArgs {
    /// Put a floor under everything: a half space below z = Z [m]; without Z below z = 0
    #[arg(long, value_name = "Z", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = finite)]
    pub floor: Option<f64>,

    /// Which collision shapes may touch: none, environment (links with obstacles), all (links of different robots, too) [default: all, in scenes with an obstacle, a floor or a free body]
    #[arg(long, value_name = "PAIRS")]
    pub contact: Option<Touching>,
}

/// The arguments with `--floor Z` as `--floor=Z` and `--hold GAINS` as `--hold=GAINS`, so that a file after them is not taken for their value.
pub fn with_values(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut words: Vec<OsString> = Vec::new();
    for argument in arguments {
        let is_number = argument.to_str().is_some_and(|text| text.trim().parse::<f64>().is_ok());
        let are_gains =
            argument.to_str().is_some_and(|text| ["kp=", "kd=", "gravity="].iter().any(|gain| text.starts_with(gain)));
        match words.last_mut() {
            Some(floor) if (is_number && *floor == "--floor") || (are_gains && *floor == "--hold") => {
                floor.push("=");
                floor.push(argument);
            }
            _ => words.push(argument),
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_after_floor_is_its_height_and_a_file_is_not() {
        let read = |words: &[&str]| -> Vec<String> {
            let words = with_values(words.iter().map(OsString::from));
            words.into_iter().map(|word| word.into_string().expect("text")).collect()
        };
        assert_eq!(read(&["--floor", "-0.5", "a.urdf"]), ["--floor=-0.5", "a.urdf"]);
        assert_eq!(read(&["--floor", "a.urdf", "1"]), ["--floor", "a.urdf", "1"]);
        assert_eq!(read(&["--floor=1", "2", "--floor"]), ["--floor=1", "2", "--floor"]);
        assert_eq!(read(&["--hold", "kp=1,kd=2", "a.urdf"]), ["--hold=kp=1,kd=2", "a.urdf"]);
        assert_eq!(read(&["--hold", "a.urdf", "kp=1"]), ["--hold", "a.urdf", "kp=1"]);
    }
}
