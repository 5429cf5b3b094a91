"""Free bodies on a level floor, with exact answers but for the last: the scenes that `contacts.py` runs in every peer.

A slope lies level and gravity leans instead. Places are those of the centres of mass [m].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

GRAVITY = 9.81
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Body:
    """A solid box or ball."""

    mass: float
    position: Vector
    half: Vector | None = None
    radius: float | None = None
    velocity: Vector = (0.0, 0.0, 0.0)
    spin: Vector = (0.0, 0.0, 0.0)

    def inertia(self) -> Vector:
        """Its principal moments of inertia [kg m²]."""
        if self.radius is not None:
            return (0.4 * self.mass * self.radius**2,) * 3
        x, y, z = (side**2 for side in self.half)
        third = self.mass / 3.0
        return (third * (y + z), third * (z + x), third * (x + y))


@dataclass(frozen=True)
class Scene:
    """What is simulated, and where the centres of mass are at the end; without an answer, our own run at 1e-10 m gives it."""

    name: str
    title: str
    duration: float
    bodies: tuple[Body, ...]
    answer: tuple[Vector, ...] | None
    friction: float
    restitution: float = 0.0
    gravity: Vector = (0.0, 0.0, -GRAVITY)


def bouncing_ball() -> Scene:
    """It falls 0.6 m and bounces four times with restitution 0.7 in 1.5 s."""
    radius, gap, restitution, duration = 0.05, 0.6, 0.7, 1.5
    falls = math.sqrt(2.0 * gap / GRAVITY)
    time, speed = falls, restitution * GRAVITY * falls
    while time + 2.0 * speed / GRAVITY < duration:
        time += 2.0 * speed / GRAVITY
        speed *= restitution
    since = duration - time
    height = radius + speed * since - 0.5 * GRAVITY * since**2
    ball = Body(1.0, (0.0, 0.0, radius + gap), radius=radius)
    return Scene(
        "bouncing_ball", "ball, four bounces", duration, (ball,), ((0.0, 0.0, height),), 0.0, restitution=restitution
    )


def block_across_slope() -> Scene:
    """Thrown across a slope of 5 : 12 with friction 0.5, it turns downhill and stops after 1.084 s."""
    speed, ratio = 1.5, 0.5 / (5.0 / 12.0)
    unit = speed**2 / (GRAVITY * 5.0 / 13.0)
    downhill = unit / 4.0 * (1.0 / (2.0 * ratio - 2.0) - 1.0 / (2.0 * ratio + 2.0))
    across = unit / 2.0 * (1.0 / (2.0 * ratio - 1.0) + 1.0 / (2.0 * ratio + 1.0))
    block = Body(1.0, (0.0, 0.0, 0.05), half=(0.2, 0.2, 0.05), velocity=(0.0, speed, 0.0))
    gravity = (GRAVITY * 5.0 / 13.0, 0.0, -GRAVITY * 12.0 / 13.0)
    return Scene(
        "block_across_slope", "block across a slope", 2.0, (block,), ((downhill, across, 0.05),), 0.5, gravity=gravity
    )


def backspin() -> Scene:
    """A ball with backspin slides until it rolls, after 0.35 s."""
    ball = Body(1.0, (0.0, 0.0, 0.12), radius=0.12, velocity=(1.8, 0.0, 0.0), spin=(0.0, -15.0, 0.0))
    return Scene("backspin", "ball with backspin", 3.0, (ball,), ((2.49402733570492417, 0.0, 0.12),), 0.3)


def _stack(name: str, title: str, masses: list[float], duration: float) -> Scene:
    side = 0.1
    bodies = tuple(
        Body(mass, (0.0, 0.0, side * (2 * place + 1)), half=(side, side, side)) for place, mass in enumerate(masses)
    )
    return Scene(name, title, duration, bodies, tuple(body.position for body in bodies), 0.5)


def stack_of_ten() -> Scene:
    """Ten cubes on each other: nothing moves."""
    return _stack("stack_of_ten", "stack of ten, 20 s", [1.0] * 10, 20.0)


def heavy_on_light() -> Scene:
    """A cube of ten tonnes on one of a kilogram: nothing moves."""
    return _stack("heavy_on_light", "10 t on 1 kg, 10 s", [1.0, 1e4], 10.0)


def thrown() -> Scene:
    """Two boxes that tumble against each other and a ball that falls between them, without rebounds; no formula gives their end."""
    half = (0.1, 0.1, 0.1)
    bodies = (
        Body(8.0, (0.0, 0.0, 0.4), half=half, velocity=(1.0, 0.0, 0.0), spin=(2.0, 3.0, 1.0)),
        Body(8.0, (0.6, 0.03, 0.3), half=half, velocity=(-1.0, 0.0, 0.0), spin=(-3.0, 2.0, 2.0)),
        Body(4.0, (0.3, 0.0, 0.9), radius=0.1),
    )
    return Scene("thrown", "two boxes and a ball thrown", 0.5, bodies, None, 0.5)


def scenes() -> list[Scene]:
    """All of them."""
    return [bouncing_ball(), block_across_slope(), backspin(), stack_of_ten(), heavy_on_light(), thrown()]
