//! A random scene: its files, and facts about its motion that need no reference.

use crate::shapes::Shape;
use crate::urdf::Robot;
use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Vector3};
use std::path::{Path, PathBuf};

/// A number that a closed form gives.
#[derive(Clone, Debug)]
pub enum Answer {
    /// A coordinate of a link's origin at the end (m).
    Place { link: String, axis: usize, right: f64, bound: f64 },
    /// The position of a joint at the end (rad, m).
    Joint { joint: String, right: f64, bound: f64 },
    /// The position of a joint at the start (rad, m).
    Start { joint: String, right: f64 },
    /// The number of contact impacts.
    Impacts { right: usize },
    /// At most this number of events.
    FewEvents { most: usize },
}

/// A shape that may touch others: of a link, or of an obstacle with its pose in the world.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Link or obstacle.
    pub name: String,
    pub shape: Shape,
    /// Of obstacles.
    pub pose: Option<IsometryMatrix3<f64>>,
    /// Number of the robot; obstacles have none.
    pub robot: Option<usize>,
}

/// A scene of one kind and seed.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub kind: &'static str,
    /// The tables of the scene file, one text each.
    tables: Vec<String>,
    /// Other files: name and text.
    files: Vec<(String, String)>,
    pub duration: f64,
    /// Whether links of different robots touch.
    pub all_pairs: bool,
    /// Pairs of links of one robot that touch, if links of one robot do.
    pub itself: Vec<[String; 2]>,
    /// It is judged as a crowd: links of one robot touch as far as the model lets them.
    pub is_crowd: bool,
    /// Of all contacts; `None`: there are no shapes.
    pub contact: Option<(f64, f64)>,
    pub solids: Vec<Solid>,
    /// Joints with limits: lower and upper.
    pub limits: Vec<(String, f64, f64)>,
    pub answers: Vec<Answer>,
    /// No motion of this kind amplifies errors: it must not be called chaotic.
    pub is_calm: bool,
    /// The energy that springs and motors store at the start (J).
    pub stored: f64,
    /// The efforts of springs and motors at the start (N m): a displacement of the tolerance changes the stored energy by as many tolerances.
    pub pull: f64,
    /// No energy is lost: every restitution is 1, and there is no friction.
    pub is_lossless: bool,
    /// The same scene written otherwise: the name and the text of its scene file.
    pub twin: Option<(String, String)>,
    count: usize,
}

/// Where a robot starts.
pub struct Start {
    pub floating: bool,
    pub position: Vector3<f64>,
    pub rpy: Vector3<f64>,
    pub linear: Vector3<f64>,
    pub angular: Vector3<f64>,
    pub positions: Vec<(String, f64)>,
    pub velocities: Vec<(String, f64)>,
}

impl Start {
    /// Fixed in the world, at rest.
    pub fn fixed(position: Vector3<f64>) -> Self {
        let (zero, none) = (Vector3::zeros(), Vec::new);
        let (positions, velocities) = (none(), none());
        Start { floating: false, position, rpy: zero, linear: zero, angular: zero, positions, velocities }
    }

    /// Floating, at rest.
    pub fn floating(position: Vector3<f64>) -> Self {
        Start { floating: true, ..Start::fixed(position) }
    }
}

