//! Friction of geoms of MJCF: how many ways of slipping it resists, and the coefficients.
//!
//! Of two geoms that touch, the one of the higher `priority` decides; of the same priority the larger `condim` and the larger coefficients count:
//!
//! | condim | resists |
//! |---|---|
//! | 1 | nothing |
//! | 3 | sliding: μ |
//! | 4 | and spinning: σ (m) |
//! | 6 | and rolling: ρ (m) |
//!
//! `friction` has μ, σ and ρ in this order. MuJoCo joins them in one elliptic cone; here each has its own bound. A scene file has one value for each
//! surface, of which the larger counts: a [`Grip`] alone, against its like. Pairs for which that is not the value of the file are in [`super::contacts`].
//!
//! Source: MuJoCo documentation, Computation, "Contact parameters".

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::tree::Element;
use std::collections::HashSet;

/// Friction of a geom that says none: μ, σ (m), ρ (m).
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];

/// Ways of slipping that a geom resists by default.
const CONDIM: f64 = 3.0;

/// The friction of a geom, or of several as one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grip {
    priority: f64,
    condim: f64,
    coefficients: [f64; 3],
}

impl Grip {
    /// The friction of a geom, with its defaults.
    pub fn of(geom: &Element) -> Result<Grip, SceneError> {
        let mut coefficients = FRICTION;
        let given = geom.list("friction", 1, 3)?.unwrap_or_default();
        if given.iter().any(|number| *number < 0.0) {
            return Err(geom.error("friction", "a coefficient is negative".to_string()));
        }
        coefficients.iter_mut().zip(given).for_each(|(own, given)| *own = given);
        let condim = geom.number("condim")?.unwrap_or(CONDIM);
        if ![1.0, 3.0, 4.0, 6.0].contains(&condim) {
            return Err(geom.error("condim", "it is none of 1, 3, 4 and 6".to_string()));
        }
        Ok(Grip { priority: geom.number("priority")?.unwrap_or(0.0), condim, coefficients })
    }

    /// The friction of a `<pair>`, and whether it is the same in all directions; otherwise the smaller coefficients count. Its defaults are not its geoms'.
    pub fn of_pair(pair: &Element) -> Result<(Grip, bool), SceneError> {
        let [sliding, spinning, rolling] = FRICTION;
        let mut all = [sliding, sliding, spinning, rolling, rolling];
        let given = pair.list("friction", 1, 5)?.unwrap_or_default();
        all.iter_mut().zip(given).for_each(|(own, given)| *own = given);
        let [one, other, spinning, along, across] = all;
        let condim = pair.number("condim")?.unwrap_or(CONDIM);
        let is_round = (condim < 3.0 || one == other) && (condim < 6.0 || along == across);
        Ok((Grip { priority: 0.0, condim, coefficients: [one.min(other), spinning, along.min(across)] }, is_round))
    }

    /// The friction of two geoms that touch.
    pub fn with(&self, other: &Grip) -> Grip {
        if self.priority != other.priority {
            return if self.priority > other.priority { *self } else { *other };
        }
        let coefficients = [0, 1, 2].map(|way: usize| self.coefficients[way].max(other.coefficients[way]));
        Grip { condim: self.condim.max(other.condim), coefficients, ..*self }
    }

    /// μ, ρ (m) and σ (m) of a contact with this friction.
    pub fn values(&self) -> [f64; 3] {
        let [sliding, spinning, rolling] = self.coefficients;
        [(3.0, sliding), (6.0, rolling), (4.0, spinning)]
            .map(|(least, value)| if self.condim >= least { value } else { 0.0 })
    }
}

/// The keys of a scene file for the values of a [`Grip`]; those of moments that are zero are left out, unless `all` are asked for.
pub(crate) fn grip_keys(values: [f64; 3], all: bool) -> String {
    let [sliding, rolling, spinning] = values;
    let mut text = format!("friction = {sliding:?}\n");
    for (key, value) in [("rolling_friction", rolling), ("spinning_friction", spinning)] {
        if all || value != 0.0 {
            text += &format!("{key} = {value:?}\n");
        }
    }
    text
}

/// The geoms that any `<pair>` names.
pub(crate) fn paired_geoms(root: &Element) -> HashSet<String> {
    let pairs = root.all("contact").flat_map(|contact| contact.all("pair"));
    pairs.flat_map(|pair| ["geom1", "geom2"].map(|end| pair.text(end).map(str::to_string))).flatten().collect()
}
