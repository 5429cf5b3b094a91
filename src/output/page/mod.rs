//! Pages: a run or a model as one HTML file that needs no server and no network.
//!
//! ```text
//!     log ─ inspection/summary.rs ─▶ facts.rs                     figures and warnings in words
//!         ─ log/reading/frames.rs ─▶ motion.rs, step_figures.rs, contacts.rs  poses, curves, forces, events
//!     model ─▶ tree.rs                                            links, bodies, joints, loops
//!           ─ log/reading/meshes.rs or files ─▶ looks.rs, shared_meshes.rs  what is drawn      (meshes/ reads, simplify.rs simplifies)
//!           ─▶ colliders.rs                                       what is drawn of what may touch
//!     all of it ─ packing.rs ─▶ header (JSON), arrays (base64) ─ html.rs ─▶ page
//! ```
//!
//! The same input gives the same bytes. The scripts of the page are in `assets/`, foreign ones with their licences.

pub(in crate::output) mod colliders;
mod contacts;
mod curve_name;
mod facts;
mod html;
pub(in crate::output) mod looks;
pub(in crate::output) mod motion;
mod packing;
pub(in crate::output) mod shared_meshes;
mod simplify;
mod spreads;
mod step_figures;
mod tree;

use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::Model;
use crate::output::inspection::summary::Summary;
use crate::output::log::reading::frames::visit;
use crate::output::log::reading::meshes::LoggedMeshes;
use crate::output::log::reading::records::ReadError;
use crate::output::log::sha256;
use crate::output::page::colliders::{DrawnCollider, colliders};
use crate::output::page::contacts::ContactLayer;
use crate::output::page::curve_name::CurveName;
use crate::output::page::facts::Fact;
use crate::output::page::looks::{DrawnShape, Looks, MeshSource, looks};
use crate::output::page::motion::Motion;
use crate::output::page::packing::{Packed, Place};
use crate::output::page::shared_meshes::{MeshContent, MeshData, PackedMesh};
use crate::output::page::tree::{DrawnRope, Frame, Tree, pose_numbers, ropes, tree};
use crate::output::report::EventEntry;
use crate::scene::MeshFile;
use serde::Serialize;
use std::path::Path;

/// The most triangles of all meshes together, unless the user wants more or fewer.
pub const MESH_LIMIT: usize = 200_000;

/// The options of a page.
#[derive(Clone, Debug)]
pub struct PageOptions {
    /// The most triangles of all meshes together; zero leaves meshes out.
    pub mesh_limit: usize,
    /// Tables about the model.
    pub tables: Vec<PageTable>,
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PageTable {
    /// The title above it.
    pub title: String,
    /// The heading of each column.
    pub columns: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
}

/// The defect of a log without links or joints, for an instant or for a page.
pub const BARE: &str = "its samples have no links or no joints: make the run again with tf, joint_states and multi_dof_joint_states in its --topics";

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The log cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The log has no samples to play back.
    #[error("{log}: there are no samples in it; catena model draws the robot alone")]
    Empty {
        /// The log.
        log: String,
    },
    /// Its samples have no links or no joints.
    #[error("{log}: {BARE}")]
    Bare {
        /// The log.
        log: String,
    },
    /// A sample has other links or joints than the model that the log carries.
    #[error("{log}: its sample at t = {time} s is not of the model it carries")]
    Misfit {
        /// The log.
        log: String,
        /// Time of the sample (s).
        time: f64,
    },
}

/// The header that the scripts of a page read as JSON; lengths in m, angles in rad, times in s.
#[derive(Serialize)]
struct Header<'p> {
    kind: &'static str,
    #[serde(flatten)]
    played: Played<'p>,
    /// Another run that is shown beside this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    second: Option<Played<'p>>,
    catena: &'static str,
    facts: Vec<Fact>,
    warnings: Vec<String>,
    notes: Vec<String>,
    tables: &'p [PageTable],
    obstacles: Vec<DrawnCollider>,
    collision_shapes: Vec<DrawnCollider>,
    events: &'p [EventEntry],
    arrows: Vec<ArrowLayer>,
    /// `null` without contacts.
    contacts: Option<ContactLayer>,
    /// Weight of all bodies that move (N); without gravity as on earth.
    weight: f64,
}

/// The robot and the motion of a run.
#[derive(Serialize)]
struct Played<'p> {
    name: &'p str,
    source: String,
    tree: Tree<'p>,
    shapes: Vec<DrawnShape>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    ropes: Vec<DrawnRope<'p>>,
    meshes: Vec<PackedMesh>,
    /// Number of samples in all arrays.
    samples: usize,
    times: Place,
    /// Bodies × 7 columns.
    poses: Place,
    curves: &'p [CurveName],
    values: Place,
    steps: StepCurves,
}

