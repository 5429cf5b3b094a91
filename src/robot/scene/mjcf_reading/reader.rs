//! What is read of an MJCF file, and what is said of it.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::compiler::Compiler;
use crate::scene::mjcf_reading::defaults::Defaults;
use crate::scene::mjcf_reading::grips::{Grip, paired_geoms};
use crate::scene::mjcf_reading::mass::Inside;
use crate::scene::mjcf_reading::orientation::Angles;
use crate::scene::mjcf_reading::parts::{Closing, Geom, Motor, Moving, Placed, Relation, Rope, Spring, Tree};
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::{MeshFile, Pose};
use crate::scene::warning::{Warning, WarningGroup};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Gravity where the file is silent [m/s²].
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// The content of an MJCF file, so far.
pub(crate) struct Reader<'r> {
    pub path: &'r Path,
    pub folder: PathBuf,
    pub name: String,
    pub defaults: Defaults,
    pub angles: Angles,
    pub compiler: Compiler,
    pub gravity: Vector3<f64>,
    /// Meshes, and how the solids in them are counted.
    pub meshes: HashMap<String, (MeshFile, Inside)>,
    pub colors: HashMap<String, [f64; 4]>,
    /// The file in memory of each height field.
    pub fields: HashMap<String, String>,
    /// Names of meshes that are left out, as a warning says.
    pub left_out: HashSet<String>,
    /// Mesh files that are in memory alone, by the names that the scene file and the URDFs give them.
    pub made: HashMap<String, Arc<Vec<u8>>>,
    pub trees: Vec<Tree>,
    /// Names of the trees as robots.
    pub robot_names: Vec<String>,
    /// Geoms that do not move, each with its body.
    pub obstacles: Vec<(String, Geom)>,
    pub placed: HashMap<String, Placed>,
    pub sites: HashMap<String, (Option<String>, Pose)>,
    /// The tree of each joint, and its position at the start as the file counts.
    pub references: HashMap<String, (usize, f64)>,
    pub free_names: HashSet<String>,
    pub order: Vec<Moving>,
    pub closings: Vec<Closing>,
    pub ropes: Vec<Rope>,
    pub springs: Vec<Spring>,
    pub relations: Vec<Relation>,
    /// The joints of fixed tendons with their coefficients.
    pub fixed_tendons: HashMap<String, Vec<(String, f64)>>,
    pub locked: Vec<(String, f64)>,
    /// Motors, each with the number of its control.
    pub motors: Vec<(usize, Motor)>,
    /// How many actuators there are, with those that are not simulated.
    pub controls: usize,
    /// How many activations there are, likewise.
    pub activations: usize,
    pub positions: Vec<(usize, String, Vec<f64>)>,
    pub velocities: Vec<(usize, String, Vec<f64>)>,
    /// Pairs of bodies that do not touch.
    pub excluded: Vec<[String; 2]>,
    /// Names of geoms that touch as a `<pair>` says.
    pub paired: HashSet<String>,
    /// Geoms with a friction of their own against each other.
    pub pairs: Vec<([String; 2], Grip)>,
    /// Whether anything touches.
    pub touches: bool,
    /// Whether controls stay in their ranges.
    pub clamps_controls: bool,
    /// Mass of bodies that do not move (kg).
    pub fixed_mass: f64,
    /// How many bodies there were.
    pub bodies: usize,
    pub warnings: Vec<Warning>,
    /// Elements without a meaning for the motion: the first file and line, and how often they are there.
    pub ignored: BTreeMap<String, (PathBuf, usize, usize)>,
}

