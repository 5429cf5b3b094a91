//! One step of a crowd: all contacts, limits, joints with friction and motors of a scene at once, from positions and rates to positions and rates.
//!
//! ```text
//!     w = v_k + ½h M⁻¹(f + …),   q_{k+1} = q_k ⊕ h w           displacement, gaps not negative at its end           (A)  moving.rs
//!     v_{k+1} = v_k + h M⁻¹(f at the middle + …)               rates of what is closed there, rebounds included     (B)  settling.rs
//! ```
//!
//! Between impacts that is the implicit midpoint rule, of second order; at impacts it has first order. Positions come from (A) alone and rates from (B)
//! alone: a gap that is left over has no effect on a rate, and a step that contains an impact does not split it in two.
//!
//! Source: J. J. Moreau (1988) and M. Jean (1999) for the step; L. Paoli, M. Schatzman, A numerical scheme for impact problems, SIAM Journal on Numerical
//! Analysis 40 (2002) for positions apart from rates.

use crate::crowd::newton::{Interrupt, Workspace};
use crate::crowd::trees::Trees;
use crate::events::crowd::clearances::Clearances;
use crate::events::crowd::contacts::{CLOSED, Candidate, Contacts, Key, Scene, has_row};
use crate::events::crowd::energies::Energies;
use crate::events::crowd::moving::{Moving, move_on};
use crate::events::crowd::resting::Resting;
use crate::events::crowd::settling::{Settling, settle};
use crate::events::crowd::speeds::Speeds;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::closure::Mimic;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;
use std::collections::BTreeSet;

/// A pair that overlaps by more than this at the end, and was no candidate, becomes one (m); this often at most.
const OVERLAPS: f64 = 1e-8;
const AGAIN: usize = 2;
/// A step at whose end shapes overlap by more than this, and twice as much as at its start, is too long (m or rad).
const LIFTED: f64 = 1e-4;

/// Accelerations of a state, and the efforts from outside and of motors in it; without rows.
pub(crate) type Forces<'f> = &'f mut dyn FnMut(&State, &mut [f64], &mut [f64]);

/// The workspace of one mechanism.
#[derive(Clone)]
pub(crate) struct Crowd {
    pub(super) trees: Trees,
    /// The same trees at the end of a step, for its rows there.
    ahead: Option<Trees>,
    /// Candidates where a step begins, and where it ends.
    pub(crate) now: Contacts,
    pub(super) next: Contacts,
    pub(super) clearances: Clearances,
    pub(super) room: Workspace,
    pub(super) bodies: Vec<BodyState>,
    /// Where the step began.
    pub(super) began: Vec<BodyState>,
    /// Speeds for which the candidates are enough.
    pub(super) speeds: Speeds,
    /// The end of the last step and its length (s).
    pub(super) end: Option<(State, f64)>,
    energies: Energies,
    /// D and K of the freedoms, of dampers, springs and motors without a bound.
    pub(super) damping: Vec<f64>,
    pub(super) stiffness: Vec<f64>,
    pub(super) free: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
    pub(super) efforts: Vec<f64>,
    pub(super) middle: Option<State>,
    /// The trees that sleep, and whether some have woken since candidates were looked for.
    pub(super) resting: Resting,
    pub(super) woken: bool,
    /// w of the last step.
    pub(super) displacement: Vec<f64>,
}

/// The result of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Made {
    /// Iterations of all islands.
    pub iterations: usize,
    /// The largest residual of (A) and (B), and the number of islands above the tolerance.
    pub residual: f64,
    pub unsolved: usize,
    /// Number of candidates.
    pub candidates: usize,
    /// The largest overlap that was lifted, and the largest that is left (m).
    pub lifted: f64,
    pub overlap: f64,
    /// The energy that was taken so that none is gained (J).
    pub taken: f64,
    /// Work of motors, efforts and forces without a potential, and what dampers and friction of joints took (J).
    pub work: f64,
    pub dissipated: f64,
    pub friction: f64,
    /// The energy that the mechanism has lost beside those (J).
    pub lost: f64,
    /// Number of contacts and limits that have closed with an impact, and number of all that are closed.
    pub closed: usize,
    pub held: usize,
    /// The largest change of the velocity of a body's points [m/s], and the kinetic energy at the end (J).
    pub jump: f64,
    pub kinetic: f64,
    /// Whether everything rests, and the part of the bodies that took no part in the step.
    pub asleep: bool,
    pub slept: f64,
}

