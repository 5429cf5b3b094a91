//! Motions of freedoms and of frames along a step, and how far they are ahead of straight lines.
//!
//! ```text
//!     vector on a body    u_i = u_0 + c_i h u̇_0 + a_i                a_i from  q_i = q_0 + c_i h q̇_0 + w_i
//!     motion about p      s = (t, u + p × t)                          s_i = s_0 + c_i h ṡ_0 + σ_i
//!     σ_i = (a_t, a_u + a_p × t_0 + p_0 × a_t + Δp × Δt)              Δ = c_i h (d/dt)_0 + a_i
//! ```
//!
//! σ is of second order in the step and comes from w without differences of large numbers: derivatives keep their digits
//! ([`crate::derivatives::forward::tree::column`]).

use crate::derivatives::forward::spatial::{NOUGHT, Twist, transposed};
use crate::derivatives::forward::tree::step::TreeStep;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::mechanism::description::joint::FreeRotation;

/// A motion along a step.
pub(super) struct Course {
    /// s_0 and h ṡ_0.
    pub begin: Twist,
    pub gone: Twist,
    /// σ of the stages i = 2..s.
    pub ahead: Vec<Twist>,
}

/// The motion of a freedom along a step.
pub(super) struct FreedomCourse {
    /// The motion by a displacement of the start that stays the same beside the parent.
    pub kept: Course,
    /// s_i − s_0 of the freedom itself at the stages i = 2..s; it is another motion if a ball turns.
    pub later: Vec<Twist>,
    /// How `U` at the end differs from that at the start (δq̇ = δT q̇ + U q): by the displacement, and by `h δv + v δh`.
    pub rates: [Twist; 2],
}

/// A frame of a joint that varies, along a step.
pub(super) struct FrameCourse {
    pub course: Course,
    /// As of a freedom.
    pub rate: Twist,
}

/// A vector that is fixed in a body (`None` is the world); points have their origin.
#[derive(Clone, Copy)]
struct On {
    body: Option<usize>,
    vector: Vector<f64>,
    is_point: bool,
}

impl On {
    fn along(body: Option<usize>, vector: Vector<f64>) -> Self {
        On { body, vector, is_point: false }
    }

    fn point(body: Option<usize>, vector: Vector<f64>) -> Self {
        On { body, vector, is_point: true }
    }

    fn seen(&self, of: &Twelve<f64>) -> Vector<f64> {
        let own = of.axes.apply(self.vector);
        if self.is_point { of.origin + own } else { own }
    }
}

/// How a motion changes that is carried by one that goes from `begin` to `end`, while it goes on by `later`.
fn carried_on([begin, end]: [&Twist; 2], later: &Twist, at_end: &Twist) -> Twist {
    let faster = end.plus(&begin.scaled(-1.0));
    faster.carries(at_end).plus(&begin.carries(later))
}

/// The transpose of [`Twist::carries`], by the motion that is carried.
fn carried_back(by: &Twist, whole: &Twist) -> Twist {
    let turn = whole.turn.cross(by.turn) + whole.shift.cross(by.shift);
    Twist { turn, shift: whole.shift.cross(by.turn) }
}

impl Course {
    /// s_i − s_0 of a stage with the node c_i, by its number among the later ones.
    pub fn later(&self, i: usize, node: f64) -> Twist {
        self.gone.scaled(node).plus(&self.ahead[i])
    }
}

