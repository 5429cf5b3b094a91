"""Joint limits and dry friction against MuJoCo, in one run: CPU time at equal error at the end of five motions.

    benches/peers/venv/bin/python benches/peers/events.py -o peers

MuJoCo makes limits and friction losses soft constraints. It runs with its default softness and with stiff settings
that follow the step (SOFTNESS). The error is the largest difference of a joint angle at the end [rad]. The cost is CPU
time of the stepping loop, the least of several runs; ours is `solve_cpu_seconds` of the report, which
includes the estimate of a tolerance.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

import catena
import peer_mujoco
from measure import clocked
from scene import Start, read_scene

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
TOLERANCE, WHOLE_PROCESS = "catena, tolerance", "catena, tolerance, whole process"
LEVELS = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9)
# Number of repetitions of a run; runs of MuJoCo of more than LONG seconds are made once.
REPEATS = 5
LONG = 0.3

# Centre of mass 0.5 m below the hinge; moment of inertia about the hinge 0.52 kg m².
LINK = """
<robot name="pendulum"><link name="world"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="hinge" type="{type}"><parent link="world"/><child link="rod"/><axis xyz="0 1 0"/>{more}</joint></robot>
"""


@dataclass(frozen=True)
class Motion:
    """A robot, its start and its joint angles at the end; restitution is 0."""

    name: str
    urdf: str
    start: dict[str, float]
    duration: float
    # Exact joint angles [rad]; None: our own fine run is the reference.
    answer: list[float] | None = None

    def options(self) -> list[str]:
        """Start and duration as options of `catena simulate`."""
        start = [f"--position={joint}={angle!r}" for joint, angle in self.start.items()]
        return [*start, "--duration", repr(self.duration)]


@dataclass(frozen=True)
class Measured:
    """A row of the table."""

    motion: str
    method: str
    setting: str
    error: float
    cpu_seconds_per_simulated_second: float
    # Cost of our whole process, also per simulated second: start, reading and run.
    process_cpu_seconds: float | str
    steps: int


def motions() -> list[Motion]:
    """The motions and their exact answers.

    Limit: after the impact at t₁ = 0.458896826103036756 s the pendulum starts again, at rest at -0.3 rad. From there
    q = -2 asin(k sn(ω (t - t₁) + K, k)) with k = sin 0.15 and ω² = 9.81/0.52 s⁻². It touches the limit again at
    1.914 s, at rate zero. Friction: the pendulum turns 13 times at angles that follow from the energy, and sticks at
    the last of them after 9.731 s.
    """
    limit = LINK.format(type="revolute", more='<limit lower="-0.3" upper="3" effort="0" velocity="100"/>')
    friction = LINK.format(type="continuous", more='<dynamics friction="0.45"/>')
    arm = (ROBOTS / "arm7.urdf").read_text()
    double = with_friction("double_pendulum", {"shoulder": 20.0, "elbow": 8.0})
    return [
        Motion("limit", limit, {"hinge": 1.0}, 1.5, [0.06437029520840973826]),
        Motion("limit_touched_again", limit, {"hinge": 1.0}, 3.0, [0.006168759760670080614]),
        Motion("friction", friction, {"hinge": 1.3}, 12.0, [0.00905640504942699298]),
        Motion("arm7_limits", arm, {}, 1.0),
        Motion("double_pendulum_friction", double, {}, 6.0),
    ]


def with_friction(robot: str, friction: dict[str, float]) -> str:
    """One of our robots with dry friction in its joints [N m]."""
    tree = ElementTree.parse(ROBOTS / f"{robot}.urdf").getroot()
    for name, moment in friction.items():
        ElementTree.SubElement(tree.find(f"joint[@name='{name}']"), "dynamics", friction=repr(moment))
    return ElementTree.tostring(tree, encoding="unicode")


@dataclass(frozen=True)
class Softness:
    """Settings of MuJoCo's soft constraints: solref and solimp of limits and friction losses."""

    time_constant: float | None  # in steps; None: everything is MuJoCo's default
    damping_ratio: float = 1.0
    noslip_iterations: int = 0


