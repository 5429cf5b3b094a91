"""Numbers of a model from measured motions, by Gauss-Newton steps on exact derivatives.

    minimise  Σ ((y(t_i; θ) − data_i)/σ)²        y: the measured joints of q        Levenberg and Marquardt: (JᵀJ + λ D) δ = −Jᵀ r
    covariance of θ:  s² (JᵀJ)⁻¹,  s² = |r|²/(samples − parameters), or 1 where σ is given
    J = U Σ Vᵀ N:  N the lengths of the columns, V and Σ of a singular value decomposition; no sample tells N⁻¹ v of a column v of V with σ ≈ 0

Source: J. Nocedal, S. J. Wright, Numerical Optimization, Springer 2006, chapter 10.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._errors import CatenaError, InputError
from ._model import Model

# A fit has ended if a step moves every parameter by less than this part of its standard deviation, or of itself.
SETTLED = 1e-4
# A number does not count if a change by all of itself moves no sample by this much [rad or m].
UNTOLD = 1e-12
# Numbers cannot be told apart if a change of them together moves the samples by less than this part of what each moves them by itself: derivatives
# by numbers of a model are exact to about 1e-10 of themselves, and no measurement is as fine.
APART = 1e-8
# A number is in such a change if it has this part of it.
TAKES_PART = 1e-3
# The first λ, and its factors after good and bad steps.
FIRST, BETTER, WORSE = 1e-3, 0.2, 5.0


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

    def __repr__(self):
        parts = ", ".join(f"{key} = {self.values[key]:.6g} ± {self.deviations[key]:.2g}" for key in self.keys)
        return f"<catena.Fit: {parts}; {self.iterations} runs, rms {self.rms:.3g}>"


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

    Raises
    ------
    InputError : where the data does not fit the model, and where a number or a combination of numbers cannot be told from the data
    """
    keys, t, data = list(keys), np.asarray(t, float), np.asarray(data, float)
    data = data.reshape(len(t), -1)
    spacing = (t[-1] - t[0]) / max(len(t) - 1, 1)
    if len(t) < 2 or t[0] < 0 or not np.allclose(np.diff(t), spacing, rtol=1e-6):
        raise InputError("t: give at least two equally spaced times, from 0 on")
    start = model.start()
    q, v = (np.array(start[i] if given is None else given, float) for i, given in enumerate((q, v)))
    if len(q) != len(v):
        raise InputError("fit is for joints of one freedom; ball and floating joints have others")
    joints = list(model.joint_names if joints is None else joints)
    if data.shape[1] != len(joints):
        raise InputError(f"data has {data.shape[1]} columns for {len(joints)} joints: {', '.join(joints)}")
    bounds = bounds or {}
    duration, step = float(t[-1]), float(spacing if step is None else step)
    theta = np.array([_value(model, q, v, key) for key in keys])

    def run(theta):
        own, q0, v0 = _with(model, q, v, keys, theta)
        found = own.sensitivity(keys, q0, v0, duration=duration, stages=stages, step=step)
        rows = np.searchsorted(found.t, t - 1e-9 * max(duration, 1))
        rows = np.minimum(rows, len(found.t) - 1)
        there = np.abs(found.t[rows] - t) < 1e-9 * max(duration, 1)
        columns = [found.freedoms.index(joint) for joint in joints]
        apart = (found.q[rows][:, columns] - data)[there]
        slopes = found.dq[rows][:, columns][there]
        return apart.ravel(), slopes.reshape(-1, len(keys)), found, (own, q0, v0)

    weight = 1.0 if sigma is None else 1.0 / float(sigma)
    residual, jacobian, found, made = run(theta)
    damping, runs = FIRST, 1
    while runs < iterations:
        normal, slope = jacobian.T @ jacobian, jacobian.T @ residual
        told = np.abs(jacobian).max(axis=0) * np.where(theta == 0, 1.0, np.abs(theta))
        if not np.all(told > UNTOLD):
            raise InputError(f"{keys[int(np.argmin(told))]}: the data does not depend on it")
        motion = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope)
        wanted = np.array([np.clip(one, *bounds.get(key, (-np.inf, np.inf))) for key, one in zip(keys, theta + motion)])
        try:
            tried = run(wanted)
        except CatenaError:
            tried = None
        runs += 1
        if tried is not None and tried[0].size == residual.size and tried[0] @ tried[0] <= residual @ residual:
            moved, theta = np.abs(wanted - theta), wanted
            residual, jacobian, found, made = tried
            damping *= BETTER
            spread = np.sqrt(np.diag(_covariance(residual, jacobian, weight if sigma else None)))
            if np.all(moved <= SETTLED * np.maximum(spread, 1e-9 * np.abs(theta))):
                break
        else:
            damping *= WORSE
            if damping > 1e12:
                break
    _refuse_combinations(keys, jacobian)
    covariance = _covariance(residual, jacobian, weight if sigma else None)
    deviations = np.sqrt(np.diag(covariance))
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
    )


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
