//! Tendons of MJCF that have a counterpart.
//!
//! | tendon | as |
//! |---|---|
//! | `spatial` through two sites or more, its upper limit | a rope: `Σ |p_{i+1} − p_i| ≤ L` |
//! | stiffness, damping and `springlength` of one through two sites | a spring between the two points |
//! | `fixed`, held by `<equality><tendon>` | a coupling: `Σ c_i q_i − k Σ d_j q_j = a`, with the positions q counted from the start |
//! | `fixed`, pulled by a motor with the effort f | efforts `c_i f` of its joints ([`super::actuators`]) |
//!
//! The polynomial `a + k x` of the equality is of the first degree. Everything else of a tendon is a warning with its line. A tendon that pulls
//! nothing and has no bound says nothing of the motion. Lengths without force are in [`super::rest_lengths`].

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::parts::{End, Relation, Rope, Spring};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use nalgebra::Point3;

/// How a tendon pulls by itself: the bounds of its length (m, or as its joints are counted), its stiffness and its damping.
struct Pull {
    range: Option<(f64, f64)>,
    stiffness: f64,
    damping: f64,
}

impl Reader<'_> {
    /// All tendons of a `<tendon>`.
    pub fn tendons(&mut self, tendons: &Element) -> Result<(), SceneError> {
        for given in &tendons.children {
            let tendon = self.defaults.applied_as("tendon", given, None);
            match tendon.name.as_str() {
                "spatial" => self.spatial(&tendon)?,
                "fixed" => self.fixed_tendon(&tendon)?,
                _ => self.unknown(&tendon, "tendon"),
            }
        }
        Ok(())
    }

    /// A tendon through points of bodies.
    fn spatial(&mut self, tendon: &Element) -> Result<(), SceneError> {
        let name = tendon.text("name").map(str::to_string);
        let Pull { range, stiffness, damping } = self.pull_of(tendon)?;
        let is_sprung = stiffness != 0.0 || damping != 0.0;
        if range.is_none() && !is_sprung {
            return Ok(());
        }
        if tendon.children.iter().any(|child| child.name != "site") || tendon.children.len() < 2 {
            let message = "tendons around geoms and over pulleys are not simulated";
            self.not_simulated(tendon, message.to_string());
            return Ok(());
        }
        let mut ends: Vec<End> = Vec::with_capacity(tendon.children.len());
        for child in &tendon.children {
            let site = child.text("site").ok_or_else(|| child.missing("site"))?;
            let unknown = || child.error("site", "there is no such site".to_string());
            let (body, pose) = self.sites.get(site).cloned().ok_or_else(unknown)?;
            let point = Point3::from(pose.translation.vector);
            ends.push(self.end(child, body.as_deref(), &point)?);
        }
        if self.are_one_body(&ends) {
            self.odd(tendon, "the sites of a tendon never move against each other; it is left out".to_string());
            return Ok(());
        }
        if let Some((lower, upper)) = range {
            if lower > 0.0 {
                self.not_simulated(tendon, "the least length of a tendon is not simulated".to_string());
            }
            self.ropes.push(Rope { name, points: ends.clone(), length: upper });
        }
        let ends = match <[End; 2]>::try_from(ends) {
            Ok(ends) => ends,
            Err(_) if is_sprung => {
                let message = "stiffness and damping of a tendon through more than two sites are not simulated";
                self.not_simulated(tendon, message.to_string());
                return Ok(());
            }
            Err(_) => return Ok(()),
        };
        if is_sprung {
            let rest = match tendon.list("springlength", 1, 2)?.as_deref() {
                Some([free]) if *free >= 0.0 => *free,
                Some([shortest, longest]) if shortest == longest && *shortest >= 0.0 => *shortest,
                Some([_, _]) => {
                    let message =
                        "a tendon with a range of lengths without force is not simulated; its spring is left out";
                    self.not_simulated(tendon, message.to_string());
                    return Ok(());
                }
                _ => self.rest_length(&ends),
            };
            self.springs.push(Spring { ends, stiffness, damping, rest });
        }
        Ok(())
    }

    /// A tendon whose length is a sum of positions of joints.
    fn fixed_tendon(&mut self, tendon: &Element) -> Result<(), SceneError> {
        let mut terms = Vec::with_capacity(tendon.children.len());
        for child in &tendon.children {
            let joint = child.text("joint").ok_or_else(|| child.missing("joint"))?;
            if !self.references.contains_key(joint) {
                return Err(child.error("joint", "there is no such joint".to_string()));
            }
            let coefficient = child.number("coef")?.ok_or_else(|| child.missing("coef"))?;
            terms.push((joint.to_string(), coefficient));
        }
        if let Some(name) = tendon.text("name") {
            self.fixed_tendons.insert(name.to_string(), terms);
        }
        let Pull { range, stiffness, damping } = self.pull_of(tendon)?;
        if range.is_some() {
            self.not_simulated(tendon, "limits of fixed tendons are not simulated".to_string());
        }
        if stiffness != 0.0 || damping != 0.0 {
            self.not_simulated(tendon, "stiffness and damping of fixed tendons are not simulated".to_string());
        }
        Ok(())
    }

    /// How a tendon pulls. Warns of what no tendon has here.
    fn pull_of(&mut self, tendon: &Element) -> Result<Pull, SceneError> {
        for key in ["frictionloss", "armature"] {
            if tendon.number(key)?.is_some_and(|number| number != 0.0) {
                self.not_simulated(tendon, format!("{key} of tendons is not simulated"));
            }
        }
        Ok(Pull {
            range: self.bounds(tendon, "range", "limited")?,
            stiffness: self.linear(tendon, "stiffness")?.unwrap_or(0.0),
            damping: self.linear(tendon, "damping")?.unwrap_or(0.0),
        })
    }

    /// Two fixed tendons that keep their relation, or one that keeps its length.
    pub fn tied(&mut self, one: &Element) -> Result<(), SceneError> {
        let coefficients = one.list("polycoef", 1, 5)?.unwrap_or_else(|| vec![0.0, 1.0]);
        let coefficient = |power: usize| coefficients.get(power).copied().unwrap_or(if power == 1 { 1.0 } else { 0.0 });
        let first = one.text("tendon1").ok_or_else(|| one.missing("tendon1"))?;
        let second = one.text("tendon2");
        let terms = |name: &str| self.fixed_tendons.get(name).cloned();
        let (Some(mut joints), Some(others)) = (terms(first), second.map_or(Some(Vec::new()), terms)) else {
            self.not_simulated(one, "only fixed tendons are held by constraints here".to_string());
            return Ok(());
        };
        if second.is_some() && coefficients.iter().skip(2).any(|number| *number != 0.0) {
            self.not_simulated(one, "relations of tendons of a higher degree than one are not simulated".to_string());
            return Ok(());
        }
        joints.extend(others.into_iter().map(|(joint, own)| (joint, -coefficient(1) * own)));
        let mut sums: Vec<(String, f64)> = Vec::with_capacity(joints.len());
        for (joint, own) in joints {
            match sums.iter_mut().find(|(name, _)| *name == joint) {
                Some((_, sum)) => *sum += own,
                None => sums.push((joint, own)),
            }
        }
        sums.retain(|(_, sum)| *sum != 0.0);
        let trees = sums.iter().map(|(joint, _)| self.references.get(joint).map(|(tree, _)| *tree));
        let is_one_robot = trees.clone().all(|tree| tree == trees.clone().next().flatten());
        match sums.as_slice() {
            [] => self.not_simulated(one, "a relation without joints is left out".to_string()),
            [(joint, own)] => self.locked.push((joint.clone(), coefficient(0) / own)),
            _ if !is_one_robot => {
                let message = "relations of joints of different children of the world are not simulated";
                self.not_simulated(one, message.to_string());
            }
            _ => {
                let name = one.text("name").map(str::to_string);
                self.relations.push(Relation { name, joints: sums, offset: coefficient(0) });
            }
        }
        Ok(())
    }
}
