//! The state of the planner of an elimination: the fronts on the stack, the contents of their slots, and the complete closures.

use crate::plan::elimination::{Column, Elimination, Operation, Unknown};
use catena_mechanism::description::closure::LoopKind;
use catena_mechanism::description::mechanism::Mechanism;

impl Elimination {
    /// Plans the elimination of the loops and contacts, which have `rows` equations each, and of mimics. If `springs` is set, the plan has the
    /// tensions of the point springs and the turning friction of contacts, and contacts with the world are eliminated at their bodies. Twists have
    /// `width` components.
    pub fn new(mechanism: &Mechanism, width: usize, rows: &[usize], springs: bool) -> Self {
        let mut planner = Planner::new(mechanism, width, rows, springs);
        let mut first_child_done = vec![false; mechanism.bodies.len()];
        let mut root_done = false;
        let mut leaf = vec![true; mechanism.bodies.len()];
        for body in &mechanism.bodies {
            if let Some(parent) = body.parent {
                leaf[parent] = false;
            }
        }
        for index in (0..mechanism.bodies.len()).rev() {
            if leaf[index] {
                planner.open();
            }
            planner.own(index);
            planner.close_on_world(index);
            planner.close_complete(Some(index));
            planner.freedoms(index);
            let parent = mechanism.bodies[index].parent;
            let first = match parent {
                Some(parent) => !std::mem::replace(&mut first_child_done[parent], true),
                None => !std::mem::replace(&mut root_done, true),
            };
            if !first {
                planner.merge(parent.is_some());
            }
            planner.close_complete(parent);
        }
        planner.plan
    }
}

/// A closure as the plan sees it.
#[derive(Clone)]
struct Closure {
    first_row: usize,
    rows: usize,
    /// Its two ends; `None` is the world. Empty for a mimic, and for a rope through several points.
    sides: [Option<usize>; 2],
    /// The bodies that a rope through several points pulls, each with the number of its gradient.
    reeved: Vec<(usize, usize)>,
    /// Bodies with an end of it; fewer than two if it ends in the world.
    ends: Vec<usize>,
    /// The body at which its branches meet; `None` is the world.
    meets: Option<usize>,
    /// Whether it goes at its only body, with a pivot of its own.
    on_world: bool,
    done: bool,
}

/// A plan in the making.
pub(crate) struct Planner<'m> {
    mechanism: &'m Mechanism,
    /// Number of closures with rows of their own: the loops, then the contacts.
    loops: usize,
    closures: Vec<Closure>,
    /// For every front on the stack: which row sits in a slot.
    stack: Vec<Vec<Option<usize>>>,
    processed: Vec<bool>,
    /// Whether a row's right-hand side is in a front already.
    gap_taken: Vec<bool>,
    /// The plan so far.
    pub(crate) plan: Elimination,
}

impl<'m> Planner<'m> {
    /// An empty plan, for the arguments of [`Elimination::new`].
    pub(crate) fn new(mechanism: &'m Mechanism, width: usize, rows: &[usize], springs: bool) -> Self {
        let ancestors = |body: Option<usize>| -> Vec<usize> {
            std::iter::successors(body, |&body| mechanism.bodies[body].parent).collect()
        };
        let pairs = mechanism
            .closing_ends()
            .zip(rows)
            .map(|([a, b], &count)| (count, a.body, b.body))
            .chain(mechanism.mimics.iter().map(|mimic| (1, Some(mimic.follower.body), Some(mimic.leader.body))))
            .chain(mechanism.forces.point_springs.iter().filter(|_| springs).map(|s| (1, s.a.body, s.b.body)))
            .chain(mechanism.braked().filter(|_| springs).map(|joint| (1, joint.a.body, joint.b.body)));
        let mut closure_of_row = Vec::new();
        let mut closures = Vec::new();
        for (index, (count, a, b)) in pairs.enumerate() {
            let (up_a, up_b) = (ancestors(a), ancestors(b));
            let meets = up_a.iter().find(|body| up_b.contains(body)).copied();
            closures.push(Closure {
                first_row: closure_of_row.len(),
                rows: count,
                sides: [a, b],
                reeved: Vec::new(),
                ends: [a, b].into_iter().flatten().collect(),
                meets,
                on_world: false,
                done: false,
            });
            closure_of_row.extend((0..count).map(|_| index));
        }
        let (loops, springs_from) = (rows.len(), rows.len() + mechanism.mimics.len());
        // A mimic acts on the freedoms of its joints themselves, below the bodies in the tree of eliminations.
        for (closure, mimic) in closures[loops..springs_from].iter_mut().zip(&mechanism.mimics) {
            closure.sides = [None; 2];
            closure.ends = mimic.terms().map(|(own, _)| own.body).collect();
            let above: Vec<Vec<usize>> =
                closure.ends.iter().map(|&body| ancestors(mechanism.bodies[body].parent)).collect();
            let all = |body: &&usize| above.iter().all(|others| others.contains(body));
            closure.meets = above.first().and_then(|first| first.iter().find(all)).copied();
        }
        // A rope through several points has a gradient for each body, after the gradients of all equations.
        let mut gradients = closure_of_row.len()..;
        let touches = mechanism.touches.iter().zip(&mut closures[mechanism.loops.len()..loops]);
        for (joint, closure) in touches.filter(|(joint, _)| joint.is_reeved()) {
            let world = joint.reeved.iter().any(|point| point.body.is_none());
            let above: Vec<Vec<usize>> = joint.reeved.iter().map(|point| ancestors(point.body)).collect();
            let all = |body: &&usize| above.iter().all(|others| others.contains(body));
            let meets = above.first().filter(|_| !world).and_then(|first| first.iter().find(all));
            (closure.sides, closure.meets, closure.ends) = ([None; 2], meets.copied(), joint.reeved_bodies());
            closure.reeved = closure.ends.iter().copied().zip(&mut gradients).collect();
        }
        for (index, closure) in closures.iter_mut().enumerate().filter(|(_, own)| springs && own.reeved.is_empty()) {
            let gives = index >= springs_from || holds_a_point(mechanism, index);
            closure.on_world = gives && closure.ends.len() == 1;
        }
        let given = closures.iter().flat_map(|closure| (0..closure.rows).map(|_| closure.on_world)).collect();
        Planner {
            mechanism,
            loops,
            closures,
            stack: Vec::new(),
            processed: vec![false; mechanism.bodies.len()],
            gap_taken: vec![false; closure_of_row.len()],
            plan: Elimination { width, operations: Vec::new(), closure_of_row, given, slots: width, levels: 0 },
        }
    }

