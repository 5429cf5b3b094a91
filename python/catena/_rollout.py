"""Many runs at once."""

from __future__ import annotations

import warnings as python_warnings
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from . import _catena
from ._errors import InputError
from ._how import how
from ._model import Model, as_array
from ._named import NamedArray

_NONE = np.zeros(0)


@dataclass(repr=False)
class Rollouts:
    """What many runs have done.

    Attributes
    ----------
    t : times of the samples (samples,) [s]
    q, v : positions and velocities (runs, samples, n), by index or name of a joint; NaN after a run has failed
    failures : reasons by number of the run
    warnings : by number of the run, of those whose start was moved
    energies : kinetic, potential, spring and load energy (runs, samples, 4) [J], where they were asked for
    contacts : for each run its closed contacts as columns of a table, as of ``Result.contacts``, where they were asked for
    """

    t: np.ndarray
    q: NamedArray
    v: NamedArray
    failures: dict[int, str]
    warnings: dict[int, list[str]] = field(default_factory=dict)
    energies: np.ndarray | None = None
    contacts: list[dict[str, np.ndarray]] | None = None

    def __repr__(self):
        runs, samples = self.q.shape[:2]
        return f"<catena.Rollouts: {runs} runs of {samples} samples to {self.t[-1]:.9g} s, {len(self.failures)} failed>"


def rollout(
    model: Model,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    duration: float | None = None,
    rate: float | None = None,
    threads: int = 0,
    *,
    tolerance: float | None = None,
    stages: int | None = None,
    step: float | None = None,
    controls: ArrayLike | None = None,
    targets: ArrayLike | None = None,
    feedback: ArrayLike | None = None,
    reference: ArrayLike | None = None,
    period: float | None = None,
    params: Mapping[str, ArrayLike] | None = None,
    warnings: bool = False,
    contacts: bool = False,
    energies: bool = False,
    estimate: bool = True,
) -> Rollouts:
    """Runs a model from many starts, on several threads, while other threads of Python go on.

    Efforts and targets are held between ticks: efforts are ``controls[run, k] - feedback @ (concatenate([q, v]) - reference)`` with q and v at the
    tick k.

    Parameters
    ----------
    q0, v0 : starts (runs, n); without v0 all start at rest. One start (n,) is that of all runs.
    duration : simulated time [s]; that of the file, or 10
    rate : samples per simulated second; without it only the start and the end
    threads : how many share the runs; 0 takes all cores. The results do not depend on it.
    tolerance : wanted accuracy of positions [m]
    stages, step : instead of a tolerance, the stages of the scheme, 2 to 16, or 1 for steps over events, and its fixed step [s]
    controls : efforts along v (runs, ticks, n) or, the same for all runs, (ticks, n) [N m or N]
    targets : of motors, in the order of ``model.motor_names`` (runs, ticks, motors) or (ticks, motors)
    feedback : the gain K (n, len(q) + len(v)) of a feedback
    reference : q and v about which it acts, one after the other; zeros if left out
    period : time between ticks [s]; the duration over the number of ticks if left out
    params : numbers of a run of its own by key path, arrays (runs,), as of :meth:`Model.with_params`
    warnings : whether a moved start is a ``RuntimeWarning`` of Python, too
    contacts, energies : whether these are wanted
    estimate : whether runs with a tolerance estimate their error; without it they take about half of the time
    """
    tolerance, fixed = how(tolerance, stages, step)
    places, motors = model._inner.v_places(), len(model.motor_names)
    params = {str(key): as_array(numbers, f"params {key}", 1, "(runs,)") for key, numbers in dict(params or {}).items()}
    shapes = [np.shape(given) for given in (controls, targets) if given is not None]
    many = [shape[0] for shape in shapes if len(shape) == 3] + [len(numbers) for numbers in params.values()]
    q0 = _starts(q0, "q0", many)
    width = places[-1][2] if places else 0
    v0 = np.zeros((len(q0), width)) if v0 is None else _starts(v0, "v0", many)
    if threads < 0:
        raise InputError(f"threads is {threads}: give a number that is not negative")
    runs = len(q0)
    efforts, ticks = _inputs(controls, "controls", runs, width)
    aims, more = _inputs(targets, "targets", runs, motors)
    if ticks and more and ticks != more:
        raise InputError(f"controls have {ticks} ticks and targets {more}: give as many of both")
    ticks = ticks or more
    if duration is None and period is not None and ticks:
        duration = ticks * period
    if period is None and ticks:
        if duration is None:
            raise InputError("give a duration or a period for controls and targets")
        period = duration / ticks
    gain = _NONE if feedback is None else as_array(feedback, "feedback", 2, "(n, len(q) + len(v))").ravel()
    about = _NONE if reference is None else as_array(reference, "reference", 1, "(len(q) + len(v),)")
    numbers = [(key, list(numbers)) for key, numbers in params.items()]
    done = _catena.rollout(
        model._inner, q0, v0, duration, tolerance, fixed, rate, threads,
        period, efforts, aims, gain, about, numbers, contacts, energies, estimate,
    )  # fmt: skip
    told = {run: lines for run, lines in enumerate(done.warnings) if lines}
    if warnings:
        for run, lines in told.items():
            python_warnings.warn(f"run {run}: {'; '.join(lines)}", RuntimeWarning, stacklevel=2)
    tables = None if done.contacts is None else [_table(done.times, *columns) for columns in done.contacts]
    q, v = NamedArray(done.q, model._inner.q_places()), NamedArray(done.v, places)
    return Rollouts(done.times, q, v, dict(done.failures), told, done.energies, tables)


def _starts(numbers, what, many):
    if np.ndim(numbers) == 1 and many:
        numbers = np.tile(as_array(numbers, what, 1, "(n,)"), (many[0], 1))
    return as_array(numbers, what, 2, "(runs, n)")


def _inputs(given, what, runs, width):
    """Inputs of all runs as flat numbers, and the number of ticks."""
    if given is None:
        return _NONE, 0
    if np.ndim(given) == 2:
        array = as_array(given, what, 2, "(ticks, n)")
        array = np.broadcast_to(array, (runs, *array.shape))
    else:
        array = as_array(given, what, 3, "(runs, ticks, n)")
    if array.shape[0] != runs or array.shape[2] != width or array.shape[1] == 0:
        raise InputError(f"{what}: an array of shape {array.shape} where ({runs}, ticks, {width}) is wanted")
    return np.ascontiguousarray(array).ravel(), array.shape[1]


def _table(times, samples, pairs, numbers, sticks):
    numbers = numbers.reshape(len(pairs), 10)
    return {
        "t": times[np.array(samples, dtype=int)],
        "pair": np.array(pairs, dtype=str),
        "position": numbers[:, 0:3],
        "normal": numbers[:, 3:6],
        "force": numbers[:, 6:9],
        "gap": numbers[:, 9],
        "sticks": np.array(sticks, dtype=bool),
    }
