"""A controller of Python: computed torque, a thousand times a second, moves an arm along a smooth path.

python python/examples/controller.py
"""

from pathlib import Path

import catena
import numpy as np

model = catena.load(Path(__file__).parents[2] / "robots" / "arm7.urdf")
goal = np.array([0.5, 0.6, -0.3, -1.0, 0.4, 0.5, 0.2])
duration, stiffness = 2.0, 400.0


def path(t):
    """Position, velocity and acceleration at rest at both ends: a polynomial of fifth degree."""
    s = min(t / duration, 1.0)
    return (
        goal * s**3 * (10 - 15 * s + 6 * s**2),
        goal * 30 * s**2 * (1 - s) ** 2 / duration,
        goal * 60 * s * (1 - s) * (1 - 2 * s) / duration**2,
    )


def computed_torque(t, q, v):
    """The efforts that give the acceleration of the path, and of a critically damped spring to it."""
    wanted, rate, acceleration = path(t)
    damping = 2 * np.sqrt(stiffness)
    return model.inverse_dynamics(q, v, acceleration + stiffness * (wanted - q) + damping * (rate - v))


sim = catena.Sim(model, tolerance=1e-6)
result = sim.run(duration, rate=100, controller=computed_torque, control_rate=1000)
apart = np.array([q - path(t)[0] for t, q in zip(result.t, result.q)])
print(f"largest distance from the path: {abs(apart).max():.1e} rad")
print(f"work of the controller: {result.summary['energy']['work']:.3f} J")
