"""Reads a log with the readers of the mcap project and checks it against the report of its run and against its URDF.

    readback.py LOG.mcap REPORT.json    a complete log: schemas, times, poses, forward kinematics computed from the URDF
    readback.py LOG.mcap                a log that may be cut off: every message up to there can be decoded
    readback.py --bag LOG.mcap FOLDER   rosbags reads the log, every message by the definition in it, and converts it to a bag
"""

import json
import math
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory as Ros2Decoder
from rosbags.highlevel import AnyReader

EXPECTED = {
    "/robot_description": "std_msgs/msg/String",
    "/visual_markers": "visualization_msgs/msg/MarkerArray",
    "/rosout": "rcl_interfaces/msg/Log",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/reactions": "sensor_msgs/msg/MultiDOFJointState",
    "/energy": "catena_msgs/msg/Energy",
    "/constraint": "catena_msgs/msg/Constraint",
    "/solver": "catena_msgs/msg/Solver",
}
# Only of mechanisms with limits, dry friction or motors.
NONSMOOTH = {"/events": "catena_msgs/msg/Event"}


def decoders():
    return [Ros2Decoder()]


def near(a, b, bound):
    return all(abs(x - y) <= bound for x, y in zip(a, b, strict=True))


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def turned(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def about(axis, angle):
    """Rodrigues' formula."""
    n = math.sqrt(sum(x * x for x in axis))
    x, y, z = (c / n for c in axis)
    c, s, t = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
    ]


def matrix(q):
    w, x, y, z = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def numbers(element, name, default):
    text = element.get(name) if element is not None else None
    return [float(word) for word in (text or default).split()]


def kinematics(urdf, positions):
    """Position and rotation of every link, by the definition of URDF alone."""
    joints = {joint.find("child").get("link"): joint for joint in urdf.findall("joint")}

    def pose(link):
        if link not in joints:
            return [0.0, 0.0, 0.0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        joint = joints[link]
        at, turn = pose(joint.find("parent").get("link"))
        roll, pitch, yaw = numbers(joint.find("origin"), "rpy", "0 0 0")
        step = turned(turn, numbers(joint.find("origin"), "xyz", "0 0 0"))
        at = [a + b for a, b in zip(at, step)]
        turn = times(turn, times(about([0, 0, 1], yaw), times(about([0, 1, 0], pitch), about([1, 0, 0], roll))))
        axis, value = numbers(joint.find("axis"), "xyz", "1 0 0"), positions.get(joint.get("name"), 0.0)
        if joint.get("type") in ("revolute", "continuous"):
            turn = times(turn, about(axis, value))
        elif joint.get("type") == "prismatic":
            n = math.sqrt(sum(x * x for x in axis))
            at = [a + b for a, b in zip(at, turned(turn, [x / n * value for x in axis]))]
        return at, turn

    return {link.get("name"): pose(link.get("name")) for link in urdf.findall("link")}


def check_complete(path, report):
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=decoders(), validate_crcs=True)
        summary = reader.get_summary()
        found = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
        limited = "/events" in found
        assert found == EXPECTED | (NONSMOOTH if limited else {}), found
        attachment = next(reader.iter_attachments())
        urdf = ElementTree.fromstring(attachment.data)
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        assert metadata["end"]["outcome"] == "finished", metadata
        last, counts, joints, events = 0, {}, {}, []
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            assert message.log_time >= last, f"{channel.topic} goes back to {message.log_time}"
            last = message.log_time
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
            if channel.topic == "/joint_states":
                joints = dict(zip(decoded.name, zip(decoded.position, decoded.velocity, strict=True), strict=True))
                expected = kinematics(urdf, {name: q for name, (q, _) in joints.items()})
                for link, (at, turn) in expected.items():
                    position, quaternion = poses[link]
                    # Products of some ten rotations, at lengths of a few metres.
                    assert near(position, at, 1e-12), f"{link}: {position} {at}"
                    rows = matrix(quaternion)
                    assert all(near(a, b, 1e-12) for a, b in zip(rows, turn)), f"{link}: {rows} {turn}"
            if channel.topic == "/events":
                events.append((decoded.time, decoded.kind, decoded.what))
            if channel.topic == "/tf":
                poses = {}
                for frame in decoded.transforms:
                    q, p = frame.transform.rotation, frame.transform.translation
                    assert abs(math.hypot(q.w, q.x, q.y, q.z) - 1) < 1e-12, f"{frame.child_frame_id} at {last}"
                    assert frame.header.frame_id == "world"
                    poses[frame.child_frame_id] = [p.x, p.y, p.z], [q.w, q.x, q.y, q.z]
    assert last == round(report["duration"] * 1e9), last
    listed = [(event["time"], event["kind"], event["what"]) for event in report["events"]["list"]]
    assert events[: len(listed)] == listed, f"{events[:5]} {listed[:5]}"
    assert poses.keys() == report["links"].keys()
    for link, expected in report["links"].items():
        # The report places bodies with what the roundings of the joints' angles left out, which logs do not have.
        end = expected["position"] + expected["orientation"]
        assert near(poses[link][0] + poses[link][1], end, 1e-14), f"{link}: {poses[link]} {expected}"
    for joint, expected in report["joints"].items():
        assert joints[joint] == (expected["position"], expected["velocity"]), f"{joint}: {joints[joint]} {expected}"
    assert counts["/tf"] == counts["/joint_states"] == counts["/reactions"] == round(report["duration"] * 60) + 1, counts
    print(sum(counts.values()))


