//! The ROS 2 messages of the log, as their schemas define them.
//!
//! A `ros2msg` schema is the definition of the message, followed by the definitions of the messages it uses. Each of them comes after a line of 80
//! equals signs and a line that names it. A reader with the schema decodes messages of any package. Source: MCAP format registry
//! (mcap.dev/spec/registry), "ros2msg"; the packages `common_interfaces`, `geometry2` and `rcl_interfaces` of ROS 2.

/// The beginning of the topics of derivatives.
pub(crate) const SENSITIVITIES: &str = "/sensitivities";

/// The definition of a message.
pub(crate) struct Definition {
    /// Package and name, as in `std_msgs/msg/Header`.
    pub name: &'static str,
    /// Its fields, one a line.
    pub fields: &'static str,
    /// The messages among its fields.
    pub uses: &'static [&'static Definition],
}

impl Definition {
    /// The text of the schema.
    pub(crate) fn schema(&self) -> String {
        let mut used: Vec<&Definition> = Vec::new();
        self.gather(&mut used);
        let mut text = self.fields.to_string();
        for definition in used {
            text.push_str(&"=".repeat(80));
            // In definitions of fields and schemas the part between package and name is left out.
            text.push_str(&format!("\nMSG: {}\n", definition.name.replace("/msg/", "/")));
            text.push_str(definition.fields);
        }
        text
    }

    /// Adds the messages that this one uses, each once.
    fn gather<'d>(&'d self, used: &mut Vec<&'d Definition>) {
        for definition in self.uses {
            if used.iter().all(|known| known.name != definition.name) {
                used.push(definition);
                definition.gather(used);
            }
        }
    }
}

static TIME: Definition =
    Definition { name: "builtin_interfaces/msg/Time", fields: "int32 sec\nuint32 nanosec\n", uses: &[] };

static DURATION: Definition =
    Definition { name: "builtin_interfaces/msg/Duration", fields: "int32 sec\nuint32 nanosec\n", uses: &[] };

/// The beginning of messages about an instant.
pub(crate) static HEADER: Definition = Definition {
    name: "std_msgs/msg/Header",
    fields: "builtin_interfaces/Time stamp\nstring frame_id\n",
    uses: &[&TIME],
};

static COLOR: Definition =
    Definition { name: "std_msgs/msg/ColorRGBA", fields: "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n", uses: &[] };

/// Three numbers of a direction.
pub(crate) static VECTOR: Definition =
    Definition { name: "geometry_msgs/msg/Vector3", fields: "float64 x\nfloat64 y\nfloat64 z\n", uses: &[] };

/// Three numbers of a place.
pub(crate) static POINT: Definition =
    Definition { name: "geometry_msgs/msg/Point", fields: "float64 x\nfloat64 y\nfloat64 z\n", uses: &[] };

static QUATERNION: Definition = Definition {
    name: "geometry_msgs/msg/Quaternion",
    fields: "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
    uses: &[],
};

static POSE: Definition = Definition {
    name: "geometry_msgs/msg/Pose",
    fields: "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    uses: &[&POINT, &QUATERNION],
};

static TRANSFORM: Definition = Definition {
    name: "geometry_msgs/msg/Transform",
    fields: "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    uses: &[&VECTOR, &QUATERNION],
};

static TRANSFORM_STAMPED: Definition = Definition {
    name: "geometry_msgs/msg/TransformStamped",
    fields: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    uses: &[&HEADER, &TRANSFORM],
};

static TWIST: Definition = Definition {
    name: "geometry_msgs/msg/Twist",
    fields: "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
    uses: &[&VECTOR],
};

static WRENCH: Definition = Definition {
    name: "geometry_msgs/msg/Wrench",
    fields: "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
    uses: &[&VECTOR],
};

/// Text: the description of a robot.
pub(crate) static STRING: Definition = Definition { name: "std_msgs/msg/String", fields: "string data\n", uses: &[] };

/// The frames of links.
pub(crate) static TRANSFORMS: Definition = Definition {
    name: "tf2_msgs/msg/TFMessage",
    fields: "geometry_msgs/TransformStamped[] transforms\n",
    uses: &[&TRANSFORM_STAMPED],
};

/// Joints of one number.
pub(crate) static JOINT_STATE: Definition = Definition {
    name: "sensor_msgs/msg/JointState",
    fields: "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    uses: &[&HEADER],
};

/// Joints of several numbers, or the wrenches in joints.
pub(crate) static MULTI_DOF_JOINT_STATE: Definition = Definition {
    name: "sensor_msgs/msg/MultiDOFJointState",
    fields: "std_msgs/Header header\nstring[] joint_names\ngeometry_msgs/Transform[] transforms\n\
             geometry_msgs/Twist[] twist\ngeometry_msgs/Wrench[] wrench\n",
    uses: &[&HEADER, &TRANSFORM, &TWIST, &WRENCH],
};

/// A line of text.
pub(crate) static LOG: Definition = Definition {
    name: "rcl_interfaces/msg/Log",
    fields: "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\n\
             builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line\n",
    uses: &[&TIME],
};

static UV: Definition =
    Definition { name: "visualization_msgs/msg/UVCoordinate", fields: "float32 u\nfloat32 v\n", uses: &[] };

static IMAGE: Definition = Definition {
    name: "sensor_msgs/msg/CompressedImage",
    fields: "std_msgs/Header header\nstring format\nuint8[] data\n",
    uses: &[&HEADER],
};

static MESH_FILE: Definition =
    Definition { name: "visualization_msgs/msg/MeshFile", fields: "string filename\nuint8[] data\n", uses: &[] };

static MARKER: Definition = Definition {
    name: "visualization_msgs/msg/Marker",
    fields: "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n\
             int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n\
             int32 TRIANGLE_LIST=11\nint32 ARROW_STRIP=12\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n\
             std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
             geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n\
             bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
             sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n\
             string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
    uses: &[&HEADER, &POSE, &VECTOR, &COLOR, &DURATION, &POINT, &IMAGE, &UV, &MESH_FILE],
};

/// The message that viewers draw: the geometry of the robots, arrows.
pub(crate) static MARKER_ARRAY: Definition = Definition {
    name: "visualization_msgs/msg/MarkerArray",
    fields: "visualization_msgs/Marker[] markers\n",
    uses: &[&MARKER],
};

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader needs every message that a field names, and may refuse one that is defined twice.
    #[test]
    fn a_schema_defines_every_message_that_it_uses_once() {
        for definition in [&STRING, &TRANSFORMS, &JOINT_STATE, &MULTI_DOF_JOINT_STATE, &LOG, &MARKER_ARRAY] {
            let schema = definition.schema();
            let defined: Vec<&str> = schema.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
            let mut once = defined.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), defined.len(), "{}", definition.name);
            let types =
                schema.lines().filter(|line| !line.starts_with("MSG: ")).filter_map(|line| line.split_once(' '));
            for (kind, _) in types.filter(|(kind, _)| kind.contains('/')) {
                assert!(defined.contains(&kind.trim_end_matches("[]")), "{}: {kind}", definition.name);
            }
        }
    }
}
