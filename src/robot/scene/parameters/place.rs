//! The places of numbers in a scene: one variant for each kind.

use crate::scene::coupling::JointReference;

/// A place of a number. Robots, links and all tables are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Place {
    Gravity(usize),
    BasePosition {
        robot: usize,
        axis: usize,
    },
    BaseTurn {
        robot: usize,
        angle: usize,
    },
    BaseVelocity {
        robot: usize,
        number: usize,
    },
    /// Of what a body is made from.
    Body {
        robot: usize,
        what: BodyNumber,
    },
    /// One of `count` numbers of a joint.
    Position {
        robot: usize,
        joint: String,
        number: usize,
        count: usize,
    },
    Velocity {
        robot: usize,
        joint: String,
        number: usize,
        count: usize,
    },
    Mass {
        robot: usize,
        link: usize,
    },
    LinkFriction {
        robot: usize,
        link: usize,
    },
    LinkRestitution {
        robot: usize,
        link: usize,
    },
    /// Length of rolling friction of a link, or of spinning friction if it is 1.
    LinkMoment {
        robot: usize,
        link: usize,
        of: usize,
    },
    /// Velocity of the surface of a link along an axis.
    LinkSurface {
        robot: usize,
        link: usize,
        axis: usize,
    },
    CenterOfMass {
        robot: usize,
        link: usize,
        axis: usize,
    },
    Inertia {
        robot: usize,
        link: usize,
        row: usize,
        column: usize,
    },
    /// An angle of the axes in which the inertia of a link is given.
    InertiaTurn {
        robot: usize,
        link: usize,
        angle: usize,
    },
    /// A number of a collision shape.
    Collision {
        robot: usize,
        link: usize,
        shape: usize,
        what: ShapeNumber,
    },
    Origin {
        robot: usize,
        joint: usize,
        axis: usize,
    },
    OriginTurn {
        robot: usize,
        joint: usize,
        angle: usize,
    },
    Axis {
        robot: usize,
        joint: usize,
        axis: usize,
    },
    EffortBound {
        robot: usize,
        joint: usize,
    },
    SpeedBound {
        robot: usize,
        joint: usize,
    },
    MimicMultiplier {
        robot: usize,
        joint: usize,
    },
    MimicOffset {
        robot: usize,
        joint: usize,
    },
    LowerLimit(JointReference),
    UpperLimit(JointReference),
    Restitution(JointReference),
    Friction(JointReference),
    Damping(JointReference),
    Armature(JointReference),
    Motor {
        motor: usize,
        what: MotorNumber,
    },
    /// The time of an entry of a motor's table.
    TargetTime {
        motor: usize,
        entry: usize,
    },
    TargetValue {
        motor: usize,
        entry: usize,
    },
    /// The time of an entry of the table of a moved joint.
    MotionTime {
        motion: usize,
        entry: usize,
    },
    MotionValue {
        motion: usize,
        entry: usize,
    },
    /// A parameter of the formula of a moved joint.
    MotionParameter {
        motion: usize,
        index: usize,
    },
    /// The position of a joint that is moved to one place.
    MotionPosition(usize),
    /// A parameter of the formula of a motor's target.
    TargetParameter {
        motor: usize,
        index: usize,
    },
    Spring {
        spring: usize,
        what: SpringNumber,
    },
    SpringEnd {
        spring: usize,
        b: bool,
        axis: usize,
    },
    RopeLength(usize),
    RopeRestitution(usize),
    RopeStop(usize),
    RopeEnd {
        rope: usize,
        end: usize,
        axis: usize,
    },
    LoopLength(usize),
    LoopEnd {
        of: usize,
        b: bool,
        axis: usize,
    },
    LoopAxis {
        of: usize,
        b: bool,
        axis: usize,
    },
    /// A number of a `<loop_joint>`, as the two variants that follow.
    UrdfLoopAxis {
        robot: usize,
        of: usize,
        axis: usize,
    },
    UrdfLoopEnd {
        robot: usize,
        of: usize,
        b: bool,
        axis: usize,
    },
    UrdfLoopTurn {
        robot: usize,
        of: usize,
        b: bool,
        angle: usize,
    },
    LoadEffort(usize),
    Load {
        load: usize,
        what: LoadNumber,
    },
    /// The time of an entry of the factor of a load.
    FactorTime {
        load: usize,
        entry: usize,
    },
    FactorValue {
        load: usize,
        entry: usize,
    },
    /// A parameter of the formula of the factor of a load.
    FactorParameter {
        load: usize,
        index: usize,
    },
    CouplingTerm {
        coupling: usize,
        term: usize,
    },
    CouplingOffset(usize),
    Drag {
        drag: usize,
        number: usize,
    },
    DragPosition {
        drag: usize,
        axis: usize,
    },
    LoadForce {
        load: usize,
        axis: usize,
    },
    LoadTorque {
        load: usize,
        axis: usize,
    },
    LoadPosition {
        load: usize,
        axis: usize,
    },
    ObstacleFriction(usize),
    ObstacleRestitution(usize),
    ObstacleMoment {
        obstacle: usize,
        of: usize,
    },
    ObstacleSurface {
        obstacle: usize,
        axis: usize,
    },
    ObstaclePosition {
        obstacle: usize,
        axis: usize,
    },
    ObstacleTurn {
        obstacle: usize,
        angle: usize,
    },
    ObstacleShape {
        obstacle: usize,
        what: ShapeNumber,
    },
    ObstacleNormal {
        obstacle: usize,
        axis: usize,
    },
    ContactFriction,
    ContactRestitution,
    ContactMoment(usize),
    SelfContact,
    PairFriction(usize),
    PairRestitution(usize),
    PairMoment {
        rule: usize,
        of: usize,
    },
    Duration,
    Tolerance,
    Stages,
    Step,
    Rate,
}

/// The numbers that a body is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BodyNumber {
    /// Its density or mass, whichever the file gives.
    Weight,
    /// Of its shape.
    Shape(ShapeNumber),
}

/// The numbers of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotorNumber {
    Kp,
    Kd,
    Target,
    MaxEffort,
    Period,
    GravityCompensation,
}

/// The numbers of a load over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LoadNumber {
    From,
    Until,
    Factor,
    Mean,
    Amplitude,
    Frequency,
    Phase,
}

/// The numbers of a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SpringNumber {
    Stiffness,
    Damping,
    Rest,
}

/// The numbers of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ShapeNumber {
    Radius,
    Length,
    /// A radius of an ellipsoid, along an axis.
    Radii(usize),
    /// Along an axis.
    Size(usize),
    /// Scale of a mesh, along an axis.
    Scale(usize),
    /// Position in the frame of its link, along an axis.
    Position(usize),
    /// The roll, pitch or yaw of its frame in the frame of its link.
    Turn(usize),
    Friction,
    Restitution,
    /// Length of rolling friction, or of spinning friction if it is 1.
    Moment(usize),
    /// Velocity of its surface along an axis of its link.
    SurfaceVelocity(usize),
}
