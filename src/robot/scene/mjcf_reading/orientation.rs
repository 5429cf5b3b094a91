//! Frames of MJCF: `pos` with `quat` (w, x, y, z), `axisangle`, `euler`, `xyaxes` or `zaxis`; and roll, pitch and yaw of a rotation.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::numbers::{normalised, turn_of_z, unrounded};
use crate::scene::robot::Pose;
use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3, Vector4};

/// What `<compiler>` says of angles.
#[derive(Clone, Debug)]
pub(crate) struct Angles {
    /// rad of a unit of the file.
    pub unit: f64,
    /// Axes of `euler` one after the other: of the frame that has turned, in capital letters of the one that has not.
    pub sequence: String,
}

impl Angles {
    /// Those of a file.
    pub fn of(root: &Element) -> Self {
        let compiler = |name: &str| root.all("compiler").filter_map(|one| one.text(name)).last();
        let unit = if compiler("angle") == Some("radian") { 1.0 } else { 1_f64.to_radians() };
        Angles { unit, sequence: compiler("eulerseq").unwrap_or("xyz").to_string() }
    }

    /// The frame of an element.
    pub fn pose(&self, element: &Element) -> Result<Pose, SceneError> {
        let translation = Translation3::from(element.vector("pos")?.unwrap_or_default());
        Ok(Pose::from_parts(translation, self.rotation(element)?))
    }

    /// The rotation of an element.
    pub fn rotation(&self, element: &Element) -> Result<Rotation3<f64>, SceneError> {
        let zero = |name: &str| element.error(name, "it has no direction".to_string());
        if let Some(quat) = element.list("quat", 4, 4)? {
            return quaternion(&quat).ok_or_else(|| zero("quat"));
        }
        if let Some(given) = element.list("axisangle", 4, 4)? {
            let axis = normalised(&Vector3::new(given[0], given[1], given[2])).ok_or_else(|| zero("axisangle"))?;
            return Ok(Rotation3::from_axis_angle(&Unit::new_unchecked(axis), unrounded(given[3] * self.unit)));
        }
        if let Some(angles) = element.vector("euler")? {
            let mut turned = Rotation3::identity();
            for (letter, angle) in self.sequence.chars().zip(angles.iter()) {
                let axis = match letter.to_ascii_lowercase() {
                    'x' => Vector3::x_axis(),
                    'y' => Vector3::y_axis(),
                    _ => Vector3::z_axis(),
                };
                let one = Rotation3::from_axis_angle(&axis, unrounded(angle * self.unit));
                turned = if letter.is_ascii_lowercase() { turned * one } else { one * turned };
            }
            return Ok(turned);
        }
        if let Some(given) = element.list("xyaxes", 6, 6)? {
            let x = normalised(&Vector3::from_column_slice(&given[..3])).ok_or_else(|| zero("xyaxes"))?;
            let y = Vector3::from_column_slice(&given[3..]);
            let y = normalised(&(y - x * x.dot(&y))).ok_or_else(|| zero("xyaxes"))?;
            return Ok(Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)])));
        }
        if let Some(z) = element.vector("zaxis")? {
            return Ok(turn_of_z(&normalised(&z).ok_or_else(|| zero("zaxis"))?));
        }
        Ok(Rotation3::identity())
    }
}

/// The rotation of a quaternion w, x, y, z of any length but zero.
pub(crate) fn quaternion(wxyz: &[f64]) -> Option<Rotation3<f64>> {
    let &[w, x, y, z] = wxyz else { return None };
    let unit = normalised(&Vector4::new(x, y, z, w))?;
    Some(UnitQuaternion::new_unchecked(Quaternion::from(unit)).to_rotation_matrix())
}

/// Roll, pitch and yaw (rad) that give the rotation again to rounding, at a pitch of 90° too: the roll follows from the yaw that was chosen.
pub(crate) fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> [f64; 3] {
    let r = rotation.matrix();
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let pitch = (-r[(2, 0)]).atan2(r[(0, 0)].hypot(r[(1, 0)]));
    let (sin, cos) = yaw.sin_cos();
    let roll = (sin * r[(0, 2)] - cos * r[(1, 2)]).atan2(cos * r[(1, 1)] - sin * r[(0, 1)]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roll_pitch_and_yaw_give_the_rotation_again_also_where_the_pitch_is_a_right_angle() {
        for pitch in
            [0.3, 1.2, std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2 - 1e-7, -std::f64::consts::FRAC_PI_2]
        {
            for (roll, yaw) in [(0.0, 0.0), (0.4, -2.0), (-3.0, 1.0)] {
                let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
                let [roll, pitch, yaw] = roll_pitch_yaw(&rotation);
                let again = Rotation3::from_euler_angles(roll, pitch, yaw);
                // Some roundings of sines and cosines.
                assert!((again.matrix() - rotation.matrix()).amax() < 1e-15, "{roll} {pitch} {yaw}");
            }
        }
    }
}
