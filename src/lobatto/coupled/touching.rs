//! The closed contacts of a mechanism in space, in the coupled system: at all stages of a step, or at one configuration.
//!
//! ```text
//!     a step            gaps φ_i and creeps, gradients at the columns' stages, pushes n − μ t at the rows'       [`crate::equations::touches`]
//!     its end           H dv = G̃ᵀ π,  G (v + dv) = 0,  G̃ = n − μ t with t of the last stage                      (2.5.11h) with friction
//!     dissipated        h Σ_k b_k Λ_k μ t_k · u_k + π μ t_s · u_s   [J],   π = h b_s Λ_s       and the work of belts likewise
//! ```
//!
//! The change of friction as slips turn is in rows of its own, after the rows of the springs: `T_k = R_k Σ_i (Ā B)_ki e_i · η_i` with the direction e
//! across the slip, as the tension of a damper is; likewise for the torques of rolling friction. It is in the matrix alone, and converged steps do not depend on it.

use crate::equations::braking::Lean;
use crate::equations::friction_moments::FrictionMoments;
use crate::equations::slips::{BodyRate, StageMixing};
use crate::equations::spatial_loops::Moved;
use crate::equations::touches::SpatialTouch;
use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::lanes::Lanes;
use crate::plan::elimination::TWIST;
use crate::stages::start::Start;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::contact::TouchJoint;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use std::ops::Range;

/// The closed contacts, in the order of their equations.
#[derive(Clone)]
pub struct Touching<V> {
    touches: Vec<SpatialTouch<V>>,
    /// For every contact that friction holds the first contact that friction brakes on one of its bodies. Its normal forces bear what the tangent along
    /// its normal could bear as well, and no other: with it one row of the two is implied in any world, and not a part of both.
    braked_beside: Vec<Option<usize>>,
    /// For every body whether it has rolling and whether it has sliding contacts, and its rates for both: the rates of the scheme, and the rates of
    /// slips.
    moving: Vec<[bool; 2]>,
    rates: Vec<[[BodyRate<V>; 2]; 2]>,
    /// The coefficients of the scheme that velocities need, in a step with slips or rolling contacts.
    mixing: Option<StageMixing<V>>,
    step: f64,
    /// One entry a contact if any has friction: in a step the friction at its end, at one configuration the directions of the multipliers if they are
    /// `leaning`.
    leans: Vec<Lean>,
    leaning: bool,
}

impl<V: Lanes> Touching<V> {
    /// The contacts of a mechanism, at all stages of a scheme, or at one configuration if `tableau` is `None`.
    pub(crate) fn new(mechanism: &Mechanism, tableau: Option<&Tableau>) -> Self {
        let touches = SpatialTouch::all(&mechanism.touches, mechanism.gravity.norm());
        let mut moving = vec![[false; 2]; mechanism.bodies.len()];
        for touch in touches.iter().filter(|touch| touch.feels_slip()) {
            let [scheme, slips] = touch.moments().map_or([false; 2], |moments| moments.kinds_of_rates());
            for body in touch.bodies().into_iter().flatten() {
                moving[body][touch.kind_of_rate()] = true;
                moving[body] = [moving[body][0] | scheme, moving[body][1] | slips];
            }
        }
        let rubs = touches.iter().any(SpatialTouch::brakes);
        let braked = |joint: &TouchJoint| {
            let is_beside = |other: &TouchJoint| other.touch.friction() != 0.0 && other.shares_a_body(joint);
            let holds = mechanism.holds_beside_rubbing(joint);
            mechanism.touches.iter().position(is_beside).filter(|_| holds)
        };
        Touching {
            braked_beside: mechanism.touches.iter().map(braked).collect(),
            mixing: tableau.filter(|_| touches.iter().any(SpatialTouch::feels_slip)).map(StageMixing::new),
            leans: vec![Lean::default(); if rubs { touches.len() } else { 0 }],
            leaning: false,
            rates: vec![[[BodyRate::zero(); 2]; 2]; moving.len()],
            moving,
            step: 0.0,
            touches,
        }
    }

    /// Whether there are no contacts.
    pub(crate) fn is_empty(&self) -> bool {
        self.touches.is_empty()
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.touches.len()
    }