/// Curves of figures of steps, with times of their own.
#[derive(Serialize)]
struct StepCurves {
    curves: Vec<CurveName>,
    times: Place,
    values: Place,
}

/// Forces of joints that are drawn as arrows, each at a place of its own body.
#[derive(Serialize)]
struct ArrowLayer {
    name: &'static str,
    unit: &'static str,
    arrows: Vec<Arrow>,
}

/// A force in the world.
#[derive(Serialize)]
struct Arrow {
    name: String,
    /// The frame in which it acts.
    at: Frame,
    /// The curves of its x, y and z.
    curves: [usize; 3],
}

/// A run to show: its log, the model that the log carries, and its state at t = 0.
#[derive(Clone, Copy)]
pub struct LoggedRun<'r> {
    /// The log.
    pub log: &'r Path,
    /// Its model.
    pub model: &'r Model,
    /// Its start.
    pub start: &'r State,
}

impl LoggedRun<'_> {
    /// The name of the log without its folder.
    fn source(&self) -> String {
        self.log.file_name().unwrap_or(self.log.as_os_str()).to_string_lossy().into_owned()
    }
}

/// The page of a run, with another run beside it, if there is one.
///
/// # Errors
/// [`PageError`].
pub fn run_page(run: LoggedRun, second: Option<LoggedRun>, options: &PageOptions) -> Result<String, PageError> {
    let summary = Summary::read(run.log)?;
    let motion = motion_of(run.log, run.model, &summary)?;
    let mut notes = thinned(&motion, summary.samples);
    let mut packed = Packed::default();
    let mut beside = None;
    let second_motion = match second {
        Some(second) => {
            let summary = Summary::read(second.log)?;
            let motion = motion_of(second.log, second.model, &summary)?;
            notes.extend(
                thinned(&motion, summary.samples).into_iter().map(|note| format!("{}: {note}", second.source())),
            );
            Some((second, motion))
        }
        None => None,
    };
    if let Some((second, motion)) = &second_motion {
        let logged = LoggedMeshes::read(second.log)?;
        let source = |link: &str, number: usize, _: &MeshFile| logged_mesh(&logged, link, number);
        let drawn = looks(second.model, &source, options.mesh_limit > 0);
        let (played, told) =
            Played::of(second.source(), second.model, second.start, motion, drawn, options, &mut packed);
        notes.extend(told.into_iter().map(|note| format!("{}: {note}", second.source())));
        beside = Some(played);
    }
    let logged = LoggedMeshes::read(run.log)?;
    let source = |link: &str, number: usize, _: &MeshFile| logged_mesh(&logged, link, number);
    let facts = facts::of_run(&summary, run.model);
    let about = About { kind: "run", source: run.source(), facts, warnings: summary.warnings.clone(), notes };
    Ok(write(run.model, run.start, about, &source, &motion, beside, options, packed))
}

/// A note, if not all samples are in the motion.
fn thinned(motion: &Motion, samples: u64) -> Vec<String> {
    let (shown, stride) = (motion.times.len(), motion.stride());
    let note = || format!("{shown} of {samples} samples are shown: one in {stride}");
    if stride > 1 { vec![note()] } else { Vec::new() }
}

/// The motion of a log of this model.
pub(in crate::output) fn motion_of<'m>(
    log: &Path,
    model: &'m Model,
    summary: &Summary,
) -> Result<Motion<'m>, PageError> {
    let mut motion = Motion::new(model, summary.samples);
    visit(log, &mut motion)?;
    motion.finish();
    let log = || log.display().to_string();
    match motion.misfit {
        Some(_) if motion.is_bare => Err(PageError::Bare { log: log() }),
        Some(time) => Err(PageError::Misfit { log: log(), time }),
        None if motion.times.is_empty() => Err(PageError::Empty { log: log() }),
        None => Ok(motion),
    }
}

/// The page of a model in the state `start`, with a slider for each joint.
pub fn model_page(model: &Model, start: &State, options: &PageOptions) -> String {
    let mut motion = Motion::new(model, 0);
    motion.times.push(start.time);
    let bodies = body_states(&model.mechanism, start);
    for (poses, body) in motion.poses.iter_mut().zip(&bodies) {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(body.rotation);
        let pose = nalgebra::IsometryMatrix3::from_parts(body.position.into(), rotation);
        poses.push(pose_numbers(&pose).map(|number| number as f32));
    }
    let source = |_: &str, _: usize, mesh: &MeshFile| match &mesh.resolved {
        Some(file) => mesh_of_file(file),
        None => Err("the file was not found".to_string()),
    };
    let path = model.path();
    let name = path.file_name().map_or_else(|| path.display().to_string(), |file| file.to_string_lossy().into_owned());
    let warnings = model.warning_lines().collect();
    let about = About { kind: "model", source: name, facts: facts::of_model(model), warnings, notes: Vec::new() };
    write(model, start, about, &source, &motion, None, options, Packed::default())
}

