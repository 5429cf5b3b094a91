//! The coordinates q and v of programs: the joint coordinates of reports, in two flat lists.
//!
//! | joint                            | entries of q                  | entries of v                                       |
//! |----------------------------------|-------------------------------|----------------------------------------------------|
//! | revolute, continuous, prismatic  | displacement (rad, m)         | rate [rad/s, m/s]                                  |
//! | planar                           | x, y, angle                   | rates                                              |
//! | spherical                        | quaternion w, x, y, z         | angular velocity of the child [rad/s]              |
//! | floating                         | x, y, z, quaternion w, x, y, z | velocity of the child frame's origin, angular velocity |
//!
//! Vectors are in the joint's frame on the parent. Movable joints come in the order of the bodies: a joint after those that carry it. Efforts,
//! accelerations, mass matrix and Jacobians belong to v: power is the product of efforts and v.
//!
//! The state uses other velocities u for ball and floating joints (angular velocity about axes of the child, velocity of the body's origin): v = T
//! u, with a block of T for each joint.

use crate::mechanism::motion::state::State;
use crate::model::Model;
use crate::session::error::Error;
use nalgebra::DMatrix;
use std::ops::Range;

/// The entries of one joint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointPlace {
    /// The joint.
    pub name: String,
    /// Its entries of q.
    pub q: Range<usize>,
    /// Its entries of v, of efforts and of accelerations.
    pub v: Range<usize>,
    /// Its record in the model.
    pub(crate) record: usize,
}

/// The coordinates of a model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coordinates {
    joints: Vec<JointPlace>,
    /// Whether q and v are position and velocity of the state: there are no ball and no floating joints.
    plain: bool,
}

impl Coordinates {
    /// The coordinates of a model.
    pub(crate) fn of(model: &Model) -> Self {
        let mechanism = &model.mechanism;
        let mut records: Vec<(usize, usize)> =
            model.joints.iter().enumerate().filter_map(|(record, joint)| Some((joint.body?, record))).collect();
        records.sort_unstable();
        let (mut q, mut joints) = (0, Vec::with_capacity(records.len()));
        for (body, record) in records {
            let joint = &mechanism.bodies[body].joint;
            let count = joint.kind.position_count();
            joints.push(JointPlace {
                name: model.joints[record].name.clone(),
                q: q..q + count,
                v: joint.velocity_range(),
                record,
            });
            q += count;
        }
        let plain =
            mechanism.bodies.iter().all(|body| body.joint.kind.position_count() == body.joint.kind.velocity_count());
        Coordinates { joints, plain }
    }

    /// The movable joints.
    pub fn joints(&self) -> &[JointPlace] {
        &self.joints
    }

    /// The entries of a joint.
    pub fn joint(&self, name: &str) -> Option<&JointPlace> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// Length of q.
    pub fn q_count(&self) -> usize {
        self.joints.last().map_or(0, |joint| joint.q.end)
    }

    /// Length of v.
    pub fn v_count(&self) -> usize {
        self.joints.iter().map(|joint| joint.v.len()).sum()
    }

    /// Writes q and v of positions and velocities of a state. Does not allocate.
    #[doc(hidden)]
    pub fn write(&self, model: &Model, position: &[f64], velocity: &[f64], q: &mut [f64], v: &mut [f64]) {
        if self.plain && position.len() == q.len() {
            q.copy_from_slice(position);
            v.copy_from_slice(velocity);
            return;
        }
        for joint in &self.joints {
            let given = model.joint_coordinates(joint.record, position, velocity);
            q[joint.q.clone()].copy_from_slice(given.position());
            v[joint.v.clone()].copy_from_slice(given.velocity());
        }
    }

    /// The state of q and v at time zero. It may violate the loops.
    ///
    /// # Errors
    /// Wrong lengths and numbers that are not finite.
    pub(crate) fn state(&self, model: &Model, q: &[f64], v: &[f64]) -> Result<State, Error> {
        self.check("q", q, self.q_count(), |joint| &joint.q)?;
        self.check("v", v, self.v_count(), |joint| &joint.v)?;
        let mut state = model.zero_state();
        for joint in &self.joints {
            model.set_position(&mut state, &model.joints[joint.record], &q[joint.q.clone()])?;
        }
        for joint in &self.joints {
            model.set_velocity(&mut state, &model.joints[joint.record], &v[joint.v.clone()])?;
        }
        Ok(state)
    }

    /// Puts the joints that are moved in time where they are at a time (s), wherever they were.
    pub(crate) fn put_on_motions(&self, model: &Model, time: f64, q: &mut [f64], v: &mut [f64]) {
        for mimic in model.mechanism.mimics.iter().filter(|mimic| mimic.is_moved()) {
            let own = self.joints.iter().find(|joint| model.joints[joint.record].body == Some(mimic.follower.body));
            if let Some(joint) = own {
                // Such a joint has one coordinate.
                [q[joint.q.start], v[joint.v.start], _] = mimic.motion(time, time);
            }
        }
    }

    /// Splits numbers into joints, as a start lists them.
    pub fn by_joint(&self, numbers: &[f64], range: impl Fn(&JointPlace) -> &Range<usize>) -> Vec<(String, Vec<f64>)> {
        self.joints.iter().map(|joint| (joint.name.clone(), numbers[range(joint).clone()].to_vec())).collect()
    }

    /// Checks the lengths of q and v.
    pub(crate) fn check_lengths(&self, q: &[f64], v: &[f64]) -> Result<(), Error> {
        for (what, given, wanted) in [("q", q.len(), self.q_count()), ("v", v.len(), self.v_count())] {
            if given != wanted {
                return Err(Error::Count { what, given, wanted });
            }
        }
        Ok(())
    }

    /// Checks the count of the numbers, and that they are finite.
    pub(crate) fn check(
        &self,
        what: &'static str,
        numbers: &[f64],
        wanted: usize,
        range: impl Fn(&JointPlace) -> &Range<usize>,
    ) -> Result<(), Error> {
        if numbers.len() != wanted {
            return Err(Error::Count { what, given: numbers.len(), wanted });
        }
        match numbers.iter().position(|number| !number.is_finite()) {
            None => Ok(()),
            Some(index) => {
                let of = self.joints.iter().find(|joint| range(joint).contains(&index));
                let of = of.map_or(String::new(), |joint| joint.name.clone());
                Err(Error::NotFinite { what, of, value: numbers[index] })
            }
        }
    }

    /// T of v = T u at positions of a state; `None` where it is the identity.
    pub(crate) fn velocity_map(&self, model: &Model, position: &[f64]) -> Option<DMatrix<f64>> {
        if self.plain {
            return None;
        }
        let count = model.mechanism.velocity_count;
        let mut map = DMatrix::zeros(count, count);
        let mut unit = vec![0.0; count];
        for joint in &self.joints {
            for freedom in joint.v.clone() {
                unit[freedom] = 1.0;
                let given = model.joint_coordinates(joint.record, position, &unit);
                map.view_mut((joint.v.start, freedom), (joint.v.len(), 1)).copy_from_slice(given.velocity());
                unit[freedom] = 0.0;
            }
        }
        Some(map)
    }

    /// Efforts along v as efforts along u of a state: `Tᵀ τ`.
    pub(crate) fn efforts_of_state(&self, model: &Model, position: &[f64], efforts: &[f64], out: &mut [f64]) {
        match self.velocity_map(model, position) {
            None => out.copy_from_slice(efforts),
            Some(map) => out.copy_from_slice(map.tr_mul(&nalgebra::DVector::from_column_slice(efforts)).as_slice()),
        }
    }
}
