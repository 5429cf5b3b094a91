"""Contacts against MuJoCo and Rapier: error at the end over CPU time, in one run of three minutes.

    benches/peers/venv/bin/python benches/peers/contacts.py -o peers

`README.md` beside this file says how to install MuJoCo and build the program of Rapier; a peer that is not there is
left out with a line that says so. Writes `contacts.csv`, `contacts.svg` and `contacts.png`, prints for every method its
least error and what that costs, and lets `catena chart` draw the scene without a formula with all peers in `chart/`.
"""

from __future__ import annotations

import argparse
import csv
import importlib.util
import math
import subprocess
import sys
import tempfile
from dataclasses import astuple, fields
from pathlib import Path

import catena
import contact_peers
from contact_peers import Measured
from contact_scenes import Scene, scenes

STYLES = {
    "catena": {"color": "#d55e00", "marker": "*"},
    "catena, whole process": {"color": "#e69f00", "marker": "*", "linestyle": "--"},
    "catena, over events": {"color": "#000000", "marker": "v"},
    "MuJoCo, default": {"color": "#0072b2", "marker": "o"},
    "MuJoCo, stiff": {"color": "#56b4e9", "marker": "s"},
    "MuJoCo, stiff, noslip": {"color": "#56b4e9", "marker": "^", "linestyle": "--"},
    "Rapier, 4 iterations": {"color": "#009e73", "marker": "v"},
    "Rapier, 50 iterations": {"color": "#009e73", "marker": "d", "linestyle": "--"},
}
# Errors are drawn no smaller: the places themselves are rounded to this [m].
LEAST = 1e-16


def measure(program: str, scene: Scene, folder: Path) -> list[Measured]:
    """All runs of a scene."""
    rows = list(contact_peers.ours(program, scene, folder))
    if importlib.util.find_spec("mujoco"):
        rows += contact_peers.mujoco(scene)
    if contact_peers.RAPIER.is_file():
        rows += contact_peers.rapier(scene, folder)
    return rows


def table(rows: list[Measured]) -> str:
    """The least error of each method and its cost, and the cheapest run with an error of at most 1e-3 m."""
    lines = [f"  {'method':28}{'least error [m]':>16}{'CPU µs per s':>14}{'at 1e-3 m: CPU µs per s':>26}"]
    for method in dict.fromkeys(row.method for row in rows):
        own = [row for row in rows if row.method == method]
        best = min(own, key=lambda row: (row.error, row.cpu_seconds_per_simulated_second))
        good = [row.cpu_seconds_per_simulated_second for row in own if row.error <= 1e-3]
        cheap = f"{1e6 * min(good):26.3g}" if good else f"{'-':>26}"
        cost = 1e6 * best.cpu_seconds_per_simulated_second
        lines.append(f"  {method:28}{best.error:16.1e}{cost:14.3g}{cheap}")
    return "\n".join(lines)


def draw(rows: list[Measured], folder: Path) -> None:
    """One panel for each scene: error over cost, all runs."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams.update({"svg.hashsalt": "contacts", "svg.fonttype": "none"})
    from matplotlib import pyplot as plt

    all_scenes = scenes()
    figure, axes = plt.subplots(2, 4, figsize=(17.5, 8.0), layout="constrained")
    handles = {}
    for axis, scene in zip(axes.flat, all_scenes, strict=False):
        for method, style in STYLES.items():
            own = [row for row in rows if (row.scene, row.method) == (scene.name, method) and math.isfinite(row.error)]
            if not own:
                continue
            costs = [1e6 * row.cpu_seconds_per_simulated_second for row in own]
            errors = [max(row.error, LEAST) for row in own]
            (handles[method],) = axis.loglog(errors, costs, markersize=5, linewidth=1.2, **style)
        axis.set_title(scene.title)
        axis.set_xlabel("distance from the exact place at the end [m]")
        axis.set_ylabel("CPU time [µs per simulated second]")
        axis.set_xlim(0.5 * LEAST, 10.0)
        axis.grid(alpha=0.3)
    for axis in axes.flat[len(all_scenes) :]:
        axis.axis("off")
        names = [method for method in STYLES if method in handles]
        title = "lower and further left is better"
        axis.legend([handles[name] for name in names], names, loc="center", frameon=False, title=title)
    for ending in ("svg", "png"):
        figure.savefig(folder / f"contacts.{ending}", dpi=90, metadata={"Date": None} if ending == "svg" else None)


def chart(program: str, rows: list[Measured], folder: Path) -> None:
    """Draws the scenes without a formula in our own chart, with the peers' measurements."""
    peers = folder / "peers.csv"
    with peers.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Measured))
        writer.writerows(astuple(row) for row in rows if not row.method.startswith("catena"))
    files = [str(contact_peers.write(scene, folder)) for scene in scenes() if scene.answer is None]
    command = [program, "chart", *files, "--quick", "--quiet", "--csv", str(peers), "-o", str(folder / "chart")]
    subprocess.run(command, check=True)


def main() -> int:
    """Measures all scenes, prints a table for each, and writes the files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the files")
    parser.add_argument("--catena", metavar="PATH", help="the program (default: this repository's release build)")
    chosen = parser.parse_args()
    chosen.output.mkdir(parents=True, exist_ok=True)
    if not importlib.util.find_spec("mujoco"):
        print("MuJoCo is left out: not installed", file=sys.stderr)
    if not contact_peers.RAPIER.is_file():
        print(f"Rapier is left out: {contact_peers.RAPIER} is not built", file=sys.stderr)
    rows: list[Measured] = []
    try:
        program = catena.find(chosen.catena)
        with tempfile.TemporaryDirectory() as folder:
            for scene in scenes():
                found = measure(program, contact_peers.answered(program, scene, Path(folder)), Path(folder))
                print(f"{scene.title}\n{table(found)}", flush=True)
                rows += found
    except catena.CatenaError as error:
        print(error, file=sys.stderr)
        return 2
    with (chosen.output / "contacts.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Measured))
        writer.writerows(astuple(row) for row in rows)
    draw(rows, chosen.output)
    chart(program, rows, chosen.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
