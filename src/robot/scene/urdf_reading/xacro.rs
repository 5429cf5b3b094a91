//! Xacro sources, which the program `xacro` expands to a URDF.

use crate::scene::bounded::STANDARD_INPUT;
use crate::scene::error::{Problem, SceneError};
use crate::scene::numbers::shown;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

/// Whether a file is a source of xacro by its name.
pub(crate) fn is_source(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xacro"))
}

/// The result of `xacro` for a source, of which `line` shows that it is one.
///
/// # Errors
/// [`SceneError`] if the program is not installed or fails.
pub(crate) fn expanded(path: &Path, line: Option<usize>) -> Result<String, SceneError> {
    let refuse =
        |problem| Err(SceneError { file: path.to_path_buf(), line, element: None, problem: Box::new(problem) });
    if path == Path::new(STANDARD_INPUT) {
        return refuse(Problem::NoXacro);
    }
    let output = Command::new("xacro").arg(path).stdin(Stdio::null()).output();
    match output {
        Ok(output) if output.status.success() => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("it says no reason");
            refuse(Problem::XacroFailed(shown(last)))
        }
        Err(error) if error.kind() == ErrorKind::NotFound => refuse(Problem::NoXacro),
        Err(error) => refuse(Problem::XacroFailed(error.to_string())),
    }
}
