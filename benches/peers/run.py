#!/usr/bin/env python3
"""Measures the peers on the same scenes and draws them into one picture with catena.

    python benches/peers/run.py robots/double_pendulum.urdf robots/arm7.urdf -o out
    python benches/peers/run.py arm.urdf --position elbow=0.4 --duration 3 --only mujoco pinocchio

For every scene: out/SCENE.csv with all peers, and, if this catena has `chart`, out/SCENE/ with pictures, our own curves and
the comparators, and a table of the cost at 1e-3, 1e-6 and 1e-9.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import catena
from scene import Scene, SceneError, Start, read_scene
from worker import NOT_FOR_THIS_SCENE, NOT_INSTALLED

HERE = Path(__file__).resolve().parent
PEERS = {
    "mujoco": ["mujoco-euler", "mujoco-implicitfast", "mujoco-rk4"],
    "pinocchio": ["pinocchio-rk4", "pinocchio-dop853"],
    "drake": ["drake-discrete", "drake-runge-kutta3", "drake-runge-kutta5", "drake-radau3"],
    "exudyn": ["exudyn-generalized-alpha", "exudyn-trapezoidal", "exudyn-tree-rk44", "exudyn-tree-dopri5"],
    "rapier": ["rapier-multibody", "rapier-impulse"],
}
COLUMNS = [
    "scene",
    "method",
    "setting",
    "error",
    "cpu_seconds_per_simulated_second",
    "steps",
    "center_of_mass_error",
    "ended",
]
LEVELS = (1e-3, 1e-6, 1e-9)


def arguments() -> argparse.Namespace:
    """The command line; what describes the start is spelled as `catena simulate` spells it."""
    parser = argparse.ArgumentParser(description="Measures the peers on the same scenes and charts them with catena.")
    parser.add_argument("inputs", nargs="+", type=Path, metavar="URDF")
    parser.add_argument("-o", "--output", type=Path, default=Path("peers"), metavar="DIR")
    parser.add_argument("--duration", type=float, help="simulated time [s] (default 2)")
    parser.add_argument("--position", action="append", default=[], metavar="JOINT=VALUE")
    parser.add_argument("--velocity", action="append", default=[], metavar="JOINT=VALUE")
    parser.add_argument(
        "--state", type=Path, metavar="FILE.json", help='{"duration": S, "initial": {JOINT: {"position", "velocity"}}}'
    )
    parser.add_argument("--base", choices=["fixed", "floating"], default="fixed")
    parser.add_argument("--base-pose", default="0,0,0,0,0,0")
    parser.add_argument("--base-velocity", default="0,0,0,0,0,0")
    parser.add_argument("--gravity", default="0,0,-9.81")
    parser.add_argument("--only", nargs="+", choices=PEERS, default=list(PEERS), metavar="PEER")
    parser.add_argument(
        "--budget", type=float, default=4.0, help="CPU time of the longest run of a method [s] (default 4)"
    )
    parser.add_argument("--reference-step", type=float, default=0.005, help="step of the reference, nine stages [s]")
    parser.add_argument("--catena", metavar="PATH", help="the program (default: this repository's release build)")
    parser.add_argument("--quick", action="store_true", help="a smaller chart")
    return parser.parse_args()


def numbers(text: str) -> list[float]:
    """Numbers separated by commas."""
    return [float(word) for word in text.split(",")]


def start_of(chosen: argparse.Namespace, urdf: Path) -> tuple[Start, float]:
    """The start of one input; with several inputs a joint that one does not have is meant for another."""
    start = Start(
        floating=chosen.base == "floating",
        base_pose=numbers(chosen.base_pose),
        base_velocity=numbers(chosen.base_velocity),
        gravity=numbers(chosen.gravity),
    )
    duration = 2.0
    if chosen.state is not None:
        state = json.loads(chosen.state.read_text())
        duration = state.get("duration", duration)
        for joint, values in state["initial"].items():
            start.positions[joint] = np.atleast_1d(values.get("position", 0.0)).tolist()
            start.velocities[joint] = np.atleast_1d(values.get("velocity", 0.0)).tolist()
    text = urdf.read_text()
    for given, taken in ((chosen.position, start.positions), (chosen.velocity, start.velocities)):
        for assignment in given:
            joint, _, values = assignment.rpartition("=")
            if len(chosen.inputs) == 1 or f'"{joint}"' in text:
                taken[joint] = numbers(values)
    return start, chosen.duration or duration


def run_peers(chosen: argparse.Namespace, scene: Scene, reference: np.ndarray, rows: Path) -> None:
    """Every method in a process of its own, so that none can take the others with it."""
    with rows.open("w", newline="") as file:
        csv.writer(file).writerow(COLUMNS)
    with tempfile.TemporaryDirectory() as folder:
        scene_file, reference_file = Path(folder) / "scene.json", Path(folder) / "reference.npy"
        scene.save(scene_file)
        np.save(reference_file, reference)
        for peer in chosen.only:
            for method in PEERS[peer]:
                command = [sys.executable, str(HERE / "worker.py"), peer, method, str(scene_file), str(reference_file)]
                command += [str(rows.resolve()), str(chosen.budget)]
                # Repetitions, coarse rungs and loading on top of the longest run; more than that hangs.
                limit = 60 + 12 * chosen.budget
                try:
                    # In the temporary folder: some peers leave logs where they are started.
                    ended = subprocess.run(
                        command, cwd=folder, capture_output=True, text=True, timeout=limit, check=False
                    )
                except subprocess.TimeoutExpired:
                    print(f"  {method}: cut after {limit:.0f} s, what it had measured is kept")
                    continue
                reason = (ended.stderr.strip().splitlines() or ["no word"])[-1]
                if ended.returncode == NOT_INSTALLED:
                    print(f"  {peer}: not installed ({reason}); skipped")
                    break
                if ended.returncode == NOT_FOR_THIS_SCENE:
                    print(f"  {method}: skipped: {reason}")
                elif ended.returncode != 0:
                    print(f"  {method}: ended with {ended.returncode}: {reason}")
                else:
                    print(f"  {method}: done")


def read_rows(*files: Path) -> dict[str, list[tuple[float, float]]]:
    """Error and cost of every finished run, by method."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for file in files:
        if not file.is_file():
            continue
        with file.open(newline="") as handle:
            for row in csv.DictReader(handle):
                if row["ended"] == "done" and row["error"] and row["cpu_seconds_per_simulated_second"]:
                    point = (float(row["error"]), float(row["cpu_seconds_per_simulated_second"]))
                    curves.setdefault(row["method"], []).append(point)
    return curves


