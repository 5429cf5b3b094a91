//! `catena film`: the run of a log as a film, or as a picture of some instants.
//!
//! The model is the one that the log carries, and so are the meshes; those that it only names are read from their files, where they are.

use crate::cli::inspect_files::check_outputs;
use crate::cli::recorded::Recorded;
use crate::cli::report::page_of_log;
use crate::cli::terminal::printing::{Failure, print, warn};
use crate::cli::terminal::progress::Pictures;
use catena::mechanism::ground::words::counted;
use catena::output::film::{FilmError, FilmOptions, Filmed, Format, View, write_film};
use catena::output::inspection::summary::Summary;
use catena::output::page::MESH_LIMIT;
use clap::Args;
use std::path::{Path, PathBuf};

/// The options of `catena film`.
#[derive(Args, Debug)]
pub struct FilmArgs {
    /// The log
    #[arg(value_name = "LOG.mcap")]
    log: PathBuf,

    /// The film; its ending says which: .gif, .mp4 (by ffmpeg), .png [default: the name of the log with .gif, in the current folder]
    #[arg(short, long, value_name = "FILE", value_parser = crate::cli::arguments::outputs::output_file())]
    output: Option<PathBuf>,

    /// Pixels of the picture [default: 640x360 for .gif, else 960x540]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size)]
    size: Option<[usize; 2]>,

    /// Pictures in a second of the film
    #[arg(long, value_name = "RATE", default_value_t = 25.0, allow_hyphen_values = true)]
    fps: f64,

    /// Seconds of the run in a second of the film: 0.1 is slow motion
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, allow_hyphen_values = true)]
    speed: f64,

    /// First and last instant of the film [s]; for .png the instants of the pictures, side by side [default: the whole run; for .png its end]
    #[arg(long, value_name = "T,…", value_delimiter = ',', allow_hyphen_values = true)]
    time: Vec<f64>,

    /// The side to look from: corner, front, back, left, right, top, or the direction to the camera x,y,z
    #[arg(long, value_name = "VIEW", default_value = "corner", allow_hyphen_values = true)]
    view: View,

    /// Most triangles of all meshes together; larger meshes are simplified, 0 leaves meshes out
    #[arg(long, value_name = "TRIANGLES", default_value_t = MESH_LIMIT)]
    mesh_limit: usize,

    /// Let a browser (Chromium) draw the pictures from the page of the run: with arrows of contact forces, and ten times slower
    #[arg(long)]
    browser: bool,

    /// Print errors only
    #[arg(long)]
    quiet: bool,
}

/// Two whole numbers.
fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once('x').map(|(width, height)| [width, height].map(|side| side.trim().parse()));
    match sides {
        Some([Ok(width), Ok(height)]) => Ok([width, height]),
        _ => Err("give width and height in pixels, such as 960x540".to_string()),
    }
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`]: 2 if the log cannot be read or shown, 1 if the film cannot be written.
pub fn run(arguments: &FilmArgs) -> Result<(), Failure> {
    let log = &arguments.log;
    let file = match &arguments.output {
        Some(file) => file.clone(),
        None => PathBuf::from(log.with_extension("gif").file_name().unwrap_or_default()),
    };
    let format = Format::of(&file).map_err(Failure::input)?;
    let options = FilmOptions {
        size: arguments.size.unwrap_or(format.usual_size()),
        rate: arguments.fps,
        speed: arguments.speed,
        view: arguments.view,
        times: arguments.time.clone(),
        mesh_limit: arguments.mesh_limit,
    };
    options.check(format).map_err(Failure::input)?;
    check_outputs(log, &[&file]).map_err(Failure::input)?;
    let summary = Summary::read(log).map_err(Failure::input)?;
    if !summary.complete {
        warn(format_args!("{}: {}", log.display(), summary.state()));
    }
    let progress = Pictures::new(arguments.quiet);
    let filmed = film_of_log(log, &file, &options, arguments.browser, &mut |drawn, all| progress.show(drawn, all));
    progress.clear();
    let filmed = filmed.map_err(|error| match error.downcast_ref::<FilmError>() {
        Some(FilmError::Write(_) | FilmError::Encoder { .. } | FilmError::NoEncoder | FilmError::Browser { .. }) => {
            Failure::run(error)
        }
        _ => Failure::input(error),
    })?;
    for note in &filmed.notes {
        warn(note);
    }
    if arguments.quiet {
        return Ok(());
    }
    let ([width, height], [first, last]) = (options.size, filmed.span);
    let pictures = counted(filmed.pictures, "picture", "pictures");
    print(format_args!(
        "{}: {pictures} of {width} x {height}, {first} to {last} s of {}\n",
        file.display(),
        log.display()
    ))
}

/// Writes the film of a log, by the program's own renderer or by a browser.
///
/// # Errors
/// The defect of the log, or a [`FilmError`].
pub fn film_of_log(
    log: &Path,
    file: &Path,
    options: &FilmOptions,
    by_browser: bool,
    drawn: &mut dyn FnMut(usize, usize),
) -> anyhow::Result<Filmed> {
    let recorded = Recorded::open(log)?;
    let page = if by_browser { Some(page_of_log(log, options.mesh_limit)?) } else { None };
    Ok(write_film(log, &recorded.loaded.model, page.as_deref(), file, options, drawn)?)
}
