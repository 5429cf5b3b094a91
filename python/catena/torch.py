"""Runs as functions of PyTorch: `motion = catena.torch.rollout(model, keys, duration=2, step=0.01)`, then `q, v = motion(numbers)`.

The derivatives are exact, through events; `backward` knows them. Numbers are doubles: tensors of float32 are refused.
"""

from ._errors import InputError
from ._motion import Motion

try:
    import torch
except ImportError as error:
    raise ImportError("catena.torch needs PyTorch: pip install torch") from error

__all__ = ["rollout"]


class _Run(torch.autograd.Function):
    @staticmethod
    def forward(ctx, numbers, motion):
        q, v, dq, dv = (torch.from_numpy(part.copy()) for part in motion(numbers.detach().cpu().numpy()))
        ctx.save_for_backward(dq, dv)
        return q, v

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx, by_q, by_v):
        dq, dv = ctx.saved_tensors
        return torch.einsum("tnk,tn->k", dq, by_q) + torch.einsum("tnk,tn->k", dv, by_v), None


def rollout(model, keys, *, duration, step, stages=5, q=None, v=None):
    """The function from the numbers of `keys` to q and v (samples, n), a step apart; `.values` are the numbers of the model."""
    motion = Motion(model, keys, duration=duration, step=step, stages=stages, q=q, v=v)

    def run(numbers):
        if numbers.dtype != torch.float64:
            raise InputError("give numbers as torch.float64: single precision would lose the derivatives")
        return _Run.apply(numbers, motion)

    run.values = motion.values
    return run
