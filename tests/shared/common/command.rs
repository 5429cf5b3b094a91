//! Running the program as scripts do, in folders of its own.

use super::scratch;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

pub const PENDULUM: &str = r#"<robot name="pendulum">
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
  <link name="rod">
    <inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 -0.5"/><geometry><box size="0.1 0.1 1"/></geometry></visual>
  </link>
  <joint name="weld" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="0 0 -1"/></joint>
  <link name="tip"/>
</robot>"#;

/// Far more than any test waits for.
pub const ENDLESS: [&str; 8] = ["--duration", "1e7", "--stages", "4", "--step", "0.01", "--rate", "1"];

/// An empty folder of this test's own with a pendulum in it.
pub fn folder(name: &str) -> PathBuf {
    let folder = scratch(name);
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM).expect("the pendulum is written");
    folder
}

pub fn catena(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_catena"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn run(folder: &Path, arguments: &[&str]) -> Output {
    catena(folder, arguments).output().expect("catena runs")
}

/// The same with a text on standard input.
pub fn run_with_input(folder: &Path, arguments: &[&str], input: &str) -> Output {
    use std::io::Write;
    let mut child = catena(folder, arguments).stdin(Stdio::piped()).spawn().expect("catena starts");
    // A program that refuses its arguments does not read.
    let _ = child.stdin.take().expect("a pipe").write_all(input.as_bytes());
    child.wait_with_output().expect("catena ends")
}

pub fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// One line on standard error, in the form scripts expect, and nothing on standard output.
pub fn assert_one_error(output: &Output, exit_code: i32, what: &str) {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(exit_code), "{what}: {error}");
    assert!(error.starts_with("catena: error: "), "{what}: {error}");
    assert_eq!(error.lines().count(), 1, "{what}: {error}");
    assert!(output.stdout.is_empty(), "{what}: {}", text(&output.stdout));
}

/// Waits until `condition` holds; panics after a minute.
pub fn wait_for(child: &mut Child, what: &str, condition: impl Fn() -> bool) {
    for _ in 0..600 {
        if condition() {
            return;
        }
        if let Some(status) = child.try_wait().expect("the child can be asked") {
            panic!("{what}: catena has ended with {status}");
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    let _ = child.kill();
    panic!("{what} did not happen");
}

/// The messages that can be read from a log that need not be complete.
pub fn salvaged<'b>(bytes: &'b [u8], topic: &str) -> Vec<mcap::Message<'b>> {
    let Ok(stream) = mcap::MessageStream::new_with_options(bytes, mcap::read::Options::IgnoreEndMagic.into()) else {
        return Vec::new();
    };
    stream.map_while(Result::ok).filter(|message| message.channel.topic == topic).collect()
}

pub fn salvaged_samples(log: &Path) -> usize {
    std::fs::read(log).map_or(0, |bytes| salvaged(&bytes, "/tf").len())
}
