//! The examples at the end of the help of each command.

pub const SIMULATE: &str = "\
Examples:
  catena simulate robots/arm7.urdf                                    ten seconds to 1e-6 m; the log is arm7.mcap
  catena simulate robot.urdf --base floating --base-pose 0,0,1,0,0,0 --floor    drop it on a floor
  catena simulate robot.urdf --hold                                   motors hold it where it starts
  catena simulate model.xml --keyframe home --floor                   a model of MuJoCo
  catena simulate robot.urdf --from run.mcap@2.5                      go on where another run was at 2.5 s
  catena simulate robot.urdf --duration 3 --tolerance 1e-9 --report run.html    a page of the run, too
  catena simulate scene.toml --stages 3 --step 0.001 --no-log --json  fixed steps, the report as JSON";

pub const MODEL: &str = "\
Examples:
  catena model robot.urdf                     bodies, joints, what was left out and why
  catena model robot.urdf -o model.html       a page with a slider for each joint
  catena model scene.toml --parameters        the numbers that --set and sweeps can change";

pub const LINEARIZE: &str = "\
Examples:
  catena linearize robot.urdf                 modes about the equilibrium near the start
  catena linearize robot.urdf --hold --at start    with motors that hold it where it starts
  catena linearize scene.toml --at 2.5 --json     matrices A and B about the state at 2.5 s
  catena linearize run.mcap --at 2.5          the same of a run that has been logged";

pub const SENSITIVITY: &str = "\
Examples:
  catena sensitivity robot.urdf --by link7.mass --by start.q     derivatives of the end of a run
  catena sensitivity scene.toml --by floor.restitution=0.01      with the standard deviation of the motion
  catena sensitivity scene.toml --by joint1.friction -o out.csv  at all steps, as a table";

pub const INSPECT: &str = "\
Examples:
  catena inspect arm7.mcap                    a summary
  catena inspect arm7.mcap --events           impacts, sticking, bounds of motors
  catena inspect arm7.mcap --plot curves.svg  positions, velocities, energy error, reactions
  catena inspect arm7.mcap --plot elbow.png --curves elbow,energy    some curves only
  catena inspect arm7.mcap other.mcap         compare two logs link by link";

pub const REPORT: &str = "\
Examples:
  catena report arm7.mcap -o run.html         one file that any browser opens
  catena report arm7.mcap other.mcap          two runs side by side, with the curves of both";

pub const FILM: &str = "\
Examples:
  catena film arm7.mcap                       the whole run as arm7.gif
  catena film arm7.mcap -o arm7.mp4 --speed 0.25    in slow motion, by ffmpeg
  catena film arm7.mcap -o arm7.png --time 0,0.5,1  three instants side by side
  catena film arm7.mcap --view top --size 800x800 --time 2,3    one second, seen from above";

pub const REPLAY: &str = "\
Example:
  catena replay arm7.mcap                     does this build make the same motion, bit for bit?";

pub const CHART: &str = "\
Example:
  catena chart robots/arm7.urdf -o chart      CPU time over error, as pictures and a table";

pub const STRESS: &str = "\
Example:
  catena stress -o maps --only mass_ratio     five links and a tip that gets heavier";

pub const SWEEP: &str = "\
Examples:
  catena sweep sweep.toml -o out              all runs, on all cores; the same call goes on after a kill
  catena sweep sweep.toml -o out/3 --shard 3/8    the third of eight shards
  catena sweep --merge out/* -o whole         the shards as one table";

pub const COMPLETIONS: &str = "\
Examples:
  catena completions bash > ~/.local/share/bash-completion/completions/catena
  catena completions zsh > \"${fpath[1]}/_catena\"
  catena completions fish > ~/.config/fish/completions/catena.fish";

pub const MANUAL: &str = "\
Example:
  catena manual ~/.local/share/man/man1       then: man catena, man catena-simulate";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::CommandLine;
    use crate::cli::arguments::contact_args::with_values;
    use clap::Parser;
    use std::ffi::OsString;

    #[test]
    fn every_example_is_a_command_line_that_is_understood() {
        let all = [SIMULATE, MODEL, LINEARIZE, INSPECT, REPORT, REPLAY, CHART, STRESS, SWEEP, COMPLETIONS, MANUAL];
        for line in all.iter().flat_map(|examples| examples.lines()).filter(|line| line.starts_with("  catena ")) {
            // Its explanation comes after two spaces, and its output file after >.
            let command = line.trim_start().split("  ").next().unwrap_or_default();
            let command = command.split(" > ").next().unwrap_or_default();
            let words = command.split(' ').map(OsString::from);
            let parsed = CommandLine::try_parse_from(with_values(words));
            assert!(parsed.is_ok(), "{command}: {}", parsed.err().map_or_else(String::new, |error| error.to_string()));
        }
    }
}