impl Crowd {
    /// For a mechanism; `None` for one with joints that are moved in time, or with contacts that are held.
    pub fn new(mechanism: &Mechanism) -> Option<Self> {
        if !mechanism.touches.is_empty() || mechanism.mimics.iter().any(Mimic::is_moved) {
            return None;
        }
        let count = mechanism.velocity_count;
        let trees = Trees::new(mechanism);
        let mut restless = vec![false; trees.trees.len()];
        for motor in mechanism.nonsmooth.motors.iter().filter(|motor| has_row(motor) && !motor.target.is_constant()) {
            restless[trees.of_freedom[motor.coordinate.freedom].0] = true;
        }
        Some(Crowd {
            resting: Resting::new(&trees, count, restless),
            woken: false,
            trees,
            ahead: None,
            now: Contacts::default(),
            next: Contacts::default(),
            clearances: Clearances::default(),
            room: Workspace::default(),
            bodies: vec![WORLD; mechanism.bodies.len()],
            began: vec![WORLD; mechanism.bodies.len()],
            speeds: Speeds::new(mechanism.bodies.len()),
            end: None,
            energies: Energies::new(mechanism),
            damping: vec![0.0; count],
            stiffness: vec![0.0; count],
            free: vec![0.0; count],
            acceleration: vec![0.0; count],
            efforts: vec![0.0; count],
            middle: None,
            displacement: vec![0.0; count],
        })
    }

    /// Once this flag is set, no step is made: one that is being made ends within an iteration.
    pub fn heed(&mut self, interrupt: Interrupt) {
        self.room.interrupt = Some(interrupt);
    }

    /// That flag.
    pub fn interrupt(&self) -> Option<Interrupt> {
        self.room.interrupt.clone()
    }

    /// Whether that flag is set.
    pub fn is_interrupted(&self) -> bool {
        self.room.is_interrupted()
    }

    /// Makes a step of this length (s) from a state, evenly if nothing that acts changes in time; `None` where a mass matrix is singular, a number is not
    /// finite, shapes overlap far at its end, or it is interrupted: the state before it is kept.
    pub fn step(&mut self, scene: Scene, forces: Forces, state: &mut State, step: f64, evenly: bool) -> Option<Made> {
        let made = self.make(scene, forces, state, step, evenly);
        if made.is_none() {
            (self.now, self.clearances, self.end) = (Contacts::default(), Clearances::default(), None);
            self.resting.wake_all();
            self.displacement = vec![0.0; self.free.len()];
        }
        made
    }

    fn make(&mut self, scene: Scene, forces: Forces, state: &mut State, step: f64, evenly: bool) -> Option<Made> {
        let start = state.clone();
        if !self.goes_on(&start) {
            self.resting.wake_all();
        }
        if evenly && self.resting.is_all() {
            // As `sleeps` has found.
            state.time += step;
            self.end = Some((state.clone(), self.end.as_ref().map_or(step, |end| end.1)));
            self.displacement.fill(0.0);
            return Some(Made { asleep: true, slept: 1.0, held: self.held(), ..Made::default() });
        }
        loop {
            match self.attempt(scene, forces, &start, state, step)? {
                Ok(made) => return Some(made),
                Err(reached) => self.wake(&reached),
            }
            state.copy_from(&start);
        }
    }

