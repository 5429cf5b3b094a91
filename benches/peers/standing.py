"""A quadruped that stands and a gripper that holds, against MuJoCo, Rapier and Drake: creep and overlap over CPU time, in one run of some minutes.

    benches/peers/venv/bin/python benches/peers/standing.py -o peers

`README.md` beside this file says how to install the peers; one that is not there is left out with a line that says so. Writes `standing.csv`,
`standing.svg` and `standing.png`, and prints every run.
"""

from __future__ import annotations

import argparse
import csv
import importlib.util
import math
import sys
import tempfile
from dataclasses import astuple, fields
from pathlib import Path

import catena
import standing_peers
from standing_peers import Measured
from standing_scenes import scenes

# Creeps are drawn no smaller [m/s].
LEAST = 1e-18
COLORS = {"catena": "#d55e00", "MuJoCo": "#0072b2", "Rapier": "#009e73", "Drake": "#cc79a7"}
MARKERS = "os^vdPX<>"


def line(row: Measured) -> str:
    """A row of the table."""
    cost = 1e6 * row.cpu_seconds_per_simulated_second
    return f"  {row.method:36}{row.setting:28}{row.creep:10.1e}{row.moved:10.1e}{row.overlap:11.1e}{cost:14.4g}"


def draw(rows: list[Measured], folder: Path) -> None:
    """One panel for each scene: creep over cost, all runs."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams.update({"svg.hashsalt": "standing", "svg.fonttype": "none"})
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(15.5, 6.4), layout="constrained")
    methods = list(dict.fromkeys(row.method for row in rows))
    handles = {}
    for axis, scene in zip(axes, scenes(), strict=True):
        for method in methods:
            own = [row for row in rows if (row.scene, row.method) == (scene.name, method)]
            own = [row for row in own if math.isfinite(row.cpu_seconds_per_simulated_second)]
            if not own:
                continue
            engine = method.split(",")[0]
            kin = [other for other in methods if other.split(",")[0] == engine]
            costs = [1e6 * row.cpu_seconds_per_simulated_second for row in own]
            creeps = [min(max(row.creep, LEAST), 10.0) for row in own]
            style = {"color": COLORS[engine], "marker": "*" if engine == "catena" else MARKERS[kin.index(method)]}
            dashed = {"linestyle": "--"} if "whole" in method or "discrete" in method else {}
            (handles[method],) = axis.loglog(creeps, costs, markersize=6, linewidth=1.2, **style, **dashed)
        axis.set_title(scene.title)
        axis.set_xlabel(f"creep in the second half [m/s]; {LEAST:g} is none")
        axis.set_ylabel("CPU time [µs per simulated second]")
        axis.set_xlim(0.3 * LEAST, 30.0)
        axis.grid(alpha=0.3)
    title = "lower and further left is better"
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False, title=title)
    for ending in ("svg", "png"):
        figure.savefig(folder / f"standing.{ending}", dpi=90, metadata={"Date": None} if ending == "svg" else None)


def main() -> int:
    """Measures all scenes, prints every run, and writes the files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the files")
    parser.add_argument("--catena", metavar="PATH", help="the program (default: this repository's release build)")
    chosen = parser.parse_args()
    chosen.output.mkdir(parents=True, exist_ok=True)
    there = {"MuJoCo": bool(importlib.util.find_spec("mujoco")), "Drake": bool(importlib.util.find_spec("pydrake"))}
    there["Rapier"] = standing_peers.RAPIER.is_file()
    for name in (name for name, is_there in there.items() if not is_there):
        print(f"{name} is left out: it is not there", file=sys.stderr)
    rows: list[Measured] = []
    try:
        program = catena.find(chosen.catena)
        with tempfile.TemporaryDirectory() as folder:
            for scene in scenes():
                head = f"  {'method':36}{'setting':28}{'creep m/s':>10}{'moved m':>10}{'overlap m':>11}{'CPU µs per s':>14}"
                print(f"{scene.title}\n{head}", flush=True)
                runs = [standing_peers.ours(program, scene, Path(folder))]
                runs += [standing_peers.mujoco(scene)] if there["MuJoCo"] else []
                runs += [standing_peers.rapier(scene, Path(folder))] if there["Rapier"] else []
                runs += [standing_peers.drake(scene)] if there["Drake"] else []
                for row in (row for run in runs for row in run):
                    print(line(row), flush=True)
                    rows.append(row)
    except catena.CatenaError as error:
        print(error, file=sys.stderr)
        return 2
    with (chosen.output / "standing.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Measured))
        writer.writerows(astuple(row) for row in rows)
    draw(rows, chosen.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
