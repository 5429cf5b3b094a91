//! The part of URDF that is read: the elements, their attributes, and what each attribute must hold.
//!
//! The table is the whole definition; `clean.rs` applies it. Everything else is left out, with a warning.

/// An element of URDF.
pub(crate) struct Schema {
    pub name: &'static str,
    pub attributes: &'static [Attribute],
    pub children: &'static [Child],
}

/// An attribute of an element.
pub(crate) struct Attribute {
    pub name: &'static str,
    pub content: Content,
    pub presence: Presence,
}

/// The content of an attribute.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Content {
    /// Any text.
    Text,
    /// A given number of finite numbers.
    Numbers(usize),
    /// A number that may be infinite: no limit.
    Limit,
}

/// Whether an attribute must be there.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Presence {
    /// Without it the element is meaningless.
    Required,
    /// URDF has a default.
    Optional,
    /// URDF has this default, but viewers want it written.
    Default(&'static str),
    /// URDF requires it; where it is missing this value is plainly meant (with a warning).
    Assumed(&'static str),
}

/// A child element and how often it may appear.
pub(crate) struct Child {
    pub schema: &'static Schema,
    pub count: Count,
}

/// How often a child element may appear.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Count {
    One,
    AtMostOne,
    Any,
}

const fn attribute(name: &'static str, content: Content, presence: Presence) -> Attribute {
    Attribute { name, content, presence }
}

const fn leaf(name: &'static str, attributes: &'static [Attribute]) -> Schema {
    Schema { name, attributes, children: &[] }
}

const fn child(schema: &'static Schema, count: Count) -> Child {
    Child { schema, count }
}

use Content::{Limit, Numbers, Text};
use Count::{Any, AtMostOne, One};
use Presence::{Assumed, Default, Optional, Required};

pub(crate) static ROBOT: Schema = Schema {
    name: "robot",
    attributes: &[attribute("name", Text, Optional), attribute("version", Text, Optional)],
    children: &[child(&LINK, Any), child(&JOINT, Any), child(&LOOP_JOINT, Any), child(&MATERIAL, Any)],
};

static LINK: Schema = Schema {
    name: "link",
    attributes: &[attribute("name", Text, Required)],
    children: &[child(&INERTIAL, AtMostOne), child(&VISUAL, Any), child(&COLLISION, Any)],
};

static INERTIAL: Schema = Schema {
    name: "inertial",
    attributes: &[],
    children: &[child(&ORIGIN, AtMostOne), child(&MASS, One), child(&INERTIA, One)],
};

static ORIGIN: Schema = leaf(
    "origin",
    &[
        attribute("xyz", Numbers(3), Optional),
        attribute("rpy", Numbers(3), Optional),
        attribute("quat_xyzw", Numbers(4), Optional),
    ],
);

static MASS: Schema = leaf("mass", &[attribute("value", Numbers(1), Required)]);

static INERTIA: Schema = leaf(
    "inertia",
    &[
        attribute("ixx", Numbers(1), Required),
        attribute("ixy", Numbers(1), Assumed("0")),
        attribute("ixz", Numbers(1), Assumed("0")),
        attribute("iyy", Numbers(1), Required),
        attribute("iyz", Numbers(1), Assumed("0")),
        attribute("izz", Numbers(1), Required),
    ],
);

static VISUAL: Schema = Schema {
    name: "visual",
    attributes: &[attribute("name", Text, Optional)],
    children: &[child(&ORIGIN, AtMostOne), child(&GEOMETRY, One), child(&MATERIAL, AtMostOne)],
};

static COLLISION: Schema = Schema {
    name: "collision",
    attributes: &[attribute("name", Text, Optional)],
    children: &[child(&ORIGIN, AtMostOne), child(&GEOMETRY, One)],
};

pub(crate) static GEOMETRY: Schema = Schema {
    name: "geometry",
    attributes: &[],
    children: &[
        child(&BOX, AtMostOne),
        child(&CYLINDER, AtMostOne),
        child(&SPHERE, AtMostOne),
        child(&CAPSULE, AtMostOne),
        child(&ELLIPSOID, AtMostOne),
        child(&MESH, AtMostOne),
    ],
};

static BOX: Schema = leaf("box", &[attribute("size", Numbers(3), Required)]);
static CYLINDER: Schema =
    leaf("cylinder", &[attribute("radius", Numbers(1), Required), attribute("length", Numbers(1), Required)]);
static SPHERE: Schema = leaf("sphere", &[attribute("radius", Numbers(1), Required)]);
static CAPSULE: Schema =
    leaf("capsule", &[attribute("radius", Numbers(1), Required), attribute("length", Numbers(1), Required)]);
static ELLIPSOID: Schema = leaf("ellipsoid", &[attribute("radii", Numbers(3), Required)]);
static MESH: Schema = leaf("mesh", &[attribute("filename", Text, Required), attribute("scale", Numbers(3), Optional)]);

static MATERIAL: Schema = Schema {
    name: "material",
    attributes: &[attribute("name", Text, Default(""))],
    children: &[child(&COLOR, AtMostOne)],
};

static COLOR: Schema = leaf("color", &[attribute("rgba", Numbers(4), Required)]);

static JOINT: Schema = Schema {
    name: "joint",
    attributes: &[attribute("name", Text, Required), attribute("type", Text, Required)],
    children: &[
        child(&ORIGIN, AtMostOne),
        child(&PARENT, One),
        child(&CHILD, One),
        child(&AXIS, AtMostOne),
        child(&LIMIT, AtMostOne),
        child(&DYNAMICS, AtMostOne),
        child(&MIMIC, AtMostOne),
        child(&THREAD_PITCH, AtMostOne),
    ],
};

static LOOP_JOINT: Schema = Schema {
    name: "loop_joint",
    attributes: &[attribute("name", Text, Required), attribute("type", Text, Required)],
    children: &[child(&LINK1, One), child(&LINK2, One), child(&AXIS, AtMostOne), child(&DYNAMICS, AtMostOne)],
};

static LINK1: Schema = leaf("link1", LOOP_END);
static LINK2: Schema = leaf("link2", LOOP_END);
const LOOP_END: &[Attribute] = &[
    attribute("link", Text, Required),
    attribute("xyz", Numbers(3), Optional),
    attribute("rpy", Numbers(3), Optional),
];

static PARENT: Schema = leaf("parent", &[attribute("link", Text, Required)]);
static CHILD: Schema = leaf("child", &[attribute("link", Text, Required)]);
static AXIS: Schema = leaf("axis", &[attribute("xyz", Numbers(3), Required)]);
static LIMIT: Schema = leaf(
    "limit",
    &[
        attribute("lower", Limit, Optional),
        attribute("upper", Limit, Optional),
        attribute("effort", Limit, Assumed("0")),
        attribute("velocity", Limit, Assumed("0")),
    ],
);
static DYNAMICS: Schema = leaf(
    "dynamics",
    &[
        attribute("damping", Numbers(1), Optional),
        attribute("friction", Numbers(1), Optional),
        attribute("armature", Numbers(1), Optional),
    ],
);
static THREAD_PITCH: Schema = leaf("thread_pitch", &[attribute("value", Numbers(1), Required)]);
static MIMIC: Schema = leaf(
    "mimic",
    &[
        attribute("joint", Text, Required),
        attribute("multiplier", Numbers(1), Optional),
        attribute("offset", Numbers(1), Optional),
    ],
);
