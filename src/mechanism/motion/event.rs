//! Events: the instants at which a motion is not smooth; and the states of joints between them.

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum EventKind {
    /// A joint runs into its limit.
    LimitImpact,
    /// A joint comes to rest on its limit, or a contact closes; at once or after infinitely many impacts.
    Rest,
    /// A joint leaves its limit, on which it rested, or two bodies part.
    Release,
    /// Friction holds a joint or a contact.
    Stick,
    /// Friction lets a joint or a contact go.
    Slip,
    /// A joint with friction turns round without a pause.
    Reversal,
    /// The effort of a motor reaches its bound.
    Saturation,
    /// It comes back from its bound.
    Unsaturation,
    /// Two bodies meet.
    ContactImpact,
}

impl EventKind {
    /// All of them, in the order of reports.
    pub const ALL: [EventKind; 9] = [
        EventKind::LimitImpact,
        EventKind::Rest,
        EventKind::Release,
        EventKind::Stick,
        EventKind::Slip,
        EventKind::Reversal,
        EventKind::Saturation,
        EventKind::Unsaturation,
        EventKind::ContactImpact,
    ];

    /// Its name in reports and logs.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::LimitImpact => "limit_impact",
            EventKind::Rest => "rest",
            EventKind::Release => "release",
            EventKind::Stick => "stick",
            EventKind::Slip => "slip",
            EventKind::Reversal => "reversal",
            EventKind::Saturation => "saturation",
            EventKind::Unsaturation => "unsaturation",
            EventKind::ContactImpact => "contact_impact",
        }
    }
}

/// One event of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When (s).
    pub time: f64,
    /// What.
    pub kind: EventKind,
    /// The body whose joint it is, or one of the bodies that touch.
    pub body: usize,
    /// The pair that touches, where it is one ([`crate::description::contact::ContactPair::number`]).
    pub pair: Option<usize>,
    /// Impulse of an impact: along the coordinate, positive into the allowed range [N m s or N s]; for a contact along its normal.
    pub impulse: Option<f64>,
}

/// How often each kind of event has happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EventCounts([usize; EventKind::ALL.len()]);

impl EventCounts {
    /// Counts one.
    pub fn count(&mut self, kind: EventKind) {
        self.0[kind as usize] += 1;
    }

    /// The number of events of one kind.
    pub fn of(&self, kind: EventKind) -> usize {
        self.0[kind as usize]
    }

    /// The number of events of all kinds.
    pub fn total(&self) -> usize {
        self.0.iter().sum()
    }
}

/// A bound of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The smallest position.
    Lower,
    /// The largest.
    Upper,
}

impl Side {
    /// Its name in reports and logs.
    pub fn name(self) -> &'static str {
        match self {
            Side::Lower => "lower",
            Side::Upper => "upper",
        }
    }
}

/// The state of friction in a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrictionState {
    /// It holds the joint.
    Stuck,
    /// It brakes the joint.
    Sliding,
}

impl FrictionState {
    /// Its name in reports and logs.
    pub fn name(self) -> &'static str {
        match self {
            FrictionState::Stuck => "stuck",
            FrictionState::Sliding => "sliding",
        }
    }
}

/// The state of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointStatus {
    /// The limit on which it rests.
    pub limit: Option<Side>,
    /// The state of its friction, if it has any.
    pub friction: Option<FrictionState>,
    /// The effort of its motor, if it has one [N m or N].
    pub effort: Option<f64>,
}