    /// The same, if nothing reaches trees that sleep; otherwise the trees that are reached, in a state of no meaning.
    fn attempt(
        &mut self,
        scene: Scene,
        forces: Forces,
        start: &State,
        state: &mut State,
        step: f64,
    ) -> Option<Result<Made, Vec<usize>>> {
        let whole = scene.whole;
        forces(start, &mut self.acceleration, &mut self.efforts);
        let reached = self.resting.loaded(&self.acceleration);
        if !reached.is_empty() {
            return Some(Err(reached));
        }
        self.soften(scene);
        self.begin(scene, start, step)?;
        let (mut made, iterations) = (Made::default(), self.room.iterations);
        made.slept = self.resting.part();
        self.energies.begin(&self.trees, &start.velocity);
        self.free_to_move(start, 0.5 * step)?;
        let mut displacement = std::mem::take(&mut self.displacement);
        for attempt in 0..=AGAIN {
            let Crowd { trees, ahead, now, room, bodies, free, resting, .. } = self;
            let moving = Moving { scene, start, step, free, resting };
            let found = move_on(trees, now, &moving, (room, ahead), &mut displacement, state, bodies);
            made.residual = made.residual.max(found.residual);
            made.unsolved += found.unsolved;
            self.take_displacement(whole, start, state, step, &mut displacement);
            if found.open || !self.place_middle(start, &displacement, step, whole) {
                return None;
            }
            place_bodies(whole, state, &mut self.bodies);
            self.find_next(scene, state, step);
            if self.is_interrupted() {
                return None;
            }
            if attempt == AGAIN || !self.widen(scene, start, &displacement, step) {
                break;
            }
        }
        let reached = self.resting.pushed(&self.now.list, |candidate| &candidate.moving);
        if !reached.is_empty() {
            self.displacement = displacement;
            return Some(Err(reached));
        }
        if !state.position.iter().all(|place| place.is_finite()) {
            return None;
        }
        self.trees.choose(whole, &self.bodies);
        self.next.fill_rows(scene, &self.resting.asleep, &self.trees, &self.bodies, 0);
        if self.next.deepest() > LIFTED.max(2.0 * self.now.deepest()) {
            return None;
        }
        let (lifted, overlap) = self.lift(scene, state, step)?;
        (made.lifted, made.overlap) = (lifted, overlap);
        self.next.warm(&self.now, step, 1.0, &self.trees);
        state.time = start.time + step;
        self.free_to_settle(start, &displacement, step, forces)?;
        let settling = Settling { scene, start, displacement: &displacement, step, free: &self.free };
        let found = settle(&self.trees, &mut self.next, &settling, &mut self.room, &mut state.velocity);
        let mut reached = self.resting.loaded(&self.acceleration);
        reached.extend(self.resting.pushed(&self.next.list, |candidate| &candidate.settling));
        if !reached.is_empty() {
            self.displacement = displacement;
            return Some(Err(reached));
        }
        made.residual = made.residual.max(found.residual);
        made.unsolved += found.unsolved;
        made.closed = found.closed;
        if self.is_interrupted() || !state.velocity.iter().all(|rate| rate.is_finite()) {
            return None;
        }
        let moved: Vec<f64> = displacement.iter().map(|rate| step * rate).collect();
        let mut work: Vec<f64> = self.efforts.iter().zip(&moved).map(|(effort, moved)| effort * moved).collect();
        work.iter_mut().zip(&found.work).for_each(|(own, more)| *own += more);
        // All trees are one group where such forces act.
        if let Some(first) = work.first_mut() {
            *first += self.energies.work_of_forces(whole, self.middle.as_ref(), step);
        }
        // The dampers among `self.damping`; what motors take is part of the work.
        for damper in &whole.forces.joint_dampers {
            made.dissipated += step * damper.coefficient * displacement[damper.freedom].powi(2);
        }
        made.work = work.iter().sum();
        made.taken = self.energies.bound(&self.trees, whole, state, &self.bodies, &work, [&self.now, &self.next]);
        made.candidates = self.next.list.len();
        made.iterations = self.room.iterations - iterations;
        let rates = self.speeds.rates().to_vec();
        self.displacement = displacement;
        self.finish(scene, state, step);
        made.lost = self.energies.lost(whole, state, &self.bodies, made.work);
        // A slip that stops in the step is not the one in its middle, nor a rate that an impact stops: dampers and friction take no more than is lost.
        made.dissipated = made.dissipated.min(made.lost.max(0.0));
        made.friction = found.friction.clamp(0.0, (made.lost - made.dissipated).max(0.0));
        made.kinetic = self.energies.kinetic_of(&self.trees, &state.velocity);
        made.held = self.held();
        if self.let_sleep(scene, forces, state, step, &rates) {
            // Their rates are zero from now on.
            made.lost = self.energies.lost(whole, state, &body_states(whole, state), made.work);
        }
        made.asleep = self.resting.is_all();
        let jumps = self.began.iter().zip(&self.bodies).map(|(before, now)| (now.velocity - before.velocity).norm());
        made.jump = jumps.fold(0.0, f64::max);
        Some(Ok(made))
    }

