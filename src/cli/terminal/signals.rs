//! Requests to end: Ctrl-C, signals, and files that grow larger than the system allows.

use anyhow::Context;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Signals that ask a process to end.
const ENDING_SIGNALS: &[i32] = &[
    SIGINT,
    SIGTERM,
    #[cfg(unix)]
    signal_hook::consts::SIGHUP,
];

/// Makes a file that has reached the size the system allows an error of the write, like a full disk, not the end of the process.
#[cfg(unix)]
pub fn outlive_large_files() {
    // If the system refuses, the process ends as it would anyway.
    let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

#[cfg(not(unix))]
pub fn outlive_large_files() {}

/// After the first Ctrl-C a second one ends the process, but not at once: `timeout` sends its signal to the process and to its group.
const PATIENCE: Duration = Duration::from_millis(500);

/// A flag that the first Ctrl-C (or request to end) sets; a second one, half a second later, ends the process.
///
/// # Errors
/// If the system does not let us watch.
pub fn watch_for_signals() -> anyhow::Result<Arc<AtomicBool>> {
    let [interrupted, impatient] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
    let watch = || -> io::Result<()> {
        for &signal in ENDING_SIGNALS {
            flag::register_conditional_shutdown(signal, 130, impatient.clone())?;
            flag::register(signal, interrupted.clone())?;
        }
        let seen = interrupted.clone();
        std::thread::Builder::new().name("signals".to_string()).spawn(move || {
            while !seen.load(Ordering::Relaxed) {
                std::thread::sleep(PATIENCE / 5);
            }
            std::thread::sleep(PATIENCE);
            impatient.store(true, Ordering::Relaxed);
        })?;
        Ok(())
    };
    watch().context("cannot watch for Ctrl-C")?;
    Ok(interrupted)
}