impl TreeStep<'_> {
    /// q_0, h q̇_0 and w_i of a body or of the world.
    fn start_of(&self, body: Option<usize>) -> Twelve<f64> {
        let world = Twelve { origin: NOUGHT - self.reference, axes: Matrix::identity() };
        body.map_or(world, |body| self.stages[0].places[body])
    }

    fn gone_of(&self, body: Option<usize>) -> Twelve<f64> {
        body.map_or_else(Twelve::zero, |body| self.rates[0][body].scaled(self.problem.step))
    }

    /// How far a vector on a body is ahead at a stage. The world does not move.
    fn seen_ahead(&self, on: &On, i: usize) -> Vector<f64> {
        on.body.map_or(NOUGHT, |body| on.seen(&self.ahead[i][body]))
    }

    /// q_i − q_0 of a body.
    pub fn moved(&self, i: usize, body: usize) -> Twelve<f64> {
        let gone = self.problem.step * self.problem.tableau.nodes[i + 1];
        self.rates[0][body].scaled(gone).plus(&self.ahead[i][body])
    }

    fn speed_of(&self, body: Option<usize>, end: usize) -> Twist {
        body.map_or(Twist::NONE, |body| self.speeds[end][body])
    }

    fn course(&self, turn: On, shift: On, point: On) -> Course {
        let start = |on: &On| on.seen(&self.start_of(on.body));
        let gone = |on: &On| on.seen(&self.gone_of(on.body));
        let ([t0, u0, p0], [tg, ug, pg]) =
            ([start(&turn), start(&shift), start(&point)], [gone(&turn), gone(&shift), gone(&point)]);
        let ahead = |i: usize| {
            let of = |on: &On| self.seen_ahead(on, i);
            let (ta, ua, pa, c) = (of(&turn), of(&shift), of(&point), self.problem.tableau.nodes[i + 1]);
            let both = (pg.scaled(c) + pa).cross(tg.scaled(c) + ta);
            Twist { turn: ta, shift: ua + pa.cross(t0) + p0.cross(ta) + both }
        };
        Course {
            begin: Twist { turn: t0, shift: u0 + p0.cross(t0) },
            gone: Twist { turn: tg, shift: ug + pg.cross(t0) + p0.cross(tg) },
            ahead: (0..self.ahead.len()).map(ahead).collect(),
        }
    }

    /// The courses of all freedoms, in their order.
    pub fn courses(&self) -> Vec<FreedomCourse> {
        let figures = &self.problem.figures.plain;
        let carriers = [self.carrier_speeds(0), self.carrier_speeds(1)];
        let last = self.ahead.len() - 1;
        let mut courses = Vec::with_capacity(figures.freedoms);
        let all = self.family.own.iter().enumerate().flat_map(|(body, own)| own.iter().map(move |own| (body, own)));
        for (number, freedom) in all {
            let motion = &self.stages[0].motions[freedom.index];
            let body = &figures.bodies[number];
            let parent = body.parent;
            let in_parent = |vector| transposed(&self.start_of(parent).axes, vector);
            let none = On::along(None, NOUGHT);
            let anchor = On::point(Some(number), body.on_child.origin);
            let kept = if freedom.is_rotation {
                self.course(On::along(parent, in_parent(motion.turn)), none, anchor)
            } else {
                self.course(none, On::along(parent, in_parent(motion.shift)), On::point(parent, NOUGHT))
            };
            let nodes = &self.problem.tableau.nodes[1..];
            let later_of = |course: &Course| -> Vec<Twist> {
                nodes.iter().enumerate().map(|(i, node)| course.later(i, *node)).collect()
            };
            let later = if freedom.is_rotation && body.kind.rotation() == FreeRotation::Ball {
                let turn = transposed(&self.start_of(Some(number)).axes, motion.turn);
                later_of(&self.course(On::along(Some(number), turn), none, anchor))
            } else {
                later_of(&kept)
            };
            let [begin, end] = [0, 1].map(|end: usize| &carriers[end][freedom.index]);
            let kept_later = kept.later(last, 1.0);
            let at_end = kept.begin.plus(&kept_later);
            let rates = [
                carried_on([begin, end], &kept_later, &at_end),
                end.carries(&self.stages[last + 1].motions[freedom.index]),
            ];
            courses.push(FreedomCourse { kept, later, rates });
        }
        courses
    }

    /// The course of the motion of a frame on the parent (0) or the child (1) of the joint of a body.
    pub fn frame_course(&self, body: usize, which: usize, motion: &Twist) -> FrameCourse {
        let (on, point) = self.frame_of(body, which);
        let course = self.course(On::along(on, motion.turn), On::along(on, motion.shift), point);
        let last = self.ahead.len() - 1;
        let later = course.later(last, 1.0);
        let speeds = [&self.speed_of(on, 0), &self.speed_of(on, 1)];
        let rate = carried_on(speeds, &later, &course.begin.plus(&later));
        FrameCourse { course, rate }
    }

    /// The cotangent of the motion of a frame, from the cotangent of its course.
    pub fn frame_cotangent(&self, body: usize, which: usize, of: &FrameCourse) -> Twist {
        let (on, point) = self.frame_of(body, which);
        let [begin_speed, end_speed] = [self.speed_of(on, 0), self.speed_of(on, 1)];
        let faster = end_speed.plus(&begin_speed.scaled(-1.0));
        let at_end = carried_back(&faster, &of.rate);
        let later = at_end.plus(&carried_back(&begin_speed, &of.rate));
        let (start, gone) = (self.start_of(on), self.gone_of(on));
        let (p0, pg) = (point.seen(&start), point.seen(&gone));
        let mut found = Twist::NONE;
        let mut add = |at: &Twelve<f64>, turn: Vector<f64>, shift: Vector<f64>| {
            let own = Twist { turn: transposed(&at.axes, turn), shift: transposed(&at.axes, shift) };
            found = found.plus(&own);
        };
        let whole = of.course.begin.plus(&at_end);
        add(&start, whole.turn + whole.shift.cross(p0), whole.shift);
        let whole = of.course.gone.plus(&later);
        add(&gone, whole.turn + whole.shift.cross(p0), whole.shift);
        add(&start, whole.shift.cross(pg), NOUGHT);
        for (i, own) in of.course.ahead.iter().enumerate() {
            let whole = if i + 1 == of.course.ahead.len() { own.plus(&later) } else { *own };
            let ahead = on.map_or_else(Twelve::zero, |body| self.ahead[i][body]);
            let c = self.problem.tableau.nodes[i + 1];
            let pa = point.seen(&ahead);
            let moved = whole.shift.cross(pg.scaled(c) + pa);
            add(&ahead, whole.turn + whole.shift.cross(p0) + moved, whole.shift);
            add(&gone, moved.scaled(c), NOUGHT);
            add(&start, whole.shift.cross(pa), NOUGHT);
        }
        found
    }

    /// The body of a frame of a joint, and the origin of the frame.
    fn frame_of(&self, body: usize, which: usize) -> (Option<usize>, On) {
        let figures = &self.problem.figures.plain.bodies[body];
        let (on, frame) = [(figures.parent, &figures.on_parent), (Some(body), &figures.on_child)][which];
        (on, On::point(on, frame.origin))
    }
}