/// The source of a page.
struct About {
    kind: &'static str,
    source: String,
    facts: Vec<Fact>,
    warnings: Vec<String>,
    notes: Vec<String>,
}

#[expect(clippy::too_many_arguments, reason = "the robot, its motion, the words and the arrays of a page are apart")]
fn write(
    model: &Model,
    start: &State,
    about: About,
    source: &MeshSource,
    motion: &Motion,
    second: Option<Played>,
    options: &PageOptions,
    mut packed: Packed,
) -> String {
    let mut drawn = looks(model, source, options.mesh_limit > 0);
    let [obstacles, collision_shapes] = colliders(model, &mut drawn, options.mesh_limit > 0);
    let (played, told) = Played::of(about.source, model, start, motion, drawn, options, &mut packed);
    let gravity = model.mechanism.gravity.norm();
    let title = format!("{} · catena", played.source);
    let header = Header {
        kind: about.kind,
        played,
        second,
        catena: env!("CARGO_PKG_VERSION"),
        facts: about.facts,
        warnings: about.warnings,
        notes: about.notes.into_iter().chain(told).collect(),
        tables: &options.tables,
        obstacles,
        collision_shapes,
        events: &motion.events,
        arrows: vec![reactions(model, &motion.curves)].into_iter().filter(|layer| !layer.arrows.is_empty()).collect(),
        contacts: motion.contacts.pack(&mut packed),
        weight: model.mechanism.total_mass() * if gravity > 0.0 { gravity } else { 9.81 },
    };
    // Everything in it has string keys and no maps, which is all that could fail.
    let text = serde_json::to_string(&header).unwrap_or_default();
    html::page(&title, &text, &packed.text())
}

impl<'p> Played<'p> {
    /// Packs a robot and its motion; returns notes about shapes, too.
    fn of(
        source: String,
        model: &'p Model,
        start: &State,
        motion: &'p Motion,
        drawn: Looks,
        options: &PageOptions,
        packed: &mut Packed,
    ) -> (Self, Vec<String>) {
        let (meshes, simplified) = drawn.meshes.pack(options.mesh_limit, packed);
        let samples = motion.times.len();
        let columns = motion.poses.iter().flat_map(|poses| (0..7).flat_map(|k| poses.iter().map(move |pose| pose[k])));
        let times = motion.steps.times();
        let steps = StepCurves {
            curves: motion.steps.curves(),
            times: packed.doubles(&times),
            values: packed.floats(motion.steps.columns(), times.len()),
        };
        let played = Played {
            name: &model.mechanism.name,
            source,
            tree: tree(model, start),
            shapes: drawn.shapes,
            ropes: ropes(model),
            meshes,
            samples,
            times: packed.doubles(&motion.times),
            poses: packed.floats(columns, samples),
            curves: &motion.curves,
            values: packed.floats(motion.values.iter().flatten().copied(), samples),
            steps,
        };
        (played, drawn.notes.into_iter().chain(simplified).collect())
    }
}

/// The forces of joints on the bodies that they carry, and of loops on their second ends.
fn reactions(model: &Model, curves: &[CurveName]) -> ArrowLayer {
    let mechanism = &model.mechanism;
    let joints = model.joints.iter().filter_map(|record| {
        let at = Frame { body: record.body, pose: pose_numbers(&record.child_link_in_body) };
        record.body.map(|_| (record.name.as_str(), at))
    });
    let loops = mechanism.loops.iter().map(|closing| (closing.name.as_str(), Frame::from(&closing.b)));
    let arrow = |(name, at): (&str, Frame)| {
        let first = curves.iter().position(|curve| curve.name == format!("{name}.reaction_force.x"))?;
        Some(Arrow { name: name.to_string(), at, curves: [first, first + 1, first + 2] })
    };
    ArrowLayer { name: "Reactions", unit: "N", arrows: joints.chain(loops).filter_map(arrow).collect() }
}

/// The mesh as the log carries it, else as its file is now.
pub(in crate::output) fn logged_mesh(logged: &LoggedMeshes, link: &str, number: usize) -> Result<MeshData, String> {
    let Some(mesh) = logged.get(link, number) else { return Err("the log does not have it".to_string()) };
    match (&mesh.parts[..], mesh.file.as_deref().filter(|file| file.is_absolute())) {
        ([], Some(file)) => mesh_of_file(file),
        ([], None) => Err("the log does not have it, nor its file".to_string()),
        (parts, _) => Ok(MeshData::of_log(parts)),
    }
}

fn mesh_of_file(file: &Path) -> Result<MeshData, String> {
    let bytes = std::fs::read(file).map_err(|error| error.to_string())?;
    Ok(MeshData { key: sha256(&bytes), content: MeshContent::File(file.to_path_buf(), bytes) })
}
