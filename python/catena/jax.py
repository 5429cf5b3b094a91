"""Runs as functions of JAX: `motion = catena.jax.rollout(model, keys, duration=2, step=0.01)`, then `q, v = motion(numbers)`.

The derivatives are exact, through events; `jax.grad`, `jax.jacfwd` and `jax.jit` know them. By more than 30 numbers they are taken
against time, at a cost that hardly grows with them, and `jax.grad` alone knows them; `against_time` says so or otherwise. JAX must count in doubles: `jax_enable_x64`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from numpy.typing import ArrayLike

from ._errors import InputError
from ._model import Model
from ._motion import Motion

try:
    import jax
    import jax.numpy as jnp
except ImportError as error:
    raise ImportError("catena.jax needs JAX: pip install jax") from error

__all__ = ["rollout"]


def rollout(
    model: Model,
    keys: str | Iterable[str],
    *,
    duration: float,
    step: float,
    stages: int = 5,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    against_time: bool | None = None,
):
    """The function from the numbers of `keys` to q and v (samples, n), a step apart; `.values` are the numbers of the model."""
    if not jax.config.jax_enable_x64:
        raise InputError('JAX counts in single precision: jax.config.update("jax_enable_x64", True) first')
    motion = Motion(model, keys, duration=duration, step=step, stages=stages, q=q, v=v, against_time=against_time)
    state = jax.ShapeDtypeStruct(motion.shape, jnp.float64)
    slopes = jax.ShapeDtypeStruct((*motion.shape, len(motion.keys)), jnp.float64)

    both = lambda numbers: jax.pure_callback(motion.motion, (state, state), numbers, vmap_method="sequential")
    if motion.against_time:
        gradient = jax.ShapeDtypeStruct((len(motion.keys),), jnp.float64)
        run = jax.custom_vjp(both)
        against = lambda numbers, by: (jax.pure_callback(motion.gradient, gradient, numbers, *by, vmap_method="sequential"),)
        run.defvjp(lambda numbers: (both(numbers), numbers), against)
    else:
        run = jax.custom_jvp(both)

        @run.defjvp
        def run_jvp(primals, tangents):
            ends = (state, state, slopes, slopes)
            q, v, dq, dv = jax.pure_callback(motion, ends, primals[0], vmap_method="sequential")
            return (q, v), (dq @ tangents[0], dv @ tangents[0])

    run.values = motion.values
    return run
