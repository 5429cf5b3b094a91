"""Environments of gymnasium: one simulation (:class:`Env`), or many side by side (:class:`VectorEnv`).

A :class:`Task` says what is simulated and what is wanted. Its functions work on the last axis of arrays, so that the same task is one
environment or many::

    task = Task(model, period=0.02, joints=["slide"], high=10.0, start=..., reward=..., terminated=...)
    env, envs = Env(task), VectorEnv(task, 64)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _catena
from ._errors import InputError
from ._named import NamedArray
from ._sim import Sim


def _all(q, v):
    return np.concatenate([q, v], axis=-1)


def _never(q, v):
    return np.zeros(q.shape[:-1], dtype=bool)


@dataclass(frozen=True)
class Task:
    """What is simulated, and what is wanted.

    Parameters
    ----------
    model : a :class:`catena.Model`
    period : an action is held for so long [s]
    joints : joints of one coordinate that actions move, in their order
    low, high : bounds of actions, a number or one for each joint [N m or N; for targets as the law of the motor says]; low is -high if left out
    action : ``"efforts"``, or ``"targets"`` of the motors of these joints
    start : ``start(rng)`` gives q and v of an episode from a generator of numpy; without it the start of the file
    observe : ``observe(q, v)``; without it q and v one after the other
    reward : ``reward(q, v, action)`` after a step
    terminated : ``terminated(q, v)``, whether an episode ends
    steps : an episode is truncated after so many steps
    tolerance : wanted accuracy of positions [m]

    q and v are arrays (..., n), with names of joints: ``q["hinge"]``; actions (..., joints).
    """

    model: object
    period: float
    joints: Sequence[str]
    high: float | Sequence[float]
    reward: Callable
    low: float | Sequence[float] | None = None
    action: str = "efforts"
    start: Callable | None = None
    observe: Callable = _all
    terminated: Callable = _never
    steps: int = 500
    tolerance: float = 1e-4

    def __post_init__(self):
        if not (np.isfinite(self.period) and self.period > 0):
            raise InputError(f"period is {self.period}: give a finite time that is longer than zero")
        if self.steps < 1:
            raise InputError(f"steps is {self.steps}: give 1 or more")
        if self.action not in ("efforts", "targets"):
            raise InputError(f"action is {self.action!r}: give 'efforts' or 'targets'")
        self._places()

    def _places(self):
        """The entries of the actions among all efforts or targets, and the number of these."""
        if self.action == "targets":
            names = self.model.motor_names
            places = {name: (index, index + 1) for index, name in enumerate(names)}
        else:
            places = {name: (first, last) for name, first, last in self.model._inner.v_places()}
        for joint in self.joints:
            first, last = places.get(joint, (0, 0))
            if last != first + 1:
                known = ", ".join(name for name, (first, last) in places.items() if last == first + 1) or "none"
                raise InputError(f"actions cannot move joint {joint!r}; joints that they can move: {known}")
        return [places[joint][0] for joint in self.joints], max((last for _, last in places.values()), default=0)

    def _action_space(self):
        high = np.broadcast_to(np.asarray(self.high, dtype=float), len(self.joints))
        low = -high if self.low is None else np.broadcast_to(np.asarray(self.low, dtype=float), len(self.joints))
        return Box(low.astype(np.float32), high.astype(np.float32))

    def _start(self, rng, of_file):
        q, v = of_file if self.start is None else self.start(rng)
        return np.array(q, dtype=float), np.array(v, dtype=float)


class _Common:
    """What one environment and many have in common."""

    def _set_up(self, task):
        self.task = task
        self._sim = Sim(task.model, tolerance=task.tolerance)
        self._of_file = task.model.start()
        self._entries, self._width = task._places()
        q, v = (self._named(np.array(array), places) for array, places in zip(self._of_file, self._names()))
        seen = np.asarray(task.observe(q, v))
        return Box(-np.inf, np.inf, seen.shape, np.float64), task._action_space()

    def _actions(self, given, *first):
        """Actions as numbers, one entry a joint."""
        joints = self.task.joints
        try:
            given = np.asarray(given, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"an action is {given!r}: give numbers, one for each of {', '.join(joints)}") from None
        shape = (*first, len(joints))
        if len(joints) == 1 and given.shape == first:
            given = given[..., None]
        if given.shape != shape:
            each = " in each environment" if first else ""
            raise InputError(f"actions have shape {given.shape}, not {shape}: give a number for each of {', '.join(joints)}{each}")
        return given

    def _names(self):
        return self.task.model._inner.q_places(), self.task.model._inner.v_places()

    @staticmethod
    def _named(array, places):
        return NamedArray(array, places)


class Env(_Common, gymnasium.Env):
    """One simulation as an environment of gymnasium."""

    metadata = {"render_modes": []}
    render_mode = None

    def __init__(self, task: Task):
        self.observation_space, self.action_space = self._set_up(task)
        self._step = 0

    def _observed(self):
        return np.array(self.task.observe(self._sim.q, self._sim.v), dtype=float)

    def reset(self, *, seed=None, options=None):
        """Begins an episode; ``options`` may give its ``q`` and ``v``."""
        super().reset(seed=seed)
        q, v = self.task._start(self.np_random, self._of_file)
        options = options or {}
        self._sim.reset()
        self._sim.q, self._sim.v = options.get("q", q), options.get("v", v)
        self._sim.set_efforts(None)
        self._step = 0
        return self._observed(), {}

    def step(self, action):
        """Holds an action for a period."""
        action = self._actions(action)
        numbers = np.zeros(self._width)
        numbers[self._entries] = np.clip(action, self.action_space.low, self.action_space.high)
        if self.task.action == "targets":
            self._sim.set_targets(dict(zip(self.task.joints, numbers[self._entries])))
        else:
            self._sim.set_efforts(numbers)
        self._sim.step(self.task.period)
        self._step += 1
        q, v = self._sim.q, self._sim.v
        terminated = bool(self.task.terminated(q, v))
        return self._observed(), float(self.task.reward(q, v, action)), terminated, self._step >= self.task.steps, {}


class VectorEnv(_Common, gymnasium.vector.VectorEnv):
    """Many simulations as a vector environment of gymnasium, bit for bit the single ones.

    An environment whose episode ends begins another in the same step; ``infos["final_obs"]`` has its last observation. A simulation that fails is
    truncated, and ``infos["failure"]`` says why.

    Parameters
    ----------
    task : the task of each
    num_envs : how many there are
    threads : how many share the work of a step; 0 takes all cores
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.SAME_STEP}
    render_mode = None

    def __init__(self, task: Task, num_envs: int, *, threads: int = 1):
        if num_envs < 1:
            raise InputError(f"num_envs is {num_envs}: give 1 or more")
        if task.action == "targets" and len(task.joints) != len(task.model.motor_names):
            raise InputError("targets of many environments are for all motors: name every joint with a motor")
        self.num_envs = num_envs
        self.single_observation_space, self.single_action_space = self._set_up(task)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._batch = _catena.Batch(self._sim._here(), num_envs, threads)
        q, v = (np.tile(array, (num_envs, 1)) for array in self._of_file)
        self._q, self._v = (self._named(array, places) for array, places in zip((q, v), self._names()))
        # The same memory, for the library.
        self._flat = np.asarray(self._q).reshape(-1), np.asarray(self._v).reshape(-1)
        self._inputs = np.zeros((num_envs, self._width))
        self._steps = np.zeros(num_envs, dtype=int)
        self._rngs = [None] * num_envs

    def reset(self, *, seed=None, options=None):
        """Begins all episodes; the seed of environment i is ``seed + i``, or entry i."""
        if seed is not None:
            seeds = [seed + index for index in range(self.num_envs)] if np.ndim(seed) == 0 else list(seed)
            self._rngs = [gymnasium.utils.seeding.np_random(None if one is None else int(one))[0] for one in seeds]
        self._rngs = [rng or gymnasium.utils.seeding.np_random()[0] for rng in self._rngs]
        for index in range(self.num_envs):
            self._begin(index)
        return self._observed(self._q, self._v), {}

    def step(self, actions):
        """Holds an action of each for a period."""
        actions = self._actions(actions, self.num_envs)
        space = self.single_action_space
        self._inputs[:, self._entries] = np.clip(actions, space.low, space.high)
        flat, none = self._inputs.reshape(-1), np.zeros(0)
        efforts, targets = (none, flat) if self.task.action == "targets" else (flat, none)
        failed = self._batch.step(self.task.period, efforts, targets, *self._flat)
        self._steps += 1
        rewards = np.array(self.task.reward(self._q, self._v, actions), dtype=float)
        terminated = np.array(self.task.terminated(self._q, self._v), dtype=bool)
        truncated = self._steps >= self.task.steps
        infos = {}
        if failed:
            reasons, which = np.full(self.num_envs, None, dtype=object), np.zeros(self.num_envs, dtype=bool)
            for index, why in failed:
                reasons[index], which[index] = why, True
            truncated = truncated | which
            infos = {"failure": reasons, "_failure": which}
        over = terminated | truncated
        seen = self._observed(self._q, self._v)
        if over.any():
            last = np.full(self.num_envs, None, dtype=object)
            for index in np.flatnonzero(over):
                last[index] = seen[index].copy()
                self._begin(index)
            seen = self._observed(self._q, self._v)
            infos |= {"final_obs": last, "_final_obs": over, "final_info": {}, "_final_info": over}
        return seen, rewards, terminated, truncated, infos

    def _observed(self, q, v):
        return np.array(self.task.observe(q, v), dtype=float)

    def _begin(self, index):
        q, v = self.task._start(self._rngs[index], self._of_file)
        self._batch.place(index, q, v)
        self._q[index], self._v[index] = q, v
        self._steps[index] = 0
