"""How a run goes: to a tolerance, or in fixed steps of some stages."""

from __future__ import annotations

from numbers import Real

from ._errors import InputError


def how(tolerance, stages, step):
    """The tolerance [m], and the stages with their step [s]; None for that which is not given.

    Raises
    ------
    InputError : numbers that no run can go by, and a tolerance beside a step
    """
    if (stages is None) != (step is None) or (tolerance is not None and step is not None):
        raise InputError("give a tolerance, or stages and step")
    for name, value in (("tolerance", tolerance), ("stages", stages), ("step", step)):
        if value is not None and not isinstance(value, Real):
            raise InputError(f"{name} is {value!r}: must be a number")
        if value is not None and not 0 < value < float("inf"):
            said = "NaN" if value != value else f"{value:g}"
            raise InputError(f"{name} is {said}: must be greater than zero, and finite")
    if stages is not None and stages != int(stages):
        raise InputError(f"stages is {stages:g}: must be a whole number, 2 to 16 of the scheme, or 1 for steps over events")
    return None if tolerance is None else float(tolerance), None if stages is None else (int(stages), float(step))
