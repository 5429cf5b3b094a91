//! Equality constraints of MJCF: points and frames of two bodies that stay together, joints that follow joints, and tendons.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::parts::{Closing, End};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use nalgebra::Point3;

impl Reader<'_> {
    /// All constraints of an `<equality>`.
    pub fn equality(&mut self, equality: &Element) -> Result<(), SceneError> {
        for given in &equality.children {
            let one = self.defaults.applied_as("equality", given, None);
            if one.flag("active") == Some(false) {
                self.not_simulated(&one, "a constraint that is not active is left out".to_string());
                continue;
            }
            match one.name.as_str() {
                "connect" => self.closing(&one, "spherical")?,
                "weld" => {
                    if one.list("relpose", 7, 7)?.is_some_and(|pose| pose[3..].iter().any(|number| *number != 0.0)) {
                        self.odd(&one, "its relpose is not read: both keep the pose that they start with".to_string());
                    }
                    self.closing(&one, "fixed")?;
                }
                "joint" => self.following(&one)?,
                "tendon" => self.tied(&one)?,
                other => self.not_simulated(&one, format!("constraints <{other}> are not simulated")),
            }
        }
        Ok(())
    }

    fn closing(&mut self, one: &Element, kind: &'static str) -> Result<(), SceneError> {
        let name = one.text("name").map(str::to_string);
        let mut ends = Vec::with_capacity(2);
        if one.text("site1").is_some() || one.text("site2").is_some() {
            for attribute in ["site1", "site2"] {
                let site = one.text(attribute).ok_or_else(|| one.missing(attribute))?;
                let unknown = || one.error(attribute, "there is no such site".to_string());
                let (body, pose) = self.sites.get(site).cloned().ok_or_else(unknown)?;
                ends.push(self.end(one, body.as_deref(), &Point3::from(pose.translation.vector))?);
            }
        } else {
            let first = one.text("body1").ok_or_else(|| one.missing("body1"))?;
            let second = one.text("body2");
            // A weld has its anchor in the second body, a connection in the first.
            let of = if kind == "fixed" { second } else { Some(first) };
            let anchor = Point3::from(one.vector("anchor")?.unwrap_or_default());
            let place = match of {
                Some(body) => self.place(one, body)? * anchor,
                None => anchor,
            };
            ends.push(self.end(one, Some(first), &place)?);
            ends.push(self.end(one, second, &place)?);
        }
        let Ok(ends) = <[_; 2]>::try_from(ends) else { return Ok(()) };
        self.closings.push(Closing { name, kind, ends });
        Ok(())
    }

    /// A point of the world as one of a body, at the start.
    pub fn end(&self, one: &Element, body: Option<&str>, point: &Point3<f64>) -> Result<End, SceneError> {
        match body {
            Some(body) if body != "world" => {
                let moving = self.placed.get(body).is_some_and(|placed| placed.tree.is_some());
                let pose = self.place(one, body)?;
                let own = (pose.inverse() * point).coords;
                Ok(if moving { (Some(body.to_string()), own) } else { (None, point.coords) })
            }
            _ => Ok((None, point.coords)),
        }
    }

    fn place(&self, one: &Element, body: &str) -> Result<crate::scene::robot::Pose, SceneError> {
        if body == "world" {
            return Ok(crate::scene::robot::Pose::identity());
        }
        let placed = self.placed.get(body);
        placed.map(|placed| placed.pose).ok_or_else(|| one.error("body1", format!("there is no body {body:?}")))
    }

    /// A joint that follows another, or is held.
    fn following(&mut self, one: &Element) -> Result<(), SceneError> {
        let follower = one.text("joint1").ok_or_else(|| one.missing("joint1"))?.to_string();
        let coefficients = one.list("polycoef", 1, 5)?.unwrap_or_else(|| vec![0.0, 1.0]);
        let coefficient = |power: usize| coefficients.get(power).copied().unwrap_or(if power == 1 { 1.0 } else { 0.0 });
        let leader = one.text("joint2").map(str::to_string);
        if leader.is_some() && coefficients.iter().skip(2).any(|number| *number != 0.0) {
            self.not_simulated(one, "relations of joints of a higher degree than one are not simulated".to_string());
            return Ok(());
        }
        let trees = |name: &str| self.references.get(name).map(|(tree, _)| *tree);
        let Some(tree) = trees(&follower) else {
            return Err(one.error("joint1", "there is no such joint".to_string()));
        };
        let Some(leader) = leader else {
            self.locked.push((follower, coefficient(0)));
            return Ok(());
        };
        match trees(&leader) {
            None => return Err(one.error("joint2", "there is no such joint".to_string())),
            Some(other) if other != tree => {
                self.not_simulated(
                    one,
                    "relations of joints of different children of the world are not simulated".to_string(),
                );
                return Ok(());
            }
            _ => {}
        }
        let mimic = Some((leader, coefficient(1), coefficient(0)));
        for (_, joint) in &mut self.trees[tree].joints {
            if let Some(joint) = joint.as_mut().filter(|joint| joint.name == follower) {
                joint.mimic.clone_from(&mimic);
            }
        }
        Ok(())
    }
}
