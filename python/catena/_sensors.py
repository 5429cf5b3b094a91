"""Sensors as robots have them, and their noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _catena
from ._errors import InputError
from ._model import _count


class Sensed:
    """What sensors measure at one instant of a simulation. Made by :meth:`Sim.sense`."""

    def __init__(self, inner):
        self._inner = inner

    def imu(self, link: str, place: ArrayLike = (0, 0, 0)) -> np.ndarray:
        """What an inertial measurement unit reads at a place on a link, given in the link's frame [m]: accelerometer [m/s²], which reads gravity
        upwards at rest, then gyroscope [rad/s], in the link's frame (6)."""
        return self._inner.imu(link, _count(place, 3, "place"))

    def joint_effort(self, joint: str) -> float:
        """What a joint of one freedom passes on to its child along it, with its motor, friction, spring and damper [N m or N]."""
        return self._inner.joint_effort(joint)

    def wrench(self, joint: str) -> np.ndarray:
        """Force and torque of the parent on the child of a joint, about its anchor, in the frame of the child link [N, N m] (6)."""
        return self._inner.wrench(joint)

    def contact_force(self, link: str) -> np.ndarray:
        """The force of all contacts of a link on it, in the world [N] (3)."""
        return self._inner.contact_force(link)

    def touches(self, link: str) -> bool:
        """Whether a link touches anything."""
        return self._inner.touches(link)

    def __repr__(self):
        return "<catena.Sensed>"


class Noise:
    """Noise of a sensor: ``noise(readings)`` adds a bias and normal numbers of a standard deviation; the same seed gives the same numbers."""

    def __init__(self, deviation: float, bias: float = 0.0, seed: int = 0):
        if not (np.isfinite(deviation) and deviation >= 0 and np.isfinite(bias)):
            raise InputError(f"deviation is {deviation} and bias {bias}: give finite numbers, and no negative deviation")
        self._deviation, self._bias, self._seed = float(deviation), float(bias), int(seed)
        self._inner = _catena.Noise(self._bias, self._deviation, self._seed)

    def __call__(self, readings: ArrayLike) -> np.ndarray:
        readings = np.asarray(readings, dtype=float)
        return self._inner.add(np.ascontiguousarray(readings.ravel())).reshape(readings.shape)

    def __repr__(self):
        return f"<catena.Noise: deviation {self._deviation:.6g}, bias {self._bias:.6g}, seed {self._seed}>"
