"""Positions and velocities at equal times as functions of numbers, with their exact derivatives: what the wrappers for frameworks call."""

from __future__ import annotations

import numpy as np

from ._errors import InputError
from ._fit import _value, _with
from ._how import how

# The gradient of a loss by more numbers than these is cheaper against time.
FEW = 30


class Motion:
    """q and v (samples, n) of a run as a function of the numbers of `keys`; the samples are a step apart, from the start on."""

    def __init__(self, model, keys, *, duration, step, stages=5, q=None, v=None, against_time=None):
        start = model.start()
        self.model, self.keys = model, list(keys)
        self.q, self.v = (np.array(start[i] if given is None else given, float) for i, given in enumerate((q, v)))
        if len(self.q) != len(self.v):
            raise InputError("this is for joints of one freedom; ball and floating joints have others")
        _, (self.stages, self.step) = how(None, stages, step)
        self.samples = round(float(duration) / self.step) + 1
        self.shape = (self.samples, len(self.v))
        self.against_time = len(self.keys) > FEW if against_time is None else bool(against_time)

    @property
    def values(self):
        """The numbers as they are (keys)."""
        return np.array([_value(self.model, self.q, self.v, key) for key in self.keys])

    def motion(self, numbers):
        """q, v (samples, n)."""
        return self._run(numbers, [])[:2]

    def __call__(self, numbers):
        """q, v (samples, n), and their derivatives (samples, n, keys)."""
        return self._run(numbers, self.keys)

    def gradient(self, numbers, by_q, by_v):
        """The derivatives (keys) of a loss, from its derivatives by q and v (samples, n), against time."""
        own, q, v = _with(self.model, self.q, self.v, self.keys, np.asarray(numbers, float))
        t = self.step * np.arange(self.samples)
        rows = np.asarray(by_q, float), np.asarray(by_v, float)
        return own.gradient(self.keys, t, lambda run: (0.0, *rows), q, v, stages=self.stages, step=self.step).by

    def _run(self, numbers, keys):
        own, q, v = _with(self.model, self.q, self.v, self.keys, np.asarray(numbers, float))
        t = self.step * np.arange(self.samples)
        duration = float(t[-1])
        run = own.sensitivity(keys, q, v, duration=duration, stages=self.stages, step=self.step)
        near = 1e-9 * max(duration, 1.0)
        rows = np.minimum(np.searchsorted(run.t, t - near), len(run.t) - 1)
        if not np.all(np.abs(run.t[rows] - t) < near):
            late = t[np.argmax(np.abs(run.t[rows] - t))]
            raise InputError(f"an event is so near to {late:g} s that the run has no step there; give another step")
        return run.q[rows], run.v[rows], run.dq[rows], run.dv[rows]
