//! Compares two logs: the largest distance of every link between them, and its time.
//!
//! ```text
//!     d(t) = |p_A − p_B|  [m]          α(t) = 2 asin |vec(q_A⁻¹ q_B)|  [rad]
//! ```
//!
//! at the instants that both logs have; the largest of each is kept for every link that both have.

use crate::mechanism::motion::state::quaternion_product;
use crate::output::log::reading::decode::LinkPose;
use crate::output::log::reading::frame_stream::Frames;
use crate::output::log::reading::records::{Completeness, ReadError};
use serde::Serialize;
use std::collections::HashMap;
use std::fmt;
use std::path::Path;

/// How two logs differ.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Comparison {
    /// The first log.
    pub a: String,
    /// The second log.
    pub b: String,
    /// Instants that both have.
    pub instants: u64,
    /// Instants that only one of them has.
    pub only_a: u64,
    /// See `only_a`.
    pub only_b: u64,
    /// Time of the last instant that both have (s).
    pub until: f64,
    /// Whether every pose of every common link at every common instant is the same, bit for bit; without such poses they are not.
    pub identical: bool,
    /// The links that both have.
    pub links: Vec<LinkDifference>,
    /// Links that only the first has.
    pub links_only_a: Vec<String>,
    /// Links that only the second has.
    pub links_only_b: Vec<String>,
    /// The missing part of the first, if it is incomplete; it is not compared.
    pub missing_a: Option<String>,
    /// See `missing_a`.
    pub missing_b: Option<String>,
}

/// How a link differs.
#[derive(Clone, Debug, Serialize)]
pub struct LinkDifference {
    /// The link.
    pub link: String,
    /// Largest distance (m).
    pub distance: f64,
    /// When it is reached (s).
    pub distance_at: f64,
    /// Largest angle (rad).
    pub angle: f64,
    /// When it is reached (s).
    pub angle_at: f64,
    /// The first instant at which the poses are not the same, bit for bit (s).
    pub first_difference: Option<f64>,
}

impl LinkDifference {
    fn new(link: &str) -> Self {
        let link = link.to_string();
        LinkDifference { link, distance: 0.0, distance_at: 0.0, angle: 0.0, angle_at: 0.0, first_difference: None }
    }

    fn see(&mut self, time: f64, a: &LinkPose, b: &LinkPose) {
        if (a.position, a.orientation) == (b.position, b.orientation) {
            return;
        }
        self.first_difference.get_or_insert(time);
        let distance = a.position.iter().zip(&b.position).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let [w, x, y, z] = a.orientation;
        let [_, x, y, z] = quaternion_product(&[w, -x, -y, -z], &b.orientation);
        let angle = 2.0 * (x * x + y * y + z * z).sqrt().min(1.0).asin();
        if distance > self.distance {
            (self.distance, self.distance_at) = (distance, time);
        }
        if angle > self.angle {
            (self.angle, self.angle_at) = (angle, time);
        }
    }
}

