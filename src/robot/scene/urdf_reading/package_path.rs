//! The paths of mesh files: `package://NAME/rest`, `file://...`, absolute and relative paths.
//!
//! `package://` (and Gazebo's `model://`) is looked for, in this order, in
//!
//! 1. the folders given by `--package NAME=DIR`: `DIR/rest`;
//! 2. `ROS_PACKAGE_PATH`: `P/NAME/rest`, or `P/rest` where the folder `P` is itself named NAME;
//! 3. `AMENT_PREFIX_PATH`: `P/NAME/rest`, `P/share/NAME/rest`;
//! 4. the folders above the URDF: `A/NAME/rest`, `A/rest`.
//!
//! A name that a program carries in memory is that.
//!
//! A rest that leads out of its package, `package://NAME/../file`, names no file.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// The places in which packages are looked for.
#[derive(Clone, Debug, Default)]
pub struct PackagePath {
    /// `--package NAME=DIR`.
    pub packages: Vec<(String, PathBuf)>,
    /// Folders of `ROS_PACKAGE_PATH`.
    pub ros_package_path: Vec<PathBuf>,
    /// Folders of `AMENT_PREFIX_PATH`.
    pub ament_prefix_path: Vec<PathBuf>,
    /// Arguments of sources of xacro: names and values.
    pub xacro: Vec<(String, String)>,
    /// Files that are in memory alone, by the names that a robot gives them.
    pub carried: HashMap<String, Arc<Vec<u8>>>,
}

/// The result of a search for a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Resolved {
    /// The file exists.
    Found(PathBuf),
    /// It is in memory.
    Carried(Arc<Vec<u8>>),
    /// It does not; these paths were tried.
    Missing(Vec<PathBuf>),
    /// It leads out of its package.
    Outside,
    /// A scheme that names no local file, such as `http`.
    NotAFile(String),
}

impl PackagePath {
    /// The given packages, and the search paths of the environment.
    pub fn from_environment(packages: Vec<(String, PathBuf)>) -> Self {
        let folders = |variable: &str| -> Vec<PathBuf> {
            std::env::var_os(variable)
                .map(|value| std::env::split_paths(&value).filter(|path| !path.as_os_str().is_empty()).collect())
                .unwrap_or_default()
        };
        PackagePath {
            packages,
            ros_package_path: folders("ROS_PACKAGE_PATH"),
            ament_prefix_path: folders("AMENT_PREFIX_PATH"),
            xacro: Vec::new(),
            carried: HashMap::new(),
        }
    }

    /// Looks for the file that a URDF in the folder `folder` calls `uri`.
    pub fn resolve(&self, uri: &str, folder: &Path) -> Resolved {
        if let Some(bytes) = self.carried.get(uri) {
            return Resolved::Carried(bytes.clone());
        }
        let candidates = match uri.split_once("://") {
            None => vec![folder.join(uri)],
            Some(("file", path)) => vec![folder.join(path)],
            Some(("package" | "model", path)) if !stays_inside(path) => return Resolved::Outside,
            Some(("package" | "model", path)) => self.package_candidates(path, folder),
            Some((scheme, _)) => return Resolved::NotAFile(scheme.to_string()),
        };
        match candidates.iter().find(|candidate| candidate.is_file()) {
            Some(found) => Resolved::Found(found.clone()),
            None => Resolved::Missing(candidates),
        }
    }

    /// The paths at which `NAME/rest` of a package may be, in the order of the module's table.
    fn package_candidates(&self, path: &str, folder: &Path) -> Vec<PathBuf> {
        let (name, rest) = path.split_once('/').unwrap_or((path, ""));
        let mut candidates: Vec<PathBuf> = Vec::new();
        let mut add = |candidate: PathBuf| {
            if !candidates.contains(&candidate) {
                candidates.push(candidate);
            }
        };
        for (_, given) in self.packages.iter().filter(|(given, _)| given == name) {
            add(given.join(rest));
        }
        for prefix in &self.ros_package_path {
            add(prefix.join(name).join(rest));
            if prefix.file_name().is_some_and(|last| last == name) {
                add(prefix.join(rest));
            }
        }
        for prefix in &self.ament_prefix_path {
            add(prefix.join(name).join(rest));
            add(prefix.join("share").join(name).join(rest));
        }
        let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
        for above in absolute.ancestors() {
            add(above.join(name).join(rest));
            add(above.join(rest));
        }
        candidates
    }
}

/// Whether `NAME/rest` names something below the folder NAME: no part of it goes above that, and the rest does not begin anew at the root.
fn stays_inside(path: &str) -> bool {
    let (name, rest) = path.split_once('/').unwrap_or((path, ""));
    let mut depth = 0_usize;
    let inside = Path::new(rest).components().all(|part| match part {
        Component::Normal(_) => {
            depth += 1;
            true
        }
        Component::CurDir => true,
        Component::ParentDir => {
            let above = depth == 0;
            depth = depth.saturating_sub(1);
            !above
        }
        Component::RootDir | Component::Prefix(_) => false,
    });
    inside && matches!(Path::new(name).components().next(), None | Some(Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_out_of_its_package_names_nothing_whatever_lies_there() {
        let folder = std::env::temp_dir().join(format!("catena-package-{}", std::process::id()));
        let package = folder.join("pk");
        std::fs::create_dir_all(package.join("meshes")).expect("a folder for the test");
        for file in [folder.join("file"), package.join("file")] {
            std::fs::write(file, b"x").expect("written");
        }
        let packages = PackagePath { packages: vec![("pk".to_string(), package.clone())], ..PackagePath::default() };
        let resolved = |uri: &str| packages.resolve(uri, &folder);
        let absolute = format!("package://pk/{}", folder.join("file").display());
        for uri in ["package://pk/../file", "package://pk/meshes/../../file", "package://../file", &absolute] {
            assert_eq!(resolved(uri), Resolved::Outside, "{uri}");
        }
        for uri in ["package://pk/file", "package://pk/meshes/../file", "model://pk/./file"] {
            assert!(matches!(resolved(uri), Resolved::Found(path) if path.exists()), "{uri}");
        }
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
