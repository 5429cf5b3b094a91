//! Reads an MJCF file into a [`Scene`].

use crate::scene::description::Scene;
use crate::scene::error::{Problem, SceneError};
use crate::scene::mjcf_reading::compiler::{Reading, reading_of};
use crate::scene::mjcf_reading::orientation::Angles;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::replicate::with_copies;
use crate::scene::mjcf_reading::tree::{Element, read_tree};
use crate::scene::robot::Robot;
use crate::scene::scene_reading::scene_file::scene_from_text;
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::text::{read_bytes, read_text};
use crate::scene::urdf_reading::package_path::PackagePath;
use crate::scene::urdf_reading::urdf::robot_from_text;
use crate::scene::warning::{Warning, WarningGroup};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Sections that have no effect on the motion.
const SILENT: [&str; 8] = ["visual", "statistic", "size", "custom", "sensor", "extension", "asset", "default"];

/// Reads and validates an MJCF file; with `keyframe` the scene starts there.
///
/// # Errors
/// [`SceneError`] with file and line.
pub fn read_mjcf(path: &Path, text: &str, keyframe: Option<&str>, packages: &PackagePath) -> Result<Scene, SceneError> {
    let root = read_tree(path, text)?;
    let angles = Angles::of(&root);
    let root = with_copies(root, &angles)?;
    let mut reader = Reader::new(path, &root)?;
    reader.read(&root, keyframe)?;
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let files: Vec<String> = (1..=reader.trees.len()).map(|number| format!("{stem}.{number}.urdf")).collect();
    let toml = reader.toml(&files);
    let urdfs: Vec<String> = reader.trees.iter().map(|tree| reader.urdf(tree)).collect();
    let files = reader.made.iter().map(|(file, bytes)| (reader.folder.join(file), bytes.clone())).collect();
    let packages = PackagePath { carried: reader.made.clone(), ..packages.clone() };
    let mut made = Made { urdfs: urdfs.into_iter(), files, packages };
    let placed = |error: SceneError| match error.file.is_file() && error.file != path {
        true => error,
        // Lines count in the text that was made, not in the file.
        false => SceneError { file: path.to_path_buf(), line: None, ..error },
    };
    let mut scene = scene_from_text(&toml, path, &mut made).map_err(placed)?;
    reader.put_lines(&mut scene);
    scene.warnings.extend(reader.all_warnings());
    Ok(scene)
}

/// The URDFs that were made, one after the other, meshes in memory, and the files of the file system.
struct Made {
    urdfs: std::vec::IntoIter<String>,
    files: HashMap<PathBuf, Arc<Vec<u8>>>,
    packages: PackagePath,
}

impl SceneFiles for Made {
    fn robot(&mut self, urdf: &Path) -> Result<Robot, SceneError> {
        robot_from_text(&self.urdfs.next().unwrap_or_default(), urdf, &self.packages)
    }

    fn text(&mut self, file: &Path) -> Result<String, SceneError> {
        read_text(file)
    }

    fn bytes(&mut self, file: &Path) -> Result<Vec<u8>, SceneError> {
        match self.files.get(file) {
            Some(bytes) => Ok(bytes.to_vec()),
            None => read_bytes(file),
        }
    }
}