pub fn list(v: &Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

fn pairs(of: &[(String, f64)]) -> String {
    let of: Vec<String> = of.iter().map(|(name, value)| format!("{name} = {value:?}")).collect();
    format!("{{ {} }}", of.join(", "))
}

impl Scene {
    pub fn new(kind: &'static str, duration: f64) -> Self {
        Scene { kind, duration, ..Scene::default() }
    }

    /// Adds a table of the scene file.
    pub fn table(&mut self, text: impl Into<String>) {
        self.tables.push(text.into());
    }

    pub fn gravity(&mut self, gravity: Vector3<f64>) {
        self.tables.insert(0, format!("[scene]\ngravity = {}", list(&gravity)));
    }

    /// Adds a robot. With `several` its links and joints are called `robot/name`.
    pub fn robot(&mut self, robot: &Robot, start: &Start, several: bool) {
        let name = &robot.name;
        let full = |part: &str| if several { format!("{name}/{part}") } else { part.to_string() };
        let base = if start.floating { "floating" } else { "fixed" };
        let mut table = format!(
            "[[robot]]\nname = \"{name}\"\nurdf = \"{name}.urdf\"\nbase = \"{base}\"\npose = {{ position = {}, rpy = {} }}",
            list(&start.position),
            list(&start.rpy)
        );
        if start.floating {
            table +=
                &format!("\nvelocity = {{ linear = {}, angular = {} }}", list(&start.linear), list(&start.angular));
        }
        for (key, values) in [("positions", &start.positions), ("velocities", &start.velocities)] {
            if !values.is_empty() {
                table += &format!("\n{key} = {}", pairs(values));
            }
        }
        self.table(table);
        self.files.push((format!("{name}.urdf"), robot.text()));
        self.files.extend(robot.shapes.iter().filter_map(|(_, shape)| shape.file()));
        let of_robot = |(link, shape): &(String, Shape)| Solid {
            name: full(link),
            shape: shape.clone(),
            pose: None,
            robot: Some(self.count),
        };
        self.solids.extend(robot.shapes.iter().map(of_robot));
        self.limits.extend(robot.limits.iter().map(|(joint, lower, upper)| (full(joint), *lower, *upper)));
        self.count += 1;
    }

    /// Adds an obstacle.
    pub fn obstacle(&mut self, shape: Shape, position: Vector3<f64>, rpy: Vector3<f64>) {
        let name = format!("o{}", self.tables.len());
        self.table(format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = {}\npose = {{ position = {}, rpy = {} }}",
            shape.toml(),
            list(&position),
            list(&rpy)
        ));
        self.files.extend(shape.file());
        let pose = IsometryMatrix3::from_parts(
            Translation3::from(position),
            Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z),
        );
        self.solids.push(Solid { name, shape, pose: Some(pose), robot: None });
    }

    /// Sets friction and restitution of all contacts.
    pub fn contacts(&mut self, all_pairs: bool, friction: f64, restitution: f64) {
        let touching = if all_pairs { "all" } else { "environment" };
        self.table(format!(
            "[contact]\npairs = \"{touching}\"\nself_contact = {}\nfriction = {friction:?}\nrestitution = {restitution:?}",
            self.is_crowd || !self.itself.is_empty()
        ));
        (self.all_pairs, self.contact) = (all_pairs, Some((friction, restitution)));
    }

    /// Adds a file beside the scene.
    pub fn file(&mut self, name: &str, text: String) {
        self.files.push((name.to_string(), text));
    }

    /// The text of the scene file.
    pub fn text(&self) -> String {
        format!("{}\n\n[simulation]\nduration = {:?}\n", self.tables.join("\n\n"), self.duration)
    }

    /// Which solids may touch: a link and an obstacle, links of different robots, or some links of one robot.
    pub fn may_touch(&self, one: usize, other: usize) -> bool {
        match (self.solids[one].robot, self.solids[other].robot) {
            (Some(a), Some(b)) if a == b => {
                let names = [one, other].map(|solid| self.solids[solid].name.as_str());
                self.itself.iter().any(|[a, b]| names == [a, b] || names == [b, a])
            }
            (Some(_), Some(_)) => self.all_pairs,
            (one, other) => self.contact.is_some() && (one.is_some() || other.is_some()),
        }
    }

    /// Writes all files into a folder, and returns the scene file.
    pub fn write(&self, folder: &Path) -> PathBuf {
        std::fs::create_dir_all(folder).expect("a folder for the scene");
        let put = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file of the scene");
        self.files.iter().for_each(|(name, text)| put(name, text));
        self.twin.iter().for_each(|(name, text)| put(name, text));
        put("scene.toml", &self.text());
        folder.join("scene.toml")
    }

    /// All files as text, for people.
    pub fn listing(&self) -> String {
        let files = self.files.iter().map(|(name, text)| format!("--- {name}\n{text}"));
        files.chain([format!("--- scene.toml\n{}", self.text())]).collect()
    }
}
