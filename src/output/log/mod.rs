//! The log: a run written as MCAP, so that viewers show it without configuration.
//!
//! | topic                | schema                                       | when                                     |
//! |----------------------|----------------------------------------------|------------------------------------------|
//! | `/robot_description` | `std_msgs/msg/String` (ros2msg, cdr)         | once, at t = 0; of several robots `/NAME/robot_description` |
//! | `/scene`             | `foxglove.SceneUpdate` (protobuf)            | once, at t = 0: primitives, embedded meshes, stand-ins |
//! | `/log`               | `foxglove.Log` (protobuf)                    | warnings at t = 0, how the run ended     |
//! | `/tf`                | `foxglove.FrameTransforms` (protobuf)        | every sample: every link, in `world`     |
//! | `/joint_states`      | `sensor_msgs/msg/JointState` (ros2msg, cdr)  | every sample: joints of one number       |
//! | `/multi_dof_joint_states` | `sensor_msgs/msg/MultiDOFJointState` (ros2msg, cdr) | every sample: all other joints |
//! | `/reactions`         | `sensor_msgs/msg/MultiDOFJointState` (ros2msg, cdr) | every sample: wrenches of all joints, in `world` |
//! | `/motors`            | `sensor_msgs/msg/JointState` (ros2msg, cdr)  | every sample: efforts of motors, if there are any |
//! | `/events`            | `catena_msgs/msg/Event` (ros2msg, cdr)       | events: time (s), kind, joint, impulse of an impact |
//! | `/energy`            | `std_msgs/msg/Float64MultiArray` (ros2msg, cdr) | step ends: kinetic, potential, total, dissipated, work (J) |
//! | `/constraint`        | `std_msgs/msg/Float64MultiArray` (ros2msg, cdr) | step ends: position, velocity violation |
//! | `/solver`            | `std_msgs/msg/Float64MultiArray` (ros2msg, cdr) | step ends: last step (s), stages; steps, iterations, rejected since before |
//!
//! The joint messages hold the whole state in the coordinates of the URDF: `/multi_dof_joint_states`, which is there
//! only if there are such joints, has the child link's frame in the joint's frame on the parent.
//!
//! Of mechanisms with limits, dry friction or motors there is `/events`, and `/energy` goes on with what friction and impacts have taken.
//! An event has the definition of its message from the log, as all ROS messages have; its log time is rounded to nanoseconds, its field
//! `time` is not.
//!
//! Links that are fixed to others or to the world are in `/tf` all the same, in every sample, and not once in `/tf_static`:
//! Lichtblick lost the transforms of that topic whenever one jumped back in a log (its pull request 1246 of July 2026), and a log
//! that was cut needs nothing from its beginning. rerun 0.41 would show them. It costs 14 % (Panda) to 47 % (Baxter) of the bytes
//! of a sample.
//! Chunks are not compressed (`container.rs` says why).
//!
//! Rerun draws the robot from `/robot_description` and `/tf` and plots the ROS messages by itself; Foxglove and
//! Lichtblick draw `/scene` when a layout makes it visible; every channel has a schema because PlotJuggler cannot do without. The
//! images of meshes are not in the log: with one a Collada mesh is plain in Foxglove, which says so. The metadata record
//! `simulation` says how the run was made, `inputs` has the hashes of the attachments, which are the URDF and scene files
//! as they were read, and `end` says how the run ended, with the figures of all its steps. Log time and publish time are
//! both the simulated time in nanoseconds and nothing in the file depends on the clock of the wall or of the processor
//! (which is why `/solver` has no CPU time), so that the same run gives the same bytes.
//!
//! A log is written by [`Recorder`] and read by [`reader`], [`decode`] and [`frames`]; [`recovery`] completes one that was cut.
//!
//! [`Recorder`] is the [`crate::simulation::Observer`].

mod background;
mod batch;
mod cdr;
mod comparison;
mod container;
pub mod decode;
mod encoder;
mod error;
mod events;
mod file;
pub mod frame_stream;
pub mod frames;
mod inputs;
mod joints;
mod motors;
mod names;
mod order;
mod output;
mod place;
mod queue;
pub mod reader;
mod recorder;
pub mod records;
pub mod recovery;
mod ros;
mod standin;
mod transforms;
mod visual;

pub use comparison::{Compared, Difference};
pub use error::LogError;
pub use file::{Ending, Outcome};
pub use inputs::{INPUTS, sha256};
pub use output::{is_locked, neighbour};
pub use recorder::{Recorder, Severity};

/// The longest run whose nanoseconds a log can hold (s).
pub const LONGEST: f64 = 1.8e10;

/// Simulated seconds as the nanoseconds of a log: rounded, never negative.
pub fn nanoseconds(time: f64) -> u64 {
    // The cast saturates, so that no time can wrap around.
    (time * 1e9).round() as u64
}

/// The nanoseconds of a log as seconds: divided, because the product with 1e-9 has digits that nobody wrote.
pub fn seconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e9
}