impl Reader<'_> {
    fn read(&mut self, root: &Element, keyframe: Option<&str>) -> Result<(), SceneError> {
        self.defaults.check(root)?;
        for option in root.all("option") {
            self.gravity = option.vector("gravity")?.unwrap_or(self.gravity);
            option.all("flag").for_each(|flag| self.flags(flag));
            if option.text("actuatorgroupdisable").is_some() {
                self.odd(option, "actuatorgroupdisable is not read; --without leaves parts out".to_string());
            }
            for medium in ["wind", "density", "viscosity"] {
                if option.list(medium, 1, 3)?.is_some_and(|numbers| numbers.iter().any(|number| *number != 0.0)) {
                    self.not_simulated(option, format!("{medium} of the medium around is not simulated"));
                }
            }
        }
        for compiler in root.all("compiler") {
            for (name, value) in &compiler.attributes {
                match reading_of(name, value) {
                    Reading::Read => {}
                    Reading::WithoutEffect => self.ignored_attribute(compiler, name),
                    Reading::Told(message) => self.odd(compiler, message),
                }
            }
        }
        for asset in root.all("asset").flat_map(|assets| &assets.children) {
            self.asset(asset)?;
        }
        let worlds: Vec<&Element> = root.all("worldbody").collect();
        worlds.iter().try_for_each(|world| self.world(world))?;
        if let Some(total) = self.compiler.total_mass {
            self.scale_masses(total);
        }
        self.name_robots();
        root.all("actuator").try_for_each(|actuators| self.add_rotors(actuators))?;
        self.tune_joints();
        root.all("tendon").try_for_each(|tendons| self.tendons(tendons))?;
        root.all("equality").try_for_each(|equality| self.equality(equality))?;
        for section in &root.children {
            match section.name.as_str() {
                "worldbody" | "option" | "compiler" => {}
                "actuator" => self.actuators(section)?,
                "contact" => self.contact(section)?,
                "keyframe" | "tendon" | "equality" => {}
                "deformable" => {
                    for one in &section.children {
                        self.not_simulated(one, format!("<{}> of <{}> is not simulated", one.name, section.name));
                    }
                }
                name if SILENT.contains(&name) => {
                    if !matches!(name, "asset" | "default") {
                        self.ignore(section, "mujoco");
                    }
                }
                _ => self.unknown(section, "mujoco"),
            }
        }
        let keys: Vec<&Element> = root.all("keyframe").flat_map(|keys| keys.all("key")).collect();
        let named = |key: &&&Element| key.text("name") == keyframe;
        match (keyframe, keys.iter().find(named)) {
            (None, _) => {
                if let Some(key) = keys.first() {
                    let name = key.text("name").unwrap_or_default();
                    let warning = self
                        .warning(key, format!("the scene starts as its bodies are; --keyframe {name} starts it there"));
                    self.warnings.push(warning.in_group(WarningGroup::Taken));
                }
            }
            (Some(_), Some(key)) => self.start_at(key)?,
            (Some(wanted), None) => {
                let known = keys.iter().filter_map(|key| key.text("name").map(str::to_string)).collect();
                let problem = Problem::UnknownName { what: "keyframe", name: wanted.to_string(), robots: 0, known };
                return Err(SceneError {
                    file: self.path.to_path_buf(),
                    line: None,
                    element: None,
                    problem: Box::new(problem),
                });
            }
        }
        if self.trees.is_empty() {
            let problem = Box::new(Problem::NothingMoves);
            return Err(SceneError { file: self.path.to_path_buf(), line: Some(root.line), element: None, problem });
        }
        Ok(())
    }

    /// Scales all masses and inertias to a total mass (kg).
    fn scale_masses(&mut self, total: f64) {
        let masses = || self.trees.iter().flat_map(|tree| &tree.links).filter_map(|link| link.mass.as_ref());
        let sum: f64 = masses().map(|of| of.mass).sum::<f64>() + self.fixed_mass;
        for of in self.trees.iter_mut().flat_map(|tree| &mut tree.links).filter_map(|link| link.mass.as_mut()) {
            of.mass *= total / sum;
            of.inertia *= total / sum;
        }
    }

    fn asset(&mut self, asset: &Element) -> Result<(), SceneError> {
        let asset = self.defaults.applied(asset, None);
        match asset.name.as_str() {
            "mesh" => self.mesh(&asset)?,
            "hfield" => self.height_field(&asset)?,
            "material" => {
                if let (Some(name), Some(rgba)) = (asset.text("name"), asset.list("rgba", 4, 4)?) {
                    self.colors.insert(name.to_string(), [rgba[0], rgba[1], rgba[2], rgba[3]]);
                }
            }
            _ => self.ignore(&asset, "asset"),
        }
        Ok(())
    }

    /// Puts the lines of the file into the robots, instead of lines of the text that was made.
    fn put_lines(&self, scene: &mut Scene) {
        for (placed, tree) in scene.robots.iter_mut().zip(&self.trees) {
            let robot = &mut placed.robot;
            for link in &mut robot.links {
                let Some(own) = tree.links.iter().find(|own| own.name == link.name) else { continue };
                link.line = own.line;
                link.inertial.iter_mut().for_each(|inertial| inertial.line = own.line);
            }
            for joint in &mut robot.joints {
                let own = tree.joints.iter().filter_map(|(_, joint)| joint.as_ref()).find(|own| own.name == joint.name);
                joint.line = own.map_or(joint.line, |own| own.line);
            }
            robot.path = self.path.to_path_buf();
            let lines: HashMap<crate::scene::error::Element, usize> = robot
                .links
                .iter()
                .map(|link| (crate::scene::error::Element::Link(link.name.clone()), link.line))
                .chain(
                    robot
                        .joints
                        .iter()
                        .map(|joint| (crate::scene::error::Element::Joint(joint.name.clone()), joint.line)),
                )
                .collect();
            for warning in &mut robot.warnings {
                warning.file = self.path.to_path_buf();
                warning.line = warning.element.as_ref().and_then(|element| lines.get(element).copied());
            }
        }
    }

    fn all_warnings(self) -> Vec<Warning> {
        let mut all: Vec<Warning> = Vec::new();
        // One warning for each kind, with the first line of it.
        let mut kinds: Vec<(String, Vec<Warning>)> = Vec::new();
        for warning in self.warnings {
            match kinds.iter_mut().find(|(message, _)| *message == warning.message) {
                Some((_, same)) => same.push(warning),
                None => kinds.push((warning.message.clone(), vec![warning])),
            }
        }
        all.extend(kinds.into_iter().filter_map(|(_, same)| Warning::of_kind(same, "element", "elements")));
        all.extend(self.ignored.into_iter().map(|(what, (file, line, count))| {
            let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
            Warning::odd(&file, Some(line), None, format!("{what}{times}")).in_group(WarningGroup::Ignored)
        }));
        all
    }
}
