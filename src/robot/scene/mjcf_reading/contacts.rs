//! Contacts of MJCF: surfaces of links and obstacles, excluded pairs, and pairs with a friction of their own.
//!
//! Two geoms touch if `(contype_a & conaffinity_b) | (contype_b & conaffinity_a)` is not zero or a `<pair>` names them, and if no `<exclude>` names their
//! bodies. A `<pair>` has its own friction, other geoms have the friction of [`super::grips`]. A scene file has a surface for each shape, of which the larger values count,
//! and above it values for two links or obstacles: those are written where the larger values are not the values of the file. Where the geoms of two
//! bodies differ so that neither says it, the smallest values count, and all geoms touch, with a warning.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::grips::{Grip, grip_keys};
use crate::scene::mjcf_reading::parts::{Form, Geom};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::mjcf_reading::written::{pose, quoted, shape_of};
use crate::scene::warning::Warning;
use crate::scene::world::WORLD_LINK;
use std::fmt::Write;

/// A link or an obstacle that may touch, with its geoms that may.
struct Touching<'g> {
    /// Of a link.
    tree: Option<usize>,
    name: String,
    body: &'g str,
    geoms: Vec<&'g Geom>,
    roundness: Roundness,
    line: usize,
}

/// Which shapes touch it: ellipsoids touch planes alone.
#[derive(PartialEq)]
enum Roundness {
    Plane,
    Ellipsoid,
    Other,
}