def check_cut(path):
    count, last = 0, 0
    with open(path, "rb") as stream:
        reader = NonSeekingReader(stream, decoder_factories=decoders())
        try:
            for _, channel, message, _ in reader.iter_decoded_messages(log_time_order=False):
                assert message.log_time >= last, f"{channel.topic} goes back to {message.log_time}"
                count, last = count + 1, message.log_time
        # The second is what this reader says of a file that ends within a number.
        except (EndOfFile, struct.error):
            pass
    print(count)


def bag_messages(path):
    """Every message as rosbags decodes it, by the definitions in the log or bag; it refuses what is no ROS 2 bag."""
    with AnyReader([Path(path)]) as reader:
        for connection, time, raw in reader.messages():
            yield connection, time, reader.deserialize(raw, connection.msgtype)


def check_shapes(message):
    """Collision shapes: translucent, for ever, moving with their frames, each with a number of its own in its namespace; their frames."""
    assert message.markers
    for marker in message.markers:
        assert marker.action == 0 and marker.frame_locked and 0 < marker.color.a < 1, marker
        assert marker.lifetime.sec == marker.lifetime.nanosec == 0
        assert marker.type in (1, 2, 3, 11) and len(marker.points) % 3 == 0
        assert (len(marker.points) > 0) == (marker.type == 11)
    names = {(marker.ns, marker.id) for marker in message.markers}
    assert len(names) == len(message.markers), names
    return {marker.header.frame_id for marker in message.markers}


def check_bag(path, folder):
    counts, latched, last, frames, links = {}, set(), 0, set(), {"world"}
    for connection, time, message in bag_messages(path):
        topic = connection.topic
        counts[topic] = counts.get(topic, 0) + 1
        assert time >= last, f"{topic} goes back to {time}"
        last = time
        if any(profile.durability.name == "TRANSIENT_LOCAL" for profile in connection.ext.offered_qos_profiles):
            latched.add(topic)
        if topic == "/collision_shapes":
            frames = check_shapes(message)
        if topic == "/tf":
            links.update(transform.child_frame_id for transform in message.transforms)
        if topic == "/energy":
            assert message.kinetic >= 0 and math.isfinite(message.total + message.dissipated + message.work)
            stamp = message.header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == time
        if topic == "/joint_states":
            assert len(message.name) == len(message.position) == len(message.velocity) == len(message.effort)
        if topic == "/solver":
            assert message.stages >= 2 and message.iterations >= 0
        if topic == "/constraint":
            assert 0 <= message.position < 1e-9 and 0 <= message.velocity < 1e-9
    touching = {"collision_shapes"} if "/contacts" in counts else set()
    assert {topic.rsplit("/", 1)[-1] for topic in latched} == {"robot_description", "visual_markers"} | touching, latched
    assert frames <= links and bool(frames) == bool(touching), f"{frames} {links}"
    assert all(counts[topic] == 1 for topic in latched), counts
    assert counts["/tf"] > 1, counts
    command = Path(sys.executable).with_name("rosbags-convert")
    subprocess.run([command, "--src", path, "--dst", folder], check=True)
    converted = {}
    for connection, _, _ in bag_messages(folder):
        converted[connection.topic] = converted.get(connection.topic, 0) + 1
    assert converted == counts, f"{converted} {counts}"
    print(sum(counts.values()))


if sys.argv[1] == "--bag":
    check_bag(sys.argv[2], sys.argv[3])
elif len(sys.argv) > 2:
    check_complete(sys.argv[1], json.load(open(sys.argv[2])))
else:
    check_cut(sys.argv[1])
