"""What every runner shares: settings, the clock, the ladder of settings and what a run leaves behind."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from scene import Scene

# A run is repeated until the clock has seen this time (s); the fastest counts, because other programs only ever make a run slower.
REPEAT_UNTIL = 0.15
REPEATS = 3
# Runs of this length (s) are not repeated.
LONG = 1.0


@dataclass(frozen=True)
class Setting:
    """A fixed step [s] or a tolerance."""

    kind: str
    value: float

    def __str__(self) -> str:
        return f"{self.kind}={self.value!r}"


@dataclass
class Run:
    """One run: its cost and where the bodies are at the end (rotation and origin of their frames in the world)."""

    cpu_seconds: float
    placements: list[tuple[np.ndarray, np.ndarray]]
    steps: int = 0
    # Other costs of the same run under other names, for peers whose Python layer would otherwise be measured.
    other_costs: dict[str, float] | None = None

    def spent(self) -> float:
        """What the run took of this machine, whatever of it counts."""
        return max(self.cpu_seconds, *(self.other_costs or {}).values(), 0.0)


def clocked(work: Callable[[], object]) -> float:
    """CPU time of the whole process while `work` runs, so that helper threads count as well."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def steps_of(scene: Scene, setting: Setting) -> tuple[int, float]:
    """Number of steps and the step that fills the duration exactly."""
    count = max(1, round(scene.duration / setting.value))
    return count, scene.duration / count


def fastest(once: Callable[[], Run]) -> Run:
    """The cheapest of several runs."""
    best = once()
    total, runs = best.spent(), 1
    while total < LONG and (total < REPEAT_UNTIL or runs < REPEATS):
        again = once()
        total += again.spent()
        runs += 1
        best = min(best, again, key=lambda run: run.cpu_seconds)
    return best


def settings(kind: str, scene: Scene, longest: float) -> Iterator[Setting]:
    """From coarse to fine: steps halved again and again, or tolerances by decades."""
    if kind == "step":
        count = max(1, math.ceil(scene.duration / longest))
        while True:
            yield Setting("step", scene.duration / count)
            count *= 2
    for exponent in range(1, 15):
        yield Setting("tolerance", float(f"1e-{exponent}"))
