//! Which source file imports which: `use` trees and paths in the code, outside of tests, through re-exports to where an item is.
//!
//! The text is read, not parsed: macros can hide an import.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// One source file.
pub struct Source {
    /// Its crate: the folder under `src`, or `catena`.
    pub of_crate: String,
    /// Its path from the folder of the repository.
    pub file: String,
    /// Its module path.
    pub module: Vec<String>,
    /// Its text without comments and tests.
    text: String,
}

/// All source files.
pub struct House {
    sources: Vec<Source>,
    /// Number of the file of each module of each crate.
    modules: HashMap<(String, Vec<String>), usize>,
}

impl Source {
    /// A file by its path in the folder of its crate.
    pub fn new(of_crate: &str, file: &str, text: &str) -> Self {
        let folder = if of_crate == "catena" { "src".to_string() } else { format!("src/{of_crate}") };
        let mut module: Vec<String> = file.trim_end_matches(".rs").split('/').map(str::to_string).collect();
        if module.last().is_some_and(|last| last == "mod" || last == "lib") {
            module.pop();
        }
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        let text: Vec<&str> = code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
        Source { of_crate: of_crate.to_string(), file: format!("{folder}/{file}"), module, text: text.join("\n") }
    }

    /// Its text without comments and tests.
    pub fn code(&self) -> &str {
        &self.text
    }

    /// Paths of all `use` trees, and whether they are re-exports.
    fn uses(&self) -> Vec<(Vec<String>, bool)> {
        let mut found = Vec::new();
        for statement in self.text.split(';') {
            let tokens: Vec<&str> = statement.lines().map(str::trim).collect();
            let begins = |line: &&str| -> bool {
                let line = line.trim_start_matches("pub(crate) ").trim_start_matches("pub(super) ");
                line.trim_start_matches("pub ").starts_with("use ")
            };
            let Some(first) = tokens.iter().position(begins) else { continue };
            let tree = tokens[first..].join(" ");
            let Some((visibility, tree)) = tree.split_once("use ") else { continue };
            let paths = expand(&tree.split_whitespace().collect::<Vec<_>>().join(" "));
            found.extend(paths.into_iter().map(|path| (segments(&path), !visibility.is_empty())));
        }
        found
    }

    /// Paths in the code that begin in this crate or in another of ours.
    fn paths(&self) -> Vec<Vec<String>> {
        let word = |c: char| c.is_alphanumeric() || c == '_';
        let starts = [
            "crate::",
            "super::",
            "self::",
            "catena::",
            "catena_mechanism::",
            "catena_geometry::",
            "catena_lobatto::",
            "catena_kernels::",
            "catena_stepping::",
            "catena_reduced::",
            "catena_crowd::",
            "catena_hybrid::",
            "catena_robot::",
            "catena_drawing::",
            "catena_run::",
            "catena_page::",
            "catena_study::",
        ];
        let mut found = Vec::new();
        for start in starts {
            for (at, _) in self.text.match_indices(start) {
                let before = self.text[..at].chars().next_back();
                if before.is_some_and(|c| word(c) || c == ':') {
                    continue;
                }
                let path: String = self.text[at..].chars().take_while(|&c| word(c) || c == ':').collect();
                found.push(segments(&path));
            }
        }
        found
    }
}

/// The paths of a `use` tree with braces.
fn expand(tree: &str) -> Vec<String> {
    let Some((head, rest)) = tree.split_once('{') else { return vec![tree.trim().to_string()] };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let (mut depth, mut part, mut parts) = (0, String::new(), Vec::new());
    for c in inner.chars().chain([',']) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 {
            parts.push(std::mem::take(&mut part));
        } else {
            part.push(c);
        }
    }
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    parts.flat_map(expand).map(|path| format!("{}{path}", head.trim())).collect()
}

/// The names of a path, without an alias.
fn segments(path: &str) -> Vec<String> {
    let path = path.split(" as ").next().unwrap_or_default();
    path.split("::").map(|name| name.trim().to_string()).filter(|name| !name.is_empty()).collect()
}

