"""Runs as functions of PyTorch: `motion = catena.torch.rollout(model, keys, duration=2, step=0.01)`, then `q, v = motion(numbers)`.

The derivatives are exact, through events; `backward` knows them. By more than 30
numbers they are taken against time, at a cost that hardly grows with them; `against_time` says so or otherwise. Numbers are doubles: tensors of float32 are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from numpy.typing import ArrayLike

from ._errors import InputError
from ._model import Model
from ._motion import Motion

try:
    import torch
except ImportError as error:
    raise ImportError("catena.torch needs PyTorch: pip install torch") from error

__all__ = ["rollout"]


class _Run(torch.autograd.Function):
    @staticmethod
    def forward(ctx, numbers, motion):
        given, ctx.motion = numbers.detach().cpu().numpy(), motion
        parts = motion.motion(given) if motion.against_time else motion(given)
        q, v, *slopes = (torch.from_numpy(part.copy()) for part in parts)
        ctx.save_for_backward(*(slopes or [numbers]))
        return q, v

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx, by_q, by_v):
        if ctx.motion.against_time:
            given = [part.detach().cpu().numpy() for part in (*ctx.saved_tensors, by_q, by_v)]
            return torch.from_numpy(ctx.motion.gradient(*given)), None
        dq, dv = ctx.saved_tensors
        return torch.einsum("tnk,tn->k", dq, by_q) + torch.einsum("tnk,tn->k", dv, by_v), None


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
    motion = Motion(model, keys, duration=duration, step=step, stages=stages, q=q, v=v, against_time=against_time)

    def run(numbers):
        if numbers.dtype != torch.float64:
            raise InputError("give numbers as torch.float64: single precision would lose the derivatives")
        return _Run.apply(numbers, motion)

    run.values = motion.values
    return run
