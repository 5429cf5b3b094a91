"""The reference and our own curves, both from the `catena` command line."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np

from scene import Scene, Start, probes, rotation_matrix

_REPOSITORY = Path(__file__).resolve().parents[2]


class CatenaError(Exception):
    """The program is missing or refuses."""


def find(given: str | None) -> str:
    """The program: as given, from this repository's build, or from the path."""
    built = _REPOSITORY / "target" / "release" / "catena"
    program = shutil.which(given or (str(built) if built.is_file() else "catena"))
    if program is None:
        raise CatenaError("no catena: cargo build --release, or give --catena PATH")
    return program


def reference(program: str, scene: Scene, start: Start, step: float) -> tuple[np.ndarray, float]:
    """Probes of all bodies at the end, and how far two stage numbers are apart.

    The Lobatto scheme with nine stages, and with eight and another step, so that neither truncation nor rounding is the
    same in both; their distance is what an error can be trusted down to.
    """
    best = _end(program, scene, start, 9, step)
    other = _end(program, scene, start, 8, step / 1.37)
    return best, float(np.linalg.norm(best - other, axis=2).max())


def _end(program: str, scene: Scene, start: Start, stages: int, step: float) -> np.ndarray:
    command = [program, "simulate", scene.urdf, "--no-log", "--quiet", "--json", "--duration", repr(scene.duration)]
    command += ["--stages", str(stages), "--step", repr(step), *start.options()]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        raise CatenaError(ended.stderr.strip() or f"catena ended with {ended.returncode}")
    links = json.loads(ended.stdout)["links"]
    return probes(
        scene,
        [
            (rotation_matrix(links[body.name]["orientation"]), np.array(links[body.name]["position"]))
            for body in scene.bodies
        ],
    )


def has_chart(program: str) -> bool:
    """Whether this catena can draw charts."""
    return subprocess.run([program, "chart", "--help"], capture_output=True, check=False).returncode == 0


def chart(program: str, scene: Scene, start: Start, rows: Path, folder: Path, quick: bool) -> bool:
    """Measures our own methods and the comparators and draws all curves into one picture."""
    command = [program, "chart", scene.urdf, "-o", str(folder), "--duration", repr(scene.duration), "--csv", str(rows)]
    command += [*start.options(), *(["--quick"] if quick else [])]
    return subprocess.run(command, check=False).returncode == 0
