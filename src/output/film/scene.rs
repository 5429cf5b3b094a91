//! The pictures of a film by the renderer of the program: the robot at an instant, its shadow, and the obstacles.
//!
//! ```text
//!     p' = R p + t                     a corner of a body at its pose (m); poses between samples lie on lines, quaternions too, then normalised
//!     s  = p' − l n·(p' − o) / n·l     its shadow on a plane of normal n through o, with the direction l to the lamp
//!     (x, y) = (w/2 + f R·c / F·c, …)  c = p' − e, as in camera.rs; triangles are cut at F·c = near
//! ```
//!
//! In the order of drawing: background, shadows, opaque triangles, translucent ones from far to near. Nothing depends on the machine or on other work,
//! so that the same log and build give the same bytes.

use crate::mechanism::description::joint::Pose;
use crate::output::film::background::{Ground, lamp, light};
use crate::output::film::camera::{Bounds, Camera};
use crate::output::film::canvas::{Canvas, FINE, Image, Linear, Spot};
use crate::output::film::options::FilmOptions;
use crate::output::film::parts::{Part, Parts, pose_of};
use crate::output::page::motion::Motion;
use nalgebra::Vector3;

/// Instants of the run that decide how much of it the camera shows, as in the page.
const LOOKS: usize = 24;

/// A camera follows a robot that goes further than so many times its size, as in the page.
const FAR: f64 = 4.0;

/// The radius of ropes, as a part of the size of what is seen.
const THIN: f64 = 2e-3;

/// A translucent triangle: its distance (m), place, colour and opacity.
type Glass = (f64, [Spot; 3], Linear, f32);

/// A film in three dimensions.
pub(super) struct Scene<'m> {
    motion: Motion<'m>,
    parts: Parts,
    ground: Ground,
    camera: Camera,
    /// The middle of the robot at the first sample, from which a following camera has moved with it.
    followed: Option<Vector3<f64>>,
    background: Option<Camera>,
    /// The background, and the canvas on which the robot is drawn over it.
    behind: Canvas,
    canvas: Canvas,
    glass: Vec<Glass>,
}

impl<'m> Scene<'m> {
    /// The film of a motion.
    pub(super) fn new(motion: Motion<'m>, parts: Parts, options: &FilmOptions) -> Self {
        let (first, last) = (motion.times[0], motion.times[motion.times.len() - 1]);
        let instants = LOOKS.min(motion.times.len());
        let (mut whole, mut size, mut travel) = (Bounds::NONE, 0.0f64, 0.0f64);
        let start = poses(&motion, first);
        let middle = middle_of(&start);
        for k in 0..instants {
            let now = poses(&motion, first + k as f64 / (instants - 1).max(1) as f64 * (last - first));
            let bounds = parts.bounds(&now);
            whole = whole.joined(&bounds);
            size = size.max(bounds.diagonal());
            travel = travel.max((middle_of(&now) - middle).norm());
        }
        let size = if size > 0.0 { size } else { 1.0 };
        let follows = travel > FAR * size;
        let mut seen = if follows { parts.bounds(&start) } else { whole };
        for obstacle in &parts.obstacles {
            let own = obstacle.bounds_at(&start);
            // A bowl around the robot is shown whole, a whole street is not.
            if own.joined(&whole).diagonal() < 5.0 * whole.diagonal() && !follows {
                seen = seen.joined(&own);
            }
        }
        let ground = Ground {
            planes: parts.planes.clone(),
            cell: Ground::cell_of(size),
            middle: seen.middle(),
            size: seen.diagonal().max(size),
        };
        let fine = options.size.map(|pixels| FINE * pixels);
        Scene {
            camera: Camera::on(&seen, options.view, fine),
            followed: follows.then_some(middle),
            motion,
            parts,
            ground,
            background: None,
            behind: Canvas::new(options.size),
            canvas: Canvas::new(options.size),
            glass: Vec::new(),
        }
    }

    /// Draws the instant `time` (s).
    pub(super) fn draw(&mut self, time: f64, image: &mut Image) {
        let poses = poses(&self.motion, time);
        if let Some(before) = self.followed {
            let now = middle_of(&poses);
            self.camera.eye += now - before;
            self.ground.middle += now - before;
            self.followed = Some(now);
        }
        if self.background.as_ref().is_none_or(|drawn| drawn.eye != self.camera.eye) {
            // The background has the resolution of the picture, the camera that of the canvas.
            let coarse = 1.0 / FINE as f64;
            let camera = Camera {
                focal: coarse * self.camera.focal,
                middle: self.camera.middle.map(|middle| coarse * middle),
                ..self.camera.clone()
            };
            self.ground.draw(&camera, &mut self.behind);
            self.background = Some(camera);
        }
        self.canvas.color.copy_from_slice(&self.behind.color);
        self.canvas.nearness.copy_from_slice(&self.behind.nearness);
        let rods = self.parts.rods(&poses, THIN * self.ground.size);
        let placed = self.parts.links.iter().chain(&self.parts.obstacles).map(|part| (part, part.pose(&poses)));
        let all = || placed.clone().chain(rods.iter().map(|(rod, place)| (rod, *place)));
        for (plane, number) in self.ground.planes.iter().zip(1..=u8::MAX) {
            for (part, pose) in all() {
                throw_shadow(part, &pose, plane, &self.camera, |spots| self.canvas.shadow(spots, number));
            }
        }
        self.glass.clear();
        for (part, pose) in all() {
            each_triangle(part, &pose, &self.camera, |distance, spots| {
                if part.opacity < 1.0 {
                    self.glass.push((distance, *spots, part.color, part.opacity));
                } else {
                    self.canvas.draw(spots, part.color);
                }
            });
        }
        self.glass.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, spots, color, opacity) in &self.glass {
            self.canvas.glaze(spots, *color, *opacity);
        }
        self.canvas.picture(image);
    }
}

