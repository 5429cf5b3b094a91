//! The key paths of friction and restitution of links and of their collision shapes.

use crate::scene::parameters::Range;
use crate::scene::parameters::keys::{Keys, MOMENT_LENGTHS};
use crate::scene::parameters::place::{Place, ShapeNumber};
use crate::scene::robot::{Link, Surface};

impl Keys {
    /// The lengths of rolling and spinning friction of a thing.
    pub(crate) fn moments(&mut self, head: &str, of: &str, place: impl Fn(usize) -> Place) {
        for (number, key) in MOMENT_LENGTHS.into_iter().enumerate() {
            self.put(head, &format!("{of}.{key}"), Range::NotNegative, place(number));
        }
    }

    /// The surface of a link called `name`, without numbers that all its shapes have themselves: those of the link would have no effect.
    pub(crate) fn surface_of_link(&mut self, robot: usize, link: usize, name: &str, of: &Link) {
        let counts = |own: &dyn Fn(&Surface) -> bool| of.collisions.iter().any(|shape| !own(&shape.surface));
        if counts(&|own| own.friction.is_some()) {
            let place = Place::LinkFriction { robot, link };
            self.put("link", &format!("{name}.friction"), Range::Friction, place);
        }
        if counts(&|own| own.restitution.is_some()) {
            let place = Place::LinkRestitution { robot, link };
            self.put("link", &format!("{name}.restitution"), Range::Fraction, place);
        }
        for (of, key) in MOMENT_LENGTHS.into_iter().enumerate() {
            if counts(&|own| own.moments[of].is_some()) {
                let place = Place::LinkMoment { robot, link, of };
                self.put("link", &format!("{name}.{key}"), Range::NotNegative, place);
            }
        }
        if counts(&|own| own.velocity.is_some()) {
            let velocity = |axis| Place::LinkSurface { robot, link, axis };
            self.vector("link", &format!("{name}.surface_velocity"), Range::Finite, velocity);
        }
    }

    /// The surface of a collision shape of a link, as far as it has its own.
    pub(crate) fn surface_of_shape(&mut self, head: &str, own: &Surface, place: impl Fn(ShapeNumber) -> Place) {
        let mut put = |is_said: bool, key: &str, range, what| {
            if is_said {
                self.put("link", &format!("{head}.{key}"), range, place(what));
            }
        };
        put(own.friction.is_some(), "friction", Range::Friction, ShapeNumber::Friction);
        put(own.restitution.is_some(), "restitution", Range::Fraction, ShapeNumber::Restitution);
        for (of, key) in MOMENT_LENGTHS.into_iter().enumerate() {
            put(own.moments[of].is_some(), key, Range::NotNegative, ShapeNumber::Moment(of));
        }
        if own.velocity.is_some() {
            let velocity = |axis| place(ShapeNumber::SurfaceVelocity(axis));
            self.vector("link", &format!("{head}.surface_velocity"), Range::Finite, velocity);
        }
    }
}