    /// Puts an empty front on the stack.
    pub(crate) fn open(&mut self) {
        self.stack.push(Vec::new());
        self.plan.levels = self.plan.levels.max(self.stack.len());
        self.plan.operations.push(Operation::Open);
    }

    /// The slot of a row in the top front, if it is there.
    fn slot_of(&self, front: &[Option<usize>], row: usize) -> Option<usize> {
        front.iter().position(|&held| held == Some(row)).map(|index| self.plan.width + index)
    }

    fn held(&self, front: &[Option<usize>]) -> Vec<usize> {
        front.iter().enumerate().filter_map(|(index, held)| held.map(|_| self.plan.width + index)).collect()
    }

    /// Gives rows a slot in a front; returns the new slots.
    fn enter(&mut self, level: usize, rows: &[usize]) -> Vec<usize> {
        let width = self.plan.width;
        let front = &mut self.stack[level];
        let mut entered = Vec::new();
        for &row in rows {
            if front.contains(&Some(row)) {
                continue;
            }
            let index = front.iter().position(Option::is_none).unwrap_or_else(|| {
                front.push(None);
                front.len() - 1
            });
            front[index] = Some(row);
            entered.push(width + index);
        }
        self.plan.slots = self.plan.slots.max(width + front.len());
        entered
    }

    fn top(&self) -> usize {
        self.stack.len() - 1
    }

    /// Brings rows into the top front, with the operation that clears their slots.
    fn bring_in(&mut self, rows: &[usize]) {
        let present = self.held(&self.stack[self.top()]);
        let slots = self.enter(self.top(), rows);
        if slots.is_empty() {
            return;
        }
        // A row may come in on two branches; its right-hand side comes with the first.
        let front = &self.stack[self.top()];
        let fresh = rows.iter().filter(|&&row| !self.gap_taken[row]);
        let gaps: Vec<(usize, usize)> =
            fresh.filter_map(|&row| self.slot_of(front, row).map(|slot| (row, slot))).collect();
        for &(row, _) in &gaps {
            self.gap_taken[row] = true;
        }
        self.plan.operations.push(Operation::Enter { slots, present, gaps });
    }

    /// Adds a body's own inertia and its ends of closures to the top front.
    pub(crate) fn own(&mut self, body: usize) {
        let touching = |closure: &Closure| closure.ends.contains(&body);
        let rows_of = |closure: &Closure| closure.first_row..closure.first_row + closure.rows;
        let rows: Vec<usize> = self.closures.iter().filter(|closure| touching(closure)).flat_map(rows_of).collect();
        self.bring_in(&rows);
        let front = &self.stack[self.top()];
        let mut ends = Vec::new();
        for closure in &self.closures {
            for (end, sign) in closure.sides.into_iter().zip([-1.0, 1.0]) {
                if end == Some(body) {
                    let of = |row| self.slot_of(front, row).map(|slot| (row, slot, sign));
                    ends.extend(rows_of(closure).filter_map(of));
                }
            }
            for &(_, gradient) in closure.reeved.iter().filter(|(own, _)| *own == body) {
                ends.extend(self.slot_of(front, closure.first_row).map(|slot| (gradient, slot, 1.0)));
            }
        }
        self.processed[body] = true;
        self.plan.operations.push(Operation::Own { body, ends });
    }

    /// The columns of the top front but for `without`; the twist is the twist of `body`.
    fn columns(&self, body: Option<usize>, without: Option<usize>) -> Vec<Column> {
        let twist = (0..self.plan.width).filter_map(|component| {
            body.map(|body| Column { slot: component, unknown: Unknown::Twist { body, component } })
        });
        let held = self.stack[self.top()].iter().enumerate().filter_map(|(index, held)| {
            held.map(|row| Column { slot: self.plan.width + index, unknown: Unknown::Multiplier(row) })
        });
        twist.chain(held).filter(|column| Some(column.slot) != without).collect()
    }