/// Calls `draw` with each triangle of a part on the canvas, and its distance (m).
fn each_triangle(part: &Part, pose: &Pose, camera: &Camera, mut draw: impl FnMut(f64, &[Spot; 3])) {
    for corners in &part.triangles {
        let placed =
            corners.map(|(place, normal)| (pose.rotation * place + pose.translation.vector - camera.eye, normal));
        let sum = placed.iter().fold(Vector3::zeros(), |sum: Vector3<f64>, (_, normal)| sum + normal);
        let outwards = pose.rotation * sum;
        // A surface that is seen from behind is lit as if that were its front.
        let side = if outwards.dot(&placed[0].0) > 0.0 { -1.0 } else { 1.0 };
        let lit = placed.map(|(place, normal)| (place, light(&(side * (pose.rotation * normal)))));
        let distance = lit.iter().map(|(place, _)| place.norm()).sum::<f64>() / 3.0;
        cut(&lit, camera, |spots| draw(distance, spots));
    }
}

/// Calls `draw` with the shadow of each triangle of a part on a plane.
fn throw_shadow(part: &Part, pose: &Pose, plane: &Pose, camera: &Camera, mut draw: impl FnMut(&[Spot; 3])) {
    let (normal, lamp) = (plane.rotation * Vector3::z(), lamp());
    let slope = normal.dot(&lamp);
    // A plane that the lamp does not reach has no shadows, and a glass throws none.
    if slope <= 0.0 || part.opacity < 1.0 {
        return;
    }
    for corners in &part.triangles {
        let placed = corners.map(|(place, _)| pose.rotation * place + pose.translation.vector);
        let heights = placed.map(|place| normal.dot(&(place - plane.translation.vector)));
        if heights.iter().all(|height| *height <= 0.0) {
            continue;
        }
        let fallen: [_; 3] =
            std::array::from_fn(|k| (placed[k] - heights[k].max(0.0) / slope * lamp - camera.eye, 1.0));
        cut(&fallen, camera, &mut draw);
    }
}

/// Cuts a triangle at the distance `near` before the eye and puts it onto the canvas.
fn cut(corners: &[(Vector3<f64>, f64); 3], camera: &Camera, mut draw: impl FnMut(&[Spot; 3])) {
    let [right, up, forward] = &camera.axes;
    let near = camera.near;
    let depths = corners.map(|(place, _)| forward.dot(&place));
    if depths.iter().all(|depth| *depth <= near) {
        return;
    }
    let spot = |(place, light): (Vector3<f64>, f64), depth: f64| Spot {
        x: camera.middle[0] + camera.focal * right.dot(&place) / depth,
        y: camera.middle[1] - camera.focal * up.dot(&place) / depth,
        nearness: 1.0 / depth,
        light,
    };
    if depths.iter().all(|depth| *depth > near) {
        return draw(&[0, 1, 2].map(|k| spot(corners[k], depths[k])));
    }
    let mut kept = [None; 4];
    let mut count = 0;
    for k in 0..3 {
        let next = (k + 1) % 3;
        if depths[k] > near {
            kept[count] = Some(spot(corners[k], depths[k]));
            count += 1;
        }
        if (depths[k] > near) != (depths[next] > near) {
            let part = (near - depths[k]) / (depths[next] - depths[k]);
            let [(from, bright), (to, other)] = [corners[k], corners[next]];
            kept[count] = Some(spot((from + part * (to - from), bright + part * (other - bright)), near));
            count += 1;
        }
    }
    if let [Some(a), Some(b), Some(c), last] = kept {
        draw(&[a, b, c]);
        if let Some(d) = last {
            draw(&[a, c, d]);
        }
    }
}

/// The poses of all bodies at a time between two samples.
fn poses(motion: &Motion, time: f64) -> Vec<Pose> {
    let after = motion.times.partition_point(|sample| *sample <= time).min(motion.times.len() - 1);
    let before = after.saturating_sub(1);
    let span = motion.times[after] - motion.times[before];
    let part = if span > 0.0 { ((time - motion.times[before]) / span).clamp(0.0, 1.0) } else { 0.0 };
    let between = |samples: &Vec<[f32; 7]>| {
        let [from, to] = [before, after].map(|sample| samples[sample].map(f64::from));
        pose_of(&std::array::from_fn(|k| from[k] + part * (to[k] - from[k])))
    };
    motion.poses.iter().map(between).collect()
}

/// The mean place of the bodies (m).
fn middle_of(poses: &[Pose]) -> Vector3<f64> {
    let sum = poses.iter().fold(Vector3::zeros(), |sum: Vector3<f64>, pose| sum + pose.translation.vector);
    sum / poses.len().max(1) as f64
}