# A time constant of two steps stops a joint within one step and is the least that MuJoCo accepts; the impedance beside
# it is its largest, 0.9999. At a damping ratio of 1 a limit gives back some of the speed however short the step: exp(-2)
# of it where steps resolve the time constant, up to a quarter here. At a ratio r it gives back at most about 1/(4 r²).
# "noslip" removes the creep of stuck joints.
SOFTNESS = {
    "default": Softness(None),
    "stiff": Softness(2.0),
    "stiff, damping 10": Softness(2.0, damping_ratio=10.0),
    "stiff, damping 100": Softness(2.0, damping_ratio=100.0),
    "stiff, noslip": Softness(2.0, noslip_iterations=10),
}
ON_LIMITS = ("default", "stiff", "stiff, damping 10", "stiff, damping 100")
UNDER_FRICTION = ("default", "stiff", "stiff, noslip")
INTEGRATORS = {
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}


class Peer:
    """A motion in MuJoCo."""

    def __init__(self, motion: Motion, file: Path):
        start = Start(positions={joint: [angle] for joint, angle in motion.start.items()})
        scene = read_scene(file, start, motion.duration)
        self.start = [body.position[0] for body in scene.bodies]
        self.duration = motion.duration
        self.spec = mujoco.MjSpec.from_string(peer_mujoco.document(scene))
        self.spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
        # The joints of the URDF by the links that they move.
        joints = {j.find("child").get("link"): j for j in ElementTree.fromstring(motion.urdf).findall("joint")}
        self.joints, self.softness = [], ON_LIMITS
        for index, body in enumerate(scene.bodies):
            source, target = joints[body.name], self.spec.joint(f"joint_{index}")
            self.joints.append(source.get("name"))
            limit, dynamics = source.find("limit"), source.find("dynamics")
            if limit is not None:
                target.limited = mujoco.mjtLimited.mjLIMITED_TRUE
                target.range = [float(limit.get("lower")), float(limit.get("upper"))]
            if dynamics is not None:
                target.frictionloss = float(dynamics.get("friction"))
                self.softness = UNDER_FRICTION

    def run(self, integrator: str, softness: Softness, step: float) -> tuple[float, np.ndarray, int]:
        """CPU seconds of the stepping loop, joint angles at the end, number of steps."""
        count = round(self.duration / step)
        option = self.spec.option
        option.timestep = self.duration / count
        option.integrator, option.noslip_iterations = INTEGRATORS[integrator], softness.noslip_iterations
        reference, impedance = [0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0]
        if softness.time_constant is not None:
            reference = [softness.time_constant * option.timestep, softness.damping_ratio]
            impedance = [0.9999, 0.9999, 0.001, 0.5, 2.0]
        for joint in self.spec.joints:
            joint.solref_limit = joint.solref_friction = reference
            joint.solimp_limit = joint.solimp_friction = impedance
        model = self.spec.compile()
        best, angles = math.inf, np.zeros(0)
        for _ in range(REPEATS):
            data = mujoco.MjData(model)
            data.qpos[:] = self.start
            best = min(best, clocked(lambda data=data: mujoco.mj_step(model, data, nstep=count)))
            angles = data.qpos.copy()
            if best > LONG:
                break
        return best, angles, count


class Ours:
    """A motion in our own program."""

    def __init__(self, program: str, motion: Motion, file: Path, joints: list[str]):
        self.command = [program, "simulate", str(file), "--no-log", "--json", *motion.options()]
        self.joints = joints

    def run(self, options: list[str], repeats: int = REPEATS) -> tuple[float, float, np.ndarray, int]:
        """CPU seconds of the run and of the whole process, joint angles at the end, number of steps."""
        solve, process, report = math.inf, math.inf, {}
        for _ in range(repeats):
            ended = subprocess.run([*self.command, *options], capture_output=True, text=True, check=False)
            if ended.returncode != 0:
                raise catena.CatenaError(ended.stderr.strip() or f"catena ended with {ended.returncode}")
            report = json.loads(ended.stdout)
            solve, process = min(solve, report["solve_cpu_seconds"]), min(process, report["cpu_seconds"])
        angles = np.array([report["joints"][joint]["position"] for joint in self.joints])
        return solve, process, angles, report["steps"]


