"""Numbers of a model from measured motions, by Gauss-Newton steps on exact derivatives.

    minimise  Σ ((y(t_i; θ) − data_i)/σ)²        y: the measured joints of q        Levenberg and Marquardt: (JᵀJ + λ D) δ = −Jᵀ r
    covariance of θ:  s² (JᵀJ)⁻¹,  s² = |r|²/(samples − parameters), or 1 where σ is given
    J = U Σ Vᵀ N:  N the lengths of the columns, V and Σ of a singular value decomposition; no sample tells N⁻¹ v of a column v of V with σ ≈ 0
    the first samples alone, with the guess θ₀ as a measurement:  minimise  |r|² + s² |(θ − θ₀)/θ₀|²

Source: J. Nocedal, S. J. Wright, Numerical Optimization, Springer 2006, chapter 10.
"""

from __future__ import annotations

import warnings as python_warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._errors import CatenaError, InputError, no_joint
from ._how import how
from ._model import Model

# A fit has ended if the step without λ would move every parameter by less than this part of its standard deviation, or by roundings of itself.
SETTLED, ROUNDING = 1e-4, 1e-9
# The same after a step that was not better: sums of squares have roundings, and other steps of a run have other errors.
NEARLY = 1e-2
# A number does not count if a change by all of itself moves no sample by this much [rad or m].
UNTOLD = 1e-12
# Numbers cannot be told apart if a change of them together moves the samples by less than this part of what each moves them by itself: derivatives
# by numbers of a model are exact to about 1e-10 of themselves, and no measurement is as fine.
APART = 1e-8
# A number is in such a change if it has this part of it.
TAKES_PART = 1e-3
# The fit begins with these parts of the samples: sums of squares over many swings and events have minima beside the one that is meant. A number that a
# part does not tell stays near the guess, as if the guess were measured to within itself.
PARTS = (8, 4, 2)
# Each part ends after so many runs, or with a step of less than this part of a standard deviation.
PART_RUNS, PART_SETTLED = 8, 0.1
# The first λ, its factors after good and bad steps, and the most.
FIRST, BETTER, WORSE, MOST_DAMPED = 1e-3, 0.2, 5.0, 1e12


@dataclass(repr=False)
class Fit:
    """The result of :func:`fit`.

    Attributes
    ----------
    values : the parameters by key
    deviations : their standard deviations
    covariance : (p, p), in the order of ``keys``
    model : with these numbers; start positions and velocities are in ``q`` and ``v``
    rms : root mean square of the residuals [rad or m]
    iterations : runs that were made
    valid_within : how far each parameter may change before the events of the run change, by key; infinite without events
    converged : whether no step is left that would move a parameter by more than a small part of its standard deviation
    warnings : why not
    """

    keys: list[str]
    values: dict[str, float]
    deviations: dict[str, float]
    covariance: np.ndarray
    model: Model
    q: np.ndarray
    v: np.ndarray
    rms: float
    iterations: int
    valid_within: dict[str, float]
    converged: bool
    warnings: list[str]

    def __repr__(self):
        parts = ", ".join(f"{key} = {self.values[key]:.6g} ± {self.deviations[key]:.2g}" for key in self.keys)
        end = "" if self.converged else ", not converged"
        return f"<catena.Fit: {parts}; {self.iterations} runs, rms {self.rms:.3g}{end}>"


