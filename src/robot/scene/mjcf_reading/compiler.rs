//! Settings of MJCF's `<compiler>`, attribute by attribute.
//!
//! | attribute | read as |
//! |---|---|
//! | `angle`, `eulerseq` | [`super::orientation`] |
//! | `alignfree` | the frame of free bodies in keyframes ([`super::free_frames`]) |
//! | `autolimits` | whether a range alone is a limit |
//! | `meshdir`, `assetdir`, `strippath` | where meshes are |
//! | `inertiafromgeom`, `inertiagrouprange` | which masses geoms give |
//! | `exactmeshinertia` | meshes whose solid is counted as it is |
//! | `boundmass`, `boundinertia`, `balanceinertia`, `settotalmass` | masses and principal moments of bodies: m ≥ m₀, I ≥ I₀; (A + B + C)/3 for all where A + B < C |
//!
//! Others change no motion, or are a warning with their line.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::mass::MassOf;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::Pose;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::path::{Path, PathBuf};

/// Attributes that are read here or elsewhere.
const READ: [&str; 15] = [
    "angle",
    "alignfree",
    "eulerseq",
    "autolimits",
    "meshdir",
    "assetdir",
    "strippath",
    "inertiafromgeom",
    "inertiagrouprange",
    "exactmeshinertia",
    "boundmass",
    "boundinertia",
    "balanceinertia",
    "settotalmass",
    "texturedir",
];

/// Attributes that change no motion.
const WITHOUT_EFFECT: [&str; 6] =
    ["discardvisual", "usethread", "fusestatic", "saveinertial", "conflict", "convexhull"];

/// Attributes without a counterpart, and their defaults.
const UNREAD: [(&str, &str); 2] = [("coordinate", "local"), ("fitaabb", "false")];

/// Settings of `<compiler>` but for angles.
#[derive(Clone, Debug)]
pub(crate) struct Compiler {
    /// Whether a range alone is a limit.
    pub auto_limits: bool,
    /// Whether free bodies without children are counted at their inertial frames.
    pub aligns_free: bool,
    /// Whether masses come from geoms: always, never, or where no inertia is given.
    pub inertia_from_geoms: Option<bool>,
    /// First and last group of geoms that have a mass.
    groups: [f64; 2],
    pub exact_meshes: bool,
    /// Least mass (kg) and least principal moment [kg m²] of a body.
    least: [f64; 2],
    balances: bool,
    /// Mass of all bodies (kg).
    pub total_mass: Option<f64>,
    /// The folder of meshes.
    meshes: PathBuf,
    strips: bool,
}

impl Compiler {
    /// The settings of a file: the last element that has an attribute counts.
    pub fn of(root: &Element) -> Result<Self, SceneError> {
        let last = |name: &str| root.all("compiler").filter(|one| one.text(name).is_some()).last();
        let flag = |name: &str| last(name).and_then(|one| one.flag(name));
        let number = |name: &str| Ok::<_, SceneError>(last(name).map(|one| one.number(name)).transpose()?.flatten());
        let groups = last("inertiagrouprange").map(|one| one.list("inertiagrouprange", 2, 2)).transpose()?.flatten();
        let folder = root.all("compiler").filter_map(|one| one.text("meshdir").or(one.text("assetdir"))).last();
        Ok(Compiler {
            auto_limits: flag("autolimits").unwrap_or(true),
            aligns_free: flag("alignfree") == Some(true),
            inertia_from_geoms: flag("inertiafromgeom"),
            groups: groups.map_or([f64::NEG_INFINITY, f64::INFINITY], |groups| [groups[0], groups[1]]),
            exact_meshes: flag("exactmeshinertia") == Some(true),
            least: [number("boundmass")?.unwrap_or(0.0), number("boundinertia")?.unwrap_or(0.0)],
            balances: flag("balanceinertia") == Some(true),
            total_mass: number("settotalmass")?.filter(|total| *total > 0.0),
            meshes: PathBuf::from(folder.unwrap_or_default()),
            strips: flag("strippath") == Some(true),
        })
    }

    /// Whether geoms of a group have a mass.
    pub fn weighs(&self, group: f64) -> bool {
        (self.groups[0]..=self.groups[1]).contains(&group)
    }

    /// The file of an asset, relative to the folder of the MJCF file.
    pub fn asset_file(&self, file: &str) -> PathBuf {
        let stripped = Path::new(file).file_name().filter(|_| self.strips).map(Path::new);
        self.meshes.join(stripped.unwrap_or(Path::new(file)))
    }

    /// The mass of a body within the bounds of all bodies.
    pub fn bounded(&self, of: Option<MassOf>) -> Option<MassOf> {
        let [mass, moment] = self.least;
        if mass == 0.0 && moment == 0.0 && !self.balances {
            return of;
        }
        let nothing = || MassOf { mass: 0.0, frame: Pose::identity(), inertia: Matrix3::zeros() };
        let of = of.unwrap_or_else(nothing);
        let axes = of.inertia.symmetric_eigen();
        let mut moments = axes.eigenvalues.map(|own| own.max(moment));
        if self.balances && 2.0 * moments.max() > moments.sum() {
            moments = Vector3::repeat(moments.sum() / 3.0);
        }
        let mass = of.mass.max(mass);
        if mass == 0.0 {
            return None;
        }
        if moments == axes.eigenvalues {
            return Some(MassOf { mass, ..of });
        }
        let mut turn = axes.eigenvectors;
        if turn.determinant() < 0.0 {
            turn.column_mut(0).neg_mut();
        }
        let rotation = of.frame.rotation * Rotation3::from_matrix_unchecked(turn);
        let frame = Pose::from_parts(of.frame.translation, rotation);
        Some(MassOf { mass, frame, inertia: Matrix3::from_diagonal(&moments) })
    }
}

/// How an attribute of `<compiler>` is read.
pub(crate) enum Reading {
    Read,
    /// It changes no motion.
    WithoutEffect,
    /// It has no counterpart, or is not known, as the message says.
    Told(String),
}

/// How an attribute with this value is read.
pub(crate) fn reading_of(name: &str, value: &str) -> Reading {
    let unread = UNREAD.iter().find(|(unread, _)| *unread == name);
    match unread {
        _ if WITHOUT_EFFECT.contains(&name) => Reading::WithoutEffect,
        Some((_, plain)) if value != *plain => Reading::Told(format!("{name}={value:?} of <compiler> is not read")),
        None if !READ.contains(&name) => Reading::Told(format!("{name} of <compiler> is not known, and not read")),
        _ => Reading::Read,
    }
}
