//! Where mesh files are: `package://NAME/rest`, `file://...`, absolute and relative paths.
//!
//! `package://` (and Gazebo's `model://`) is looked for, in this order, in
//!
//! 1. the folders given by `--package NAME=DIR`: `DIR/rest`;
//! 2. `ROS_PACKAGE_PATH`: `P/NAME/rest`, or `P/rest` where the folder `P` is itself named NAME;
//! 3. `AMENT_PREFIX_PATH`: `P/NAME/rest`, `P/share/NAME/rest`;
//! 4. the folders above the URDF: `A/NAME/rest`, `A/rest`.

use std::path::{Path, PathBuf};

/// The places in which packages are looked for.
#[derive(Clone, Debug, Default)]
pub struct PackagePath {
    /// `--package NAME=DIR`.
    pub packages: Vec<(String, PathBuf)>,
    /// Folders of `ROS_PACKAGE_PATH`.
    pub ros_package_path: Vec<PathBuf>,
    /// Folders of `AMENT_PREFIX_PATH`.
    pub ament_prefix_path: Vec<PathBuf>,
}

/// What became of a file reference.
#[derive(Clone, Debug, PartialEq)]
pub enum Resolved {
    /// The file exists.
    Found(PathBuf),
    /// It does not; these paths were tried.
    Missing(Vec<PathBuf>),
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
        }
    }

    /// Looks for the file that a URDF in the folder `folder` calls `uri`.
    pub fn resolve(&self, uri: &str, folder: &Path) -> Resolved {
        let candidates = match uri.split_once("://") {
            None => vec![folder.join(uri)],
            Some(("file", path)) => vec![folder.join(path)],
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