def fit(
    model: Model,
    t: ArrayLike,
    data: ArrayLike,
    keys: Iterable[str],
    *,
    joints: Iterable[str] | None = None,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    sigma: float | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    stages: int = 5,
    step: float | None = None,
    iterations: int = 50,
) -> Fit:
    """Finds numbers of a model so that a run goes through measured positions.

    Parameters
    ----------
    model : with guesses of the numbers
    t : equally spaced times of the samples from 0 on [s]
    data : measured positions (samples, joints) [rad or m]
    keys : key paths of ``model.params``, and ``start.q.JOINT``, ``start.v.JOINT``
    joints : of the columns of the data; all joints of one freedom if left out
    q, v : the start; that of the file if left out
    sigma : standard deviation of the data; estimated from the residuals if left out
    bounds : (lowest, highest) of a key, by key
    stages, step : of fixed steps; the step is the spacing of the samples if left out, or a part of it
    iterations : most runs; a fit that has not converged then, or cannot go on, warns of it (:class:`Fit`)

    Raises
    ------
    InputError : where the data does not fit the model, and where a number or a combination of numbers cannot be told from the data
    """
    keys = list(keys)
    t, data, spacing = _measured(t, data)
    start = model.start()
    q, v = (np.array(start[i] if given is None else given, float) for i, given in enumerate((q, v)))
    if len(q) != len(v):
        raise InputError("fit is for joints of one freedom; ball and floating joints have others")
    joints = list(model.joint_names if joints is None else joints)
    for joint in joints:
        if joint not in model.joint_names:
            raise no_joint(joint, model.joint_names)
    if data.shape[1] != len(joints):
        raise InputError(f"data has {data.shape[1]} columns for {len(joints)} joints: {', '.join(joints)}")
    bounds = bounds or {}
    _, (stages, step) = how(None, stages, spacing if step is None else step)
    theta = np.array([_value(model, q, v, key) for key in keys])

    def run(theta, count):
        own, q0, v0 = _with(model, q, v, keys, theta)
        found = own.sensitivity(keys, q0, v0, duration=float(t[count - 1]), stages=stages, step=step, times=t[:count])
        rows = np.minimum(np.searchsorted(found.t, t[:count]), len(found.t) - 1)
        missing = found.t[rows] != t[:count]
        if missing.any():
            raise CatenaError(f"the run has no sample at t = {t[:count][missing][0]:g} s")
        columns = [found.freedoms.index(joint) for joint in joints]
        apart = found.q[rows][:, columns] - data[:count]
        return apart.ravel(), found.dq[rows][:, columns].reshape(-1, len(keys)), found, (own, q0, v0)

    weight = None if sigma is None else 1.0 / float(sigma)
    lowest, highest = np.array([bounds.get(key, (-np.inf, np.inf)) for key in keys], float).reshape(-1, 2).T
    runs = 0
    for count in sorted({max(len(t) // part, 2) for part in PARTS} - {len(t)}):
        theta, more = _toward(lambda theta, count=count: run(theta, count)[:2], theta, (lowest, highest), min(PART_RUNS, iterations // 2 - runs))
        runs += more
    residual, jacobian, found, made = run(theta, len(t))
    damping, runs, refused = FIRST, runs + 1, ""
    while True:
        slope = jacobian.T @ residual
        told = np.abs(jacobian).max(axis=0) * np.where(theta == 0, 1.0, np.abs(theta))
        if not np.all(told > UNTOLD):
            raise InputError(f"{keys[int(np.argmin(told))]}: the data does not depend on it")
        # A number at its bound that would leave it stays there.
        free = ~((theta <= lowest) & (slope > 0) | (theta >= highest) & (slope < 0))
        spread = np.sqrt(np.diag(_covariance(residual, jacobian, weight)))
        left = _ahead(residual, jacobian, free) / np.maximum(spread, ROUNDING * np.abs(theta) / SETTLED)
        if np.all(np.abs(left) <= (SETTLED if damping <= FIRST else NEARLY)):
            warnings = []
            break
        if runs >= iterations or damping > MOST_DAMPED:
            warnings = [_not_settled(keys, left, refused, runs if runs >= iterations else None)]
            break
        normal = jacobian[:, free].T @ jacobian[:, free]
        motion = np.zeros(len(keys))
        motion[free] = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope[free])
        wanted = np.clip(theta + motion, lowest, highest)
        try:
            tried = run(wanted, len(t))
        except CatenaError as error:
            tried, refused = None, str(error)
        runs += 1
        if tried is not None and tried[0] @ tried[0] <= residual @ residual:
            theta, refused = wanted, ""
            residual, jacobian, found, made = tried
            damping *= BETTER
        else:
            refused = refused if tried is None else ""
            damping *= WORSE
    _refuse_combinations(keys, jacobian)
    covariance = _covariance(residual, jacobian, weight)
    deviations = np.sqrt(np.diag(covariance))
    for line in warnings:
        python_warnings.warn(line, RuntimeWarning, stacklevel=2)
    own, q0, v0 = made
    return Fit(
        keys=keys,
        values=dict(zip(keys, theta.tolist())),
        deviations=dict(zip(keys, deviations.tolist())),
        covariance=covariance,
        model=own,
        q=q0,
        v=v0,
        rms=float(np.sqrt(np.mean(residual**2))),
        iterations=runs,
        valid_within=dict(zip(keys, np.asarray(found.valid_within).tolist())),
        converged=not warnings,
        warnings=warnings,
    )


def _toward(run, theta, bounds, runs):
    """Numbers that some of the samples tell better than the guess, and the runs that were made, of at most so many."""
    if runs < 2:
        return theta, 0
    guess, width, damping = theta, np.where(theta == 0, 1.0, np.abs(theta)), FIRST
    residual, jacobian = run(theta)
    for made in range(2, runs + 1):
        variance = residual @ residual / max(len(residual) - len(theta), 1)
        held = variance / width**2
        normal = jacobian.T @ jacobian + np.diag(held)
        slope = jacobian.T @ residual + held * (theta - guess)
        if variance == 0:
            return theta, made - 1
        wanted = np.clip(theta - np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope), *bounds)
        try:
            tried = run(wanted)
        except CatenaError:
            tried = None
        if tried is None or _cost(tried[0], held, wanted - guess) > _cost(residual, held, theta - guess):
            damping *= WORSE
            continue
        moved = np.abs(wanted - theta) / np.sqrt(variance * np.diag(np.linalg.inv(normal)))
        theta, (residual, jacobian), damping = wanted, tried, damping * BETTER
        if moved.max() < PART_SETTLED:
            break
    return theta, made


def _cost(residual, held, moved):
    return residual @ residual + held @ moved**2


def _ahead(residual, jacobian, free):
    """The step of the free numbers without λ, in the directions that can be told (p)."""
    lengths, values, rows = _decomposed(jacobian[:, free])
    told = values > APART * values.max(initial=0.0)
    along = rows[told] @ (jacobian[:, free].T @ residual / lengths)
    step = np.zeros(jacobian.shape[1])
    step[free] = -(rows[told].T @ (along / values[told] ** 2)) / lengths
    return step


def _not_settled(keys, left, refused, runs):
    """Why a fit is not told as converged, in words; `left` is the step ahead in standard deviations (p)."""
    most = int(np.argmax(np.abs(left)))
    ahead = f"{keys[most]} is to move by {abs(left[most]):.2g} of its standard deviations yet"
    if runs is not None:
        return f"the fit has not converged after {runs} runs: {ahead}; give more iterations"
    why = f"the last trial has failed: {refused}" if refused else "no trial was better: the numbers are where an event begins or ends, or far from those of the data"
    return f"the fit has not converged: {ahead}, but {why}; begin with other numbers"


def _covariance(residual, jacobian, weight):
    """The covariance of what can be told."""
    lengths, values, rows = _decomposed(jacobian)
    variance = residual @ residual / max(len(residual) - jacobian.shape[1], 1) if weight is None else 1.0 / weight**2
    told = values > APART * values.max(initial=0.0)
    known = rows[told] / lengths
    return variance * (known.T / values[told] ** 2) @ known


def _decomposed(jacobian):
    """The lengths of the columns (p), and the singular values (p) and right vectors (p rows) of the matrix whose columns have length one."""
    lengths = np.linalg.norm(jacobian, axis=0)
    lengths = np.where(lengths > 0, lengths, 1.0)
    _, values, rows = np.linalg.svd(np.linalg.qr(jacobian / lengths, mode="r"))
    return lengths, np.concatenate([values, np.zeros(len(rows) - len(values))]), rows


def _refuse_combinations(keys, jacobian):
    """Refuses numbers that no sample tells apart, because changes of them together cancel."""
    _, values, rows = _decomposed(jacobian)
    untold = rows[values <= APART * values.max(initial=0.0)]
    if not len(untold):
        return
    names = [key for key, part in zip(keys, np.linalg.norm(untold, axis=0)) if part > TAKES_PART]
    if len(names) == 1:
        raise InputError(f"{names[0]}: the data does not depend on it")
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    left = len(names) - len(untold)
    raise InputError(
        f"{listed} cannot be told from the data: changes of them together cancel, and the data fixes "
        f"{left} {'number' if left == 1 else 'numbers'} of them; leave out {len(untold)} of them, which keep the numbers of the model"
    )


def _start(model, key):
    """The part of the start that a key names, and its joint."""
    for part in ("q", "v"):
        if key.startswith(f"start.{part}."):
            joint = key.removeprefix(f"start.{part}.")
            if joint not in model.joint_names:
                raise InputError(f"{key}: there is no joint {joint!r}")
            return part, model.joint_names.index(joint)
    return None


def _measured(t, data):
    """The times (samples), the data (samples, joints) and the spacing of the times [s], if they are measurements."""
    t, data = np.asarray(t, float), np.asarray(data, float)
    spacing = float(t[-1] - t[0]) / (len(t) - 1) if t.ndim == 1 and len(t) > 1 else 0.0
    if not (spacing > 0 and t[0] >= 0 and np.allclose(np.diff(t), spacing, rtol=1e-6, atol=0)):
        raise InputError("t: give at least two equally spaced times, from 0 on")
    if data.ndim not in (1, 2) or len(data) != len(t):
        raise InputError(f"data has the shape {data.shape} for {len(t)} times; give one row for each time")
    data = data.reshape(len(t), -1)
    if not np.isfinite(data).all():
        row, column = np.argwhere(~np.isfinite(data))[0]
        raise InputError(f"data is {data[row, column]} at t = {t[row]:g} s, column {column}; fit the samples before or after it")
    return t, data, spacing


def _value(model, q, v, key):
    own = _start(model, key)
    if own is not None:
        return (q if own[0] == "q" else v)[own[1]]
    params = model.params
    names = [key] if key in params else [name for name in params if name.endswith(f".{key}")]
    if len(names) != 1 or params[names[0]] is None:
        raise InputError(f"{key}: give the key path of one number that a file has, as in model.params")
    return params[names[0]]


def _with(model, q, v, keys, theta):
    q, v, numbers = q.copy(), v.copy(), {}
    for key, value in zip(keys, theta):
        own = _start(model, key)
        if own is None:
            numbers[key] = float(value)
        else:
            (q if own[0] == "q" else v)[own[1]] = value
    return model.with_params(numbers) if numbers else model, q, v
