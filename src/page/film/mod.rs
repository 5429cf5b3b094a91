//! Films: the run of a log as GIF, MP4 or PNG.
//!
//! ```text
//!     log ─ page/motion.rs ─▶ poses at the samples
//!     model ─ page/looks.rs, page/colliders.rs ─▶ parts.rs (primitives.rs, normals.rs)      triangles of each body
//!     both ─▶ scene.rs (camera.rs, background.rs) ─▶ canvas.rs ─▶ formats.rs (palette.rs) ─▶ file
//! ```
//!
//! The renderer is the program's own: it needs no browser and no graphics card, and the same log and build give the same bytes. A browser may draw the
//! pictures instead, from the page of the run (browser.rs): with arrows of forces, and some ten times slower.

mod background;
mod browser;
mod camera;
mod canvas;
mod error;
mod formats;
mod normals;
mod options;
mod palette;
mod parts;
mod primitives;
mod scene;

pub use camera::View;
pub use error::FilmError;
pub use formats::Format;
pub use options::FilmOptions;

use crate::drawing::files::write_with;
use crate::film::browser::Browser;
use crate::film::canvas::Image;
use crate::film::formats::Film;
use crate::film::parts::Parts;
use crate::film::scene::Scene;
use crate::model::Model;
use crate::output::inspection::summary::Summary;
use crate::output::log::reading::meshes::LoggedMeshes;
use crate::page::{PageError, logged_mesh, motion_of};
use crate::scene::MeshFile;
use std::path::Path;

/// The film that was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Filmed {
    /// Number of pictures.
    pub pictures: usize,
    /// The instants of the first and of the last (s).
    pub span: [f64; 2],
    /// Shapes that are not drawn, or not as in their files.
    pub notes: Vec<String>,
}

/// Writes the film of a log, whose model is the one that the log carries. With a `page` of the run a browser draws its pictures. `drawn` is told the
/// number of pictures that were drawn, and of all.
///
/// # Errors
/// [`FilmError`]; an older film is then as it was.
pub fn write_film(
    log: &Path,
    model: &Model,
    page: Option<&str>,
    file: &Path,
    options: &FilmOptions,
    drawn: &mut dyn FnMut(usize, usize),
) -> Result<Filmed, FilmError> {
    let format = Format::of(file)?;
    options.check(format)?;
    let summary = Summary::read(log).map_err(PageError::from)?;
    let motion = motion_of(log, model, &summary)?;
    let instants = options.instants(format, [motion.times[0], motion.times[motion.times.len() - 1]])?;
    let film = Film { instants: &instants, rate: options.rate, size: options.size };
    let mut count = 0;
    let mut counted = || {
        count += 1;
        drawn(count.min(instants.len()), instants.len());
    };
    let notes = if let Some(page) = page {
        let mut browser = Browser::open(page, options.view, options.size)?;
        let mut draw = |time: f64, image: &mut Image| browser.draw(time, image).map(|()| counted());
        write_with(file, |part| film.write(format, part, &mut draw))?;
        Vec::new()
    } else {
        let logged = LoggedMeshes::read(log).map_err(PageError::from)?;
        let source = |link: &str, number: usize, _: &MeshFile| logged_mesh(&logged, link, number);
        let parts = Parts::of(model, &source, options.mesh_limit);
        let notes = parts.notes.clone();
        let mut scene = Scene::new(motion, parts, options);
        let mut draw = |time: f64, image: &mut Image| {
            scene.draw(time, image);
            counted();
            Ok(())
        };
        write_with(file, |part| film.write(format, part, &mut draw))?;
        notes
    };
    Ok(Filmed { pictures: instants.len(), span: [instants[0], instants[instants.len() - 1]], notes })
}
