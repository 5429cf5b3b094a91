"""A scene for all peers: a tree of bodies read from a URDF, the state it starts from and how long it runs.

Every peer is built from this tree and not by its own URDF reader, so that all of them simulate the same thing: links that
hang on fixed joints are lumped into their parents, shapes, limits and drives are left out, inertia is used as it is
written. A body's frame is the frame of its first link; its axes stay parallel to that frame.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

SINGLE_AXIS = ("revolute", "prismatic")


class SceneError(Exception):
    """The scene holds something these runners do not know."""


@dataclass
class Body:
    """A moving body and the joint that holds it, all numbers in SI units."""

    name: str
    parent: int  # index of the parent body, -1 for the world
    kind: str  # revolute, prismatic or floating
    axis: list[float]  # in the joint's frame
    frame_rotation: list[list[float]]  # of the joint's frame on the parent
    frame_position: list[float]
    mass: float
    center_of_mass: list[float]  # in the body's frame
    inertia: list[list[float]]  # about the centre of mass, in the body's axes
    # One number for a single axis; x, y, z, roll, pitch, yaw and the velocity of the body's origin, angular velocity (both
    # in the joint's frame on the parent) for a floating joint.
    position: list[float] = field(default_factory=lambda: [0.0])
    velocity: list[float] = field(default_factory=lambda: [0.0])


@dataclass
class Scene:
    """A tree of bodies, parents first."""

    name: str
    urdf: str
    duration: float
    gravity: list[float]
    bodies: list[Body]

    def save(self, path: Path) -> None:
        """Writes the scene for a runner in another process."""
        path.write_text(json.dumps(asdict(self)))

    @staticmethod
    def load(path: Path) -> Scene:
        """Reads what `save` wrote."""
        data = json.loads(path.read_text())
        data["bodies"] = [Body(**body) for body in data["bodies"]]
        return Scene(**data)

    def placements(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Rotation and origin of every body's frame in the world at the start."""
        placed: list[tuple[np.ndarray, np.ndarray]] = []
        for body in self.bodies:
            rotation, origin = placed[body.parent] if body.parent >= 0 else (np.eye(3), np.zeros(3))
            origin = origin + rotation @ np.array(body.frame_position)
            rotation = rotation @ np.array(body.frame_rotation)
            axis = np.array(body.axis)
            if body.kind == "revolute":
                placed.append((rotation @ turn(axis, body.position[0]), origin))
            elif body.kind == "prismatic":
                placed.append((rotation, origin + rotation @ axis * body.position[0]))
            else:
                offset, angles = np.array(body.position[:3]), body.position[3:]
                placed.append((rotation @ roll_pitch_yaw(*angles), origin + rotation @ offset))
        return placed

    def twists(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Velocity of the origin and angular velocity of every body at the start, in the world."""
        placed = self.placements()
        twists: list[tuple[np.ndarray, np.ndarray]] = []
        for body, (_, origin) in zip(self.bodies, placed, strict=True):
            if body.parent >= 0:
                parent_rotation, parent_origin = placed[body.parent]
                linear, angular = twists[body.parent]
                linear = linear + np.cross(angular, origin - parent_origin)
            else:
                parent_rotation, linear, angular = np.eye(3), np.zeros(3), np.zeros(3)
            frame = parent_rotation @ np.array(body.frame_rotation)
            if body.kind == "floating":
                linear, angular = linear + frame @ body.velocity[:3], angular + frame @ body.velocity[3:]
            else:
                along = frame @ np.array(body.axis) * body.velocity[0]
                if body.kind == "revolute":
                    angular = angular + along
                else:
                    linear = linear + along
            twists.append((linear, angular))
        return twists


def probes(scene: Scene, placements: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Four points of every body in the world: its centre of mass and the tips of its axes.

    The tips lie at the radius at which the mass sits on average, as in `catena chart`, so that a body that only spins has
    an error too. Shape (bodies, 4, 3).
    """
    points = np.empty((len(scene.bodies), 4, 3))
    for row, body, (rotation, origin) in zip(points, scene.bodies, placements, strict=True):
        center = np.asarray(origin) + np.asarray(rotation) @ np.array(body.center_of_mass)
        radius = math.sqrt(max(0.0, 0.5 * np.trace(np.array(body.inertia)) / body.mass)) if body.mass > 0 else 0.0
        row[0] = center
        row[1:] = center + radius * np.asarray(rotation).T
    return points


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation by an angle about a unit axis (Rodrigues)."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """The rotation of URDF's rpy: about the fixed axes x, y, z in this order."""
    x, y, z = np.eye(3)
    return turn(z, yaw) @ turn(y, pitch) @ turn(x, roll)


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """The unit quaternion (w, x, y, z) of a rotation matrix, exact to rounding everywhere."""
    r = np.asarray(rotation)
    trace = np.trace(r)
    # Four times the products of the components; the row with the largest diagonal loses no digits.
    products = np.array(
        [
            [1 + trace, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], 1 + 2 * r[0, 0] - trace, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 1 + 2 * r[1, 1] - trace, r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1 + 2 * r[2, 2] - trace],
        ]
    )
    row = products[np.argmax(np.diag(products))]
    return row / np.linalg.norm(row)


