//! Ropes, from the tables `[[rope]]`: names resolved, and the winches that pay ropes out ([`super::winch`]).

use crate::mechanism::description::target::Interpolation;
use crate::scene::coupling::{JointReference, LinkReference, Point, SceneRope};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_settings::{SceneMotion, TableFile};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::joint_schema::TargetKey;
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::{Positive, Quantity};
use crate::scene::scene_reading::scene_schema::RopeTable;
use crate::scene::scene_reading::winch::{PAID_OUT, Winch, most, smooth};
use nalgebra::Vector3;
use std::ops::Range;
use toml::Spanned;

/// The stop of a rope by default, as a part of its length.
const STOP: f64 = 1e-3;

/// The ropes of a scene, with their winches and the motions of these.
pub(crate) struct Ropes {
    pub ropes: Vec<SceneRope>,
    /// To come after the robots, in this order.
    pub winches: Vec<Winch>,
    pub motions: Vec<SceneMotion>,
}

impl CouplingReader<'_> {
    /// All ropes; the CSV files of their lengths join `read`. Lengths in time are looked at until `end` (s).
    pub fn ropes(
        &mut self,
        tables: Vec<Spanned<RopeTable>>,
        end: f64,
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<Ropes, SceneError> {
        let mut all = Ropes { ropes: Vec::with_capacity(tables.len()), winches: Vec::new(), motions: Vec::new() };
        for (index, table) in tables.into_iter().enumerate() {
            let span = table.span();
            let RopeTable { name, points, length, longest, stop, restitution } = table.into_inner();
            let name = name.map_or_else(|| format!("rope{}", index + 1), Spanned::into_inner);
            let owner = Element::Rope(name.clone());
            let refuse = |span, problem| Err(self.text.error(span, Some(owner.clone()), problem));
            if let Some(first) = all.ropes.iter().find(|other| other.name == name) {
                return refuse(&span, Problem::DuplicateName { first_line: first.line });
            }
            if name.is_empty() || name.contains(['|', '*']) {
                return refuse(&span, Problem::Keys("a rope has a name without | and *"));
            }
            let place = points.span();
            if points.get_ref().len() < 2 {
                return refuse(
                    &place,
                    Problem::Keys("a rope has two points or more: its ends, and eyelets between them"),
                );
            }
            let points = points.get_ref().iter().map(|point| self.point(&point.link, &point.position, &owner));
            let mut points = points.collect::<Result<Vec<Point>, SceneError>>()?;
            let value = |given: Quantity, span: &Range<usize>| {
                let number = given.value(false, false).and_then(|number| Ok(Positive::try_from(number)?.0));
                let wrong = |message| Problem::Toml { key: Some("rope.length".to_string()), message };
                number.map_err(|message| self.text.error(span, Some(owner.clone()), wrong(message)))
            };
            let line = self.text.line(&span);
            let (length, winch) = match length.get_ref() {
                TargetKey::Number(given) => {
                    let length = value(*given, &length.span())?;
                    if let Some(longest) = longest {
                        let message = "the length of this rope does not change in time: remove `longest`";
                        return refuse(&longest.span(), Problem::Keys(message));
                    }
                    (length, None)
                }
                TargetKey::Start => {
                    let message = "its length is a number, a list of [time, value], the name of a CSV file of time,value, or { formula = \"…\" }";
                    return refuse(&length.span(), Problem::Keys(message));
                }
                _ => {
                    let (target, table) = self.target(&length, &value, Interpolation::Cubic, &owner, files, read)?;
                    let target = smooth(target, table.as_ref());
                    let first = &points[0];
                    if first.link != LinkReference::World {
                        let message = "the first point of a rope whose length changes in time is its winch, which stands in the world";
                        return refuse(&place, Problem::Keys(message));
                    }
                    if name.contains('/') || self.robots.iter().any(|robot| robot.name == name) {
                        let message = "a rope with a winch has a name without a slash that no robot has";
                        return refuse(&span, Problem::Keys(message));
                    }
                    let longest = longest.map_or_else(|| most(&target, end), |longest| longest.get_ref().0);
                    let robot = self.robots.len() + all.winches.len();
                    let winch = Winch { name: name.clone(), place: first.position, longest, line };
                    let joint = JointReference { robot, joint: PAID_OUT.to_string() };
                    let end = LinkReference::Link { robot, link: 1 };
                    points.insert(0, Point { link: end, name: winch.end(), position: Vector3::zeros() });
                    let on = format!("{name}/{PAID_OUT}");
                    all.winches.push(winch);
                    all.motions.push(SceneMotion { joint: joint.clone(), on, position: target, table, line });
                    (longest, Some(joint))
                }
            };
            if let Some(stop) = stop.as_ref().filter(|_| points.len() == 2) {
                return refuse(&stop.span(), Problem::Keys("a rope between two points has no stop"));
            }
            let stop = stop.map_or(STOP * length, |stop| stop.get_ref().0);
            let restitution = restitution.map_or(0.0, |restitution| restitution.0);
            all.ropes.push(SceneRope { name, points, length, winch, stop, restitution, line });
        }
        Ok(all)
    }
}
