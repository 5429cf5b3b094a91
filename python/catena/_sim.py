"""Runs: to the end at once, or step by step."""

from __future__ import annotations

import os

import numpy as np

from . import _catena
from ._errors import InputError
from ._model import flat
from ._named import NamedArray
from ._result import Result

#: How far ahead steps of a run that goes step by step are planned [s].
HORIZON = 10.0


class Sim:
    """A simulation of a model, and where it is: ``time``, ``q`` and ``v``.

    ``q`` and ``v`` are numpy arrays that may be read and changed by index or by the name of a joint. Every run and step
    writes the present values into the same arrays, so a slice of them follows the motion. The next run or step starts from the values in them.

    Parameters
    ----------
    model : a :class:`Model`
    tolerance : wanted accuracy of positions [m]; 1e-6 if neither this nor the file says otherwise
    stages, step : instead of a tolerance, the stages of the scheme and its fixed step [s]
    keep : rules that are switched off (``catena model`` lists them)
    """

    def __init__(self, model, *, tolerance=None, stages=None, step=None, keep=()):
        if (stages is None) != (step is None) or (tolerance is not None and step is not None):
            raise InputError("give a tolerance, or stages and step")
        self.model = model
        self._how = (tolerance, stages, step)
        self._keep = [keep] if isinstance(keep, str) else list(keep)
        self._controller = None
        self._efforts = None
        self._run = None
        q, v = model.start()
        self._q = NamedArray(q, model._inner.q_places())
        self._v = NamedArray(v, model._inner.v_places())
        self._time = 0.0

    def reset(self):
        """Back to the start that the file gives, at time 0."""
        q, v = self.model.start()
        self._q[:], self._v[:] = q, v
        self._time = 0.0
        self._run = None

    @property
    def time(self) -> float:
        """Time [s]."""
        return self._time

    @property
    def q(self) -> NamedArray:
        """Positions, by index or name of a joint."""
        return self._q

    @q.setter
    def q(self, numbers):
        self._take(self._q, numbers, "q")

    @property
    def v(self) -> NamedArray:
        """Velocities, by index or name of a joint."""
        return self._v

    @v.setter
    def v(self, numbers):
        self._take(self._v, numbers, "v")

    @staticmethod
    def _take(array, numbers, what):
        numbers = flat(numbers, what)
        if numbers.shape != array.shape:
            raise InputError(f"{what}: {len(numbers)} numbers where {len(array)} are wanted")
        array[:] = numbers

    def set_controller(self, controller, rate=None, period=None):
        """Lets ``controller(t, q, v)`` decide on efforts, asked at a fixed rate [Hz] or period [s]: it returns an array of efforts along v [N m or
        N], held until it is asked again, or None for none. ``set_controller(None)`` takes it away."""
        if controller is None:
            self._controller = None
        else:
            if not callable(controller):
                raise InputError("the controller cannot be called: give a function of t, q and v")
            if (rate is None) == (period is None):
                raise InputError("give the rate of the controller in Hz, or its period in s")
            self._controller = (controller, _period(rate, period))
        self._run = None

    def set_efforts(self, efforts):
        """Efforts along v from now on [N m or N], besides the forces of the model; None for none."""
        self._efforts = None if efforts is None else flat(efforts, "efforts").copy()
        if self._run is not None and self._run.is_at(self._q, self._v):
            self._run.set_efforts(np.zeros(len(self._v)) if efforts is None else self._efforts)
        else:
            self._run = None

    def run(self, duration=None, rate=60.0, *, log=None, controller=None, control_rate=None) -> Result:
        """Runs from where it is, for a duration [s], and returns samples at a rate [Hz].

        ``log`` is an MCAP file that is written on the way. ``controller`` with its ``control_rate`` is as of :meth:`set_controller`, for this run.
        Without a duration it is that of the file, or 10 s.
        """
        asked = self._controller
        if controller is not None:
            if control_rate is None:
                raise InputError("give the control_rate of the controller in Hz")
            asked = (controller, _period(control_rate, None))
        run = self._begin(duration, rate, log, True, asked)
        self._run = None
        try:
            run.run()
        finally:
            self._look(run)
        return Result(self.model, run.finish())

    def step(self, duration):
        """Goes on for a duration [s], exactly, under the efforts or the controller that are set."""
        self.step_to(self._time + duration)

    def step_to(self, time):
        """Goes on until a time [s], exactly."""
        if not np.isfinite(time) or time < self._time:
            raise InputError(f"cannot step to t = {time} s: the run is at {self._time} s")
        if self._run is None or time > self._run.end or not self._run.is_at(self._q, self._v):
            self._run = self._begin(max(HORIZON, time - self._time), None, None, False, self._controller)
        try:
            self._run.step_to(float(time))
        except BaseException:
            self._look(self._run)
            self._run = None
            raise
        self._look(self._run)

    def pose(self, link):
        """x, y, z and the quaternion w, x, y, z of a link frame in the world now."""
        return self.model.pose(link, self._q)

    def energy(self) -> dict[str, float]:
        """The energy now [J]: kinetic, potential, spring, load and total."""
        run = self._begin(HORIZON, None, None, False, None)
        parts = dict(zip(("kinetic", "potential", "spring", "load"), run.energy()))
        return parts | {"total": sum(parts.values())}

    def _begin(self, duration, rate, log, record, controller):
        tolerance, stages, step = self._how
        log = None if log is None else os.fspath(log)
        numbers = [np.ascontiguousarray(self._q), np.ascontiguousarray(self._v)]
        run = _catena.Run(
            self.model._inner, *numbers, self._time, duration, tolerance, stages, step, rate, self._keep, log, record
        )
        if self._efforts is not None:
            run.set_efforts(self._efforts)
        if controller is not None:
            run.set_controller(controller[1], controller[0])
        return run

    def _look(self, run):
        self._time = run.time
        run.look(self._q, self._v)

    def __repr__(self):
        return f"<catena.Sim of {self.model.name!r} at t = {self._time} s>"


def _period(rate, period):
    try:
        period = 1.0 / float(rate) if period is None else float(period)
    except (TypeError, ValueError, ZeroDivisionError):
        raise InputError(f"the controller's rate is {rate}: give a finite number that is greater than zero") from None
    return period
