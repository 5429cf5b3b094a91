"""Contacts with a floor against MuJoCo: a ball that bounces, and a block that slides down a slope and stops.

    benches/peers/venv/bin/python benches/peers/contacts.py

`README.md` beside this file says how to install MuJoCo. The error is the distance from the exact place of the centre
of mass at the end [m]. The cost is CPU time per simulated second, the least of several runs: of MuJoCo the stepping
loop, of ours `solve_cpu_seconds` of the report, without the trial runs of a tolerance, and the whole process.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

import catena
from measure import clocked

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
GRAVITY = 9.81
REPEATS = 5
STEPS = (1e-2, 1e-3, 1e-4)

DOCUMENT = """
<mujoco><option integrator="implicitfast" cone="elliptic" gravity="0 0 -9.81"/><worldbody>
<geom type="plane" size="0 0 1" zaxis="{normal}" friction="{friction}" condim="3"/>
<body pos="{position}" euler="0 {turn} 0"><freejoint/><geom {shape} friction="{friction}" condim="3" mass="1"/></body>
</worldbody></mujoco>
"""


@dataclass(frozen=True)
class Motion:
    """A scene of `robots/`, the same in MuJoCo, and where the body is at the end."""

    name: str
    duration: float
    document: str
    velocity: tuple[float, float, float]
    answer: np.ndarray  # m
    # solref of the contact for a step [s].
    reference: Callable[[float], tuple[float, float]]


def ball() -> Motion:
    """It falls 1 m, bounces once with restitution 0.8, and is on its way down again after 1 s."""
    duration, restitution = 1.0, 0.8
    falls = math.sqrt(2.0 / GRAVITY)
    since = duration - falls
    height = 0.1 + restitution * GRAVITY * falls * since - 0.5 * GRAVITY * since**2
    document = DOCUMENT.format(
        normal="0 0 1", friction="0", position="0 0 1.1", turn="0", shape='type="sphere" size="0.1"'
    )
    # A spring and damper of this ratio give back 0.8 of the speed; four steps resolve their motion.
    ratio = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    return Motion(
        "ball_dropped", duration, document, (0, 0, 0), np.array([0, 0, height]), lambda step: (4 * step / ratio, ratio)
    )


def block() -> Motion:
    """It starts with 1 m/s down a slope of 20 degrees with friction 0.5, and stops after 0.4 m."""
    slope, friction = math.radians(20.0), 0.5
    distance = 0.5 / (GRAVITY * (friction * math.cos(slope) - math.sin(slope)))
    normal = np.array([math.sin(slope), 0.0, math.cos(slope)])
    down = np.array([math.cos(slope), 0.0, -math.sin(slope)])
    document = DOCUMENT.format(
        normal=" ".join(map(repr, normal.tolist())),
        friction=friction,
        position=" ".join(map(repr, (0.05 * normal).tolist())),
        turn=20.0,
        shape='type="box" size="0.1 0.1 0.05"',
    )
    answer = 0.05 * normal + distance * down
    return Motion("block_on_incline", 2.0, document, tuple(down), answer, lambda step: (2 * step, 1.0))


def theirs(motion: Motion, step: float, stiff: bool) -> tuple[float, float]:
    """Error (m) and CPU seconds per simulated second of MuJoCo."""
    spec = mujoco.MjSpec.from_string(motion.document)
    spec.option.timestep = step
    if stiff:
        for geom in spec.geoms:
            geom.solref = motion.reference(step)
            geom.solimp = [0.9999, 0.9999, 0.001, 0.5, 2.0]
    model = spec.compile()
    best, place = math.inf, np.zeros(3)
    for _ in range(REPEATS):
        data = mujoco.MjData(model)
        data.qvel[:3] = motion.velocity
        count = round(motion.duration / step)
        best = min(best, clocked(lambda data=data, count=count: mujoco.mj_step(model, data, nstep=count)))
        place = data.qpos[:3].copy()
    return float(np.linalg.norm(place - motion.answer)), best / motion.duration


def ours(program: str, motion: Motion, options: list[str]) -> tuple[float, float, float]:
    """Error (m), and CPU seconds per simulated second of the run and of the whole process."""
    command = [program, "simulate", str(ROBOTS / f"{motion.name}.toml"), "--no-log", "--json"]
    command += ["--duration", repr(motion.duration), *options]
    solve, process, place = math.inf, math.inf, np.zeros(3)
    for _ in range(REPEATS):
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise catena.CatenaError(ended.stderr.strip() or f"catena ended with {ended.returncode}")
        report = json.loads(ended.stdout)
        solve, process = min(solve, report["solve_cpu_seconds"]), min(process, report["cpu_seconds"])
        (link,) = report["links"].values()
        place = np.array(link["center_of_mass"])
    return float(np.linalg.norm(place - motion.answer)), solve / motion.duration, process / motion.duration


def main() -> int:
    """Prints a table for each motion."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--catena", metavar="PATH", help="the program (default: this repository's release build)")
    chosen = parser.parse_args()
    try:
        program = catena.find(chosen.catena)
        for motion in (ball(), block()):
            print(f"{motion.name}: error [m], CPU ms per simulated second")
            for exponent in (3, 6, 9):
                error, solve, process = ours(program, motion, ["--tolerance", f"1e-{exponent}"])
                label = f"catena, tolerance 1e-{exponent}"
                print(f"  {label:36}{error:10.1e}{1e3 * solve:10.3g}  (process {1e3 * process:.3g})")
            for stiff in (False, True):
                for step in STEPS:
                    error, cost = theirs(motion, step, stiff)
                    label = f"MuJoCo, {'stiff' if stiff else 'default'}, step {step:g} s"
                    print(f"  {label:36}{error:10.1e}{1e3 * cost:10.3g}", flush=True)
    except catena.CatenaError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
