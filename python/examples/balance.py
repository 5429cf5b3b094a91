"""Learns to balance a cart and pole upright: the cross-entropy method on a linear law, with 64 environments at once."""

from pathlib import Path

import catena
import numpy as np
from catena.gym import Task, VectorEnv

ROBOT = Path(__file__).parents[2] / "robots/parts/cart_pole.urdf"


def task():
    """The pole is upright at the angle π of its hinge; an episode ends where it leans by 0.3 rad, or the cart is 2 m off."""
    model = catena.load(ROBOT, params={"cart.mass": 1.0})

    def start(rng):
        return np.array([0.0, np.pi]) + rng.uniform(-0.05, 0.05, 2), rng.uniform(-0.05, 0.05, 2)

    def observe(q, v):
        return np.stack([q["slide"], q["hinge"] - np.pi, v["slide"], v["hinge"]], axis=-1)

    def terminated(q, v):
        return (abs(q["hinge"] - np.pi) > 0.3) | (abs(q["slide"]) > 2.0)

    def reward(q, v, action):
        return 1.0 - abs(q["slide"]) / 2.0

    return Task(model, 0.02, ["slide"], 20.0, reward, start=start, observe=observe, terminated=terminated)


def learn(generations=12, envs=64, best=8, seed=0):
    """The gains (4,) of the best law, and how many steps it balances of 500."""
    rng, env = np.random.default_rng(seed), VectorEnv(task(), envs)
    mean, spread = np.zeros(4), np.full(4, 30.0)
    for generation in range(generations):
        gains = mean + spread * rng.standard_normal((envs, 4))
        seen, _ = env.reset(seed=generation)
        returns, alive = np.zeros(envs), np.ones(envs, dtype=bool)
        while alive.any():
            seen, rewards, terminated, truncated, _ = env.step((gains * seen).sum(axis=1, keepdims=True))
            returns += rewards * alive
            alive &= ~(terminated | truncated)
        elite = gains[np.argsort(returns)[-best:]]
        mean, spread = elite.mean(axis=0), elite.std(axis=0) + 0.5
        print(f"generation {generation}: best return {returns.max():.1f}, median {np.median(returns):.1f}")
    return mean


if __name__ == "__main__":
    print("gains of slide, hinge and their rates:", learn().round(1))