def cost_at(curve: list[tuple[float, float]], level: float) -> float:
    """The lowest cost at this error: of a run that is good enough, or between two neighbouring runs on both sides of it.

    Between neighbours the cost follows a power of the error; otherwise a ladder of steps by two would be read too high.
    """
    best = min((cost for error, cost in curve if error <= level), default=math.inf)
    for (coarse, cheap), (fine, dear) in pairwise(curve):
        if coarse > level >= fine > 0:
            share = math.log(coarse / level) / math.log(coarse / fine)
            best = min(best, cheap * (dear / cheap) ** share)
    return best


def table(curves: dict[str, list[tuple[float, float]]]) -> str:
    """Cost at each level in microseconds per simulated second, and over the cheapest of our own curves."""
    ours = [
        min((cost_at(c, level) for m, c in curves.items() if m.startswith("lobatto")), default=math.inf)
        for level in LEVELS
    ]
    lines = [f"{'method':30}" + "".join(f"{level:>22.0e}" for level in LEVELS)]
    for method, curve in curves.items():
        cells = []
        for level, best in zip(LEVELS, ours, strict=True):
            cost = cost_at(curve, level)
            ratio = f" ({cost / best:.1f}x)" if math.isfinite(best) and math.isfinite(cost) else ""
            cells.append(f"{1e6 * cost:.1f} us{ratio}" if math.isfinite(cost) else "-")
        lines.append(f"{method:30}" + "".join(f"{cell:>22}" for cell in cells))
    return "\n".join(lines)


def main() -> int:
    """Scene after scene."""
    chosen = arguments()
    chosen.output.mkdir(parents=True, exist_ok=True)
    failed = False
    try:
        program = catena.find(chosen.catena)
    except catena.CatenaError as error:
        print(error, file=sys.stderr)
        return 2
    draws = catena.has_chart(program)
    if not draws:
        print("this catena has no chart: numbers only")
    for urdf in chosen.inputs:
        print(urdf.stem)
        try:
            start, duration = start_of(chosen, urdf)
            scene = read_scene(urdf, start, duration)
            reference, uncertainty = catena.reference(program, scene, start, chosen.reference_step)
        except (OSError, SceneError, catena.CatenaError) as error:
            print(f"  skipped: {error}", file=sys.stderr)
            failed = True
            continue
        print(f"  reference: two stage numbers agree to {uncertainty:.1e} m")
        rows = chosen.output / f"{scene.name}.csv"
        run_peers(chosen, scene, reference, rows)
        folder = chosen.output / scene.name
        drawn = draws and catena.chart(program, scene, start, rows, folder, chosen.quick)
        failed |= draws and not drawn
        print(flush=True)
        print(table(read_rows(rows, *([folder / "measurements.csv"] if drawn else []))))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
