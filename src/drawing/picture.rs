//! A picture as data: axes, curves, shaded regions and legend. Drawing it is `render`'s.

use crate::style::Look;

/// Everything that is in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Headline.
    pub title: String,
    /// A line under it.
    pub subtitle: String,
    /// Horizontal axis.
    pub x: Scale,
    /// Vertical axis.
    pub y: Scale,
    /// Regions to the left of a value that are shaded.
    pub bands: Vec<Band>,
    /// The curves, in the groups of the legend.
    pub panels: Vec<Panel>,
    /// Lines of text under the legend.
    pub notes: Vec<String>,
    /// Values of the horizontal axis that a thin tick inside the data area marks.
    pub marks: Vec<f64>,
}

/// Pictures one below the other that share their horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Headline.
    pub title: String,
    /// A line under it.
    pub subtitle: String,
    /// The pictures from top to bottom; those without a subtitle have small titles.
    pub pictures: Vec<Picture>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// A fixed range with round ticks.
    Linear {
        /// The name of its quantity, with the unit.
        label: String,
        /// The two ends.
        range: (f64, f64),
    },
    /// As many decades as the curves need, but not beyond these limits; points outside are not drawn.
    Log {
        /// The name of its quantity, with the unit.
        label: String,
        /// Lower limit.
        least: f64,
        /// Upper limit.
        most: f64,
    },
}

/// A shaded region from the left edge to a value of the horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Its right edge.
    pub below: f64,
    /// How dark: 0 is invisible, 1 is black.
    pub strength: f64,
    /// Its meaning, for the legend.
    pub label: String,
}

/// A group of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Its heading.
    pub heading: String,
    /// Its curves.
    pub series: Vec<Series>,
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name.
    pub label: String,
    /// Colour, marker and line.
    pub look: Look,
    /// Its points, joined in this order.
    pub points: Vec<(f64, f64)>,
    /// A marker at every so-many-th point.
    pub markers_every: usize,
}