    /// Number of equations of every contact.
    pub(crate) fn rows(&self) -> impl Iterator<Item = usize> {
        self.touches.iter().map(SpatialTouch::rows)
    }

    /// Takes the start of a step; `origins` are the common origins of the parts of all bodies (m).
    pub(crate) fn begin(&mut self, start: &Start, origins: &[[f64; 3]]) {
        for (number, other) in self.braked_beside.iter().enumerate() {
            let beside = other.map(|other| self.touches[other].normal(start));
            self.touches[number].begin(start, origins, beside);
        }
    }

    /// Finds gaps, slips and friction of bodies that have moved so in a step of this length (s).
    #[inline(always)]
    pub(crate) fn place(&mut self, start: &Start, step: f64, moved: &[[Moved<V>; 2]], origins: &[[f64; 3]]) {
        let Touching { touches, moving, rates, mixing, leans, .. } = self;
        self.step = step;
        if let Some(mixing) = mixing {
            for (body, (rates, moves)) in rates.iter_mut().zip(&*moving).enumerate() {
                let Moved { turn, anchor } = &moved[body][0];
                let [rolls, slips] = *moves;
                if rolls {
                    rates[0] = BodyRate::of(mixing, step, &start.bodies[body], turn, *anchor);
                }
                if slips {
                    rates[1] = BodyRate::of_slips(mixing, step, &start.bodies[body], turn, *anchor);
                }
            }
        }
        let still = &Moved { turn: Matrix::zero(), anchor: Vector::zero() };
        for (number, touch) in touches.iter_mut().enumerate() {
            if let Some(rope) = touch.rope() {
                rope.place(moved);
                continue;
            }
            let ends = touch.bodies();
            touch.place([0, 1].map(|side: usize| ends.map(|end| end.map_or(still, |body| &moved[body][side]))));
            let Some(mixing) = mixing.as_ref().filter(|_| touch.feels_slip()) else { continue };
            let of = |body: usize| {
                let anchor = start.anchor(body);
                let rates = &rates[body][touch.kind_of_rate()];
                [0, 1].map(|side: usize| (&rates[side], moved[body][side].anchor_from(&anchor, &origins[body])))
            };
            touch.slip(mixing, step, ends.map(|end| end.map(of)));
            if touch.moments().is_some() {
                touch.turn(mixing, step, ends.map(|end| end.map(|body| &rates[body])));
            }
            if touch.brakes() {
                leans[number] = touch.lean(mixing);
            }
        }
    }

    /// Writes gaps, gradients and pushes of the contacts, which have the rows `touches`, the directions across slips, which have the rows
    /// `rubbing`, and after all rows the pulls of ropes through several points.
    #[inline(always)]
    pub(crate) fn write(
        &self,
        touches: &[Range<usize>],
        rubbing: &[Range<usize>],
        gaps: &mut [V],
        gradients: &mut [[[V; TWIST]; 2]],
    ) {
        for (number, (touch, rows)) in self.touches.iter().zip(touches).enumerate() {
            let lean = if self.leaning { self.leans.get(number) } else { None };
            touch.write(lean, &mut gaps[rows.clone()], &mut gradients[rows.clone()]);
        }
        let slips = self.rubbing().map(SpatialTouch::across);
        let rolls = self.touches.iter().filter_map(|touch| touch.moments().filter(|moments| moments.brakes_rolling()));
        for (across, rows) in slips.chain(rolls.map(FrictionMoments::across)).zip(rubbing) {
            gradients[rows.start] = across;
        }
        let pulls = self.touches.iter().flat_map(SpatialTouch::pulls);
        gradients[gaps.len()..].iter_mut().zip(pulls).for_each(|(gradient, pull)| *gradient = *pull);
    }

    /// The gradient of the gap of a contact at the rows' stages.
    pub(crate) fn gradient_of_rows(&self, number: usize) -> [V; TWIST] {
        self.touches[number].gradient_of_rows()
    }

    /// How far the slowest contact that slides does so in the step, at the fastest of its stages (m); infinite without friction.
    pub(crate) fn slowest_slide(&self) -> f64 {
        self.rubbing().map(SpatialTouch::fastest).fold(f64::INFINITY, f64::min) * self.step
    }