/// Compares two logs.
///
/// # Errors
/// [`ReadError`] if one of them is not a log.
pub fn compare(a: &Path, b: &Path) -> Result<Comparison, ReadError> {
    let (mut frames_a, mut frames_b) = (Frames::of(a)?, Frames::of(b)?);
    let mut comparison = Comparison { a: a.display().to_string(), b: b.display().to_string(), ..Comparison::default() };
    let mut places: Option<HashMap<String, usize>> = None;
    let (mut next_a, mut next_b) = (frames_a.next().transpose()?, frames_b.next().transpose()?);
    while let (Some(frame_a), Some(frame_b)) = (&next_a, &next_b) {
        let order = frame_a.nanoseconds.cmp(&frame_b.nanoseconds);
        if order.is_eq() {
            let places = places.get_or_insert_with(|| comparison.find_links(&frame_a.links, &frame_b.links));
            let time = frame_a.time();
            comparison.instants += 1;
            comparison.until = time;
            let of_b: HashMap<&str, &LinkPose> = frame_b.links.iter().map(|pose| (pose.link.as_str(), pose)).collect();
            for pose in &frame_a.links {
                if let (Some(&place), Some(other)) = (places.get(&pose.link), of_b.get(pose.link.as_str())) {
                    comparison.links[place].see(time, pose, other);
                }
            }
        }
        if order.is_lt() {
            comparison.only_a += 1;
        }
        if order.is_gt() {
            comparison.only_b += 1;
        }
        if order.is_le() {
            next_a = frames_a.next().transpose()?;
        }
        if order.is_ge() {
            next_b = frames_b.next().transpose()?;
        }
    }
    let rest = |next: Option<_>, mut frames: Frames| -> Result<_, ReadError> {
        let mut count = u64::from(next.is_some());
        for frame in &mut frames {
            frame?;
            count += 1;
        }
        Ok((count, frames.completeness().and_then(Completeness::missing)))
    };
    let ((more_a, missing_a), (more_b, missing_b)) = (rest(next_a, frames_a)?, rest(next_b, frames_b)?);
    comparison.only_a += more_a;
    comparison.only_b += more_b;
    (comparison.missing_a, comparison.missing_b) = (missing_a, missing_b);
    // Links are looked for at the first common instant; without one the list is empty.
    comparison.identical =
        !comparison.links.is_empty() && comparison.links.iter().all(|link| link.first_difference.is_none());
    Ok(comparison)
}

impl Comparison {
    /// Sorts the links into common ones and links of one log; returns the places of the common ones.
    fn find_links(&mut self, a: &[LinkPose], b: &[LinkPose]) -> HashMap<String, usize> {
        let has = |links: &[LinkPose], name: &str| links.iter().any(|pose| pose.link == name);
        let names = |links: &[LinkPose], others: &[LinkPose]| -> Vec<String> {
            links.iter().filter(|pose| !has(others, &pose.link)).map(|pose| pose.link.clone()).collect()
        };
        self.links_only_a = names(a, b);
        self.links_only_b = names(b, a);
        self.links = a.iter().filter(|pose| has(b, &pose.link)).map(|pose| LinkDifference::new(&pose.link)).collect();
        self.links.iter().enumerate().map(|(place, link)| (link.link.clone(), place)).collect()
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Comparison { a, b, instants, until, .. } = self;
        let verdict = match (instants, self.identical) {
            (0, _) => "no instant in common".to_string(),
            _ if self.links.is_empty() => "no link in common".to_string(),
            (_, true) => format!("identical at {instants} instants up to t = {until} s"),
            (_, false) => format!("different; {instants} instants in common, up to t = {until} s"),
        };
        writeln!(out, "{a} and {b}: {verdict}")?;
        for (name, missing) in [(a, &self.missing_a), (b, &self.missing_b)] {
            if let Some(missing) = missing {
                writeln!(out, "  {name} is {missing}")?;
            }
        }
        for (name, count) in [(a, self.only_a), (b, self.only_b)] {
            if count > 0 {
                writeln!(out, "  {count} instants are in {name} only")?;
            }
        }
        for (name, links) in [(a, &self.links_only_a), (b, &self.links_only_b)] {
            if !links.is_empty() {
                writeln!(out, "  links in {name} only: {}", links.join(", "))?;
            }
        }
        if !self.identical && !self.links.is_empty() {
            let width = self.links.iter().map(|link| link.link.chars().count()).max().unwrap_or(0).max(4);
            writeln!(
                out,
                "  {:width$}  {:>12}  {:>10}  {:>12}  {:>10}  {:>14}",
                "link", "distance [m]", "at t [s]", "angle [rad]", "at t [s]", "differs from t"
            )?;
            for link in &self.links {
                let LinkDifference { link, distance, distance_at, angle, angle_at, first_difference } = link;
                let from = first_difference.map_or("never".to_string(), |time| format!("{time:.4}"));
                writeln!(
                    out,
                    "  {link:width$}  {distance:>12.3e}  {distance_at:>10.4}  {angle:>12.3e}  {angle_at:>10.4}  {from:>14}"
                )?;
            }
        }
        Ok(())
    }
}
