"""Robots that stand under a controller at 1 kHz, against MuJoCo: CPU time, overlap, and for one of them error over CPU time; some minutes.

    benches/peers/venv/bin/python benches/peers/driven.py -o peers

The models are those of the package `example-robot-data`, which pip puts into the folder `robots` of the output. Without it, and without MuJoCo, a line
says what is left out. Writes `driven.csv`, `driven.svg` and `driven.png`, and prints every run.
"""

from __future__ import annotations

import argparse
import csv
import importlib.util
import json
import math
import subprocess
import sys
import tempfile
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

import catena
from driven_mujoco import Engine

PACKAGE = "example-robot-data==6.0.0"
# Duration of a run whose cost counts, and the period of the controller (s).
DURATION = 1.0
PERIOD = 0.001
# When errors are looked at (s): the robot has landed and still sways; at the end of the run it stands.
SWAYS = 0.2
FRICTION = 0.8
REPEATS = 3
TOLERANCES = tuple(10.0**-power for power in range(2, 10))
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
# The reference of our runs (m), and the robot of which errors are drawn.
FINEST = 1e-11
DRAWN = "a1"


@dataclass(frozen=True)
class Robot:
    """A model of the package, and how it stands."""

    name: str
    urdf: str
    # Angles by parts of the names of joints; the first part that fits counts [rad].
    pose: dict[str, float]
    # Height of the base at the start (m); the controller's gains [N m/rad, N m s/rad].
    height: float
    stiffness: float
    damping: float


ROBOTS = (
    Robot("a1", "a1_description/urdf/a1.urdf", {"thigh": 0.8, "calf": -1.6}, 0.32, 60.0, 2.0),
    Robot("laikago", "laikago_description/urdf/laikago.urdf", {"thigh": 0.7, "calf": -1.4}, 0.46, 150.0, 4.0),
    Robot(
        "anymal",
        "anymal_b_simple_description/robots/anymal.urdf",
        {"F_HFE": 0.5, "F_KFE": -1.0, "H_HFE": -0.5, "H_KFE": 1.0},
        0.58,
        200.0,
        6.0,
    ),
    Robot("go2", "go2_description/urdf/go2.urdf", {"thigh": 0.8, "calf": -1.6}, 0.33, 60.0, 2.0),
    Robot("solo12", "solo_description/robots/solo12.urdf", {"HFE": 0.7, "KFE": -1.4}, 0.27, 10.0, 0.3),
    Robot(
        "g1",
        "g1_description/urdf/g1_29dof_rev_1_0.urdf",
        {"hip_pitch": -0.2, "knee": 0.4, "ankle_pitch": -0.2},
        0.78,
        200.0,
        5.0,
    ),
)


@dataclass(frozen=True)
class Measured:
    """A row of the table."""

    robot: str
    method: str
    setting: float  # tolerance (m) or step (s)
    cpu_seconds_per_simulated_second: float
    overlap: float  # the deepest during the run (m); of MuJoCo at the ends of steps
    error: float  # of the base while it sways, beside the finest run of the same program (m)
    apart: float  # the same beside our finest run (m)


def targets(robot: Robot, path: Path) -> dict[str, float]:
    """The angle of each joint that moves."""
    joints = [joint for joint in ElementTree.parse(path).getroot().findall("joint") if joint.get("type") in ("revolute", "continuous", "prismatic")]
    names = [joint.get("name", "") for joint in joints]
    return {name: next((angle for part, angle in robot.pose.items() if part in name), 0.0) for name in names}


def scene(robot: Robot, path: Path) -> str:
    """The scene file: the robot on a floor, with a motor at each joint whose effort is constant between ticks."""
    angles = targets(robot, path)
    positions = ", ".join(f"{name} = {angle}" for name, angle in angles.items() if angle)
    lines = [
        f'[[robot]]\nname = "{robot.name}"\nurdf = "{path}"\nbase = "floating"',
        f"pose = {{ position = [0, 0, {robot.height}] }}\npositions = {{ {positions} }}",
        '[[obstacle]]\nname = "floor"\nshape = { type = "half_space" }',
        f"[contact]\nfriction = {FRICTION}",
    ]
    for name, angle in angles.items():
        gains = f"kp = {robot.stiffness}\nkd = {robot.damping}\nperiod = {PERIOD}"
        lines.append(f'[[motor]]\njoint = "{name}"\nkind = "position"\ntarget = {angle}\n{gains}')
    return "\n".join([*lines, f"[simulation]\nduration = {DURATION}", ""])


@dataclass(frozen=True)
class Ended:
    """One of our runs."""

    cpu_seconds: float
    overlap: float
    base: np.ndarray


def simulate(program: str, file: Path, tolerance: float, duration: float, repeats: int) -> Ended:
    """The fastest of some runs, by the CPU time of the run without reading the files."""
    command = [program, "simulate", str(file), "--no-log", "--quiet", "--json", "--no-estimate"]
    command += ["--duration", repr(duration), "--tolerance", repr(tolerance)]
    runs = []
    for _ in range(repeats):
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise catena.CatenaError(ended.stderr.strip() or f"catena ended with {ended.returncode}")
        runs.append(json.loads(ended.stdout))
    links = next(iter(runs[0]["links"].values()))
    cost = min(run["cpu_seconds"] for run in runs) / duration
    return Ended(cost, runs[0]["contact"]["max_penetration"], np.array(links["position"]))


def fetch(folder: Path) -> Path | None:
    """The folder of the models, fetched once."""
    robots = folder / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
    if not robots.is_dir():
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(folder), PACKAGE]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0 or not robots.is_dir():
            print(f"left out: the models, because pip could not fetch {PACKAGE}: {ended.stderr.strip()[-200:]}")
            return None
    return robots