    /// Makes pairs that overlap at the end of a step, and were no candidates, candidates of it; returns whether there are any. Features that tell nothing at
    /// its start, where others are deeper, have the gap there that their gap and their rows at the end give: `φ − h H w`.
    fn widen(&mut self, scene: Scene, start: &State, displacement: &[f64], step: f64) -> bool {
        let Crowd { now, next, trees, bodies, resting, .. } = self;
        let known: BTreeSet<Key> = now.list.iter().map(|candidate| candidate.key).collect();
        let new =
            |candidate: &&Candidate| candidate.closes() && candidate.gap < -OVERLAPS && !known.contains(&candidate.key);
        let first = now.list.len();
        if !next.list.iter().any(|candidate| new(&candidate)) {
            return false;
        }
        let at_end = bodies.clone();
        place_bodies(scene.whole, start, bodies);
        let mut hidden = Vec::new();
        for candidate in next.list.iter().filter(new) {
            let there = candidate.at(scene.elements, start, bodies);
            if there.gap >= -CLOSED {
                now.list.push(there);
            } else {
                hidden.push(candidate.clone());
            }
        }
        now.fill_rows(scene, &resting.asleep, trees, bodies, first);
        bodies.copy_from_slice(&at_end);
        let second = now.list.len();
        now.list.append(&mut hidden);
        now.fill_rows(scene, &resting.asleep, trees, bodies, second);
        for number in second..now.list.len() {
            let moved = now.closing_rate(number, trees, displacement);
            now.list[number].gap -= step * moved;
        }
        true
    }

    /// Number of contacts and limits that are closed in a state from which a step of this length (s) begins.
    pub fn held_at(&mut self, scene: Scene, state: &State, step: f64) -> Option<usize> {
        self.begin(scene, state, step)?;
        Some(self.held())
    }

    /// Number of closed contacts and limits.
    fn held(&self) -> usize {
        let asleep = self.resting.candidates().iter().map(|(candidate, _)| candidate);
        self.now.list.iter().chain(asleep).filter(|candidate| candidate.is_closed()).count()
    }

    /// Takes the start of a step: candidates, their rows and M, known from the last step if it ended there.
    fn begin(&mut self, scene: Scene, start: &State, step: f64) -> Option<()> {
        let same = |(end, length): &(State, f64)| end == start && *length >= step;
        let known = self.end.as_ref().is_some_and(same);
        let longer = self.end.as_ref().map_or(1.0, |(_, length)| step / length);
        if known && longer == 1.0 && !self.woken {
            return Some(());
        }
        self.woken = false;
        place_bodies(scene.whole, start, &mut self.bodies);
        self.trees.choose(scene.whole, &self.bodies);
        self.look_anew(scene, start, step, longer);
        self.energies.place(scene.whole, start, &self.bodies, &self.trees);
        Some(())
    }

    /// The candidates at the end become those at the start of the next step.
    fn finish(&mut self, scene: Scene, state: &State, step: f64) {
        place_bodies(scene.whole, state, &mut self.bodies);
        let grown = self.speeds.have_grown(&self.bodies, scene.whole.gravity.norm() * step);
        std::mem::swap(&mut self.now, &mut self.next);
        self.end = Some((state.clone(), step));
        // Candidates for slower bodies are not enough.
        if grown {
            self.look_anew(scene, state, step, 1.0);
        }
    }

    /// Finds the candidates of a step that begins in a state with these bodies and trees, at their speeds; forces are known from the last candidates,
    /// for a step that was shorter by a factor.
    fn look_anew(&mut self, scene: Scene, state: &State, step: f64, longer: f64) {
        self.speeds.begin(&self.bodies);
        let Crowd { now, bodies, speeds, resting, clearances, trees, .. } = self;
        let mut found = Contacts::default();
        found.find(scene, &resting.asleep, state, (bodies, speeds), step, clearances);
        found.fill_rows(scene, &resting.asleep, trees, bodies, 0);
        found.warm(now, step, longer, trees);
        *now = found;
    }

    /// Finds the candidates at the end of a step, where the bodies are placed.
    pub(super) fn find_next(&mut self, scene: Scene, state: &State, step: f64) {
        let Crowd { next, bodies, speeds, resting, clearances, .. } = self;
        next.find(scene, &resting.asleep, state, (bodies, speeds), step, clearances);
    }
}
