//! Colours and markers: the palette of Okabe and Ito, which people with any of the usual colour deficiencies can tell
//! apart, and a marker of its own for every method, for prints without colour.
//!
//! Ours are filled and solid, the comparators hollow and dashed, other programs hollow and dotted.
//!
//! Source: M. Okabe, K. Ito, Color Universal Design, 2008 (jfly.uni-koeln.de/color).

/// Red, green, blue.
pub type Color = (u8, u8, u8);

const BLACK: Color = (0, 0, 0);
pub const ORANGE: Color = (230, 159, 0);
pub const SKY_BLUE: Color = (86, 180, 233);
const GREEN: Color = (0, 158, 115);
pub const BLUE: Color = (0, 114, 178);
pub const VERMILLION: Color = (213, 94, 0);
#[cfg(feature = "plot")]
pub const YELLOW: Color = (240, 228, 66);
const PURPLE: Color = (204, 121, 167);
const GREY: Color = (130, 130, 130);

/// The shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// No marker: the line is enough.
    None,
    /// ○
    Circle,
    /// □
    Square,
    /// △
    Triangle,
    /// ▽
    TriangleDown,
    /// ◇
    Diamond,
    /// ×
    Cross,
    /// ＋
    Plus,
    /// A star of five points.
    Star,
}

/// How a line is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
}

/// How a curve looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Colour of line and marker.
    pub color: Color,
    /// Marker.
    pub marker: Marker,
    /// Whether the marker is filled.
    pub filled: bool,
    /// Line.
    pub dash: Dash,
    /// Width of the line in pixels.
    pub width: u32,
}

/// The look of a method by its name in CSV files; `foreign` counts the methods of other programs.
pub fn look(method: &str, foreign: usize) -> Look {
    let ours = |color, marker| Look { color, marker, filled: true, dash: Dash::Solid, width: 2 };
    let rival = |color, marker| Look { color, marker, filled: false, dash: Dash::Dashed, width: 2 };
    match method {
        "over-events" => ours(BLACK, Marker::TriangleDown),
        "lobatto-2" => ours(SKY_BLUE, Marker::Triangle),
        "lobatto-3" => ours(PURPLE, Marker::Square),
        "lobatto-5" => ours(GREEN, Marker::Diamond),
        "lobatto-9" => ours(BLUE, Marker::Circle),
        "lobatto-tolerance" => Look { width: 3, ..ours(VERMILLION, Marker::Star) },
        "lobatto-unestimated" => ours(ORANGE, Marker::Star),
        "euler" => rival(GREY, Marker::Plus),
        "rk4" => rival(ORANGE, Marker::TriangleDown),
        "dop853" => rival(BLACK, Marker::Circle),
        "dop853-regularised" => rival(VERMILLION, Marker::Cross),
        _ => {
            const COLORS: [Color; 6] = [PURPLE, SKY_BLUE, ORANGE, GREEN, VERMILLION, BLUE];
            const MARKERS: [Marker; 5] =
                [Marker::Cross, Marker::Square, Marker::Diamond, Marker::Triangle, Marker::Plus];
            let (color, marker) = (COLORS[foreign % COLORS.len()], MARKERS[foreign % MARKERS.len()]);
            Look { color, marker, filled: false, dash: Dash::Dotted, width: 2 }
        }
    }
}

/// The look of the curve with this number in a picture: colours first, then kinds of line.
pub fn curve(number: usize) -> Look {
    const COLORS: [Color; 7] = [BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY_BLUE, BLACK];
    const DASHES: [Dash; 3] = [Dash::Solid, Dash::Dashed, Dash::Dotted];
    Look {
        color: COLORS[number % COLORS.len()],
        marker: Marker::None,
        filled: false,
        dash: DASHES[number / COLORS.len() % DASHES.len()],
        width: 2,
    }
}
