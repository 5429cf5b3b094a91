//! Small blows that the friction of joints bears: the joints would slip by too little to matter, and stop.
//!
//! ```text
//!     a joint at rest stays at rest if    ½ P² D/τ < d             P: the impulse that holds it [N m s or N s];  D: its mobility alone [1/(kg m²) or 1/kg]
//!                                                                  τ: its friction [N m or N];  d: the slide that may be left out (rad or m)
//! ```
//!
//! An impact is infinitely short, and friction gives no impulse in it. Each blow makes every joint slip that friction holds, by the rate `D P`; the slides
//! end after `½ P² D/τ`. An arm of seven joints on which a finger meets its limit at 1e-9 rad/s slips seven times, which makes the finger leave its limit
//! and meet it again. A joint whose load takes nine tenths of its friction slides ten times as far: d is a tenth of the height that accumulating impacts may
//! leave.

use crate::events::effects::decision::Scene;
use crate::events::effects::immobile::at_dead_points;
use crate::instant::holding::blocks::{Block, Rows};
use crate::instant::holding::elements::ElementJoint;
use crate::mechanism::motion::state::State;

/// d over the height that accumulating impacts may leave.
const SLIDE: f64 = 0.1;

/// A joint at rest that friction holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Brake {
    /// Its number among the elements, and its freedom.
    pub joint: usize,
    pub freedom: usize,
    /// τ [N m or N].
    friction: f64,
    /// d (rad or m).
    most: f64,
}

impl Brake {
    /// The joints at rest that friction holds away from their limits, where impacts may leave this height (rad or m). Joints at dead points of loops turn
    /// round by themselves.
    pub fn all(scene: &mut Scene, state: &State, height: f64) -> Vec<Brake> {
        let holds = |(joint, of): (usize, &ElementJoint)| {
            let held = of.friction > 0.0 && of.rate(state) == 0.0 && of.side(of.position(state)).is_none();
            let (freedom, friction) = (of.coordinate.freedom, of.friction);
            held.then_some(Brake { joint, freedom, friction, most: SLIDE * height })
        };
        let mut all: Vec<Brake> = scene.elements.joints.iter().enumerate().filter_map(holds).collect();
        let freedoms: Vec<usize> = all.iter().map(|brake| brake.freedom).collect();
        let dead = at_dead_points(scene.whole, scene.response, state, &freedoms);
        all.retain(|brake| !dead.contains(&brake.freedom));
        all
    }

    /// Its block in a mechanism of this many freedoms, which holds.
    pub fn block(&self, count: usize) -> Block {
        Block::of_joint(self.joint, self.freedom, count, 1.0, [f64::NEG_INFINITY, f64::INFINITY])
    }

    /// Whether it bears an impulse, by its row among others.
    pub fn bears(&self, rows: &Rows, row: usize, impulse: f64) -> bool {
        self.slide(rows, row, impulse) < self.most
    }

    /// The slide that is left out for an impulse, by its row among others (rad or m).
    pub fn slide(&self, rows: &Rows, row: usize, impulse: f64) -> f64 {
        0.5 * impulse * impulse * rows.square[(row, row)] / self.friction
    }
}