    /// Eliminates the freedoms of a body's joint: the top front then belongs to its parent.
    pub(crate) fn freedoms(&mut self, body: usize) {
        let joint = &self.mechanism.bodies[body].joint;
        let front = &self.stack[self.top()];
        for freedom in joint.velocity_range().rev() {
            // The world does not move: the rest of the twist is known once the first freedom is the last to go.
            let moves = self.mechanism.bodies[body].parent.is_some() || freedom != joint.velocity_index;
            let columns = self.columns(moves.then_some(body), None);
            let mut direct = Vec::new();
            for (mimic, closure) in self.mechanism.mimics.iter().zip(&self.closures[self.loops..]) {
                for (coordinate, coefficient) in mimic.terms() {
                    if coordinate.freedom == freedom
                        && let Some(slot) = self.slot_of(front, closure.first_row)
                    {
                        direct.push((closure.first_row, slot, coefficient));
                    }
                }
            }
            self.plan.operations.push(Operation::Freedom { body, freedom, columns, direct });
        }
    }

    /// Eliminates the closures that go at their body, whose front is on top and unchanged since they came in: they are coupled to the twist only.
    pub(crate) fn close_on_world(&mut self, body: usize) {
        for index in 0..self.closures.len() {
            let closure = &mut self.closures[index];
            if !closure.on_world || closure.ends != [body] {
                continue;
            }
            closure.done = true;
            for row in closure.first_row..closure.first_row + closure.rows {
                let top = self.top();
                let Some(slot) = self.slot_of(&self.stack[top], row) else { continue };
                let mut columns = self.columns(Some(body), None);
                columns.truncate(self.plan.width);
                self.plan.operations.push(Operation::Multiplier { row, slot, columns, measure: Vec::new() });
                self.stack[top][slot - self.plan.width] = None;
            }
        }
    }

    /// Eliminates the closures that are complete in the top front, whose twist is the twist of `twist`.
    pub(crate) fn close_complete(&mut self, twist: Option<usize>) {
        let complete: Vec<(usize, Vec<(usize, usize)>)> = (0..self.closures.len())
            .filter_map(|index| self.complete(index, twist).map(|slots| (index, slots)))
            .collect();
        // All of them are measured before the first goes: the next may be implied by it, and would be measured by its rounding.
        let mut measure: Vec<(usize, usize)> = complete.iter().flat_map(|(_, slots)| slots).copied().collect();
        for (index, slots) in complete {
            self.closures[index].done = true;
            for (row, slot) in slots {
                let columns = self.columns(twist, Some(slot));
                let measure = std::mem::take(&mut measure);
                self.plan.operations.push(Operation::Multiplier { row, slot, columns, measure });
                let top = self.top();
                self.stack[top][slot - self.plan.width] = None;
            }
        }
    }

    /// The rows and slots of a closure, if it can be eliminated in the top front.
    fn complete(&self, index: usize, twist: Option<usize>) -> Option<Vec<(usize, usize)>> {
        let closure = &self.closures[index];
        let is_mimic = (self.loops..self.loops + self.mechanism.mimics.len()).contains(&index);
        let both = closure.ends.iter().all(|&end| self.processed[end]);
        // A mimic is complete only when the freedoms of both joints are gone.
        let gone = |&end: &usize| !self.is_open(end, twist);
        let here = closure.meets == twist && (!is_mimic || closure.ends.iter().all(gone));
        if closure.done || !both || !here {
            return None;
        }
        let front = &self.stack[self.top()];
        let rows = closure.first_row..closure.first_row + closure.rows;
        rows.map(|row| self.slot_of(front, row).map(|slot| (row, slot))).collect()
    }

    /// Whether the freedoms of a body's joint are not eliminated yet while the front has the twist of `twist`.
    fn is_open(&self, body: usize, twist: Option<usize>) -> bool {
        !self.processed[body] || twist == Some(body)
    }

    /// Adds the top front to the one below; both have the same twist.
    pub(crate) fn merge(&mut self, twist: bool) {
        let Some(top) = self.stack.pop() else { return };
        let rows: Vec<usize> = top.iter().flatten().copied().collect();
        let below = self.top();
        let present = self.held(&self.stack[below]);
        let enter = self.enter(below, &rows);
        let front = &self.stack[below];
        let slots = rows.iter().filter_map(|&row| Some((self.slot_of(&top, row)?, self.slot_of(front, row)?)));
        let slots = slots.collect();
        self.plan.operations.push(Operation::Merge { slots, enter, present, twist });
    }
}

/// Whether a closure, by its number among the loops and contacts, is a contact or holds a point.
fn holds_a_point(mechanism: &Mechanism, index: usize) -> bool {
    match mechanism.loops.get(index) {
        Some(joint) => joint.kind == LoopKind::Spherical,
        None => index - mechanism.loops.len() < mechanism.touches.len(),
    }
}
