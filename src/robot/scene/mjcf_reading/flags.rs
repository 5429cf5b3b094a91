//! Flags of MJCF's `<option>`, attribute by attribute.
//!
//! | flag | read as |
//! |---|---|
//! | `contact`, `gravity` | whether anything touches or falls |
//! | `clampctrl` | whether controls stay in their ranges |
//!
//! Numerical flags of MuJoCo change no motion here. All others are a warning with their line where they are not as by default.
//!
//! Source: MuJoCo documentation, XML reference, `option/flag`.

use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use nalgebra::Vector3;

/// Flags whose parts of the motion are in it by default.
const PARTS: [&str; 9] =
    ["limit", "frictionloss", "equality", "actuation", "constraint", "passive", "spring", "damper", "filterparent"];

/// Flags of how MuJoCo solves, measures or speeds up.
const WITHOUT_EFFECT: [&str; 16] = [
    "warmstart",
    "refsafe",
    "sensor",
    "midphase",
    "eulerdamp",
    "autoreset",
    "nativeccd",
    "multiccd",
    "island",
    "energy",
    "fwdinv",
    "invdiscrete",
    "sleep",
    "diagexact",
    "ipc",
    "speculative",
];

impl Reader<'_> {
    /// What a file switches off or on.
    pub fn flags(&mut self, flag: &Element) {
        for (name, value) in &flag.attributes {
            let is_off = value == "disable";
            match name.as_str() {
                "contact" => self.touches &= !is_off,
                "clampctrl" => self.clamps_controls &= !is_off,
                "gravity" if is_off => self.gravity = Vector3::zeros(),
                "gravity" => {}
                "filterparent" if is_off => {
                    self.odd(
                        flag,
                        "filterparent=\"disable\" is not read: bodies do not touch their parents".to_string(),
                    );
                }
                name if PARTS.contains(&name) && is_off => {
                    self.odd(flag, format!("{name}={value:?} is not read; --without leaves parts out"));
                }
                "override" if !is_off => {
                    self.odd(
                        flag,
                        "override=\"enable\" is not read: contacts have the friction of their geoms".to_string(),
                    );
                }
                name if PARTS.contains(&name) || name == "override" => {}
                name if WITHOUT_EFFECT.contains(&name) => self.ignored_attribute(flag, name),
                _ => self.odd(flag, format!("{name} of <flag> is not known, and not read")),
            }
        }
    }
}
