//! Files that one more kind of something touches: those that name a kind of today, counted and listed in `doc/touched_files.md`.
//!
//! A kind stands for all others of its sort. A new file with its name is one more place that somebody who adds a kind must know, so that the list
//! must have it.

use crate::imports::House;

/// What is added, and the names by which a file shows that it treats kinds of it one by one.
const SORTS: [(&str, &[&str]); 3] = [
    ("A joint type", &["JointKind::Planar"]),
    ("A force", &["point_springs"]),
    ("A friction law", &["Grip::Slides", "Law::Sliding", "Law::Contact"]),
];

/// Whether the code has this name as a whole word.
fn names(code: &str, name: &str) -> bool {
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    code.match_indices(name)
        .any(|(at, _)| !is_part(code[..at].chars().next_back()) && !is_part(code[at + name.len()..].chars().next()))
}

/// The page as the sources make it.
fn page(house: &House) -> String {
    let mut text = String::from(
        "# Files that a new kind touches\n\n`cargo test --test house` compares this page with the sources, and prints it anew if they differ.\n",
    );
    for (sort, kinds) in SORTS {
        let all = house.sources().iter().filter(|source| kinds.iter().any(|kind| names(source.code(), kind)));
        let mut files: Vec<&str> = all.map(|source| source.file.as_str()).collect();
        files.sort_unstable();
        let named: Vec<String> = kinds.iter().map(|kind| format!("`{kind}`")).collect();
        text += &format!("\n## {sort}: {} files name {}\n\n", files.len(), named.join(" or "));
        files.iter().for_each(|file| text += &format!("- `{file}`\n"));
    }
    text
}

#[test]
fn the_files_that_a_joint_type_a_force_and_a_friction_law_touch_are_counted_and_listed() {
    let now = page(&House::read());
    let said = std::fs::read_to_string("doc/touched_files.md").unwrap_or_default();
    assert!(said == now, "doc/touched_files.md differs from the sources; it should be:\n{now}");
}

#[test]
fn a_name_is_found_as_a_whole_word_only() {
    assert!(names("match JointKind::Planar {", "JointKind::Planar"));
    assert!(!names("UrdfJointKind::Planar", "JointKind::Planar"));
    assert!(!names("JointKind::PlanarAxis", "JointKind::Planar"));
}
