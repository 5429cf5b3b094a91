//! The exact answers that were computed at 40 digits, read from where they lie.

use crate::common::shared;

/// The numbers of each line of the answer with this heading (`J1`, `D2`): all that follow words; none if the answers are not there.
pub fn answer(heading: &str) -> Option<Vec<Vec<f64>>> {
    let text = shared("reference").and_then(|folder| std::fs::read_to_string(folder.join("nonsmooth.md")).ok());
    let Some(text) = text else {
        println!("skipped: there is no ../shared/reference/nonsmooth.md");
        return None;
    };
    let after = text.split(&format!("\n## {heading} ")).nth(1).expect("a heading");
    let block = after.split("```").nth(1).expect("a block of numbers");
    let numbers = |line: &str| line.split_whitespace().filter_map(|word| word.parse().ok()).collect::<Vec<f64>>();
    Some(block.trim_start_matches('\n').lines().map(numbers).collect())
}

/// Fails where a number is further from the wanted one than is allowed.
#[track_caller]
pub fn near(found: f64, wanted: f64, allowed: f64) {
    assert!((found - wanted).abs() <= allowed, "{found} for {wanted}: off by {:e}", found - wanted);
}