def rotation_matrix(wxyz: np.ndarray) -> np.ndarray:
    """The rotation matrix of a quaternion (w, x, y, z)."""
    w, x, y, z = np.asarray(wxyz) / np.linalg.norm(wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@dataclass
class Start:
    """What the command line says about the start; the words mean what they mean to `catena simulate`."""

    positions: dict[str, list[float]] = field(default_factory=dict)
    velocities: dict[str, list[float]] = field(default_factory=dict)
    floating: bool = False
    base_pose: list[float] = field(default_factory=lambda: [0.0] * 6)
    base_velocity: list[float] = field(default_factory=lambda: [0.0] * 6)
    gravity: list[float] = field(default_factory=lambda: [0.0, 0.0, -9.81])

    def options(self) -> list[str]:
        """The same as options of `catena`."""

        def text(numbers: list[float]) -> str:
            return ",".join(repr(float(number)) for number in numbers)

        options = ["--gravity", text(self.gravity), "--base-pose", text(self.base_pose)]
        if self.floating:
            options += ["--base", "floating", "--base-velocity", text(self.base_velocity)]
        for flag, values in (("--position", self.positions), ("--velocity", self.velocities)):
            for joint, numbers in values.items():
                options += [flag, f"{joint}={text(numbers)}"]
        return options


def read_scene(urdf: Path, start: Start, duration: float) -> Scene:
    """Reads a URDF and lumps what does not move."""
    robot = ElementTree.parse(urdf).getroot()
    links = {link.get("name"): _inertial(link) for link in robot.findall("link")}
    joints = robot.findall("joint")
    children: dict[str, list[ElementTree.Element]] = {}
    for joint in joints:
        children.setdefault(joint.find("parent").get("link"), []).append(joint)
    child_names = {joint.find("child").get("link") for joint in joints}
    roots = [name for name in links if name not in child_names]
    if len(roots) != 1:
        raise SceneError(f"{urdf}: {len(roots)} root links")
    unknown = (set(start.positions) | set(start.velocities)) - {joint.get("name") for joint in joints}
    if unknown:
        raise SceneError(f"{urdf}: no joint {', '.join(sorted(unknown))}")

    scene = Scene(urdf.stem, str(urdf), duration, start.gravity, [])
    base = (roll_pitch_yaw(*start.base_pose[3:]), np.array(start.base_pose[:3]))
    fixed_to_world = -1
    if start.floating:
        identity = (np.eye(3), np.zeros(3))
        body = _body(roots[0], -1, "floating", np.zeros(3), identity, links[roots[0]])
        body.position, body.velocity = list(start.base_pose), list(start.base_velocity)
        scene.bodies.append(body)
        fixed_to_world, base = 0, identity

    # Depth first, in the order of the file; each entry is a link, the body it belongs to and its place on that body.
    stack = [(roots[0], fixed_to_world, base)]
    while stack:
        link, owner, (rotation, position) = stack.pop()
        pending = []
        for joint in children.get(link, []):
            offset, angles = _origin(joint)
            place = (rotation @ roll_pitch_yaw(*angles), position + rotation @ offset)
            child, kind = joint.find("child").get("link"), joint.get("type")
            if kind == "fixed":
                if owner >= 0:
                    _lump(scene.bodies[owner], links[child], place)
                pending.append((child, owner, place))
                continue
            kind = "revolute" if kind == "continuous" else kind
            if kind not in (*SINGLE_AXIS, "floating"):
                raise SceneError(f"joint {joint.get('name')} is {kind}, which these runners do not know")
            body = _body(child, owner, kind, _axis(joint), place, links[child])
            size = 1 if kind in SINGLE_AXIS else 6
            body.position = start.positions.get(joint.get("name"), [0.0] * size)
            body.velocity = start.velocities.get(joint.get("name"), [0.0] * size)
            scene.bodies.append(body)
            pending.append((child, len(scene.bodies) - 1, (np.eye(3), np.zeros(3))))
        stack.extend(reversed(pending))
    if not scene.bodies:
        raise SceneError(f"{urdf}: nothing in it moves")
    return scene


def _origin(element: ElementTree.Element) -> tuple[np.ndarray, list[float]]:
    origin = element.find("origin")
    get = (lambda key: "0 0 0") if origin is None else (lambda key: origin.get(key, "0 0 0"))
    return np.array([float(word) for word in get("xyz").split()]), [float(word) for word in get("rpy").split()]


def _axis(joint: ElementTree.Element) -> np.ndarray:
    axis = joint.find("axis")
    vector = np.array([float(word) for word in ("1 0 0" if axis is None else axis.get("xyz")).split()])
    return vector / np.linalg.norm(vector)


def _inertial(link: ElementTree.Element) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of mass and inertia about it, in the link's axes."""
    inertial = link.find("inertial")
    if inertial is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    center, angles = _origin(inertial)
    entry = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
    matrix = np.array(
        [
            [entry["ixx"], entry["ixy"], entry["ixz"]],
            [entry["ixy"], entry["iyy"], entry["iyz"]],
            [entry["ixz"], entry["iyz"], entry["izz"]],
        ]
    )
    rotation = roll_pitch_yaw(*angles)
    return float(inertial.find("mass").get("value")), center, rotation @ matrix @ rotation.T


def _body(name, parent, kind, axis, place, inertial) -> Body:
    mass, center, inertia = inertial
    rotation, position = place
    return Body(
        name, parent, kind, axis.tolist(), rotation.tolist(), position.tolist(), mass, center.tolist(), inertia.tolist()
    )


def _lump(body: Body, inertial, place) -> None:
    """Adds a link that is fixed to the body; the parallel-axis theorem about the common centre of mass."""
    mass, center, inertia = inertial
    rotation, position = place
    center, inertia = position + rotation @ center, rotation @ inertia @ rotation.T
    own_center = np.array(body.center_of_mass)
    total = body.mass + mass
    if total == 0.0:
        return
    common = (body.mass * own_center + mass * center) / total
    moments = np.array(body.inertia) + inertia
    for part, place_of_part in ((body.mass, own_center), (mass, center)):
        arm = place_of_part - common
        moments += part * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    body.mass, body.center_of_mass, body.inertia = total, common.tolist(), moments.tolist()
