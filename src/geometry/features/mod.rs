//! Vertices, edges, faces, rims and sides: names, parts, borders; closed forms of pairs of them.

pub(crate) mod arcs;
pub(crate) mod both;
pub(crate) mod crossing;
pub(crate) mod feature;
pub(crate) mod forms;
pub(crate) mod guesses;
pub(crate) mod lens;
pub(crate) mod meet;
pub(crate) mod place;
pub(crate) mod rims;
pub(crate) mod slab;
