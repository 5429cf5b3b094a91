//! The house: data goes one way through `src`, from floor to floor, and no files or folders import each other in a circle. Comments and documents
//! are in plain words.

mod imports;
mod touched;
mod words;

use imports::{House, Source};
use std::collections::{BTreeMap, BTreeSet};

/// The floors of each crate from the ground up; a file imports its own floor and those before it.
const FLOORS: [(&str, &[&str]); 8] = [
    ("mechanism", &["ground", "description", "forces", "motion", "structure"]),
    (
        "lobatto",
        &[
            "numbers",
            "vectors",
            "tableau",
            "plan",
            "stages",
            "equations",
            "solve",
            "ending",
            "coupled",
            "planar",
            "instants",
            "step",
        ],
    ),
    ("robot", &["meshes", "scene", "model"]),
    ("hybrid", &["instant", "events"]),
    ("run", &["simulation", "derivatives", "output", "session"]),
    ("page", &["page", "film"]),
    ("study", &["chart", "stress", "sweep"]),
    ("catena", &["errors", "observing", "report", "of_urdf_rs", "prelude", "cli"]),
];

/// The crates from the ground up.
const CRATES: [&str; 17] = [
    "mechanism",
    "geometry",
    "crowd",
    "lobatto",
    "kernels/avx512",
    "kernels/avx2",
    "kernels/portable",
    "kernels",
    "stepping",
    "reduced",
    "robot",
    "hybrid",
    "drawing",
    "run",
    "page",
    "study",
    "catena",
];

/// Nodes that are left when every node is taken away whose targets have all been: those of circles, and those that lead to them.
fn circles(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let mut left: BTreeSet<&String> = edges.keys().collect();
    loop {
        let done = |node: &&String| edges[*node].iter().all(|target| !left.contains(target));
        let free: Vec<&String> = left.iter().copied().filter(|node| done(node)).collect();
        if free.is_empty() {
            return left.into_iter().cloned().collect();
        }
        free.into_iter().for_each(|node| {
            left.remove(node);
        });
    }
}

/// Which folders import which; files beside the root of a crate are folders of their own.
fn folders(house: &House) -> BTreeMap<String, BTreeSet<String>> {
    let folder = |file: &str| file.rsplit_once('/').map_or(file, |(folder, _)| folder).to_string();
    let mut between: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (file, targets) in house.edges() {
        let here = folder(&file);
        let others = targets.iter().map(|target| folder(target)).filter(|other| *other != here);
        between.entry(here.clone()).or_default().extend(others);
    }
    between
}

/// Imports of a floor by one below it, or of a crate by one below it.
fn upward(house: &House) -> Vec<String> {
    let rank = |(own, module): &(String, Vec<String>)| {
        let of_crate = CRATES.iter().position(|name| name == own).unwrap_or(CRATES.len());
        let floors = FLOORS.iter().find(|(name, _)| name == own).map_or(&[][..], |(_, floors)| floors);
        let floor = module.first().and_then(|first| floors.iter().position(|floor| floor == first));
        (of_crate, floor.unwrap_or(usize::MAX))
    };
    let mut found = Vec::new();
    for (file, targets) in house.edges() {
        let here = rank(&house.place(&file));
        found.extend(
            targets
                .iter()
                .filter(|target| rank(&house.place(target)) > here)
                .map(|target| format!("{file} -> {target}")),
        );
    }
    found
}

#[test]
fn no_files_and_no_folders_import_each_other_in_a_circle() {
    let house = House::read();
    assert!(house.edges().len() > 250, "the sources were found");
    assert_eq!(circles(&house.edges()), Vec::<String>::new(), "files");
    assert_eq!(circles(&folders(&house)), Vec::<String>::new(), "folders");
}

#[test]
fn nothing_imports_a_floor_above_its_own() {
    assert_eq!(upward(&House::read()), Vec::<String>::new());
}

#[test]
fn every_folder_of_the_sources_is_a_floor() {
    for source in House::read().sources() {
        let Some((_, floors)) = FLOORS.iter().find(|(name, _)| *name == source.of_crate) else { continue };
        let first = source.module.first().map_or("", String::as_str);
        assert!(
            first.is_empty() || floors.contains(&first),
            "{}: {first:?} is no floor of {}",
            source.file,
            source.of_crate
        );
    }
}

#[test]
fn circles_and_upward_imports_are_found_through_re_exports_braces_and_paths_in_the_code() {
    let source = |of_crate: &str, file: &str, text: &str| Source::new(of_crate, file, text);
    let house = House::of(vec![
        source(
            "robot",
            "scene/mod.rs",
            "mod error;\nmod robot;\npub use robot::Robot;\npub use error::{Problem, SceneError};",
        ),
        source("robot", "scene/robot.rs", "use super::error::Problem; // use crate::output::log;\npub struct Robot;"),
        source(
            "robot",
            "scene/error.rs",
            "fn of(robot: &crate::scene::Robot) {}\n#[cfg(test)]\nmod tests { use crate::output::log::Log; }",
        ),
        source(
            "run",
            "output/log.rs",
            "use crate::{\n    mechanism::motion::state::State,\n    scene::{Robot, SceneError},\n};",
        ),
        source("mechanism", "motion/state.rs", "use catena_lobatto::numbers::Lanes;"),
        source("lobatto", "numbers/mod.rs", "pub struct Lanes;"),
    ]);
    assert_eq!(
        circles(&house.edges()),
        ["robot/scene/error.rs", "robot/scene/robot.rs", "run/output/log.rs"].map(|file| format!("src/{file}"))
    );
    assert_eq!(upward(&house), ["src/mechanism/motion/state.rs -> src/lobatto/numbers/mod.rs"]);
    let folders = folders(&house);
    assert!(circles(&folders).is_empty(), "all of that circle is in one folder: {folders:?}");
}

#[test]
fn what_the_library_shows_of_itself_is_what_programs_are_meant_to_use() {
    let root = std::fs::read_to_string("src/lib.rs").expect("the root of the library");
    let mut hidden = false;
    let mut shown = Vec::new();
    for line in root.lines() {
        if line.starts_with("pub ") && !hidden {
            shown.push(line.trim_end_matches([';', '{', ' ']).to_string());
        }
        // Attributes of an item follow each other.
        hidden = line == "#[doc(hidden)]" || (hidden && line.starts_with("#["));
    }
    let meant = [
        "pub mod errors",
        "pub mod observing",
        "pub mod prelude",
        "pub mod report",
        "pub use catena_run::session",
        "pub use nalgebra",
    ];
    assert_eq!(shown, meant, "hide what is for the programs of this repository alone");
}
