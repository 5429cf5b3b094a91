//! The reasons why two shapes never touch.

/// Why two shapes never touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeverTouch {
    /// Neither moves.
    BothFixed,
    /// A `[[contact.pair]]` says so, on this line.
    Ignored(usize),
    /// No motion of the joints brings them together.
    OutOfReach,
    /// Links of one robot without a joint that moves between them.
    OneBody,
    /// Links of one robot that turn on the same link, each about the axis of its shape, so that the distance of the shapes never changes.
    OneDistance,
    /// Links of one robot with one joint between them.
    Neighbours,
    /// The same only because joints are locked by their limits.
    Locked,
    /// Links of one robot that overlap where all joints are at zero, and also at the start.
    Overlap,
}

impl NeverTouch {
    /// The reason, for people.
    pub fn reason(self) -> String {
        match self {
            NeverTouch::BothFixed => "both are fixed in the world".to_string(),
            NeverTouch::Ignored(line) => format!("ignored by the [[contact.pair]] of line {line}"),
            NeverTouch::OutOfReach => "the joints cannot bring them together".to_string(),
            NeverTouch::OneBody => "no joint moves between them".to_string(),
            NeverTouch::OneDistance => {
                "they turn about their own axes on one link, which keeps their distance".to_string()
            }
            NeverTouch::Neighbours => "one joint joins them".to_string(),
            NeverTouch::Locked => "locked joints hold them together, or leave one joint between them".to_string(),
            NeverTouch::Overlap => "they overlap where all joints are at zero, and at the start".to_string(),
        }
    }

    /// A name for programs.
    pub fn name(self) -> &'static str {
        match self {
            NeverTouch::BothFixed => "both_fixed",
            NeverTouch::Ignored(_) => "ignored",
            NeverTouch::OutOfReach => "out_of_reach",
            NeverTouch::OneBody => "one_body",
            NeverTouch::OneDistance => "one_distance",
            NeverTouch::Neighbours => "neighbours",
            NeverTouch::Locked => "locked",
            NeverTouch::Overlap => "overlap",
        }
    }
}
