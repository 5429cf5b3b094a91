//! Xacro sources, which the program `xacro` expands to a URDF.

use crate::scene::bounded::STANDARD_INPUT;
use crate::scene::error::{Problem, SceneError};
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The name of standard input for other programs.
const INPUT_FILE: &str = "/dev/stdin";

/// Most letters of a reason.
const LONGEST: usize = 400;

/// Whether a file is a source of xacro by its name.
pub(crate) fn is_source(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xacro"))
}

/// The result of `xacro` for a source with this text, of which `line` shows that it is one; with arguments as `NAME:=VALUE`. Standard input, which
/// was read to its end, is given to the program as its own.
///
/// # Errors
/// [`SceneError`] if the program is not installed or fails.
pub(crate) fn expanded(
    path: &Path,
    text: &str,
    line: Option<usize>,
    arguments: &[(String, String)],
) -> Result<String, SceneError> {
    let refuse =
        |problem| Err(SceneError { file: path.to_path_buf(), line, element: None, problem: Box::new(problem) });
    let piped = path == Path::new(STANDARD_INPUT);
    match run(if piped { Path::new(INPUT_FILE) } else { path }, piped.then_some(text), arguments) {
        Ok(output) if output.status.success() => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        Ok(output) => refuse(Problem::XacroFailed(reason(&String::from_utf8_lossy(&output.stderr)))),
        Err(error) if error.kind() == ErrorKind::NotFound => refuse(Problem::NoXacro),
        Err(error) => refuse(Problem::XacroFailed(error.to_string())),
    }
}

fn run(path: &Path, input: Option<&str>, arguments: &[(String, String)]) -> std::io::Result<Output> {
    let mut command = Command::new("xacro");
    command.arg(path).args(arguments.iter().map(|(name, value)| format!("{name}:={value}")));
    command.stdin(if input.is_some() { Stdio::piped() } else { Stdio::null() });
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    if let (Some(mut pipe), Some(text)) = (child.stdin.take(), input) {
        // The program reads all of it before it writes. One that ends early says why itself.
        match pipe.write_all(text.as_bytes()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => return Err(error),
            _ => {}
        }
    }
    child.wait_with_output()
}

/// The reason that the program gives, in one line, without warnings and without the name of the source, which is said already.
fn reason(said: &str) -> String {
    let lines = || said.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_plain =
        |line: &&str| !line.starts_with("when processing file:") && !line.to_lowercase().starts_with("warning");
    // The last line counts if the program itself failed.
    let all: Vec<&str> = match lines().any(|line| line.starts_with("Traceback")) {
        true => lines().next_back().into_iter().collect(),
        false => lines().filter(is_plain).map(|line| line.trim_start_matches("error: ")).collect(),
    };
    if all.is_empty() {
        return "it says no reason".to_string();
    }
    let whole = all.join("; ");
    whole.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect()
}