def measure(program: str, robots: Path, names: list[str]) -> list[Measured]:
    """All runs of some robots."""
    rows: list[Measured] = []
    there = importlib.util.find_spec("mujoco") is not None
    if not there:
        print("left out: MuJoCo, which is not installed")
    with tempfile.TemporaryDirectory() as room:
        for robot in (robot for robot in ROBOTS if robot.name in names):
            path = robots / robot.urdf
            file = Path(room) / f"{robot.name}.toml"
            file.write_text(scene(robot, path))
            drawn = robot.name == DRAWN
            best = simulate(program, file, FINEST, SWAYS, 1).base if drawn else np.full(3, math.nan)
            for tolerance in TOLERANCES if drawn else (1e-3, 1e-6):
                ended = simulate(program, file, tolerance, DURATION, REPEATS)
                sways = simulate(program, file, tolerance, SWAYS, 1).base if drawn else best
                error = float(np.linalg.norm(sways - best))
                rows.append(Measured(robot.name, "catena", tolerance, ended.cpu_seconds, ended.overlap, error, error))
                print(line(rows[-1]), flush=True)
            if not there:
                continue
            gains = (robot.stiffness, robot.damping)
            try:
                engine = Engine(path, robots, robot.height, targets(robot, path), gains, FRICTION)
            except ValueError as refused:
                print(f"left out: {robot.name} in MuJoCo, which refuses its file: {' '.join(str(refused).split())}")
                continue
            runs = {step: engine.run(DURATION, PERIOD, step, REPEATS) for step in (STEPS if drawn else (PERIOD,))}
            sways = {step: engine.run(SWAYS, PERIOD, step, 1).base for step in runs}
            for step, ended in runs.items():
                error = float(np.linalg.norm(sways[step] - sways[min(runs)])) if step > min(runs) else math.nan
                apart = float(np.linalg.norm(sways[step] - best))
                rows.append(Measured(robot.name, "MuJoCo", step, ended.cpu_seconds, ended.overlap, error, apart))
                print(line(rows[-1]), flush=True)
    return rows


def line(row: Measured) -> str:
    """A row of the table."""
    cost = 1e3 * row.cpu_seconds_per_simulated_second
    return f"  {row.robot:10}{row.method:8}{row.setting:9.0e}{cost:11.1f} ms{row.overlap:11.1e}{row.error:11.1e}{row.apart:11.1e}"


def ratios(rows: list[Measured]) -> None:
    """Prints our time over MuJoCo's with the step of the controller."""
    print("CPU time over that of MuJoCo with steps of 1 ms")
    for tolerance in (1e-3, 1e-6):
        own = {row.robot: row.cpu_seconds_per_simulated_second for row in rows if (row.method, row.setting) == ("catena", tolerance)}
        other = {row.robot: row.cpu_seconds_per_simulated_second for row in rows if (row.method, row.setting) == ("MuJoCo", PERIOD)}
        found = {name: cost / other[name] for name, cost in own.items() if name in other}
        if found:
            print(f"  {tolerance:.0e} m: " + ", ".join(f"{name} {ratio:.1f}" for name, ratio in found.items()) + f"; median {np.median(list(found.values())):.1f}")


def draw(rows: list[Measured], folder: Path) -> None:
    """Error over cost of one robot."""
    if importlib.util.find_spec("matplotlib") is None:
        print("left out: the picture, because matplotlib is not installed")
        return
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams.update({"svg.hashsalt": "driven", "svg.fonttype": "none"})
    from matplotlib import pyplot as plt

    figure, axis = plt.subplots(figsize=(7.6, 5.0), layout="constrained")
    own = [row for row in rows if row.robot == DRAWN]
    curves = (
        ("catena", "error", "catena, 1e-2 to 1e-9 m", "#d55e00", "*-"),
        ("MuJoCo", "error", "MuJoCo, 4 to 0.1 ms, beside its own finest run", "#0072b2", "o-"),
        ("MuJoCo", "apart", "MuJoCo, 4 to 0.05 ms, beside rigid contacts", "#0072b2", "s--"),
    )
    for method, figure_of, label, color, style in curves:
        points = [(getattr(row, figure_of), 1e3 * row.cpu_seconds_per_simulated_second) for row in own if row.method == method]
        points = [(max(error, 1e-16), cost) for error, cost in points if math.isfinite(error)]
        if points:
            axis.loglog(*zip(*points), style, color=color, label=label, linewidth=1.2, markersize=7)
    axis.set_title(f"{DRAWN} under a controller at 1 kHz, {DURATION:g} s")
    axis.set_xlabel(f"error of the base after {SWAYS:g} s, while it sways [m]")
    axis.set_ylabel("CPU time [ms per simulated second]")
    axis.grid(alpha=0.3)
    axis.legend(frameon=False)
    for ending in ("svg", "png"):
        figure.savefig(folder / f"driven.{ending}", dpi=90, metadata={"Date": None} if ending == "svg" else None)


def main() -> int:
    """Measures the robots, prints every run, and writes the files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the files")
    parser.add_argument("--catena", metavar="PATH", help="the program (default: this repository's release build)")
    parser.add_argument("--only", nargs="+", default=[robot.name for robot in ROBOTS], metavar="ROBOT", help="some robots")
    chosen = parser.parse_args()
    chosen.output.mkdir(parents=True, exist_ok=True)
    robots = fetch(chosen.output / "robots")
    if robots is None:
        return 0
    print("  robot     program    setting        cost      overlap      error   beside ours")
    rows = measure(catena.find(chosen.catena), robots, chosen.only)
    ratios(rows)
    with (chosen.output / "driven.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow([field.name for field in fields(Measured)])
        table.writerows(astuple(row) for row in rows)
    draw(rows, chosen.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