    /// The contacts that have friction.
    fn rubbing(&self) -> impl Iterator<Item = &SpatialTouch<V>> {
        self.touches.iter().filter(|touch| touch.friction() != 0.0)
    }

    /// Writes the derivatives of friction by the turning of slips, and the correction for directions that lag behind slips, contact by contact that
    /// has friction. Writes the changes of the rates of rolling contacts, row by row. The contacts have the rows `touches`, of which these are all
    /// multipliers. Returns whether the direction of any friction lags behind its slip.
    pub(crate) fn turn(
        &mut self,
        touches: &[Range<usize>],
        multipliers: &[V],
        [friction, behind]: [&mut [V]; 2],
        rolling: &mut [Option<[[V; TWIST]; 2]>],
    ) -> bool {
        let mut friction = friction.iter_mut().zip(behind);
        let mut lags = false;
        for (touch, rows) in self.touches.iter_mut().zip(touches).filter(|(touch, _)| touch.feels_slip()) {
            if touch.rolls() {
                for (axis, change) in touch.rolling().into_iter().enumerate() {
                    rolling[rows.start + 1 + axis] = Some(change);
                }
            } else if touch.friction() != 0.0
                && let Some((friction, behind)) = friction.next()
            {
                [*friction, *behind] = touch.turning_friction(self.step, multipliers[rows.start]);
            }
            if let Some(moments) = touch.moments() {
                let held = rows.end - moments.changes().count();
                moments.changes().zip(&mut rolling[held..]).for_each(|(change, row)| *row = Some(change));
            }
            if touch.brakes() {
                lags |= touch.iterated();
            }
        }
        // The rows of rolling come after the rows of all slips.
        for (touch, rows) in self.touches.iter().zip(touches) {
            if let Some(moments) = touch.moments().filter(|moments| moments.brakes_rolling())
                && let Some((friction, behind)) = friction.next()
            {
                [*friction, *behind] = moments.turning_friction(self.step, multipliers[rows.start]);
            }
        }
        lags
    }

    /// Whether contacts exchange energy with what is no body: by friction, or by surfaces that are driven.
    pub(crate) fn exchanges(&self) -> bool {
        self.touches.iter().any(SpatialTouch::exchanges)
    }

    /// Energy that friction dissipated in the rows of the step for which the bodies are placed, and the work of driven surfaces, for the multipliers
    /// `λ = h² Λ` (J).
    pub(crate) fn exchanged(&self, touches: &[Range<usize>], multipliers: &[V]) -> Exchange {
        let mut sum = Exchange::default();
        let Some(mixing) = &self.mixing else { return sum };
        for (touch, rows) in self.touches.iter().zip(touches).filter(|(touch, _)| touch.exchanges()) {
            sum += touch.exchanged(mixing, &multipliers[rows.clone()]);
        }
        Exchange { friction: sum.friction / self.step, work: sum.work / self.step, ..sum }
    }

    /// The velocities of driven surfaces along the tangents of contacts that roll, with the first row of each, where its bodies are placed [m/s].
    pub(crate) fn carried(&self, touches: &[Range<usize>]) -> impl Iterator<Item = (usize, [V; 2])> {
        let belts = self.touches.iter().zip(touches).filter(|(touch, _)| touch.exchanges() && touch.rolls());
        belts.map(|(touch, rows)| (rows.start + 1, touch.carried(0)))
    }

    /// Friction at the end of the step for which the bodies are placed, contact by contact; empty without friction.
    pub(crate) fn leans(&self) -> &[Lean] {
        &self.leans
    }

    /// Lets multipliers push beside the gradients of the contacts; an empty list makes them push along the gradients.
    pub(crate) fn lean(&mut self, leans: &[Lean]) {
        self.leaning = !leans.is_empty();
        self.leans.iter_mut().zip(leans).for_each(|(own, &lean)| *own = lean);
    }

    /// How they push beside them, if they do.
    pub(crate) fn leaning(&self) -> &[Lean] {
        if self.leaning { &self.leans } else { &[] }
    }
}
