"""Robots and scenes, and their equations of motion."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from . import _catena
from ._errors import InputError
from ._how import how
from ._result import save_columns, table_of


def as_array(numbers, what, axes, wanted):
    """Numbers as an array of so many axes."""
    try:
        array = np.ascontiguousarray(numbers, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what}: {error}") from None
    if array.ndim != axes:
        raise InputError(f"{what}: an array {wanted} is wanted, not of shape {array.shape}")
    return array


def flat(numbers, what):
    """Numbers as a flat array."""
    return as_array(numbers, what, 1, "of one axis")


def load(
    path: str | os.PathLike[str],
    *,
    base: str = "fixed",
    base_pose: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    floor: float | None = None,
    contact: str | None = None,
    without: Iterable[str] = (),
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    params: Mapping[str, float] | None = None,
    hold: bool | Mapping[str, float] | None = None,
    keyframe: str | None = None,
) -> Model:
    """Reads a robot (``.urdf``) or a scene (``.toml``).

    Parameters
    ----------
    path : path of the file
    base : ``"fixed"`` as the file says, or ``"floating"``
    base_pose : x, y, z, roll, pitch, yaw of the root link in the world [m, rad]
    gravity : acceleration of gravity in the world, x, y, z [m/s²]; (0, 0, -9.81) if neither this nor the file says otherwise
    floor : height of a floor under everything [m]
    contact : which shapes may touch: ``"none"``, ``"environment"`` (links with obstacles) or ``"all"``, the default in scenes with an obstacle, a floor or a free body
    without : what is left out: ``"limits"``, ``"friction"``, ``"damping"``, ``"motors"``, ``"contact"``
    packages : folders of ROS packages by name
    params : numbers by key path, as of :meth:`Model.with_params`
    hold : True, and motors hold all joints that have none where a run starts; ``{"kp": 100, "kd": 5}`` gives them gains [N m/rad or N/m, N m s/rad or N s/m],
        and ``"gravity": 1`` an effort that holds the weight besides. A second run, a start that is set and a pickle that is read hold where they begin
    keyframe : the name of a keyframe of a model of MuJoCo to start with

    Raises
    ------
    InputError : what is wrong with the file, with its line
    """
    if base not in ("fixed", "floating"):
        raise InputError(f"base is {base!r}: give 'fixed' or 'floating'")
    without = [without] if isinstance(without, str) else list(without)
    pose = None if base_pose is None else _count(base_pose, 6, "base_pose")
    down = None if gravity is None else _count(gravity, 3, "gravity")
    given = dict(
        base=base, base_pose=pose, gravity=down, floor=floor, contact=contact, without=without, packages=dict(packages or {}), params=_params(params or {}),
        hold=hold, keyframe=keyframe,
    )  # fmt: skip
    inner = _catena.Model(
        os.fspath(path), base == "floating", pose, down, floor, contact, without, given["packages"], given["params"], _gains(hold), keyframe
    )
    return Model(inner, given)


def _count(numbers, count, what):
    array = flat(numbers, what)
    if len(array) != count:
        raise InputError(f"{what}: {count} numbers are wanted, not {len(array)}")
    return array.tolist()


def _gains(hold):
    """The gains of motors that hold joints; None for no motors."""
    if hold is None or hold is False:
        return None
    if hold is True:
        return (None, None, None)
    try:
        gains = {str(name): float(gain) for name, gain in dict(hold).items()}
    except (TypeError, ValueError):
        raise InputError(f"hold is {hold!r}: give True, or gains such as {{'kp': 100, 'kd': 5}}") from None
    if unknown := set(gains) - {"kp", "kd", "gravity"}:
        raise InputError(f"hold has no gain {sorted(unknown)[0]!r}: give kp, kd and gravity")
    return (gains.get("kp"), gains.get("kd"), gains.get("gravity"))


def _params(params):
    try:
        return {str(key): float(number) for key, number in dict(params).items()}
    except (TypeError, ValueError) as error:
        raise InputError(f"params: {error}") from None


def _rows(rows, name, shape):
    """Derivatives of a loss by all samples."""
    if rows is None:
        return np.zeros(shape)
    array = as_array(rows, f"{name} of the loss", 2, f"of shape {shape}")
    if array.shape != shape:
        raise InputError(f"{name} of the loss: an array of shape {shape} is wanted, not of {array.shape}")
    return array


def _of_event(number, by):
    """Derivatives of a loss by an event."""
    dt, dq, dv = by if isinstance(by, (tuple, list)) else (by, None, None)
    parts = [None if part is None else flat(part, f"the loss by event {number}") for part in (dq, dv)]
    return int(number), float(dt), *parts


@dataclass(repr=False)
class Sensitivity:
    """A run and its derivatives at its start and at the end of every step to a given instant.

    Attributes
    ----------
    t : times (steps,) [s]
    q, v : (steps, n) as of a run
    dq, dv : derivatives (steps, n, p) along ``freedoms``, the entries of v, by ``keys``. Where q has a quaternion, dq has a rotation vector φ about the
        axes in which v has the angular velocity, those of the parent: ``R <- exp(hat(φ)) R``, the quaternion changes by ``0.5 (0, φ) * quaternion``.
        A floating joint moves the origin of its link, as in q and v
    keys, freedoms : names
    events : of the run, each with its time ``t`` [s], ``what`` it is, the derivatives ``dt`` (p) of its time, the ``rate`` of its function, and ``q``, ``v``
        before it jumps with their derivatives ``dq``, ``dv`` (n, p)
    valid_within : how far each parameter may change before an event is missed, added, or comes in another order (p), to first order
    bounded_by : the event that bounds it, in words (p)
    warnings : events behind which the derivatives are worse than their order
    """

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    keys: list[str]
    freedoms: list[str]
    events: list[dict]
    valid_within: np.ndarray
    bounded_by: list[str]
    warnings: list[str]

    def _columns(self):
        # Ball joints have more positions than freedoms.
        named = self.freedoms if self.q.shape[1] == len(self.freedoms) else range(self.q.shape[1])
        columns = {"t": self.t}
        columns |= {f"q.{name}": part for name, part in zip(named, self.q.T)}
        columns |= {f"v.{name}": part for name, part in zip(self.freedoms, self.v.T)}
        for symbol, array in (("dq", self.dq), ("dv", self.dv)):
            for row, freedom in enumerate(self.freedoms):
                columns |= {f"{symbol}.{freedom}/d.{key}": array[:, row, column] for column, key in enumerate(self.keys)}
        return columns

    def to_pandas(self):
        """A table indexed by time with a column for each position and velocity, and for each derivative, ``dq.JOINT/d.KEY`` and ``dv.JOINT/d.KEY``."""
        return table_of(self._columns())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the run and its derivatives, the columns of ``to_pandas``, to a file of this ending: ``.npz``, ``.parquet`` or ``.csv``.

        A file that is there is replaced when all of the new one is written.
        """
        save_columns(path, self._columns())

    def __repr__(self):
        return f"<catena.Sensitivity: {len(self.t) - 1} steps to {self.t[-1]:.9g} s, by {', '.join(self.keys)}>"


