//! `catena inspect --follow`: looks again and again at a log that a run is writing.

use crate::cli::terminal::printing::{Failure, print, print_while_read};
use anyhow::anyhow;
use catena::output::inspection::summary::Summary;
use catena::output::log::{is_locked, neighbour};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Pause between two looks at a log that is being written.
const LOOK_INTERVAL: Duration = Duration::from_millis(500);

/// Shows a log while it grows, until the run that writes it has ended.
///
/// # Errors
/// [`Failure`]: 2 if the log cannot be read, 130 if it is interrupted.
pub(crate) fn follow(log: &Path, json: bool) -> Result<(), Failure> {
    let interrupted = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;
    let mut shown = None;
    loop {
        let looked = Instant::now();
        // While its output must stay, a run writes beside it.
        let beside = neighbour(log);
        // The lock is asked before reading, so that at least all bytes are read that existed while the run still wrote. It is asked once, because the
        // run may end meanwhile.
        let is_beside = is_locked(&beside);
        let current = if is_beside { &beside } else { log };
        let is_written = is_beside || is_locked(log);
        match Summary::read(current) {
            Ok(summary) => {
                if shown != Some(summary.samples) {
                    shown = Some(summary.samples);
                    let line = if json {
                        serde_json::to_string(&summary).map_err(Failure::run)? + "\n"
                    } else {
                        line(&summary)
                    };
                    if print_while_read(line)?.is_break() {
                        return Ok(());
                    }
                }
                if !is_written {
                    if !json {
                        print(format_args!("{}: {}\n", current.display(), summary.state()))?;
                    }
                    return Ok(());
                }
            }
            // The first bytes may not be there yet.
            Err(_) if is_written => {}
            Err(error) => return Err(Failure::input(error)),
        }
        // Long logs take longer to read; most of the time should go to the run.
        let pause = LOOK_INTERVAL.max(4 * looked.elapsed());
        let until = Instant::now() + pause;
        while Instant::now() < until {
            if interrupted.load(Ordering::Relaxed) {
                return Err(Failure::interrupted(anyhow!("interrupted")));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

fn line(summary: &Summary) -> String {
    let mut line = format!("t = {} s, {} samples", summary.duration, summary.samples);
    if let Some(energy) = &summary.energy {
        let _ = write!(line, ", energy error {:.1e}", energy.max_relative_error);
    }
    if let Some(constraint) = &summary.constraint {
        let _ = write!(line, ", violation {:.1e} m, {:.1e} m/s", constraint.max_position, constraint.max_velocity);
    }
    if let Some(said) = &summary.accuracy_so_far {
        let _ = write!(line, ", {said}");
    }
    line + "\n"
}