impl House {
    /// The sources of this repository.
    pub fn read() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut sources = Vec::new();
        collect(&root, "catena", "", &root, &mut sources);
        House::of(sources)
    }

    /// A house of these sources.
    pub fn of(sources: Vec<Source>) -> Self {
        let named = sources.iter().enumerate();
        let modules =
            named.map(|(number, source)| ((source.of_crate.clone(), source.module.clone()), number)).collect();
        House { sources, modules }
    }

    /// All files.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Crate and module of a file.
    pub fn place(&self, file: &str) -> (String, Vec<String>) {
        let source = self.sources.iter().find(|source| source.file == file).expect("a file of the house");
        (source.of_crate.clone(), source.module.clone())
    }

    /// For every file those that it imports. What a file re-exports from its own folder is no import: who takes it imports where it is.
    pub fn edges(&self) -> BTreeMap<String, BTreeSet<String>> {
        let mut edges = BTreeMap::new();
        for source in &self.sources {
            let imports = source.uses().into_iter().filter(|(_, passes_on)| !passes_on).map(|(path, _)| path);
            let targets = imports.chain(source.paths()).filter_map(|path| self.file_of(source, &path, 0));
            let targets = targets.filter(|&target| self.sources[target].file != source.file);
            edges.insert(source.file.clone(), targets.map(|target| self.sources[target].file.clone()).collect());
        }
        edges
    }

    /// The file that holds the item of a path, as it is written in a file.
    fn file_of(&self, source: &Source, path: &[String], depth: usize) -> Option<usize> {
        let (of_crate, full) = absolute(source, path)?;
        let inside = (0..=full.len()).rev().find_map(|length| {
            let number = self.modules.get(&(of_crate.clone(), full[..length].to_vec()))?;
            Some((*number, full.get(length)))
        });
        let (number, item) = inside?;
        let facade = &self.sources[number];
        let passed_on = item.filter(|_| depth < 6).and_then(|item| {
            let uses = facade.uses().into_iter();
            let (path, _) = uses.filter(|(_, passes_on)| *passes_on).find(|(path, _)| path.last() == Some(item))?;
            self.file_of(facade, &path, depth + 1)
        });
        Some(passed_on.unwrap_or(number))
    }
}

/// The crate that holds the beginning of a path, and how many of its names say so, if the root of another crate lends it that name.
fn lent(of_crate: &str, path: &[String]) -> Option<(&'static str, usize)> {
    let room = path.first()?.as_str();
    let of_page = path.get(1).is_some_and(|inner| ["page", "film"].contains(&inner.as_str()));
    let (owner, taken) = match room {
        "output" if of_page => ("page", 1),
        "instant" | "events" => ("hybrid", 0),
        "meshes" | "scene" | "model" => ("robot", 0),
        "simulation" | "derivatives" | "output" | "session" => ("run", 0),
        "mechanism" => ("mechanism", 1),
        "geometry" => ("geometry", 1),
        "lobatto" => ("lobatto", 1),
        "kernels" => ("kernels", 1),
        "stepping" => ("stepping", 1),
        "reduced" => ("reduced", 1),
        "crowd" => ("crowd", 1),
        "drawing" => ("drawing", 1),
        "study" => ("study", 1),
        _ => return None,
    };
    (owner != of_crate).then_some((owner, taken))
}

/// Crate and module path of a path, as it is written in a file; `None` for other crates than ours.
fn absolute(source: &Source, path: &[String]) -> Option<(String, Vec<String>)> {
    let (first, rest) = path.split_first()?;
    let ours = |of_crate: &str, rest: &[String]| Some((of_crate.to_string(), rest.to_vec()));
    match first.as_str() {
        "crate" | "catena" if first == "crate" || source.module.first().is_some_and(|room| room == "cli") => {
            let of_crate = if first == "catena" { "catena" } else { &source.of_crate };
            match lent(of_crate, rest) {
                Some((of_crate, taken)) => ours(of_crate, &rest[taken..]),
                None => ours(of_crate, rest),
            }
        }
        "super" | "self" => {
            let mut base = source.module.clone();
            let mut rest = path;
            while let Some((step, later)) = rest.split_first().filter(|(step, _)| *step == "super" || *step == "self") {
                if step == "super" {
                    base.pop();
                }
                rest = later;
            }
            ours(&source.of_crate, &[&base[..], rest].concat())
        }
        name => match name.strip_prefix("catena_") {
            Some(of_crate) => ours(&of_crate.replace("kernels_", "kernels/"), rest),
            // A child of this module, as re-exports name it.
            None => {
                ours(&source.of_crate, &[&source.module[..], path].concat()).filter(|_| source.file.ends_with("mod.rs"))
            }
        },
    }
}

/// Reads a folder; one with a `Cargo.toml` is a crate of its own.
fn collect(root: &Path, of_crate: &str, inside: &str, folder: &Path, sources: &mut Vec<Source>) {
    let entries = std::fs::read_dir(folder).expect("a folder of the sources");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let below = if inside.is_empty() { name.clone() } else { format!("{inside}/{name}") };
        if path.join("Cargo.toml").exists() {
            let relative = path.strip_prefix(root).expect("below the root").to_string_lossy().into_owned();
            collect(root, &relative, "", &path, sources);
        } else if path.is_dir() {
            collect(root, of_crate, &below, &path, sources);
        } else if name.ends_with(".rs") && name != "main.rs" {
            let text = std::fs::read_to_string(&path).expect("a source file");
            sources.push(Source::new(of_crate, &below, &text));
        }
    }
}