impl<'r> Reader<'r> {
    /// Before anything but the settings of the file is read.
    pub fn new(path: &'r Path, root: &Element) -> Result<Self, SceneError> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let name = root.text("model").map_or_else(
            || path.file_stem().map_or_else(|| "scene".to_string(), |stem| stem.to_string_lossy().into_owned()),
            str::to_string,
        );
        Ok(Reader {
            path,
            folder,
            name,
            defaults: Defaults::of(root)?,
            angles: Angles::of(root),
            compiler: Compiler::of(root)?,
            gravity: GRAVITY,
            meshes: HashMap::new(),
            colors: HashMap::new(),
            fields: HashMap::new(),
            left_out: HashSet::new(),
            made: HashMap::new(),
            trees: Vec::new(),
            robot_names: Vec::new(),
            obstacles: Vec::new(),
            placed: HashMap::new(),
            sites: HashMap::new(),
            references: HashMap::new(),
            free_names: HashSet::new(),
            order: Vec::new(),
            closings: Vec::new(),
            ropes: Vec::new(),
            springs: Vec::new(),
            relations: Vec::new(),
            fixed_tendons: HashMap::new(),
            locked: Vec::new(),
            motors: Vec::new(),
            controls: 0,
            activations: 0,
            positions: Vec::new(),
            velocities: Vec::new(),
            excluded: Vec::new(),
            paired: paired_geoms(root),
            pairs: Vec::new(),
            touches: true,
            clamps_controls: true,
            fixed_mass: 0.0,
            bodies: 0,
            warnings: Vec::new(),
            ignored: BTreeMap::new(),
        })
    }

    /// Names the trees after their bodies, without letters that names of robots may not have.
    pub fn name_robots(&mut self) {
        for index in 0..self.trees.len() {
            let mut name = self.trees[index].name.replace('/', "_");
            while name == "world" || self.robot_names.contains(&name) {
                name.push('_');
            }
            self.robot_names.push(name);
        }
    }

    /// The name of a link or joint of a tree in the scene file.
    pub fn called(&self, tree: usize, name: &str) -> String {
        if self.trees.len() > 1 { format!("{}/{name}", self.robot_names[tree]) } else { name.to_string() }
    }

    /// The name of the link of a body that moves.
    pub fn link_name(&self, body: &str) -> String {
        let tree = self.placed.get(body).and_then(|placed| placed.tree);
        tree.map_or_else(|| "world".to_string(), |tree| self.called(tree, body))
    }

    /// A name for an obstacle that no link has.
    pub fn obstacle_name(&self, name: &str) -> String {
        let name = name.replace(['|', '*'], "_");
        let is_link = self.trees.iter().flat_map(|tree| &tree.links).any(|link| link.name == name);
        if is_link || name == "world" { format!("{name}_obstacle") } else { name }
    }

    /// The name of the file.
    pub fn source_name(&self) -> String {
        self.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().replace(['\n', '\r'], " "))
    }

    /// A warning about an element.
    pub fn warning(&self, element: &Element, message: String) -> Warning {
        Warning::odd(&element.file, Some(element.line), None, message)
    }

    /// Warns of what means something for the motion and is not simulated.
    pub fn not_simulated(&mut self, element: &Element, message: String) {
        let warning = self.warning(element, message).in_group(WarningGroup::NotSimulated);
        self.warnings.push(warning);
    }

    /// Warns of what is read otherwise than it is written.
    pub fn odd(&mut self, element: &Element, message: String) {
        let warning = self.warning(element, message);
        self.warnings.push(warning);
    }

    /// The first coefficient of a polynomial, if there is one; warns of the others, which have no counterpart.
    pub fn linear(&mut self, element: &Element, name: &str) -> Result<Option<f64>, SceneError> {
        let Some(all) = element.list(name, 1, 3)? else { return Ok(None) };
        if all.iter().skip(1).any(|number| *number != 0.0) {
            self.not_simulated(element, format!("{name} that is not linear is not simulated; its first number is"));
        }
        Ok(all.first().copied())
    }

    /// A range that bounds something: where its flag says so, or alone with `autolimits` if it is not empty. MuJoCo refuses one that neither decides on.
    pub fn bounds(&mut self, of: &Element, range: &str, flag: &str) -> Result<Option<(f64, f64)>, SceneError> {
        let Some(given) = of.list(range, 2, 2)? else { return Ok(None) };
        let (lower, upper) = (given[0], given[1]);
        let is_written = (lower, upper) != (0.0, 0.0);
        if of.flag(flag).is_none() && !self.compiler.auto_limits && is_written {
            self.odd(of, format!("{range} without {flag} bounds nothing while autolimits=\"false\""));
        }
        let holds = of.flag(flag).unwrap_or(lower < upper && self.compiler.auto_limits);
        Ok(holds.then_some((lower, upper)))
    }

    /// Lists an element that says nothing of the motion.
    pub fn ignore(&mut self, element: &Element, parent: &str) {
        let parent = if parent == "mujoco" { String::new() } else { format!(" of <{parent}>") };
        self.list_ignored(element, format!("<{}>{parent}", element.name));
    }

    /// Lists an attribute that has no counterpart, because contacts are rigid.
    pub fn ignored_attribute(&mut self, element: &Element, name: &str) {
        self.list_ignored(element, format!("{name} of <{}>", element.name));
    }

    fn list_ignored(&mut self, element: &Element, what: String) {
        let entry = self.ignored.entry(what).or_insert_with(|| (element.file.to_path_buf(), element.line, 0));
        entry.2 += 1;
    }

    /// Warns of an element that is not known.
    pub fn unknown(&mut self, element: &Element, parent: &str) {
        self.not_simulated(element, format!("<{}> of <{parent}> is not read", element.name));
    }
}
