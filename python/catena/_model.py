"""Robots and scenes, and their equations of motion."""

from __future__ import annotations

import os

import numpy as np

from . import _catena
from ._errors import InputError


def as_array(numbers, what, axes, wanted):
    """Numbers as an array of so many axes."""
    try:
        array = np.ascontiguousarray(numbers, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what}: {error}") from None
    if array.ndim != axes:
        raise InputError(f"{what}: an array {wanted} is wanted, not of shape {array.shape}")
    return array


def flat(numbers, what):
    """Numbers as a flat array."""
    return as_array(numbers, what, 1, "of one axis")


def load(path, *, base="fixed", base_pose=None, gravity=None, floor=None, contact=None, without=(), packages=None, params=None):
    """Reads a robot (``.urdf``) or a scene (``.toml``).

    Parameters
    ----------
    path : path of the file
    base : ``"fixed"`` as the file says, or ``"floating"``
    base_pose : x, y, z, roll, pitch, yaw of the root link in the world [m, rad]
    gravity : acceleration of gravity in the world, x, y, z [m/s²]; (0, 0, -9.81) if neither this nor the file says otherwise
    floor : height of a floor under everything [m]
    contact : which shapes may touch: ``"none"``, ``"environment"`` or ``"all"``
    without : what is left out: ``"limits"``, ``"friction"``, ``"damping"``, ``"motors"``, ``"contact"``
    packages : folders of ROS packages by name
    params : numbers by key path, as of :meth:`Model.with_params`

    Raises
    ------
    InputError : what is wrong with the file, with its line
    """
    if base not in ("fixed", "floating"):
        raise InputError(f"base is {base!r}: give 'fixed' or 'floating'")
    without = [without] if isinstance(without, str) else list(without)
    pose = None if base_pose is None else _count(base_pose, 6, "base_pose")
    down = None if gravity is None else _count(gravity, 3, "gravity")
    inner = _catena.Model(
        os.fspath(path), base == "floating", pose, down, floor, contact, without, dict(packages or {}), _params(params or {})
    )
    return Model(inner)


def _count(numbers, count, what):
    array = flat(numbers, what)
    if len(array) != count:
        raise InputError(f"{what}: {count} numbers are wanted, not {len(array)}")
    return array.tolist()


def _params(params):
    try:
        return {str(key): float(number) for key, number in dict(params).items()}
    except (TypeError, ValueError) as error:
        raise InputError(f"params: {error}") from None


class Model:
    """A robot or scene, ready to be simulated; it never changes. Made by :func:`load`.

    q and v hold the coordinates of the joints that move, one joint after another: lengths, angles and their rates; a ball joint has a quaternion
    w, x, y, z in q and its angular velocity in v, a floating one x, y, z, w, x, y, z and its velocity and angular velocity. Efforts, accelerations
    and matrices go with v. SI units.
    """

    def __init__(self, inner):
        self._inner = inner

    @property
    def name(self) -> str:
        """Name of the robot or scene."""
        return self._inner.name

    @property
    def path(self):
        """The file it was read from."""
        return self._inner.path

    @property
    def joint_names(self) -> list[str]:
        """Joints that move, in the order of q and v."""
        return self._inner.joint_names

    @property
    def link_names(self) -> list[str]:
        """All links, in the order of the file."""
        return self._inner.link_names

    @property
    def warnings(self) -> list[str]:
        """What was left out and why, and what else is worth knowing."""
        return self._inner.warnings

    @property
    def params(self) -> dict[str, float | None]:
        """Numbers by key path, as the files say them; None where they do not."""
        return dict(self._inner.params())

    def with_params(self, params) -> Model:
        """The same with other numbers, by key path: ``model.with_params({"link7.mass": 2.5, "gravity.z": -1.62})``.

        ``model.params`` has all key paths; the first word may be left out where one number remains.
        """
        return Model(self._inner.with_params(_params(params)))

    def start(self):
        """q and v where the file starts it, with all loops closed."""
        return self._inner.start()

    def mass_matrix(self, q):
        """The mass matrix M(q), (n, n)."""
        return self._inner.mass_matrix(flat(q, "q"))

    def jacobian(self, link, q):
        """The Jacobian (6, n) of a link: velocity of its frame's origin, then its angular velocity, in the world, for v."""
        return self._inner.jacobian(link, flat(q, "q"))

    def inverse_dynamics(self, q, v, a):
        """The efforts (n) that give the accelerations a = dv/dt, besides gravity, springs, dampers and loads; of the tree without its loops."""
        return self._inner.inverse_dynamics(flat(q, "q"), flat(v, "v"), flat(a, "a"))

    def forward_dynamics(self, q, v, efforts):
        """The accelerations dv/dt (n) under efforts; of the tree without its loops."""
        return self._inner.forward_dynamics(flat(q, "q"), flat(v, "v"), flat(efforts, "efforts"))

    def gravity_efforts(self, q):
        """The efforts (n) that hold it at rest against gravity alone."""
        return self._inner.gravity_efforts(flat(q, "q"))

    def pose(self, link, q):
        """x, y, z and the quaternion w, x, y, z of a link frame in the world."""
        return self._inner.pose(link, flat(q, "q"))

    def __repr__(self):
        return f"<catena.Model {self.name!r}: {len(self.link_names)} links, {len(self.joint_names)} joints that move>"
