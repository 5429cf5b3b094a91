"""Robots that keep still by friction: a quadruped that is dropped and stands, and a box that two pads hold.

Nothing moves in the end, so that every speed of a foot or of the box is an error. Frames of links are those of the URDF files.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

GRAVITY = 9.81
QUADRUPED = Path(__file__).resolve().parents[2] / "robots" / "quadruped.urdf"


@dataclass(frozen=True)
class Shape:
    """A ball (`half` is None) or a box, at a place of its link [m]."""

    at: tuple[float, float, float]
    radius: float = 0.0
    half: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Link:
    """A body and the joint above it, whose frame is turned about y."""

    name: str
    parent: int  # -1 is the world
    kind: str  # floating, revolute, prismatic
    axis: tuple[float, float, float]
    place: tuple[float, float, float]
    pitch: float
    mass: float
    center: tuple[float, float, float]
    inertia: tuple[tuple[float, float, float], ...]  # about the centre of mass, in the axes of the link
    shape: Shape | None = None


@dataclass(frozen=True)
class Scene:
    """What is simulated; joints are pulled to a target by stiffness and damping, or pushed with an effort."""

    name: str
    title: str
    duration: float
    links: tuple[Link, ...]
    friction: float
    floor: bool
    stiffness: float = 0.0
    damping: float = 0.0
    target: float = 0.0
    effort: float = 0.0

    def trees(self) -> list[list[int]]:
        """The links of each robot: one for every link on the world."""
        of: list[int] = []
        for number, link in enumerate(self.links):
            of.append(number if link.parent < 0 else of[link.parent])
        return [[number for number, root in enumerate(of) if root == tree] for tree in dict.fromkeys(of)]


def turned(pitch: float) -> np.ndarray:
    """A rotation about y."""
    c, s = math.cos(pitch), math.sin(pitch)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _numbers(element: ElementTree.Element, name: str) -> tuple[float, ...]:
    return tuple(float(word) for word in element.get(name).split())


def quadruped() -> Scene:
    """`robots/quadruped.urdf` with its feet for shapes, dropped from 5 cm; motors of 200 N m/rad and 5 N m s/rad hold twelve joints."""
    document = ElementTree.parse(QUADRUPED).getroot()
    joints = {joint.find("child").get("link"): joint for joint in document.findall("joint")}
    names: list[str] = []
    links = []
    for element in document.findall("link"):
        name = element.get("name")
        inertial = element.find("inertial")
        moments = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
        inertia = tuple(tuple(moments["i" + "".join(sorted(a + b))] for b in "xyz") for a in "xyz")
        foot = next((one for one in element.findall("collision") if one.find("geometry/sphere") is not None), None)
        shape = None
        if foot is not None:
            shape = Shape(
                _numbers(foot.find("origin"), "xyz"), radius=float(foot.find("geometry/sphere").get("radius"))
            )
        joint = joints.get(name)
        if joint is None:
            above = (-1, "floating", (0.0, 0.0, 1.0), (0.0, 0.0, 0.3233062112 + 0.05), 0.0)
        else:
            place, rpy = _numbers(joint.find("origin"), "xyz"), _numbers(joint.find("origin"), "rpy")
            parent = names.index(joint.find("parent").get("link"))
            above = (parent, "revolute", _numbers(joint.find("axis"), "xyz"), place, rpy[1])
        center = _numbers(inertial.find("origin"), "xyz")
        links.append(Link(name, *above, float(inertial.find("mass").get("value")), center, inertia, shape))
        names.append(name)
    return Scene("quadruped", "quadruped stands, 100 s", 100.0, tuple(links), 0.8, True, stiffness=200.0, damping=5.0)


def _box(name: str, kind: str, axis, place, mass: float, half) -> Link:
    square = [side * side for side in half]
    moments = [mass / 3.0 * (sum(square) - square[axis]) for axis in range(3)]
    inertia = tuple(tuple(moments[a] if a == b else 0.0 for b in range(3)) for a in range(3))
    return Link(name, -1, kind, axis, place, 0.0, mass, (0.0, 0.0, 0.0), inertia, Shape((0.0, 0.0, 0.0), half=half))


def _gripped() -> tuple[Link, ...]:
    pad = (0.01, 0.02, 0.02)
    left = _box("left", "prismatic", (1.0, 0.0, 0.0), (-0.035, 0.0, 0.0), 0.1, pad)
    right = _box("right", "prismatic", (-1.0, 0.0, 0.0), (0.035, 0.0, 0.0), 0.1, pad)
    cube = _box("cube", "floating", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.1, (0.025, 0.025, 0.025))
    return (left, right, cube)


def gripper() -> Scene:
    """Springs press two pads on a cube of 0.1 kg with 2 N each; friction 0.5 could carry 2 N, and the cube weighs 0.98 N."""
    title = "springs hold a box, 60 s"
    return Scene("gripper", title, 60.0, _gripped(), 0.5, False, stiffness=200.0, damping=5.0, target=0.01)


def neutral_gripper() -> Scene:
    """The same with forces of 2 N, whatever the place: nothing but that they are equal keeps the three of them together from drifting across."""
    return Scene("neutral_gripper", "two forces hold a box, 60 s", 60.0, _gripped(), 0.5, False, effort=2.0)


def scenes() -> list[Scene]:
    """All of them."""
    return [quadruped(), gripper(), neutral_gripper()]


def urdf(scene: Scene, tree: list[int], properties: str = "") -> str:
    """One robot of a scene as URDF; `properties` go into every collision shape."""

    def words(numbers) -> str:
        return " ".join(repr(float(number)) for number in numbers)

    text = [f'<robot name="{scene.links[tree[0]].name}">']
    for number in tree:
        link = scene.links[number]
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = link.inertia
        shape = ""
        if link.shape:
            geometry = f'<sphere radius="{link.shape.radius!r}"/>'
            if link.shape.half:
                geometry = f'<box size="{words(2.0 * side for side in link.shape.half)}"/>'
            origin = f'<origin xyz="{words(link.shape.at)}"/>'
            shape = f"<collision>{origin}<geometry>{geometry}</geometry>{properties}</collision>"
        text.append(
            f'<link name="{link.name}"><inertial><origin xyz="{words(link.center)}"/><mass value="{link.mass!r}"/>'
            f'<inertia ixx="{xx!r}" ixy="{xy!r}" ixz="{xz!r}" iyy="{yy!r}" iyz="{yz!r}" izz="{zz!r}"/></inertial>{shape}</link>'
        )
        if link.kind == "floating":
            continue
        if link.parent < 0:
            text.append('<link name="world"/>')
        kind = "continuous" if link.kind == "revolute" else "prismatic"
        limit = '<limit lower="-1" upper="1" effort="1000" velocity="1000"/>' if kind == "prismatic" else ""
        parent = scene.links[link.parent].name if link.parent >= 0 else "world"
        text.append(
            f'<joint name="{link.name}_joint" type="{kind}"><parent link="{parent}"/><child link="{link.name}"/>'
            f'<origin xyz="{words(link.place)}" rpy="0 {link.pitch!r} 0"/><axis xyz="{words(link.axis)}"/>{limit}</joint>'
        )
    return "".join(text) + "</robot>"
