"""Runs: to the end at once, or step by step."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike

from . import _catena
from ._errors import InputError, RunError
from ._how import how
from ._model import Model, flat
from ._named import NamedArray
from ._result import Result
from ._sensors import Sensed

#: Steps may go on for so long without a new run [s].
_LONG = 1e6


class State:
    """A simulation between two steps, as a value: ``s = sim.state``, ``sim.state = s``.

    ``time``, ``q``, ``v``, ``efforts``, ``targets`` and ``held`` (what sampled motors hold until their next ticks, an entry a motor of
    ``model.motor_names``) may be read. A simulation that takes it goes on bit for bit, because it holds all that the steps remember, too: modes of
    joints and contacts, impacts, anchors of friction. Only a pickled state has no such memory: a simulation begins anew from its numbers.
    """

    def __init__(self, model, time, q, v, efforts, targets, held, held_at, kept):
        self.model, self.time, self.q, self.v = model, time, q, v
        self.efforts, self.targets, self.held, self._held_at, self._kept = efforts, targets, held, held_at, kept

    def __call__(self):
        """Itself, so that ``sim.state()`` is ``sim.state``."""
        return self

    def __reduce__(self):
        numbers = np.asarray(self.q), np.asarray(self.v)
        return _state, (self.model, self.time, *numbers, self.efforts, self.targets, self.held, self._held_at)

    def __repr__(self):
        return f"<catena.State of {self.model.name!r} at t = {self.time:.9g} s>"


def _state(model, time, q, v, efforts, targets, held=None, held_at=None):
    q, v = NamedArray(q, model._inner.q_places()), NamedArray(v, model._inner.v_places())
    return State(model, time, q, v, efforts, targets, held, held_at or {}, None)


class Sim:
    """A simulation of a model, and where it is: ``time``, ``q`` and ``v``.

    ``q`` and ``v`` are numpy arrays that may be read and changed by index or by the name of a joint. Every run and step
    writes the present values into the same arrays, so a slice of them follows the motion. The next run or step starts from the values in them.

    Parameters
    ----------
    model : a :class:`Model`
    tolerance : wanted accuracy of positions [m]; 1e-6 if neither this nor the file says otherwise
    stages, step : instead of a tolerance, the stages of the scheme, 2 to 16, or 1 for steps over events, and its fixed step [s]
    keep : rules that are switched off (``catena model`` lists them)
    estimate : whether :meth:`run` with a tolerance estimates its error; without it a run takes about half of the time
    """

    # An assignment to another name, as in ``sim.controller = law``, is an error.
    __slots__ = (
        "model", "_how", "_estimate", "_keep", "_controller", "_efforts", "_targets", "_held", "_run", "_start", "_q", "_v", "_time", "_moved", "__weakref__",
    )

    def __init__(self, model, *, tolerance=None, stages=None, step=None, keep=(), estimate=True):
        if not isinstance(model, Model):
            raise InputError(f"model is {model!r}: give a catena.Model, as catena.load makes it")
        self.model = model
        self._how = {"tolerance": tolerance, "stages": stages, "step": step}
        how(**self._how)
        self._estimate = bool(estimate)
        self._keep = [keep] if isinstance(keep, str) else list(keep)
        self._controller = None
        self._efforts = None
        self._targets = {}
        # Time, q and v where sampled motors are known to hold efforts, and these.
        self._held = None
        self._run = None
        self._start = q, v = model.start()
        self._q = NamedArray(q.copy(), model._inner.q_places())
        self._v = NamedArray(v.copy(), model._inner.v_places())
        self._time = 0.0
        self._moved = False

    def reset(self) -> None:
        """Back to the start that the file gives, at time 0, with its targets of motors."""
        self._q[:], self._v[:] = self._start
        self._time = 0.0
        self._targets = {}
        self._moved = True

    def start_from(self, log: str | os.PathLike[str], time: float | None = None) -> None:
        """Puts q and v where another run was: in the sample of its log that is nearest to a time [s], or in the last one, as ``--from LOG@T``. The
        simulation is at time 0 then, with the targets of motors that the file gives, and with joints of a [[motion]] where that is at time 0."""
        self._q[:], self._v[:] = self.model._inner.logged(os.fspath(log), None if time is None else float(time))
        self._time = 0.0
        self._targets = {}
        self._moved = True

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

    @property
    def state(self) -> State:
        """Where it is, as a value; assigned, the simulation goes on from there bit for bit."""
        run = self._here()
        q, v = self._q.alike(), self._v.alike()
        efforts = None if self._efforts is None else self._efforts.copy()
        return State(self.model, self._time, q, v, efforts, dict(self._targets), run.held_efforts(), run.held_targets(), run.state())

    @state.setter
    def state(self, state):
        if not isinstance(state, State):
            raise InputError(f"a state is wanted, as of sim.state, not {type(state).__name__}")
        if state.q.shape != self._q.shape or state.v.shape != self._v.shape:
            raise InputError(f"the state is of {state.model.name!r}, and the simulation of {self.model.name!r}")
        efforts = None if state.efforts is None else state.efforts.copy()
        if state._kept is None:
            self._q[:], self._v[:] = state.q, state.v
            self._time, self._efforts, self._targets = state.time, efforts, dict(state.targets)
            self._know_held(state.held, state._held_at)
            self._moved = True
            return
        if self._run is None:
            self._run = self._begin(_LONG, None, None, False, self._controller, False)
        self._run.set_state(state._kept)
        self._efforts, self._targets = efforts, dict(state.targets)
        self._look(self._run)
        self._moved = False

    def copy(self) -> Sim:
        """Another simulation that goes on to the same bits; both have the same controller."""
        copy = self._alike()
        copy.state = self.state
        return copy

    def _alike(self):
        copy = Sim(self.model, **self._how, keep=self._keep, estimate=self._estimate)
        copy._controller = self._controller
        return copy

    __copy__ = copy

    def __deepcopy__(self, memo):
        return self.copy()

    def __reduce__(self):
        return _sim, (self.model, self._how, self._estimate, self._keep, self._controller, self.state)

    def set_controller(
        self,
        controller: Callable[[float, np.ndarray, np.ndarray], ArrayLike | None] | None,
        rate: float | None = None,
        period: float | None = None,
    ) -> None:
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

    def set_efforts(self, efforts: ArrayLike | None) -> None:
        """Efforts along v from now on [N m or N], besides the forces of the model; None for none."""
        efforts = None if efforts is None else flat(efforts, "efforts").copy()
        if efforts is not None:
            places, wanted = self.model._inner.v_places(), len(self._v)
            if len(efforts) != wanted:
                joints = ", ".join(name if last == first + 1 else f"{name} ({last - first})" for name, first, last in places)
                raise InputError(f"{len(efforts)} efforts for {wanted} degrees of freedom: give one for each, in the order of {joints}")
            for name, first, last in places:
                if not np.all(np.isfinite(efforts[first:last])):
                    raise InputError(f'an effort on joint "{name}" is not finite: give finite numbers')
        self._efforts = efforts
        if self._is_here():
            self._run.set_efforts(np.zeros(len(self._v)) if efforts is None else self._efforts)

    def set_target(self, joint: str, target: float) -> None:
        """Gives the motor of a joint a target from now on, in place of the file's: a position, a velocity or an effort, as its law says. Motors
        that work out their efforts at ticks see it at the next one. ``model.motor_names`` has the joints."""
        if joint not in self.model.motor_names:
            known = ", ".join(map(repr, self.model.motor_names)) or "none"
            raise InputError(f"joint {joint!r} has no motor; the joints with motors are {known}")
        self._targets[joint] = float(target)
        if self._is_here():
            self._run.set_target(joint, float(target))

    def set_targets(self, targets: ArrayLike) -> None:
        """Targets of all motors: a mapping from joints, or numbers in the order of ``model.motor_names``."""
        if not hasattr(targets, "items"):
            numbers = flat(targets, "targets")
            if len(numbers) != len(self.model.motor_names):
                raise InputError(f"targets: {len(numbers)} numbers where {len(self.model.motor_names)} are wanted")
            targets = dict(zip(self.model.motor_names, numbers))
        for joint, target in targets.items():
            self.set_target(joint, target)

    def run(
        self,
        duration: float | None = None,
        rate: float = 60.0,
        *,
        log: str | os.PathLike[str] | None = None,
        controller: Callable[[float, np.ndarray, np.ndarray], ArrayLike | None] | None = None,
        control_rate: float | None = None,
        sensitivity: str | Iterable[str] = (),
    ) -> Result:
        """Runs from where it is, for a duration [s], and returns samples at a rate [Hz].

        ``log`` is an MCAP file that is written on the way. ``controller`` with its ``control_rate`` is as of :meth:`set_controller`, for this run.
        ``sensitivity`` are keys as of :meth:`Model.sensitivity`: ``result.sensitivity`` has the derivatives of this run by them, from its start on.
        Without a duration it is that of the file, or 10 s. A run that is interrupted or fails raises, and the exception has what was made as
        ``result``.
        """
        asked = self._controller
        if controller is not None:
            if control_rate is None:
                raise InputError("give the control_rate of the controller in Hz")
            asked = (controller, _period(control_rate, None))
        keys = [sensitivity] if isinstance(sensitivity, str) else list(sensitivity)
        if keys and (asked is not None or self._efforts is not None or self._targets or self._keep or self._time != 0):
            raise InputError("derivatives are of runs from time 0 on, without controllers, efforts, targets and switches that are set from outside")
        start = np.array(self._q), np.array(self._v)
        run = self._begin(duration, rate, log, True, asked, True)
        self._apply(run)
        self._moved = True
        try:
            run.run()
        except (KeyboardInterrupt, SystemExit, RunError) as error:
            self._look(run)
            error.result = Result(self.model, run.finish())
            raise
        self._look(run)
        self._know_held(run.held_efforts(), run.held_targets())
        result = Result(self.model, run.finish())
        if keys:
            result.sensitivity = self.model.sensitivity(keys, *start, duration=self._time, **self._how)
        return result

    def step(self, duration: float) -> None:
        """Goes on for a duration [s], exactly, under the efforts or the controller that are set."""
        self.step_to(self._time + duration)

    def step_to(self, time: float) -> None:
        """Goes on until a time [s], exactly."""
        time = float(time)
        if not self._time <= time < np.inf:
            raise InputError(f"cannot step to t = {time} s: the run is at {self._time} s")
        run = self._here()
        try:
            run.step_to(time)
        except BaseException:
            self._look(run)
            self._moved = True
            raise
        self._look(run)

    def pose(self, link: str) -> np.ndarray:
        """x, y, z and the quaternion w, x, y, z of a link frame in the world now."""
        return self.model.pose(link, self._q)

    def sense(self) -> Sensed:
        """What sensors measure now; all forces and accelerations are worked out once, for any number of readings."""
        return Sensed(self._here().sense())

    def energy(self) -> dict[str, float]:
        """The energy now [J]: kinetic, potential, spring, load and total."""
        run = self._run if self._is_here() else self._begin(_LONG, None, None, False, None, False)
        parts = dict(zip(("kinetic", "potential", "spring", "load"), run.energy()))
        return parts | {"total": sum(parts.values())}

    def _is_here(self):
        """Whether the run that is stepped is where q, v and time say."""
        return self._run is not None and not self._moved and self._run.is_at(self._time, self._q, self._v)

    def _here(self):
        """The run that is stepped, where q, v and time say."""
        if self._is_here():
            return self._run
        if self._run is None or self._known_held() is not None:
            self._run = self._begin(_LONG, None, None, False, self._controller, False)
        else:
            self._run.place(self._time, self._q, self._v)
        self._apply(self._run)
        # A start that was moved is where it goes on.
        self._look(self._run)
        self._moved = False
        return self._run

    def _know_held(self, held, held_at):
        """Sampled motors hold these efforts where it is now, and motors that hold their joints where a run starts these targets."""
        known = held is not None and any(effort is not None for effort in held) or held_at
        self._held = (self._time, np.array(self._q), np.array(self._v), (held, held_at)) if known else None

    def _known_held(self):
        """The efforts and targets that motors hold, if it is still where they are known."""
        if self._held is None:
            return None
        time, q, v, held = self._held
        return held if time == self._time and np.array_equal(q, self._q) and np.array_equal(v, self._v) else None

    def _apply(self, run):
        if self._efforts is not None:
            run.set_efforts(self._efforts)
        for joint, target in self._targets.items():
            run.set_target(joint, target)

    def _begin(self, duration, rate, log, record, controller, figures):
        log = None if log is None else os.fspath(log)
        numbers = [np.ascontiguousarray(self._q), np.ascontiguousarray(self._v)]
        held = (self._run.held_efforts(), self._run.held_targets()) if self._is_here() else self._known_held() or (None, {})
        run = _catena.Run(
            self.model._inner, *numbers, self._time, *held, duration, *how(**self._how), rate, self._keep, log, record, figures, self._estimate
        )
        if controller is not None:
            run.set_controller(controller[1], controller[0])
        return run

    def _look(self, run):
        self._time = run.time
        run.look(self._q, self._v)

    def __repr__(self):
        return f"<catena.Sim of {self.model.name!r} at t = {self._time:.9g} s>"


def _sim(model, given, estimate, keep, controller, state):
    sim = Sim(model, **given, keep=keep, estimate=estimate)
    sim._controller = controller
    sim.state = state
    return sim


def _period(rate, period):
    try:
        period = 1.0 / float(rate) if period is None else float(period)
    except (TypeError, ValueError, ZeroDivisionError):
        raise InputError(f"the controller's rate is {rate}: give a finite number that is greater than zero") from None
    return period