@dataclass(repr=False)
class Samples:
    """The samples of a run that a loss is of.

    Attributes
    ----------
    t : times (samples,) [s]
    q, v : (samples, n) as of a run
    events : of the whole run, each with its time ``t`` [s], ``what`` it is, and ``q``, ``v`` before it jumps
    """

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    events: list[dict]

    def event(self, word: str, count: int = 0) -> int:
        """The number among all events of the one that has this word, as the name of a joint or shape, after so many others: ``run.event("floor", 2)``."""
        own = [number for number, event in enumerate(self.events) if word in event["what"]]
        if not 0 <= count < len(own):
            known = ", ".join(sorted({event["what"] for event in self.events})) or "none"
            raise InputError(f"the run has {len(own)} events with {word!r}, not {count + 1}; it has: {known}")
        return own[count]


@dataclass(repr=False)
class Gradient:
    """A loss of a run and its gradient.

    Attributes
    ----------
    value : of the loss
    by : derivatives (p) by ``keys``
    keys : names
    samples : of the run: :class:`Samples`
    warnings : events behind which the derivatives are worse than their order
    """

    value: float
    by: np.ndarray
    keys: list[str]
    samples: Samples
    warnings: list[str]

    def __repr__(self):
        return f"<catena.Gradient: loss {self.value:.6g}, by {len(self.keys)} numbers>"


