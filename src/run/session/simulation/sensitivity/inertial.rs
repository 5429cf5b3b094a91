//! How the figures of a mechanism change with the mass, the centre of mass and the inertia of a link: without models of other numbers.
//!
//! ```text
//!     ∂m = 1     ∂p = c       ∂P = c cᵀ                  by the mass m of the link
//!                ∂p = m e     ∂P = m (e cᵀ + c eᵀ)       by its centre of mass c, along the axis e
//!                             ∂P = ½ tr(∂I) 1 − ∂I       by its inertia about c,  ∂I = R E Rᵀ
//! ```
//!
//! m, p and P belong to the body that carries the link ([`crate::derivatives::equations::figures`]), in the frame of its head link, as c and e do.
//! R has the axes of the inertial frame. E is one for the number and its mirror image, and zero elsewhere.

use crate::derivatives::equations::figures::mass_entry;
use crate::mechanism::description::joint::{JointKind, Pose};
use crate::model::Model as Description;
use crate::scene::{InertialNumber, Parameter as Number, Scene};
use nalgebra::{Matrix3, Point3, Vector3};

/// The derivatives of all figures by a number of the inertia of a link; `None` for other numbers, and where more than the inertia of a body depends on
/// it: floating bodies have their frames at their centres of mass, and links without mass may be held still.
pub(super) fn slopes(
    description: &Description,
    frames: &[Pose],
    scene: &Scene,
    number: &Number,
    figures: usize,
) -> Option<Vec<f64>> {
    let ([robot, link], number) = number.as_inertial()?;
    let mechanism = &description.mechanism;
    let inertial = scene.robots.get(robot)?.robot.links.get(link)?.inertial.as_ref()?;
    let place = description.links.get(description.robots.get(robot)?.links.clone())?.get(link)?;
    if inertial.mass <= 0.0 {
        return None;
    }
    let mut slopes = vec![0.0; figures];
    let Some(body) = place.body else { return Some(slopes) };
    if mechanism.bodies.get(body)?.joint.kind == JointKind::Floating {
        return None;
    }
    let in_head = frames.get(body)?.inverse() * place.in_body;
    let center = (in_head * Point3::from(inertial.origin.translation.vector)).coords;
    let (mass, moment, second) = match number {
        InertialNumber::Mass => (1.0, center, center * center.transpose()),
        InertialNumber::CenterOfMass(axis) => {
            let moment = inertial.mass * in_head.rotation.matrix().column(axis);
            (0.0, moment, moment * center.transpose() + center * moment.transpose())
        }
        InertialNumber::Inertia(row, column) => {
            let mut of_entry = Matrix3::zeros();
            (of_entry[(row, column)], of_entry[(column, row)]) = (1.0, 1.0);
            let axes = (in_head.rotation * inertial.origin.rotation).into_inner();
            let turned = axes * of_entry * axes.transpose();
            (0.0, Vector3::zeros(), Matrix3::identity() * (0.5 * turned.trace()) - turned)
        }
    };
    let own = std::iter::once(&mass).chain(&moment).chain(&second);
    slopes.get_mut(mass_entry(body)..)?.iter_mut().zip(own).for_each(|(slope, own)| *slope = *own);
    Some(slopes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivatives::events::parameter::WIDTH;
    use crate::mechanism::motion::state::State;
    use crate::session::model::{Model, number_of};
    use crate::session::simulation::Simulation;
    use crate::session::simulation::sensitivity::parameters::{Numbers, Varying};
    use std::path::Path;

    #[test]
    fn slopes_by_masses_centres_and_inertias_are_those_of_models_with_other_numbers() {
        let mut compared = 0;
        for file in [
            "arm7.urdf",
            "humanoid.urdf",
            "gantry.urdf",
            "spherical_chain.urdf",
            "cart_pole_light.toml",
            "four_bar_1.toml",
        ] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file);
            let model = Model::load(path).expect("a model");
            let simulation = Simulation::new(&model);
            let start = simulation.look(State::clone).expect("a start");
            let numbers = Numbers::of(&simulation, &start).expect("numbers");
            let Numbers { scene, all, frames, figures, bounds, .. } = &numbers;
            for number in all {
                let own = slopes(model.description(), frames, scene, number, figures.len());
                let (Some(own), Ok((number, value))) = (own, number_of(scene, all, number.key())) else { continue };
                let varying = Varying { key: number.key(), scene, number, value, bounds: *bounds, figures };
                // Light links have no inertias that are much larger than theirs.
                let tried = [1.0, 1e-2, 1e-4].into_iter().find_map(|narrower| {
                    Some((narrower, simulation.by_differences(&varying, &start, narrower * WIDTH).ok()?))
                });
                // Inertias of points of mass have no differences: they are not negative.
                let Some((narrower, other)) = tried else { continue };
                let size = other.figures.iter().fold(1e-3, |size: f64, slope| size.max(slope.abs()));
                // Figures of some units have roundings of 1e-16, over a width of 4e-3 of numbers that may be smaller.
                for (entry, (own, other)) in own.iter().zip(&other.figures).enumerate() {
                    let apart = (own - other).abs() / size;
                    assert!(apart < 1e-10 / narrower, "{file}, {}, {entry}: {own} and {other}", number.key());
                }
                assert!(other.others.is_empty() && other.position.amax() + other.velocity.amax() == 0.0, "{file}");
                compared += 1;
            }
        }
        assert!(compared > 100, "{compared} numbers");
    }
}