impl Reader<'_> {
    /// Pairs of bodies that do not touch, and pairs of geoms that do.
    pub fn contact(&mut self, contact: &Element) -> Result<(), SceneError> {
        for one in &contact.children {
            let both = |names: [&str; 2]| -> Result<[String; 2], SceneError> {
                let [a, b] = names.map(|name| one.text(name).ok_or_else(|| one.missing(name)));
                Ok([a?.to_string(), b?.to_string()])
            };
            match one.name.as_str() {
                "exclude" => {
                    let bodies = both(["body1", "body2"])?;
                    for (end, body) in ["body1", "body2"].into_iter().zip(&bodies) {
                        if body != WORLD_LINK && !self.placed.contains_key(body) {
                            return Err(one.error(end, "there is no such body".to_string()));
                        }
                    }
                    self.excluded.push(bodies);
                }
                "pair" => {
                    let pair = self.defaults.applied(one, None);
                    let geoms = both(["geom1", "geom2"])?;
                    let (grip, is_round) = Grip::of_pair(&pair)?;
                    if !is_round {
                        self.odd(&pair, "its friction differs by direction; the smaller one is used".to_string());
                    }
                    for soft in ["solref", "solreffriction", "solimp", "margin", "gap"] {
                        if pair.text(soft).is_some() {
                            self.ignored_attribute(&pair, soft);
                        }
                    }
                    let bodies = [0, 1].map(|end: usize| self.body_of_geom(&geoms[end]));
                    for (end, body) in ["geom1", "geom2"].into_iter().zip(&bodies) {
                        if body.is_none() {
                            return Err(one.error(end, "there is no such geom that may touch".to_string()));
                        }
                    }
                    let joins =
                        |parent: &str, child: &str| bodies.contains(&Some(parent)) && bodies.contains(&Some(child));
                    let mut joints = self.trees.iter().flat_map(|tree| &tree.joints);
                    if joints.any(|(between, _)| joins(&between.parent, &between.child)) {
                        self.not_simulated(&pair, "a pair of two bodies that a joint joins does not touch".to_string());
                    }
                    self.pairs.push((geoms, grip));
                }
                _ => self.unknown(one, "contact"),
            }
        }
        Ok(())
    }

    /// The body of a geom that may touch.
    fn body_of_geom(&self, name: &str) -> Option<&str> {
        let is = |geom: &Geom| geom.name.as_deref() == Some(name);
        let mut links = self.trees.iter().flat_map(|tree| &tree.links);
        let of_link = links.find(|link| link.geoms.iter().any(|geom| geom.can_touch() && is(geom)));
        let of_world = || self.obstacles.iter().find(|(_, geom)| is(geom)).map(|(body, _)| body.as_str());
        of_link.map(|link| link.name.as_str()).or_else(of_world)
    }

    /// All that may touch: obstacles, then links.
    fn touching(&self) -> Vec<Touching<'_>> {
        let mut all: Vec<Touching> = Vec::with_capacity(self.obstacles.len());
        for (number, (body, geom)) in self.obstacles.iter().enumerate() {
            let name = geom.name.clone().unwrap_or_else(|| format!("geom{}", number + 1));
            let mut name = self.obstacle_name(&name);
            while all.iter().any(|other| other.name == name) {
                name.push('_');
            }
            let roundness = if matches!(geom.form, Form::Plane) { Roundness::Plane } else { Roundness::Other };
            all.push(Touching { tree: None, name, body, geoms: vec![geom], roundness, line: 0 });
        }
        for (index, tree) in self.trees.iter().enumerate() {
            for link in &tree.links {
                let geoms: Vec<&Geom> = link.geoms.iter().filter(|geom| geom.can_touch()).collect();
                if !geoms.is_empty() {
                    let (name, body, line) = (self.called(index, &link.name), &link.name, link.line);
                    let roundness = if link.is_round() { Roundness::Ellipsoid } else { Roundness::Other };
                    all.push(Touching { tree: Some(index), name, body, geoms, roundness, line });
                }
            }
        }
        all
    }

    /// The friction that a `<pair>` gives two geoms.
    fn pair_of(&self, geoms: [&Geom; 2]) -> Option<Grip> {
        let [a, b] = [geoms[0].name.as_ref()?, geoms[1].name.as_ref()?];
        let own = self.pairs.iter().rfind(|(names, _)| [[a, b], [b, a]].contains(&[&names[0], &names[1]]));
        own.map(|(_, grip)| *grip)
    }

    /// Whether two geoms touch if they meet.
    fn meet(&self, geoms: [&Geom; 2]) -> bool {
        let [a, b] = geoms.map(|geom| geom.masks);
        (a[0] & b[1]) | (b[0] & a[1]) != 0 || self.pair_of(geoms).is_some()
    }

    /// Obstacles, surfaces of links, and pairs. The warnings are about settings that no scene file has.
    pub fn write_contact(&self, text: &mut String) -> Vec<Warning> {
        let all = self.touching();
        let pairs_of = |kind: &dyn Fn(&Touching, &Touching) -> bool| {
            let of = |(place, one)| all[place + 1..].iter().map(move |other: &Touching| (one, other));
            let pairs = all.iter().enumerate().flat_map(of);
            pairs.filter(|(one, other)| kind(one, other)).collect::<Vec<(&Touching, &Touching)>>()
        };
        let any_meet = |(one, other): &(&Touching, &Touching)| {
            one.geoms.iter().any(|a| other.geoms.iter().any(|b| self.meet([a, b])))
        };
        let is_link = |one: &Touching| one.tree.is_some();
        let of_one = pairs_of(&|one, other| is_link(one) && one.tree == other.tree);
        let of_two = pairs_of(&|one, other| is_link(one) && is_link(other) && one.tree != other.tree);
        let (itself, between) = (of_one.iter().any(any_meet), of_two.iter().any(any_meet));
        let pairs = match (self.touches, between) {
            (false, _) => "none",
            (true, true) => "all",
            (true, false) => "environment",
        };
        let _ = writeln!(text, "\n[contact]\npairs = \"{pairs}\"\nself_contact = {itself}\ncombine = \"larger\"");
        for (one, (_, geom)) in all.iter().zip(&self.obstacles) {
            let Some(shape) = shape_of(geom) else { continue };
            let (name, at) = (quoted(&one.name), pose(&geom.pose));
            let _ = writeln!(text, "\n[[obstacle]]\nname = {name}\nshape = {shape}\npose = {at}");
            *text += &grip_keys(geom.grip.values(), false);
        }
        for one in all.iter().filter(|one| is_link(one)) {
            let name = quoted(&one.name);
            let values: Vec<[f64; 3]> = one.geoms.iter().map(|geom| geom.grip.values()).collect();
            if values.iter().all(|own| *own == values[0]) {
                let _ = write!(text, "\n[[link]]\nname = {name}\n{}", grip_keys(values[0], false));
                continue;
            }
            for (shape, own) in values.iter().enumerate() {
                let keys = grip_keys(*own, true);
                let _ = write!(text, "\n[[link]]\nname = {name}\nshape = {}\n{keys}", shape + 1);
            }
        }
        let asked = pairs_of(&|one, other| match (one.tree, other.tree) {
            (Some(one), Some(other)) => {
                if one == other {
                    itself
                } else {
                    between
                }
            }
            (one, other) => one.is_some() || other.is_some(),
        });
        asked.into_iter().flat_map(|(one, other)| self.write_pair(one, other, text)).collect()
    }

    /// The settings of two that would touch otherwise.
    fn write_pair(&self, one: &Touching, other: &Touching, text: &mut String) -> Vec<Warning> {
        let rule = |keys: &str| {
            let (a, b) = (quoted(&one.name), quoted(&other.name));
            format!("\n[[contact.pair]]\na = {a}\nb = {b}\n{keys}")
        };
        let bodies = [one.body, other.body];
        let is_excluded =
            |[a, b]: &[String; 2]| bodies == [a.as_str(), b.as_str()] || bodies == [b.as_str(), a.as_str()];
        let is = |roundness: &Roundness| [&one.roundness, &other.roundness].contains(&roundness);
        let pairs = one.geoms.iter().flat_map(|a| other.geoms.iter().map(move |b| [*a, *b]));
        let (meeting, apart): (Vec<_>, Vec<_>) = pairs.partition(|pair| self.meet(*pair));
        let misses = is(&Roundness::Ellipsoid) && !is(&Roundness::Plane);
        if meeting.is_empty() || misses || self.excluded.iter().any(is_excluded) {
            *text += &rule("ignore = true\n");
            return Vec::new();
        }
        let mut warnings = Vec::new();
        let line = Some(one.line.max(other.line));
        let mut warn = |message: String| warnings.push(Warning::odd(self.path, line, None, message));
        let (a, b) = (&one.name, &other.name);
        if !apart.is_empty() {
            warn(format!(
                "contype and conaffinity let some geoms of {a:?} and {b:?} touch and some not; all of them touch"
            ));
        }
        let own = |geom: &Geom| geom.grip.values();
        let wanted = |pair: [&Geom; 2]| self.pair_of(pair).unwrap_or_else(|| pair[0].grip.with(&pair[1].grip)).values();
        let larger = |[a, b]: [&Geom; 2]| [0, 1, 2].map(|way: usize| own(a)[way].max(own(b)[way]));
        if meeting.iter().all(|pair| wanted(*pair) == larger(*pair)) {
            return warnings;
        }
        let all: Vec<[f64; 3]> = meeting.iter().map(|pair| wanted(*pair)).collect();
        let least = [0, 1, 2].map(|way: usize| all.iter().map(|values| values[way]).fold(f64::INFINITY, f64::min));
        if all.iter().any(|values| *values != least) {
            warn(format!("friction of {a:?} and {b:?} differs by geom; the smallest is used"));
        }
        *text += &rule(&grip_keys(least, true));
        warnings
    }
}