def our_settings() -> Iterator[tuple[str, str, list[str]]]:
    """Method, setting and options of our runs."""
    for exponent in range(2, 12):
        yield TOLERANCE, f"tolerance=1e-{exponent}", ["--tolerance", f"1e-{exponent}"]
    for stages, shortest in ((3, 13), (5, 10), (9, 8)):
        for halvings in range(shortest + 1):
            step = 0.5 * 0.5**halvings
            options = ["--stages", str(stages), "--step", repr(step)]
            yield f"catena, {stages} stages", f"step={step!r}", options


def measure(program: str, motion: Motion, folder: Path) -> list[Measured]:
    """Every run of one motion, from coarse to fine for each method."""
    file = folder / f"{motion.name}.urdf"
    file.write_text(motion.urdf)
    peer = Peer(motion, file)
    ours = Ours(program, motion, file, peer.joints)
    if motion.answer is None:
        answer = ours.run(["--stages", "9", "--step", "0.002"], 1)[2]
        other = ours.run(["--stages", "8", "--step", "0.00146"], 1)[2]
        print(f"{motion.name}: two references agree to {np.abs(answer - other).max():.1e} rad")
    else:
        answer = np.array(motion.answer)
    rows = []
    for method, setting, options in our_settings():
        try:
            cpu, process, angles, steps = ours.run(options)
        except catena.CatenaError as failure:
            print(f"{motion.name}: {method}, {setting}: {failure}")
            continue
        error = float(np.abs(angles - answer).max())
        rows.append(
            Measured(motion.name, method, setting, error, cpu / motion.duration, process / motion.duration, steps)
        )
    for integrator in INTEGRATORS:
        for softness in peer.softness:
            for halvings in range(13):
                cpu, angles, steps = peer.run(integrator, SOFTNESS[softness], 0.04 * 0.5**halvings)
                error = float(np.abs(angles - answer).max())
                method, setting = f"MuJoCo {integrator}, {softness}", f"step={motion.duration / steps!r}"
                rows.append(Measured(motion.name, method, setting, error, cpu / motion.duration, "", steps))
    return rows


def curves_of(rows: list[Measured]) -> dict[str, list[tuple[float, float]]]:
    """Error and cost of every run, by method."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        curves.setdefault(row.method, []).append((row.error, row.cpu_seconds_per_simulated_second))
        if row.method == TOLERANCE:
            curves.setdefault(WHOLE_PROCESS, []).append((row.error, row.process_cpu_seconds))
    return curves


def confirmed(curve: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The runs of a ladder, each with the largest error of itself and all finer runs, so that no lucky run counts.

    The finest run has none to confirm it and is left out.
    """
    worst, found = curve[-1][0], []
    for error, cost in reversed(curve[:-1]):
        worst = max(worst, error)
        found.append((worst, cost))
    return found[::-1]


def cost_at(curve: list[tuple[float, float]], level: float) -> float:
    """The least cost at which the error is at most this large and stays so."""
    return min((cost for error, cost in confirmed(curve) if error <= level), default=math.inf)


def best_error(curves: Iterable[list[tuple[float, float]]]) -> float:
    """The least error that any of these methods reaches."""
    return min(error for curve in curves for error, _ in confirmed(curve))


def table(curves: dict[str, list[tuple[float, float]]]) -> str:
    """Costs in microseconds per simulated second at each level, and what the best of MuJoCo costs over ours."""
    lines = [f"  {'method':38}" + "".join(f"{level:>10.0e}" for level in LEVELS) + f"{'best error':>12}"]
    for name, curve in curves.items():
        costs = [cost_at(curve, level) for level in LEVELS]
        cells = "".join(f"{1e6 * cost:10.3g}" if math.isfinite(cost) else f"{'-':>10}" for cost in costs)
        lines.append(f"  {name:38}{cells}{best_error([curve]):12.1e}")
    theirs = {name: curve for name, curve in curves.items() if name.startswith("MuJoCo")}
    fixed = [curve for name, curve in curves.items() if "stages" in name]
    best = best_error(theirs.values())
    for level in (*(level for level in LEVELS if level > best), best):
        cost, name = min((cost_at(curve, level), name) for name, curve in theirs.items())
        ours = (
            ("tolerance", cost_at(curves[TOLERANCE], level)),
            ("tolerance, whole process", cost_at(curves[WHOLE_PROCESS], level)),
            ("best fixed steps", min(cost_at(curve, level) for curve in fixed)),
        )
        ratios = "; ".join(f"{label} {cost / own:.3g}" for label, own in ours)
        lines.append(f"  at {level:.1e} rad: {name} over ours: {ratios}")
    return "\n".join(lines)


