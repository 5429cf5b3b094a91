"""Runs one method on one scene in a process of its own: a peer that crashes or hangs takes nothing else with it.

Called by run.py: worker.py PEER METHOD SCENE.json REFERENCE.npy ROWS.csv BUDGET. Exit code 3: the peer is not installed;
4: it cannot do this scene. Rows appear in the file as they are measured.
"""

from __future__ import annotations

import csv
import importlib
import os
import sys
from pathlib import Path

# One core for everybody; must be set before the libraries are loaded.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np

from measure import Run, fastest, settings
from scene import Scene, probes

NOT_INSTALLED = 3
NOT_FOR_THIS_SCENE = 4
# The first step of every ladder [s].
LONGEST_STEP = 0.16
# Number of rungs in a row without improvement after which rounding has won.
FUTILE = 3


def main() -> int:
    """Walks every ladder of the peer and writes a row for each run."""
    name, method, scene_file, reference_file, rows_file, budget = sys.argv[1:7]
    try:
        module = importlib.import_module(f"peer_{name}")
    except ImportError as error:
        print(error, file=sys.stderr)
        return NOT_INSTALLED
    scene = Scene.load(Path(scene_file))
    reference = np.load(reference_file)
    try:
        peer = module.Peer(scene)
        with Path(rows_file).open("a", newline="", buffering=1) as file:
            climb(peer, scene, reference, method, module.METHODS[method], float(budget), csv.writer(file))
    except NotImplementedError as error:
        print(error, file=sys.stderr)
        return NOT_FOR_THIS_SCENE
    return 0


def climb(peer, scene, reference, method, kind, budget, writer) -> None:
    """One method from coarse to fine until its budget of CPU time is used or rounding has won."""
    best, futile, last = float("inf"), 0, 0.0
    for setting in settings(kind, scene, LONGEST_STEP):
        try:
            run = fastest(lambda setting=setting: peer.run(method, setting))
            failure = "" if finite(run) else "failed: the end state is not finite"
        except NotImplementedError:
            raise
        except Exception as error:  # noqa: BLE001 — whatever a foreign solver throws is a result
            run, failure = None, f"failed: {str(error).strip().splitlines()[0] if str(error).strip() else type(error)}"
        if failure:
            writer.writerow([scene.name, method, setting, "", "", "", "", failure])
            futile += 1
        else:
            distances = np.linalg.norm(probes(scene, run.placements) - reference, axis=2)
            error, center_error = float(distances.max()), float(distances[:, 0].max())
            for label, cpu in {method: run.cpu_seconds, **(run.other_costs or {})}.items():
                cost = cpu / scene.duration
                writer.writerow(
                    [scene.name, label, setting, repr(error), repr(cost), run.steps, repr(center_error), "done"]
                )
            futile = 0 if error < 0.9 * best else futile + 1
            best = min(best, error)
            last = run.spent()
        # A first rung that is too long is no reason to stop; afterwards the next one would cost about twice the last.
        if last > budget / 2 or (futile >= FUTILE and best < 1e-3) or futile >= 14:
            return


def finite(run: Run) -> bool:
    """Whether the end can be compared at all."""
    return all(np.isfinite(rotation).all() and np.isfinite(origin).all() for rotation, origin in run.placements)


if __name__ == "__main__":
    sys.exit(main())
