#!/usr/bin/env python3
"""Prices of the package for Python beside their goals: environments, states, the wheel.

    pip install gymnasium and the wheel; then: python benches/python/goals.py [WHEEL]

Each price is the least of five series, in CPU time of this process (user and system), so that other work on the machine counts little.
"""

import resource
import sys
from pathlib import Path

import catena
import numpy as np
from catena.gym import Env, Task, VectorEnv

ROBOTS = Path(__file__).parents[2] / "robots"

#: An environment holds an action for so long [s].
PERIOD = 0.02


def cpu():
    """CPU time of this process [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def price(work, count):
    """CPU time of one call [s]: the least of five series of so many calls."""
    series = []
    for _ in range(5):
        before = cpu()
        for _ in range(count):
            work()
        series.append((cpu() - before) / count)
    return min(series)


def nothing(q, v, action):
    """No reward, for one environment or many."""
    return np.zeros(q.shape[:-1])


def arm_task():
    """An arm of seven joints that small efforts move, from starts near zero."""
    model = catena.load(ROBOTS / "arm7.urdf")
    start = lambda rng: (rng.uniform(-0.1, 0.1, model.nq), np.zeros(model.nv))
    return Task(model, PERIOD, list(model.joint_names), 1.0, nothing, start=start)


def quadruped_task():
    """A quadruped whose motors hold it, and that stands on a floor."""
    model = catena.load(ROBOTS / "quadruped_dropped.toml")
    sim = catena.Sim(model)
    sim.run(2.0)
    q, v = np.array(sim.q), np.array(sim.v)
    joints = [name for name in model.joint_names if name.endswith(("hip", "knee"))]
    return Task(model, PERIOD, joints, 0.1, nothing, start=lambda rng: (q, v))


def reset_and_step(task):
    """The price of an episode of one step [s]."""
    env = Env(task)
    env.reset(seed=0)
    action = np.zeros(len(task.joints))

    def work():
        env.reset()
        env.step(action)

    return price(work, 200)


def many(task, count):
    """The price of a step of one of many environments on one core [s]."""
    envs = VectorEnv(task, count, threads=1)
    envs.reset(seed=0)
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1, 1, (count, len(task.joints)))
    return price(lambda: envs.step(actions), 50) / count


def driven(count):
    """The price of a step of one of many arms on one core whose motors get other targets at random in each step [s]."""
    model = catena.load(ROBOTS / "arm7_held.toml")
    envs = VectorEnv(Task(model, PERIOD, list(model.motor_names), 0.3, nothing, action="targets"), count, threads=1)
    envs.reset(seed=0)
    rng = np.random.default_rng(0)
    return price(lambda: envs.step(rng.uniform(-0.3, 0.3, (count, len(model.motor_names)))), 10) / count


def state_copy(task):
    """The price of a copy of the state of a simulation [s]."""
    sim = catena.Sim(task.model)
    sim.step(PERIOD)
    return price(lambda: sim.state, 500)


def main():
    arm, quadruped = arm_task(), quadruped_task()
    rows = [
        ("arm: reset and step of 20 ms", 1e3 * reset_and_step(arm), 0.3, "ms"),
        ("quadruped on a floor: reset and step of 20 ms", 1e3 * reset_and_step(quadruped), 0.5, "ms"),
        ("64 arms: a step of 20 ms of one of them", 1e6 * many(arm, 64), 30.0, "µs"),
        ("64 arms whose motors get random targets: the same", 1e6 * driven(64), None, "µs"),
        ("arm: copy of the state", 1e6 * state_copy(arm), 20.0, "µs"),
        ("quadruped: copy of the state", 1e6 * state_copy(quadruped), 20.0, "µs"),
    ]
    if len(sys.argv) > 1:
        rows.append(("wheel", Path(sys.argv[1]).stat().st_size / 1e6, 12.0, "MB"))
    for name, value, goal, unit in rows:
        beside = "" if goal is None else f"goal {goal:4g} {unit:3} {'reached' if value <= goal else 'SHORT'}"
        print(f"{name:52} {value:8.3g} {unit:3} {beside}")


if __name__ == "__main__":
    main()
