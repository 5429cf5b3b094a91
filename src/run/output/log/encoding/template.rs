//! Messages of which all but the numbers is the same in every sample: encoded once, then copied and filled in.
//!
//! The layout of a CDR message with the same names is always the same, so that the place of each number is known.

use crate::output::log::encoding::cdr;
use crate::output::log::encoding::cdr::CdrWriter;

/// A message of which all but the numbers is the same again and again.
pub(crate) struct Template {
    encoded: Vec<u8>,
    /// The place of the first number of each row.
    rows: Vec<usize>,
}

/// The place of the stamp in the header at the beginning of a message.
const STAMP: std::ops::Range<usize> = 4..12;

impl Template {
    /// A header without a frame, and `count` numbers after it.
    pub(crate) fn numbers(count: usize) -> Self {
        let mut encoded = Vec::new();
        let mut writer = CdrWriter::begin(&mut encoded);
        writer.time(0);
        writer.string("");
        let rows = vec![writer.row(count)];
        Template { encoded, rows }
    }

    /// A `sensor_msgs/msg/JointState`: rows of positions, velocities and efforts.
    pub(crate) fn joint_state<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| [0; 3].map(|_| writer.structures::<1>(count)).to_vec())
    }

    /// A `sensor_msgs/msg/JointState` without efforts: rows of positions and velocities.
    pub(crate) fn slopes<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            let rows = [0; 2].map(|_| writer.structures::<1>(count)).to_vec();
            writer.unsigned(0);
            rows
        })
    }

    /// A `sensor_msgs/msg/JointState` with efforts alone: one row of them.
    pub(crate) fn efforts<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            writer.unsigned(0);
            writer.unsigned(0);
            vec![writer.structures::<1>(count)]
        })
    }

    /// A `sensor_msgs/msg/MultiDOFJointState` with wrenches (force, torque) alone: one row of six numbers each.
    pub(crate) fn wrenches<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            writer.unsigned(0);
            writer.unsigned(0);
            vec![writer.structures::<6>(count)]
        })
    }

    /// A `sensor_msgs/msg/MultiDOFJointState` without wrenches: a row of seven numbers each, x, y, z and the quaternion x, y, z, w, and
    /// one of six, the linear and the angular velocity.
    pub(crate) fn multi_dof<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            let rows = vec![writer.structures::<7>(count), writer.structures::<6>(count)];
            writer.unsigned(0);
            rows
        })
    }

    /// A header, the names, and what `rest` adds, which returns where the rows are.
    fn new<'n>(
        frame: &str,
        names: impl ExactSizeIterator<Item = &'n str>,
        rest: impl FnOnce(&mut CdrWriter) -> Vec<usize>,
    ) -> Self {
        let mut encoded = Vec::new();
        let mut writer = CdrWriter::begin(&mut encoded);
        writer.time(0);
        writer.string(frame);
        writer.unsigned(names.len() as u32);
        names.for_each(|name| writer.string(name));
        let rows = rest(&mut writer);
        Template { encoded, rows }
    }

    /// The message with zeros.
    pub(crate) fn encoded(&self) -> &[u8] {
        &self.encoded
    }

    /// Puts the time into a message.
    pub(crate) fn fill_stamp(&self, message: &mut [u8], nanoseconds: u64) {
        message[STAMP].copy_from_slice(&cdr::time(nanoseconds));
    }

    /// Puts the numbers of a row into a message.
    pub(crate) fn fill(&self, message: &mut [u8], row: usize, values: impl Iterator<Item = f64>) {
        cdr::fill(&mut message[self.rows[row]..], values);
    }

    /// Puts the numbers of a row of structures into a message.
    pub(crate) fn fill_structures<const N: usize>(
        &self,
        message: &mut [u8],
        row: usize,
        structures: impl Iterator<Item = [f64; N]>,
    ) {
        cdr::fill(&mut message[self.rows[row]..], structures.flatten());
    }
}
