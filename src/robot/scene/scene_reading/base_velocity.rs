//! The velocity of a floating base, and its line.

use crate::scene::scene_reading::scene_numbers::VelocityTable;
use crate::scene::scene_reading::toml_text::TomlText;
use toml::Spanned;

/// The velocity of a base (linear, angular) [m/s, rad/s], and its line.
pub fn base_velocity(text: &TomlText, velocity: &Spanned<VelocityTable>) -> ([f64; 6], usize) {
    let [vx, vy, vz] = velocity.get_ref().linear.map(|number| number.0);
    let [wx, wy, wz] = velocity.get_ref().angular.map(|number| number.0);
    ([vx, vy, vz, wx, wy, wz], text.line(&velocity.span()))
}
