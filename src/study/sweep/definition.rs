//! The sweep file: the scene, the varied numbers, and the kept quantities.
//!
//! | table        | keys                                                                                                        |
//! |--------------|-------------------------------------------------------------------------------------------------------------|
//! | `sweep`      | `scene` (a scene file or URDF, relative to this file), `name`, `seed`, `samples`, `rows_per_file`             |
//! | `vary`       | `key` or `keys` ([`crate::scene::parameters`]), `relative`, and one of `linear`, `logarithmic`               |
//! |              | (`from`, `to`, `count`), `values`, `uniform`, `log_uniform`, `normal`; or `csv` alone                       |
//! | `keep`       | `end`, `curves`, `extremes`, `rate`, `events`                                                               |
//! | `simulation` | replaces the table of the scene: `duration`, `tolerance` or `stages` and `step`, `rate`                     |

use crate::model::Model;
use crate::scene::{PackagePath, Problem, Scene, SimulationSettings, TomlText, read_input, read_text, simulation};
use crate::simulation::StepChoice;
use crate::sweep::error::SweepError;
use crate::sweep::quantities::Kept;
use crate::sweep::schema::FileTable;
use crate::sweep::variation::{Source, Variation};
use crate::sweep::vary::Reader;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use toml::Spanned;

const DEFAULT_DURATION: f64 = 10.0;
const DEFAULT_TOLERANCE: f64 = 1e-6;
const DEFAULT_RATE: f64 = 60.0;

/// Most runs of a sweep: up to here an index is a double without rounding.
const MOST_RUNS: u64 = 1 << 53;

/// About this many numbers are in a file of rows, unless the sweep file says how many rows.
const NUMBERS_PER_FILE: u64 = 1 << 22;
/// Rows of a file.
const MOST_ROWS: u64 = 1 << 16;

/// Samples a run that curves and extremes may have.
const MOST_SAMPLES: f64 = 1e7;

/// A sweep: everything that its rows follow from.
#[derive(Debug)]
pub struct Sweep {
    /// Its name: the name of the file unless it gives one.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// The scene, with the numbers of its files.
    pub(crate) scene: Scene,
    pub(crate) variation: Variation,
    pub(crate) kept: Kept,
    /// How many runs there are.
    pub runs: u64,
    /// Number of consecutive rows in a file.
    pub rows_per_file: u64,
    /// A hash that tells it from other sweeps: of the sweep file, of all files that it names, and of the version of this program.
    pub fingerprint: String,
    /// Warnings about the scene.
    pub warnings: Vec<String>,
}

/// Reads a sweep file and the files that it names; tries its scene with the numbers of the files.
///
/// # Errors
/// [`SweepError`] with file, line and key.
pub fn read_sweep(path: &Path, packages: &PackagePath) -> Result<Sweep, SweepError> {
    let source = read_text(path)?;
    let text = TomlText { file: path, text: source.strip_prefix('\u{feff}').unwrap_or(&source) };
    let file: FileTable = text.read().map_err(|error| match path.extension().and_then(|ending| ending.to_str()) {
        Some("urdf" | "xacro" | "xml") => SweepError::NotASweep { path: path.to_path_buf() },
        _ => error.into(),
    })?;
    let mut reader = Reader { text: &text, hash: Sha256::new(), columns: Vec::new() };
    reader.mix(env!("CARGO_PKG_VERSION").as_bytes());
    reader.mix(source.as_bytes());

    let named = path.parent().unwrap_or(Path::new("")).join(file.sweep.scene.get_ref());
    let mut scene = match read_input(&named, None, packages) {
        Err(error) if matches!(*error.problem, Problem::Unreadable(_)) => {
            return Err(reader.refuse(&file.sweep.scene.span(), "sweep.scene", error.to_string()).into());
        }
        read => read?,
    };
    reader.mix_scene(&scene);
    if let Some(table) = &file.simulation {
        replace(&mut scene.simulation, simulation(&text, table)?);
    }
    let sources = reader.sources(&scene, &file.vary)?;
    let random = sources.iter().any(|source| matches!(source, Source::Random { .. }));
    let samples = match &file.sweep.samples {
        Some(samples) if *samples.get_ref() == 0 => {
            return Err(reader.refuse(&samples.span(), "sweep.samples", "give at least 1".into()).into());
        }
        Some(samples) => *samples.get_ref(),
        None if random => {
            return Err(reader
                .refuse(&(0..0), "sweep", "numbers are drawn, so it needs its samples: how many runs".into())
                .into());
        }
        None => 1,
    };
    let variation = Variation {
        columns: std::mem::take(&mut reader.columns),
        sources,
        seed: file.sweep.seed.unwrap_or(0),
        samples,
    };
    let runs = match variation.runs() {
        Some(runs) if runs <= MOST_RUNS => runs,
        _ => return Err(reader.refuse(&(0..0), "vary", format!("there are more than {MOST_RUNS} runs")).into()),
    };

    let (model, _) = Model::from_scene(&scene)?;
    let kept = Kept::new(&model, &file.keep, scene.simulation.rate.unwrap_or(DEFAULT_RATE), &text)?;
    let duration = scene.simulation.duration.unwrap_or(DEFAULT_DURATION);
    if kept.samples(duration) > MOST_SAMPLES {
        let message = format!("{:e} samples a run; give a lower rate", kept.samples(duration));
        return Err(reader.refuse(&file.keep.rate.as_ref().map_or(0..0, Spanned::span), "keep.rate", message).into());
    }
    let rows_per_file = match &file.sweep.rows_per_file {
        Some(rows) if !(1..=1 << 24).contains(rows.get_ref()) => {
            return Err(reader.refuse(&rows.span(), "sweep.rows_per_file", "give 1 to 16777216".into()).into());
        }
        Some(rows) => *rows.get_ref(),
        None => (NUMBERS_PER_FILE / kept.numbers(variation.columns.len(), duration)).clamp(1, MOST_ROWS),
    };
    let stem = || path.file_stem().map_or_else(|| "sweep".to_string(), |stem| stem.to_string_lossy().into_owned());
    Ok(Sweep {
        name: file.sweep.name.unwrap_or_else(stem),
        path: path.to_path_buf(),
        variation,
        kept,
        runs,
        rows_per_file,
        fingerprint: reader.fingerprint(),
        warnings: model.warning_lines().collect(),
        scene,
    })
}

/// Overwrites settings by the ones that `instead` has.
fn replace(settings: &mut SimulationSettings, instead: SimulationSettings) {
    settings.duration = instead.duration.or(settings.duration);
    settings.rate = instead.rate.or(settings.rate);
    settings.estimate = instead.estimate.or(settings.estimate);
    if instead.tolerance.is_some() || instead.fixed.is_some() {
        (settings.tolerance, settings.fixed) = (instead.tolerance, instead.fixed);
    }
}

/// The duration (s) and the steps of a run.
pub(super) fn course(settings: &SimulationSettings) -> (f64, StepChoice) {
    let duration = settings.duration.unwrap_or(DEFAULT_DURATION);
    let choice = match settings.fixed {
        Some((stages, step)) => StepChoice::Fixed { stages, step },
        None => StepChoice::Tolerance(settings.tolerance.unwrap_or(DEFAULT_TOLERANCE)),
    };
    let choice = if settings.estimate == Some(false) { choice.without_estimate() } else { choice };
    (duration, choice.within(duration))
}
