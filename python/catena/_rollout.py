"""Many runs at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import _catena
from ._errors import InputError
from ._model import as_array
from ._named import NamedArray


@dataclass
class Rollouts:
    """What many runs have done.

    Attributes
    ----------
    t : times of the samples (samples,) [s]
    q, v : positions and velocities (runs, samples, n), by index or name of a joint; NaN after a run has failed
    failures : reasons by number of the run
    """

    t: np.ndarray
    q: NamedArray
    v: NamedArray
    failures: dict[int, str]


def rollout(model, q0, v0=None, duration=None, rate=None, threads=0, *, tolerance=None, stages=None, step=None) -> Rollouts:
    """Runs a model from many starts, on several threads, while other threads of Python go on.

    Parameters
    ----------
    q0, v0 : starts (runs, n); without v0 all start at rest
    duration : simulated time [s]; that of the file, or 10
    rate : samples per simulated second; without it only the start and the end
    threads : how many share the runs; 0 takes all cores. The results do not depend on it.
    tolerance : wanted accuracy of positions [m]
    stages, step : instead of a tolerance, the stages of the scheme and its fixed step [s]
    """
    q0 = as_array(q0, "q0", 2, "(runs, n)")
    places = model._inner.v_places()
    v0 = np.zeros((len(q0), places[-1][2] if places else 0)) if v0 is None else as_array(v0, "v0", 2, "(runs, n)")
    if threads < 0:
        raise InputError(f"threads is {threads}: give a number that is not negative")
    t, q, v, failures = _catena.rollout(model._inner, q0, v0, duration, tolerance, stages, step, rate, threads)
    return Rollouts(t, NamedArray(q, model._inner.q_places()), NamedArray(v, places), dict(failures))
