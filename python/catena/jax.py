"""Runs as functions of JAX: `motion = catena.jax.rollout(model, keys, duration=2, step=0.01)`, then `q, v = motion(numbers)`.

The derivatives are exact, through events; `jax.grad`, `jax.jacfwd` and `jax.jit` know them. JAX must count in doubles: `jax_enable_x64`.
"""

from ._errors import InputError
from ._motion import Motion

try:
    import jax
    import jax.numpy as jnp
except ImportError as error:
    raise ImportError("catena.jax needs JAX: pip install jax") from error

__all__ = ["rollout"]


def rollout(model, keys, *, duration, step, stages=5, q=None, v=None):
    """The function from the numbers of `keys` to q and v (samples, n), a step apart; `.values` are the numbers of the model."""
    if not jax.config.jax_enable_x64:
        raise InputError('JAX counts in single precision: jax.config.update("jax_enable_x64", True) first')
    motion = Motion(model, keys, duration=duration, step=step, stages=stages, q=q, v=v)
    state = jax.ShapeDtypeStruct(motion.shape, jnp.float64)
    slopes = jax.ShapeDtypeStruct((*motion.shape, len(motion.keys)), jnp.float64)

    @jax.custom_jvp
    def run(numbers):
        return jax.pure_callback(lambda numbers: motion(numbers)[:2], (state, state), numbers, vmap_method="sequential")

    @run.defjvp
    def run_jvp(primals, tangents):
        ends = (state, state, slopes, slopes)
        q, v, dq, dv = jax.pure_callback(motion, ends, primals[0], vmap_method="sequential")
        return (q, v), (dq @ tangents[0], dv @ tangents[0])

    run.values = motion.values
    return run
