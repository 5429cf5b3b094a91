//! Finds the mesh files of a robot; the ones that are missing are reported once for each package or folder.

use crate::scene::error::Element;
use crate::scene::urdf_reading::element::CleanElement;
use crate::scene::urdf_reading::package_path::{PackagePath, Resolved};
use crate::scene::warning::Warning;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The mesh files that were found, by the name the URDF gives them.
#[derive(Default)]
pub(crate) struct MeshFiles {
    found: HashMap<String, PathBuf>,
    carried: HashMap<String, Arc<Vec<u8>>>,
}

/// Meshes of one package (or folder) that were not found.
struct Missing {
    place: String,
    first: String,
    element: Element,
    line: usize,
    reason: String,
    others: usize,
}

impl MeshFiles {
    /// The existing file behind a name.
    pub fn get(&self, name: &str) -> Option<&PathBuf> {
        self.found.get(name)
    }

    /// The bytes behind a name, if they are in memory alone.
    pub fn carried(&self, name: &str) -> Option<&Arc<Vec<u8>>> {
        self.carried.get(name)
    }

    /// Looks for every mesh of the robot.
    pub fn find(file: &Path, robot: &CleanElement, packages: &PackagePath) -> (Self, Vec<Warning>) {
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut files = MeshFiles::default();
        let mut seen: HashSet<&str> = HashSet::new();
        let mut missing: Vec<Missing> = Vec::new();
        for (link, mesh) in meshes(robot) {
            let Some(name) = mesh.attribute("filename") else { continue };
            if !seen.insert(name) {
                continue;
            }
            let reason = match packages.resolve(name, folder) {
                Resolved::Found(path) => {
                    files.found.insert(name.to_string(), path);
                    continue;
                }
                Resolved::Carried(bytes) => {
                    files.carried.insert(name.to_string(), bytes);
                    continue;
                }
                Resolved::Missing(tried) => {
                    let tried: Vec<String> = tried.iter().map(|path| path.display().to_string()).collect();
                    format!("was not found; tried {}", tried.join(", "))
                }
                Resolved::Outside => "leads out of its package, and is not used".to_string(),
                Resolved::NotAFile(scheme) => format!("is not a local file ({scheme}://)"),
            };
            let place = place_of(name);
            match missing.iter_mut().find(|missing| missing.place == place) {
                Some(missing) => missing.others += 1,
                None => missing.push(Missing {
                    place,
                    first: name.to_string(),
                    element: Element::Link(link.to_string()),
                    line: mesh.line,
                    reason,
                    others: 0,
                }),
            }
        }
        let warnings = missing
            .into_iter()
            .map(|missing| {
                let others = match missing.others {
                    0 => String::new(),
                    others => format!("; the same for {others} more of {}", missing.place),
                };
                let packaged = missing.place.starts_with("package://") || missing.place.starts_with("model://");
                let advice = if packaged { "; --package NAME=DIR says where a package is" } else { "" };
                let message = format!("the mesh {:?} {}{others}{advice}", missing.first, missing.reason);
                Warning::odd(file, Some(missing.line), Some(missing.element), message)
            })
            .collect();
        (files, warnings)
    }

    /// Makes the mesh names in the robot absolute, for readers who do not know where the URDF was.
    pub fn make_absolute(&self, element: &mut CleanElement) {
        if let Some(path) = element.attribute("filename").and_then(|name| self.get(name)) {
            let absolute = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            element.set("filename", format!("file://{}", absolute.display()));
        }
        for child in &mut element.children {
            self.make_absolute(child);
        }
    }
}

/// Every mesh element with the name of its link.
fn meshes(robot: &CleanElement) -> impl Iterator<Item = (&str, &CleanElement)> {
    robot.children_named("link").flat_map(|link| {
        let name = link.attribute("name").unwrap_or_default();
        let shapes = link.children.iter().filter(|child| matches!(child.name, "visual" | "collision"));
        shapes.filter_map(move |shape| Some((name, shape.child("geometry")?.child("mesh")?)))
    })
}

/// The package of a mesh, or "this folder".
fn place_of(name: &str) -> String {
    match name.split_once("://") {
        Some((scheme @ ("package" | "model"), path)) => {
            format!("{scheme}://{}", path.split('/').next().unwrap_or_default())
        }
        Some((scheme, _)) => format!("{scheme}://"),
        None => "the URDF's folder".to_string(),
    }
}