def draw(rows: list[Measured], file: Path) -> None:
    """One panel for each motion: cost over error, all runs."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams.update({"svg.hashsalt": "events", "svg.fonttype": "none"})
    from matplotlib import pyplot as plt

    names = list(dict.fromkeys(row.motion for row in rows))
    columns = 3
    figure, axes = plt.subplots(math.ceil(len(names) / columns), columns, figsize=(13.5, 8.5), layout="constrained")
    styles = our_styles() | their_styles()
    handles = {}
    for axis, name in zip(axes.flat, names, strict=False):
        for method, curve in curves_of([row for row in rows if row.motion == name]).items():
            errors, costs = zip(*((max(error, 1e-16), 1e6 * cost) for error, cost in curve), strict=True)
            (handles[method],) = axis.loglog(errors, costs, markersize=3.5, linewidth=1.2, **styles[method])
        axis.set_title(name.replace("_", " "))
        axis.set_xlabel("error at the end [rad]")
        axis.set_ylabel("CPU time [µs per simulated second]")
        axis.grid(color="0.9")
        axis.set_axisbelow(True)
    for axis in axes.flat[len(names) :]:
        axis.set_axis_off()
    place = axes.flat[-1] if len(names) < axes.size else figure
    place.legend([handles[m] for m in styles if m in handles], [m for m in styles if m in handles], loc="center")
    figure.savefig(file, metadata={"Date": None})


def our_styles() -> dict[str, dict]:
    """Lines of our methods."""
    colors = ("black", "0.4", "tab:cyan", "tab:blue", "navy")
    names = ("tolerance", "tolerance, whole process", "3 stages", "5 stages", "9 stages")
    return {f"catena, {name}": {"color": c, "marker": "o"} for name, c in zip(names, colors, strict=True)}


def their_styles() -> dict[str, dict]:
    """Lines of MuJoCo's methods: a colour for each softness, a marker for each integrator."""
    colors = dict(zip(SOFTNESS, ("tab:brown", "tab:red", "tab:orange", "goldenrod", "tab:pink"), strict=True))
    forms = {"implicitfast": {"marker": "s", "linestyle": "-"}, "RK4": {"marker": "^", "linestyle": "--"}}
    return {f"MuJoCo {i}, {s}": {"color": colors[s], **forms[i]} for i in INTEGRATORS for s in SOFTNESS}


def main() -> int:
    """Measures, prints a table for each motion, and writes events.csv and events.svg."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("peers"), metavar="DIR")
    parser.add_argument("--catena", metavar="PATH", help="the program (default: this repository's release build)")
    parser.add_argument("--only", nargs="+", choices=[motion.name for motion in motions()], metavar="MOTION")
    chosen = parser.parse_args()
    chosen.output.mkdir(parents=True, exist_ok=True)
    try:
        program = catena.find(chosen.catena)
    except catena.CatenaError as error:
        print(error, file=sys.stderr)
        return 2
    rows: list[Measured] = []
    with tempfile.TemporaryDirectory() as folder:
        for motion in motions():
            if chosen.only and motion.name not in chosen.only:
                continue
            measured = measure(program, motion, Path(folder))
            rows += measured
            print(f"{motion.name}: CPU µs per simulated second at errors of")
            print(table(curves_of(measured)) + "\n", flush=True)
    with (chosen.output / "events.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(field.name for field in fields(Measured))
        writer.writerows(astuple(row) for row in rows)
    try:
        draw(rows, chosen.output / "events.svg")
    except ImportError:
        print("no figure: matplotlib is not installed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
