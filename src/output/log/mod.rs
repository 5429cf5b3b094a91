//! The log of a run: a ROS 2 bag in one MCAP file, which ROS 2 tools play and viewers show.
//!
//! All messages are CDR, and the profile of the file is `ros2`. Every channel has the definition of its messages as its schema.
//!
//! | topic                | message                                 | when                                     |
//! |----------------------|-----------------------------------------|------------------------------------------|
//! | `/robot_description` | `std_msgs/msg/String`                   | once, at the start; of several robots `/NAME/robot_description` |
//! | `/visual_markers`    | `visualization_msgs/msg/MarkerArray`    | once, at the start: primitives, triangles of meshes, stand-ins |
//! | `/collision_shapes`  | `visualization_msgs/msg/MarkerArray`    | once, at the start: the shapes of links and obstacles, if any may touch |
//! | `/rosout`            | `rcl_interfaces/msg/Log`                | warnings at the start, how the run ended |
//! | `/tf`                | `tf2_msgs/msg/TFMessage`                | every sample: every link, in `world`     |
//! | `/joint_states`      | `sensor_msgs/msg/JointState`            | every sample: joints of one number       |
//! | `/multi_dof_joint_states` | `sensor_msgs/msg/MultiDOFJointState` | every sample: all other joints         |
//! | `/reactions`         | `sensor_msgs/msg/MultiDOFJointState`    | every sample: wrenches of all joints, in `world` |
//! | `/motors`            | `sensor_msgs/msg/JointState`            | every sample: efforts of motors, if there are any |
//! | `/contacts`          | `catena_msgs/msg/Contacts`              | every sample: closed contacts and their forces, if shapes may touch |
//! | `/contact_forces`    | `visualization_msgs/msg/MarkerArray`    | every sample: the same forces as arrows  |
//! | `/ropes`             | `visualization_msgs/msg/MarkerArray`    | every sample: ropes as lines             |
//! | `/events`            | `catena_msgs/msg/Event`                 | events: time (s), kind, joint or pair `a\|b`, impulse of an impact |
//! | `/energy`            | `catena_msgs/msg/Energy`                | step ends: the parts of the energy (J), by name |
//! | `/constraint`        | `catena_msgs/msg/Constraint`            | step ends: constraint errors of positions and velocities |
//! | `/solver`            | `catena_msgs/msg/Solver`                | step ends: last step (s), stages; steps, iterations, rejections since before |
//! | `/sensitivities/KEY` | `sensor_msgs/msg/JointState`            | step ends: derivatives by a parameter, with `--sensitivity` |
//!
//! The joint messages hold the whole state in the coordinates of the URDF: `/multi_dof_joint_states`, which is there
//! only if there are such joints, has the child link's frame in the joint's frame on the parent.
//!
//! Mechanisms with limits, dry friction or motors have `/events`. The log time of an event is rounded to nanoseconds, its field
//! `time` is not. `catena_msgs` is no package: its definitions are in the log. `ros2 bag play` leaves out topics whose package is not
//! installed, with a warning, and plays the others.
//!
//! The first three topics never change. They are offered to those who come late, too (durability `transient_local`). Their chunk is compressed
//! by Zstandard. Chunks of samples hold what their messages repeat once (LZ4), and are compressed by Zstandard on request ([`LogOptions`]).
//!
//! Links that are fixed to others or to the world are in `/tf` all the same, in every sample, and not once in `/tf_static`. Lichtblick lost the
//! transforms of that topic whenever one jumped back in a log (its pull request 1246 of July 2026). A log that was cut needs no message from its
//! beginning then. rerun 0.41 would show `/tf_static`. The choice costs 14 % (Panda) to 47 % (Baxter) of the bytes of a sample.
//!
//! rerun and RViz draw the robot from `/robot_description` and `/tf`; Foxglove, Lichtblick and RViz draw `/visual_markers` and
//! `/collision_shapes`, which need no other file. The images of meshes are not in the log. There is no `foxglove.SceneUpdate`: Foxglove
//! draws all shapes from these markers, and a second encoding would keep `ros2 bag play` from playing the file. The metadata record
//! `simulation` says how the run was made, `inputs` has the hashes of the attachments, which are the URDF and scene files
//! as they were read, and `end` says how the run ended, with the figures of all its steps. Log time and publish time are
//! both the time of the run in nanoseconds after the start of the log, which is zero unless the user sets it ([`START`]); `/solver` has no CPU time.
//! So the same run gives the same bytes.
//!
//! A log is written by [`Recorder`] and read by [`reading`].
//!
//! [`Recorder`] is the [`crate::simulation::Observer`].
//!
//! | room | what is in it |
//! |---|---|
//! | `encoding` | messages as bytes, and the words that all topics share |
//! | [`reading`] | logs read back |
//! | `storage` | the file, and its place on disk |
//! | `messages` | the topics |
//! | `recording` | from the run to the file |

mod encoding;
pub(crate) mod messages;
pub mod reading;
pub(crate) mod recording;
mod storage;

pub use encoding::ending::{Ending, Outcome};
pub use encoding::names::START;
pub use encoding::severity::Severity;
pub use encoding::time::{LONGEST, nanoseconds, seconds};
pub use messages::options::{LogOptions, Meshes};
pub use messages::sensitivities::{Derivatives, DerivativesRow};
pub use messages::topics::{Topics, UnknownTopic};
pub use recording::comparison::{Compared, Difference};
pub use recording::recorder::Recorder;
pub use storage::error::LogError;
pub use storage::inputs::{INPUTS, sha256};
pub use storage::output::{is_locked, neighbour};
