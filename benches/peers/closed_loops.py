"""Closed loops against MuJoCo, in one run: CPU time per simulated second at equal error, on two problems with known answers.

    benches/peers/venv/bin/python benches/peers/closed_loops.py

The four-bar is a parallelogram that falls through the position in which its rods lie in one line; Bricard's mechanism has one
redundant equation everywhere. The answers are those of the IFToMM benchmark problems A02 and A04, recomputed in quadruple
precision. MuJoCo closes loops by soft `connect` constraints, here as stiff as a step allows (time constant of two steps, impedance
0.9999), because without that its error does not fall with the step at all. Costs are CPU time of the stepping loop, the least of three
runs; of ours `solve_cpu_seconds` of the report.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import subprocess

import mujoco
import numpy as np

from measure import clocked

ROOT = pathlib.Path(__file__).resolve().parents[2]
REPEATS = 3
# CPU seconds after which no shorter step is tried.
ENOUGH = 10.0
ROD = 'mass="1" diaginertia'

FOUR_BAR = f"""
<mujoco><option gravity="0 0 -9.81" timestep="{{step}}" integrator="{{integrator}}" iterations="200" tolerance="1e-12"/>
<default><equality solref="{{constant}} 1" solimp="0.9999 0.9999 0.001"/></default>
<worldbody>
 <body name="crank0"><joint name="q0" axis="0 1 0"/><inertial pos="0 0 0.5" {ROD}="0.08333333333333333 0.08333333333333333 1e-9"/>
  <body name="coupler" pos="0 0 1"><joint name="q1" axis="0 1 0"/><inertial pos="0.5 0 0" {ROD}="1e-9 0.08333333333333333 0.08333333333333333"/></body>
  <site name="watched" pos="0 0 1"/></body>
 <body name="crank1" pos="1 0 0"><joint name="q2" axis="0 1 0"/><inertial pos="0 0 0.5" {ROD}="0.08333333333333333 0.08333333333333333 1e-9"/></body>
</worldbody>
<equality><connect body1="coupler" body2="crank1" anchor="1 0 0"/></equality></mujoco>
"""


def bricard() -> str:
    """Five rods along the edges of a cube, hinged about y, z, x, y, z; the sixth hinge, about x, is two points that stay together."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], dtype=float)
    axes = ["0 1 0", "0 0 1", "1 0 0", "0 1 0", "0 0 1"]
    text, close = "", ""
    for rod in range(5):
        along = points[rod + 1] - points[rod]
        offset = along if rod == 0 else points[rod] - points[rod - 1]
        place = "0 0 0" if rod == 0 else " ".join(map(str, offset))
        inertia = np.where(np.abs(along) > 0.5, 0.01 / 6.0, 1.01 / 12.0)
        site = f'<site name="watched" pos="{" ".join(map(str, along))}"/>' if rod == 1 else ""
        text += (
            f'<body name="rod{rod}" pos="{place}"><joint axis="{axes[rod]}"/>{site}'
            f'<inertial pos="{" ".join(map(str, along / 2))}" {ROD}="{" ".join(map(repr, map(float, inertia)))}"/>'
        )
        close += "</body>"
    # Anchors are in the frame of the last rod, which starts at (0, -1, 1): its end, and a metre further along the axis of the hinge.
    connects = "".join(f'<connect body1="rod4" body2="world" anchor="{x} 1 0"/>' for x in (0, 1))
    return (
        '<mujoco><option gravity="0 -9.81 0" timestep="{step}" integrator="{integrator}" iterations="200" tolerance="1e-12"/>'
        '<default><equality solref="{constant} 1" solimp="0.9999 0.9999 0.001"/></default>'
        f"<worldbody>{text}{close}</worldbody><equality>{connects}</equality></mujoco>"
    )


def mujoco_run(text: str, rates: list[float], duration: float, integrator: str, step: float) -> tuple[float, np.ndarray]:
    """CPU seconds of the stepping loop and where the watched point ends."""
    count = round(duration / step)
    step = duration / count
    model = mujoco.MjModel.from_xml_string(text.format(step=repr(step), integrator=integrator, constant=repr(2.0 * step)))
    best, place = np.inf, np.zeros(3)
    for _ in range(REPEATS):
        data = mujoco.MjData(model)
        data.qvel[:] = rates
        best = min(best, clocked(lambda data=data: mujoco.mj_step(model, data, nstep=count)))
        mujoco.mj_forward(model, data)
        place = data.site("watched").xpos.copy()
        if best > 1.0:
            break
    return best, place


def ours(program: str, scene: str, link: str, point: np.ndarray, duration: float, tolerance: float) -> tuple[float, np.ndarray]:
    """The same of ours."""
    command = [program, "simulate", str(ROOT / "robots" / f"{scene}.toml"), "--no-log", "--json"]
    command += ["--duration", repr(duration), "--tolerance", repr(tolerance)]
    best, place = np.inf, np.zeros(3)
    for _ in range(REPEATS):
        report = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        best = min(best, report["solve_cpu_seconds"])
        end = report["links"][link]
        w, x, y, z = end["orientation"]
        # v + 2 u × (u × v + w v)
        u = np.array([x, y, z])
        place = np.array(end["position"]) + point + 2.0 * np.cross(u, np.cross(u, point) + w * point)
    return best, place


def cost_at(curve: list[tuple[float, float]], error: float) -> float:
    """The least cost from which on every run is at least this accurate, so that no lucky step counts."""
    best = np.nan
    for found, cost in sorted(curve, key=lambda run: -run[1]):
        if not found <= error:
            break
        best = cost
    return best


def main() -> None:
    """Measures, and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=str(ROOT / "target" / "release" / "catena"))
    program = parser.parse_args().program
    problems = [
        ("four_bar_1", FOUR_BAR, [1.0, -1.0, 1.0], 5.0, "crank0", np.array([0.0, 0.0, 1.0]), [-0.9449081860429539, 0.0, -0.32733548531898349]),
        ("bricard", bricard(), [0.0] * 5, 3.6, "rod2", np.array([0.0, -1.0, 0.0]), [-0.15974654806161381, -0.87326781429513911, -0.48724052019119923]),
    ]
    for scene, text, rates, duration, link, point, answer in problems:
        curves: dict[str, list[tuple[float, float]]] = {}
        for integrator in ("Euler", "implicitfast", "RK4"):
            curve = curves.setdefault(f"MuJoCo {integrator}", [])
            for rung in range(20):
                seconds, place = mujoco_run(text, rates, duration, integrator, 0.02 * 0.5**rung)
                curve.append((float(np.linalg.norm(place - answer)), seconds / duration))
                if seconds > ENOUGH:
                    break
        curve = curves.setdefault("catena", [])
        for exponent in range(1, 13):
            seconds, place = ours(program, scene, link, point, duration, 10.0**-exponent)
            curve.append((float(np.linalg.norm(place - answer)), seconds / duration))
        print(f"\n{scene}: CPU ms per simulated second at an error of 1e-3 / 1e-6 / 1e-9 m; smallest error of any run")
        for name, curve in curves.items():
            costs = " / ".join(f"{1e3 * cost_at(curve, error):9.3f}" for error in (1e-3, 1e-6, 1e-9))
            print(f"  {name:20s} {costs}   {min(error for error, _ in curve):.1e} m")


if __name__ == "__main__":
    main()
