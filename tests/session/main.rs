//! Runs as programs make them: the same bits as the command line, controllers and efforts, the equations of motion, and every wrong input.

mod bad_input;
mod between_ticks;
mod control;
mod dynamics;
mod forces_at_jumps;
mod linear;
mod linear_contacts;
mod linear_slopes;
mod quantities;
mod runs;
mod sensitivity;
mod sensitivity_close_events;
mod sensitivity_contacts;
mod sensitivity_corners;
mod sensitivity_events;
mod sensitivity_frames;
mod sensitivity_gradient;
mod sensitivity_keys;
mod sensitivity_starts;
mod sensitivity_ticks;
mod sensors;
mod states;

use std::path::{Path, PathBuf};

/// An example robot or scene.
fn robot(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name)
}

/// A folder of its own for a test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("catena-session-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}
