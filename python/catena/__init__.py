"""catena: rigid multibody dynamics without drift.

>>> import catena
>>> model = catena.load("arm.urdf")                      # or a scene file
>>> sim = catena.Sim(model, tolerance=1e-6)              # or stages=5, step=0.01
>>> sim.q["joint1"] = 0.5                                # q, v: numpy arrays, by name or index
>>> result = sim.run(2.0, rate=60)                       # result.t, .q, .v, .energy, .poses["link1"]
>>> result.save("run.mcap"); result.report("run.html")

Lengths in m, angles in rad, times in s, masses in kg; quaternions w, x, y, z from body to world.
"""

from ._catena import __version__
from ._errors import CatenaError, InputError, RunError
from ._fit import Fit, fit
from ._model import Gradient, Linear, Model, Multipliers, Samples, Sensitivity, load
from ._named import NamedArray
from ._result import Result
from ._rollout import Rollouts, rollout
from ._sensors import Noise, Sensed
from ._sim import Sim, State
from ._sweep import Swept, sweep

__all__ = [
    "CatenaError",
    "Fit",
    "Gradient",
    "InputError",
    "Linear",
    "Model",
    "Multipliers",
    "NamedArray",
    "Noise",
    "Result",
    "Rollouts",
    "RunError",
    "Samples",
    "Sensed",
    "Sensitivity",
    "Sim",
    "State",
    "Swept",
    "__version__",
    "fit",
    "load",
    "rollout",
    "sweep",
]
