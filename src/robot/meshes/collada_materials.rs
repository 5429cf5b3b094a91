//! The colours of a Collada file.
//!
//! ```text
//!     instance_geometry  bind_material … instance_material symbol target      what a symbol of the geometry stands for there
//!     material           instance_effect                                      how it looks:
//!     effect             profile_COMMON technique, then phong, lambert, blinn or constant: diffuse (or emission) color r g b a
//!                        transparent (opaque="A_ONE" or "RGB_ZERO") color, transparency float
//!     opacity            A_ONE: a t        RGB_ZERO: 1 − t (0.2126 r + 0.7152 g + 0.0722 b)
//! ```
//!
//! An opacity of almost zero is read as one: an invisible mesh makes no sense, and some programs write transparency instead. Source: Khronos, COLLADA
//! 1.4.1 specification, chapters 7 and 8.

use crate::meshes::collada_elements::{Elements, child, numbers};
use roxmltree::Node;

/// The largest opacity that is taken for one.
const FAINTEST: f32 = 0.05;

/// The colours of a geometry where it is shown.
pub(super) struct Colors<'e, 'd> {
    pub elements: &'e Elements<'d>,
    /// The element that shows the geometry.
    pub instance: Node<'d, 'd>,
}

impl Colors<'_, '_> {
    /// The colour that a symbol of the geometry stands for, if it has one, and whether it is an image.
    pub(super) fn of(&self, symbol: &str) -> (Option<[f32; 4]>, bool) {
        let Some(shader) = self.shader(symbol) else { return (None, false) };
        let is_image = child(shader, "diffuse").is_some_and(|diffuse| child(diffuse, "texture").is_some());
        let color = child(shader, "diffuse").or_else(|| child(shader, "emission")).and_then(color_of);
        let color = color.map(|[r, g, b, a]| {
            let alpha = a * opacity(shader);
            [r, g, b, if alpha > FAINTEST { alpha.min(1.0) } else { 1.0 }]
        });
        (color, is_image)
    }

    /// The element of an effect that says how a symbol looks.
    fn shader(&self, symbol: &str) -> Option<Node<'_, '_>> {
        let mut bindings = self.instance.descendants().filter(|node| node.tag_name().name() == "instance_material");
        let bound = bindings.find(|binding| binding.attribute("symbol") == Some(symbol));
        // Files without bindings use the names of materials themselves.
        let material = match bound {
            Some(binding) => self.elements.target(binding, "target"),
            None => self.elements.named(symbol),
        };
        let effect = self.elements.target(child(material?, "instance_effect")?, "url")?;
        let technique = child(child(effect, "profile_COMMON")?, "technique")?;
        let kinds = ["phong", "lambert", "blinn", "constant"];
        technique.children().find(|shader| kinds.contains(&shader.tag_name().name()))
    }
}

fn color_of(node: Node) -> Option<[f32; 4]> {
    match numbers::<f32>(child(node, "color")?).ok()?[..] {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a, ..] => Some([r, g, b, a]),
        _ => None,
    }
}

fn opacity(shader: Node) -> f32 {
    let Some(transparent) = child(shader, "transparent") else { return 1.0 };
    let amount = child(shader, "transparency").and_then(|amount| child(amount, "float"));
    let amount = amount.and_then(|amount| numbers::<f32>(amount).ok()?.first().copied()).unwrap_or(1.0);
    let [r, g, b, a] = color_of(transparent).unwrap_or([1.0; 4]);
    match transparent.attribute("opaque") {
        Some("RGB_ZERO") => 1.0 - amount * (0.2126 * r + 0.7152 * g + 0.0722 * b),
        _ => a * amount,
    }
}
