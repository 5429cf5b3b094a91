//! Warnings about the input, in three groups: parts that are not simulated, odd parts of the file, and ignored ones.

use crate::mechanism::ground::words::counted;
use crate::scene::error::{Element, place};
use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

/// The statement of a warning about its part of the file. The order is the order in which people read them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum WarningGroup {
    /// No warning: the part is used, and other programs keep it elsewhere or read it otherwise.
    Taken,
    /// The part means something for the motion, and the motion goes without it.
    NotSimulated,
    /// The part is missing, wrong or unusual; the message says how it was read.
    Odd,
    /// Tags and attributes that are ignored; a list of warnings has one line for all of a file.
    Ignored,
}

impl WarningGroup {
    /// The title above the warnings of this group.
    pub fn title(self) -> &'static str {
        match self {
            WarningGroup::Taken => "Taken from the file",
            WarningGroup::NotSimulated => "Not simulated",
            WarningGroup::Odd => "Odd in the file",
            WarningGroup::Ignored => "Ignored tags and attributes",
        }
    }
}

/// Something that was repaired, left out, or will not be simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// Its statement about the file.
    pub group: WarningGroup,
    /// The file.
    pub file: PathBuf,
    /// The line, counted from 1.
    pub line: Option<usize>,
    /// The link or joint.
    pub element: Option<Element>,
    /// The treatment of the part; for an ignored part its name, and its number of occurrences.
    pub message: String,
}

impl Warning {
    /// A warning that something in the file is missing, wrong or unusual.
    pub fn odd(file: &Path, line: Option<usize>, element: Option<Element>, message: impl Into<String>) -> Self {
        Warning { group: WarningGroup::Odd, file: file.to_path_buf(), line, element, message: message.into() }
    }

    /// The same warning in another group.
    pub(crate) fn in_group(self, group: WarningGroup) -> Self {
        Warning { group, ..self }
    }

    /// One warning for several of a kind: the first, and how many more it is true of, links or joints (`one`, `several`).
    pub(crate) fn of_kind(all: Vec<Warning>, one: &str, several: &str) -> Option<Warning> {
        let more = all.len().saturating_sub(1);
        let mut first = all.into_iter().next()?;
        if more > 0 {
            first.message +=
                &format!("; the same for {}", counted(more, &format!("more {one}"), &format!("more {several}")));
        }
        Some(first)
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ignored = if self.group == WarningGroup::Ignored { "ignored: " } else { "" };
        write!(out, "{}: {ignored}{}", place(&self.file, self.line, &self.element), self.message)
    }
}

/// The lines that people read, group by group; ignored parts are one line for each file.
pub fn warning_lines(warnings: &[Warning]) -> Vec<(WarningGroup, String)> {
    let of = |group| warnings.iter().filter(move |warning| warning.group == group);
    let mut paths = LongPaths::of(warnings);
    let mut lines: Vec<(WarningGroup, String)> = [WarningGroup::Taken, WarningGroup::NotSimulated, WarningGroup::Odd]
        .into_iter()
        .flat_map(of)
        .map(|warning| {
            (
                warning.group,
                format!("{}: {}", place(paths.said(&warning.file), warning.line, &warning.element), warning.message),
            )
        })
        .collect();
    let files: BTreeSet<&Path> = of(WarningGroup::Ignored).map(|warning| warning.file.as_path()).collect();
    lines.extend(files.into_iter().map(|file| {
        let named = |warning: &Warning| match warning.line {
            Some(line) => format!("line {line}: {}", warning.message),
            None => warning.message.clone(),
        };
        let all: Vec<String> = of(WarningGroup::Ignored).filter(|warning| warning.file == file).map(named).collect();
        (WarningGroup::Ignored, format!("{}: ignored: {}", paths.said(file).display(), all.join("; ")))
    }));
    lines
}

/// A path of more letters is long.
const LONG: usize = 40;

/// The files of some warnings, of which a long path is said once, and then the name of the file.
struct LongPaths<'w> {
    files: BTreeSet<&'w Path>,
    said: BTreeSet<&'w Path>,
}

impl<'w> LongPaths<'w> {
    fn of(warnings: &'w [Warning]) -> Self {
        LongPaths { files: warnings.iter().map(|warning| warning.file.as_path()).collect(), said: BTreeSet::new() }
    }

    /// The name of a file.
    fn said(&mut self, file: &'w Path) -> &'w Path {
        let name = Path::new(file.file_name().unwrap_or(file.as_os_str()));
        let is_one_of_several = self.files.iter().any(|other| *other != file && other.file_name() == file.file_name());
        if self.said.insert(file) || is_one_of_several || file.as_os_str().len() <= LONG { file } else { name }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_group_by_group_and_what_is_ignored_takes_one_line_for_each_file() {
        let warning = |group, file: &str, line, message: &str| {
            Warning::odd(Path::new(file), Some(line), None, message).in_group(group)
        };
        let lines = warning_lines(&[
            warning(WarningGroup::Ignored, "a.urdf", 3, "<gazebo> (2 times)"),
            warning(WarningGroup::Odd, "a.urdf", 4, "has inertia but no mass"),
            warning(WarningGroup::Ignored, "b.urdf", 5, "<sensor>"),
            warning(WarningGroup::NotSimulated, "b.urdf", 6, "limits of 2 floating joints are not simulated"),
            warning(WarningGroup::Ignored, "a.urdf", 7, "<transmission>"),
        ]);
        let expected = [
            (WarningGroup::NotSimulated, "b.urdf:6: limits of 2 floating joints are not simulated"),
            (WarningGroup::Odd, "a.urdf:4: has inertia but no mass"),
            (WarningGroup::Ignored, "a.urdf: ignored: line 3: <gazebo> (2 times); line 7: <transmission>"),
            (WarningGroup::Ignored, "b.urdf: ignored: line 5: <sensor>"),
        ];
        assert_eq!(lines, expected.map(|(group, line)| (group, line.to_string())));
    }

    #[test]
    fn a_long_path_is_said_once_and_then_the_name_of_its_file_unless_two_files_have_it() {
        let long = "/a/folder/with/a/long/name/and/one/more/below/it/robot.urdf";
        let warn = |file: &str| Warning::odd(Path::new(file), Some(3), None, "odd");
        let said = |files: &[&str]| -> Vec<String> {
            let warnings: Vec<Warning> = files.iter().map(|file| warn(file)).collect();
            warning_lines(&warnings).into_iter().map(|(_, line)| line).collect()
        };
        assert_eq!(
            said(&[long, long, "short/a.urdf", "short/a.urdf"]),
            [
                format!("{long}:3: odd"),
                "robot.urdf:3: odd".to_string(),
                "short/a.urdf:3: odd".to_string(),
                "short/a.urdf:3: odd".to_string(),
            ]
        );
        let other = "b/robot.urdf";
        assert_eq!(said(&[long, other, long]), [long, other, long].map(|file| format!("{file}:3: odd")));
    }
}
