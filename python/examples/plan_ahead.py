"""Model predictive control with copies of the state: a pendulum swings up with a weak motor."""

from pathlib import Path

import catena
import numpy as np

ROBOT = Path(__file__).parents[2] / "robots/pendulum.urdf"
AHEAD, TICK, PLANS = 12, 0.1, 60


def swing_up(ticks=60, seed=0):
    """The potential energy after each tick [J]."""
    rng, model = np.random.default_rng(seed), catena.load(ROBOT)
    sim = catena.Sim(model, tolerance=1e-5)
    strongest = 0.4 * max(abs(model.gravity_efforts([angle])[0]) for angle in (0.0, np.pi / 2))
    plan, seen = np.zeros(AHEAD), []
    for _ in range(ticks):
        here = sim.state
        plans = np.clip(plan + strongest * rng.standard_normal((PLANS, AHEAD)), -strongest, strongest)
        plans[0] = plan
        tried = catena.rollout(model, here.q, here.v[None].repeat(PLANS, 0), rate=1 / TICK, period=TICK, controls=plans[:, :, None], energies=True, tolerance=1e-5)
        plan = plans[tried.energies[:, 1:, 1].sum(axis=1).argmax()]
        sim.set_efforts(plan[:1])
        sim.step(TICK)
        seen.append(sim.energy()["potential"])
        plan = np.append(plan[1:], 0.0)
    return np.array(seen)


if __name__ == "__main__":
    print(swing_up().round(2))