class Linear:
    """Linear equations of motion ``d/dt x = A x + B u``; x holds the independent joint coordinates, then their velocities.

    Coordinates of ball and floating joints are slight motions along v: a rotation vector about the axes of the parent, and the displacement of the
    origin of a floating link. The lower rows of A and B are the derivatives of :meth:`Model.forward_dynamics`.

    Attributes
    ----------
    A, B : (d + e, d + e) and (d + e, n), B for efforts along ``freedoms``
    B_targets : (d + e, m), for targets of the motors of the joints ``targets``
    inertia, damping, stiffness : (e, e), (e, e) and (e, d)
    names, units : of the d independent coordinates; ``JOINT.x`` where a joint has several
    velocities : those of the names whose velocities are independent, e; all of them unless contacts roll
    q, v : the state; ``largest_acceleration`` is zero at an equilibrium
    eigenvalues : of the modes, complex, the slowest first; one for each pair of conjugates
    frequencies, damping_ratios : of the modes, Hz and −Re λ/|λ| (nan for free motions)
    shapes : (modes, n), complex, along ``freedoms``
    stable : "yes", "neutral", "no" or "free" for each mode
    sticking_contacts, rolling_contacts, sliding_contacts : how many contacts are closed
    stuck, saturated : joints that do not move, with the reason; joints whose motor is at its bound
    eigenvalues_by : by key path, the derivatives of the eigenvalues (nan where eigenvalues are equal)
    frequencies_by : the same of the frequencies, Hz per unit
    """

    def __init__(self, told):
        def complexes(pairs):
            return np.array([complex(np.nan, np.nan) if pair is None else complex(*pair) for pair in pairs])

        self.eigenvalues_by = {key: complexes(pairs) for key, pairs in told["by"].items()}
        self.frequencies_by = {key: of.imag / (2 * np.pi) for key, of in self.eigenvalues_by.items()}
        self.A, self.B, self.B_targets = told["A"], told["B"], told["B_targets"]
        self.inertia, self.damping, self.stiffness = told["inertia"], told["damping"], told["stiffness"]
        self.names, self.units, self.freedoms, self.targets = told["names"], told["units"], told["freedoms"], told["targets"]
        self.velocities = told["velocities"]
        self.sticking_contacts, self.rolling_contacts, self.sliding_contacts = (told[f"{kind}_contacts"] for kind in ("sticking", "rolling", "sliding"))
        self.q, self.v, self.largest_acceleration = told["q"], told["v"], told["largest_acceleration"]
        self.iterations, self.stuck, self.saturated, self.stable = told["iterations"], told["stuck"], told["saturated"], told["stable"]
        self.eigenvalues = told["eigenvalues_re"] + 1j * told["eigenvalues_im"]
        self.frequencies = told["eigenvalues_im"] / (2 * np.pi)
        size = np.abs(self.eigenvalues)
        self.damping_ratios = np.where(size > 0, -self.eigenvalues.real / np.where(size > 0, size, 1), np.nan)
        parts = np.array(told["shapes"], dtype=float).reshape(len(size), len(self.freedoms), 2)
        self.shapes = parts[..., 0] + 1j * parts[..., 1]

    def discrete(self, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B and B_targets of the discrete system whose inputs are held over a step [s]."""
        if not (np.isfinite(step) and step > 0):
            raise InputError(f"step is {step!r}: give seconds above zero")
        return tuple(_catena.discrete(self.A, self.B, self.B_targets, float(step)))

    def __repr__(self):
        modes = ", ".join(f"{frequency:.4g} Hz ({stable})" for frequency, stable in zip(self.frequencies, self.stable))
        return f"Linear({', '.join(self.names)}; modes: {modes})"


@dataclass
class Multipliers:
    """How slight changes of a start have grown after a period.

    Attributes
    ----------
    period : s
    values : the multipliers, complex, the largest first; an orbit that may begin anywhere on itself has one of 1, with energy two
    apart : how far q and v at the end are from those at the start; whole turns count as none
    warnings : what makes them worse than the order of the steps
    """

    period: float
    values: np.ndarray
    apart: float
    warnings: list[str]


class Model:
    """A robot or scene, ready to be simulated; it never changes. Made by :func:`load`.

    q and v hold the coordinates of the joints that move, one joint after another: lengths, angles and their rates; a ball joint has a quaternion
    w, x, y, z in q and its angular velocity in v, a floating one x, y, z, w, x, y, z and its velocity and angular velocity. Efforts, accelerations
    and matrices go with v. SI units.
    """

    def __init__(self, inner, given=None):
        self._inner = inner
        self._given = given or {}

    def __reduce__(self):
        # The file is read again where it is unpickled.
        return _load, (os.path.abspath(self.path), self._given)

    @property
    def name(self) -> str:
        """Name of the robot or scene."""
        return self._inner.name

    @property
    def path(self):
        """The file it was read from."""
        return self._inner.path

    @property
    def nq(self) -> int:
        """Number of positions in q; a rotation has four."""
        return max((end for _, _, end in self._inner.q_places()), default=0)

    @property
    def nv(self) -> int:
        """Number of velocities in v, the degrees of freedom of the tree."""
        return max((end for _, _, end in self._inner.v_places()), default=0)

    @property
    def joint_names(self) -> list[str]:
        """Joints that move, in the order of q and v."""
        return self._inner.joint_names

    @property
    def link_names(self) -> list[str]:
        """All links, in the order of the file."""
        return self._inner.link_names

    @property
    def motor_names(self) -> list[str]:
        """Joints with motors, in the order of targets."""
        return self._inner.motor_names

    @property
    def warnings(self) -> list[str]:
        """What was left out and why, and what else is worth knowing."""
        return self._inner.warnings

    @property
    def params(self) -> dict[str, float | None]:
        """Numbers by key path: those that were set, or else those of the files; None where no file has one."""
        return dict(self._inner.params())

    def with_params(self, params: Mapping[str, float]) -> Model:
        """The same with other numbers, by key path: ``model.with_params({"link7.mass": 2.5, "gravity.z": -1.62})``.

        ``model.params`` has all key paths; the first word may be left out where one number remains.
        """
        params = _params(params)
        given = {**self._given, "params": {**self._given.get("params", {}), **params}}
        return Model(self._inner.with_params(params), given)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """q and v where the file starts it, with all loops closed."""
        return self._inner.start()

    def linearize(self, q: ArrayLike | None = None, v: ArrayLike | None = None, efforts: ArrayLike | None = None, *, at: str | None = None, by: str | Iterable[str] = ()) -> Linear:
        """Linear equations of motion and their modes: a :class:`Linear`.

        Parameters
        ----------
        q, v : the state; the start of the file if they are left out
        efforts : besides motors, springs and dampers; zero if they are left out
        at : ``"rest"`` for the equilibrium near q, ``"state"`` for q and v themselves; "rest" unless v or efforts are given
        by : key paths of numbers of the scene, by which eigenvalues and frequencies are differentiated

        Raises
        ------
        InputError : if there is no equilibrium near q, or contacts begin to slide
        """
        if at is None:
            at = "rest" if v is None and efforts is None else "state"
        if at not in ("rest", "state"):
            raise InputError(f"at is {at!r}: give 'rest' or 'state'")
        if at == "rest" and not (v is None and efforts is None):
            raise InputError("at is 'rest': v and efforts are for at='state'")
        given = [None if numbers is None else flat(numbers, name) for name, numbers in (("q", q), ("v", v), ("efforts", efforts))]
        keys = [by] if isinstance(by, str) else [str(key) for key in by]
        return Linear(self._inner.linearize(*given, at == "rest", keys))

    def multipliers(
        self,
        period: float,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        *,
        tolerance: float | None = None,
        stages: int | None = None,
        step: float | None = None,
    ) -> Multipliers:
        """Multipliers of the motion from q and v on, which comes back after a period [s]: a :class:`Multipliers`.

        Parameters
        ----------
        period : s
        q, v : the start; that of the file if they are left out
        tolerance : wanted accuracy [m], or ``stages`` and ``step`` [s] of fixed steps

        Raises
        ------
        InputError : as :meth:`sensitivity`
        """
        given = [None if numbers is None else flat(numbers, name) for name, numbers in (("q", q), ("v", v))]
        values, apart, warnings = self._inner.multipliers(float(period), *given, *how(tolerance, stages, step))
        return Multipliers(float(period), np.array([complex(*value) for value in values]), apart, warnings)

    def sensitivity(
        self,
        keys: str | Iterable[str],
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        *,
        duration: float = 1.0,
        tolerance: float | None = None,
        stages: int | None = None,
        step: float | None = None,
        times: ArrayLike | None = None,
    ) -> Sensitivity:
        """A run and its derivatives by its start and its numbers: a :class:`Sensitivity`.

        The derivatives go through the steps of the run and are exact for them, also through its events: limits, dry friction, motors at their bounds
        and impacts of contacts.

        Parameters
        ----------
        keys : ``"start.q"``, ``"start.v"`` (or ``"start.q.JOINT"``), ``"effort.JOINT"``, and key paths of ``model.params``. Starts and efforts of
            floating and ball joints are along v, as dq is; an effort is held as :meth:`Sim.set_efforts` holds it
        q, v : the start; that of the file if they are left out
        duration : s
        tolerance : wanted accuracy [m], or ``stages`` and ``step`` [s] of fixed steps
        times : instants at which steps end as well [s]: each is among ``t``, at an event with the velocities before it

        Raises
        ------
        InputError : unknown keys, and runs without derivatives: with drag, ropes through points, belts, rolling and spinning friction, joints that are
            moved in time, loads over time or in the axes of a link, motors that hold weights, ellipsoids, dampers in ball joints, contacts whose
            forces are not unique where they let go, and many events in one instant
        """
        keys = [keys] if isinstance(keys, str) else [str(key) for key in keys]
        given = [None if numbers is None else flat(numbers, name) for name, numbers in (("q", q), ("v", v))]
        accuracy, fixed = how(tolerance, stages, step)
        told = self._inner.sensitivity(keys, *given, float(duration), accuracy, fixed, None if times is None else flat(times, "times"))
        return Sensitivity(**told)

    def gradient(
        self,
        keys: str | Iterable[str],
        times: ArrayLike,
        loss: Callable[[Samples], tuple],
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        *,
        duration: float | None = None,
        tolerance: float | None = None,
        stages: int | None = None,
        step: float | None = None,
        every: int = 1,
    ) -> Gradient:
        """The gradient of a loss of a run, against time: a :class:`Gradient`. Its cost hardly depends on the number of keys.

        The steps of the run also end at the samples, and the gradient is exact for them, through events as well.

        Parameters
        ----------
        keys : as of :meth:`sensitivity`
        times : of the samples, in order, from 0 on [s]
        loss : a function of the :class:`Samples`: its value, and the derivatives dq, dv (samples, n) of it along v, as of :class:`Sensitivity`; None for zeros.
            A fourth entry has the derivatives by events: ``{number: dt}`` or ``{number: (dt, dq, dv)}``
        q, v : the start; that of the file if they are left out
        duration : s; the last time if left out
        tolerance : wanted accuracy [m], or ``stages`` and ``step`` [s] of fixed steps
        every : one of so many states is kept, and those between are computed again; the gradient is the same

        Raises
        ------
        InputError : as :meth:`sensitivity`; also motors that hold their effort between ticks, and corners that stick
        """
        keys = [keys] if isinstance(keys, str) else [str(key) for key in keys]
        times = flat(times, "times")
        if len(times) == 0:
            raise InputError("times: give one sample at least")
        if int(every) < 1:
            raise InputError(f"every is {every!r}: give 1 or more")
        given = [None if numbers is None else flat(numbers, name) for name, numbers in (("q", q), ("v", v))]
        accuracy, fixed = how(tolerance, stages, step)
        seen = []

        def lost(t, q, v, events):
            seen.append(Samples(t, q, v, events))
            said = tuple(loss(seen[0]))
            if len(said) not in (3, 4):
                raise InputError(f"loss gives {len(said)} numbers: its value, dq, dv, and at most those by events are wanted")
            rows = [_rows(rows, name, (len(t), self.nv)) for rows, name in zip(said[1:3], ("dq", "dv"))]
            by_events = said[3] if len(said) == 4 else {}
            return float(said[0]), *rows, [_of_event(number, by) for number, by in dict(by_events).items()]

        length = float(times[-1]) if duration is None else float(duration)
        value, names, by, warnings = self._inner.gradient(keys, times, lost, *given, length, accuracy, fixed, int(every))
        return Gradient(value, by, names, seen[0], warnings)

    def mass_matrix(self, q: ArrayLike) -> np.ndarray:
        """The mass matrix M(q), (n, n)."""
        return self._inner.mass_matrix(flat(q, "q"))

    def jacobian(self, link: str, q: ArrayLike, point: ArrayLike = (0, 0, 0)) -> np.ndarray:
        """The Jacobian (6, n) of a point on a link, given in the link's frame [m]: its velocity, then the link's angular velocity, in the world, for v."""
        return self._inner.point_jacobian(link, _count(point, 3, "point"), flat(q, "q"))

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike, joints: Iterable[str] | None = None) -> np.ndarray:
        """The efforts (n) that give the accelerations a = dv/dt, besides gravity, springs, dampers and loads.

        With closed loops and joints that mimic others several efforts do: those of least norm, or those on ``joints`` alone."""
        return self._inner.inverse_dynamics(flat(q, "q"), flat(v, "v"), flat(a, "a"), None if joints is None else list(joints))

    def velocity(self, link: str, q: ArrayLike, v: ArrayLike, point: ArrayLike = (0, 0, 0)) -> np.ndarray:
        """Velocity of a point on a link, given in the link's frame [m], then the link's angular velocity, in the world (6)."""
        return self._inner.point_velocity(link, _count(point, 3, "point"), flat(q, "q"), flat(v, "v"))

    def acceleration(self, link: str, q: ArrayLike, v: ArrayLike, a: ArrayLike, point: ArrayLike = (0, 0, 0)) -> np.ndarray:
        """Acceleration of that point, then the link's angular acceleration, in the world (6), for a = dv/dt."""
        return self._inner.point_acceleration(link, _count(point, 3, "point"), flat(q, "q"), flat(v, "v"), flat(a, "a"))

    def bias_acceleration(self, link: str, q: ArrayLike, v: ArrayLike, point: ArrayLike = (0, 0, 0)) -> np.ndarray:
        """J̇ v of that point (6): its acceleration, and the link's, for dv/dt = 0."""
        return self.acceleration(link, q, v, np.zeros(len(flat(v, "v"))), point)

    def center_of_mass(self, q: ArrayLike) -> np.ndarray:
        """Centre of mass of all that moves, in the world (3)."""
        return self._inner.center_of_mass(flat(q, "q"))

    def center_of_mass_jacobian(self, q: ArrayLike) -> np.ndarray:
        """Its Jacobian (3, n) for v."""
        return self._inner.center_of_mass_jacobian(flat(q, "q"))

    def momentum(self, q: ArrayLike, v: ArrayLike) -> np.ndarray:
        """Momentum of all that moves, then its angular momentum about the origin of the world (6)."""
        return self._inner.momentum(flat(q, "q"), flat(v, "v"))

    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, efforts: ArrayLike) -> np.ndarray:
        """The accelerations dv/dt (n) under efforts, with closed loops and joints that mimic others."""
        return self._inner.forward_dynamics(flat(q, "q"), flat(v, "v"), flat(efforts, "efforts"))

    def gravity_efforts(self, q: ArrayLike) -> np.ndarray:
        """The efforts (n) that hold it at rest against gravity alone."""
        return self._inner.gravity_efforts(flat(q, "q"))

    def pose(self, link: str, q: ArrayLike) -> np.ndarray:
        """x, y, z and the quaternion w, x, y, z of a link frame in the world."""
        return self._inner.pose(link, flat(q, "q"))

    def __repr__(self):
        return f"<catena.Model {self.name!r}: {len(self.link_names)} links, {len(self.joint_names)} joints that move>"


def _load(path, given):
    return load(path, **given)
