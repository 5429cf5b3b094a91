"""Environments of gymnasium: its own checker, seeds, autoreset, and many that are single ones bit for bit."""

import importlib.util
import time
from pathlib import Path

import catena
import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from catena.gym import Env, Task, VectorEnv  # noqa: E402


@pytest.fixture(scope="module")
def balance():
    """The example that learns to balance."""
    path = Path(__file__).parents[1] / "examples/balance.py"
    spec = importlib.util.spec_from_file_location("balance", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_gymnasium_accepts_the_environment(balance):
    from gymnasium.utils.env_checker import check_env

    check_env(Env(balance.task()), skip_render_check=True)


def test_many_environments_are_single_ones_bit_for_bit_and_begin_again_by_themselves(balance):
    task = balance.task()
    for threads in (1, 2):
        envs, singles = VectorEnv(task, 3, threads=threads), [Env(task) for _ in range(3)]
        seen, _ = envs.reset(seed=7)
        assert np.array_equal(seen, [env.reset(seed=7 + index)[0] for index, env in enumerate(singles)])
        rng, ended = np.random.default_rng(1), 0
        for _ in range(120):
            actions = rng.uniform(-20, 20, (3, 1))
            seen, rewards, terminated, truncated, infos = envs.step(actions)
            for index, env in enumerate(singles):
                own, reward, over, late, _ = env.step(actions[index])
                assert (rewards[index], terminated[index], truncated[index]) == (reward, over, late)
                if over or late:
                    ended += 1
                    assert np.array_equal(infos["final_obs"][index], own) and infos["_final_obs"][index]
                    own, _ = env.reset()
                assert np.array_equal(seen[index], own)
        assert ended >= 3
    assert envs.observation_space.contains(seen.astype(np.float64)) and envs.action_space.shape == (3, 1)


def test_motors_that_hold_a_start_are_those_of_the_episode_in_one_environment_and_in_many(robots):
    # Their gains follow from the inertias where an episode begins: the second episode, and all but one of many, had the motors of the first.
    model = catena.load(robots / "double_pendulum.urdf", hold=True)
    of_file, rest = model.start()

    def start(rng):
        q = of_file.copy()
        q[:] = rng.uniform(-0.5, 0.5, len(q))
        return q, rest.copy()

    task = Task(model, 0.02, model.motor_names, 0.5, lambda q, v, action: 0.0 * q[..., 0], action="targets", start=start, tolerance=1e-6)
    many, single = VectorEnv(task, 3), Env(task)
    seen, _ = many.reset(seed=1)
    actions = np.random.default_rng(0).uniform(-0.5, 0.5, (5, 3, 2))
    for step in actions:
        seen = many.step(step)[0]
    for index in range(3):
        begun, _ = single.reset(seed=1 + index)
        sim = catena.Sim(model, tolerance=1e-6)
        sim.q, sim.v = begun[:2], begun[2:]
        for step in actions:
            own = single.step(step[index])[0]
            sim.set_targets(step[index])
            sim.step(0.02)
        assert np.array_equal(seen[index], own)
        assert np.array_equal(own, np.concatenate([sim.q, sim.v]))


def test_episodes_are_truncated_after_their_steps(balance):
    env = Env(Task(balance.task().model, 0.01, ["slide"], 1.0, lambda q, v, action: 0.0, steps=3))
    env.reset(seed=0)
    assert [env.step([0.0])[3] for _ in range(3)] == [False, False, True]
    env.reset()
    assert not env.step([0.0])[3]


def test_actions_may_be_targets_of_motors(robots):
    model = catena.load(robots / "arm7_held.toml")
    task = Task(model, 0.05, model.motor_names, 1.0, lambda q, v, action: -np.abs(q - action).sum(axis=-1), action="targets")
    envs = VectorEnv(task, 2)
    envs.reset(seed=0)
    targets = np.array([[0.2] * 7, [-0.3] * 7])
    for _ in range(30):
        seen, rewards, *_ = envs.step(targets)
    # Stiff motors: off by what gravity takes, 0.05 rad at most here.
    assert np.abs(seen[:, :7] - targets).max() < 0.06


@pytest.mark.parametrize("action", [np.zeros(3), np.zeros((2, 7)), "up", None])
def test_actions_of_another_shape_are_refused_with_the_joints_that_they_move(robots, action):
    model = catena.load(robots / "arm7_held.toml")
    task = Task(model, 0.05, model.motor_names, 1.0, lambda q, v, action: 0.0 * q[..., 0], action="targets")
    for env in (Env(task), VectorEnv(task, 3)):
        env.reset(seed=0)
        with pytest.raises(catena.InputError, match="joint1, joint2"):
            env.step(action)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (dict(period=0.0), "period is 0.0"),
        (dict(joints=["pole"]), "cannot move joint 'pole'"),
        (dict(action="torque"), "action is 'torque'"),
        (dict(steps=0), "steps is 0"),
    ],
)
def test_tasks_that_cannot_be_are_named(balance, given, message):
    whole = dict(model=balance.task().model, period=0.01, joints=["slide"], high=1.0, reward=None)
    with pytest.raises(catena.InputError, match=message):
        Task(**{**whole, **given})


def test_a_law_learns_to_balance(balance, capsys):
    gains = balance.learn(generations=10, envs=32, best=6)
    env, total = Env(balance.task()), 0
    for episode in range(3):
        seen, _ = env.reset(seed=1000 + episode)
        for _ in range(500):
            seen, _, terminated, truncated, _ = env.step(np.array([gains @ seen]))
            total += not terminated
            if terminated or truncated:
                break
    assert total == 1500, "it balances to the end of every episode"


def pace():
    """Microseconds a step of 64 arms, for `python tests/test_gym.py`; machines differ, so that no test asserts it."""
    model = catena.load(Path(__file__).parents[2] / "robots/arm7.urdf")
    task = Task(model, 0.02, model.joint_names, 10.0, lambda q, v, action: -(q**2).sum(axis=-1), steps=100)
    envs = VectorEnv(task, 64)
    envs.reset(seed=0)
    actions = np.zeros((64, 7))
    began = time.process_time()
    for _ in range(200):
        envs.step(actions)
    steps = (time.process_time() - began) / (200 * 64)
    sim = catena.Sim(model)
    began = time.process_time()
    for _ in range(500):
        sim.reset()
        sim.step(0.02)
    resets = (time.process_time() - began) / 500
    began = time.process_time()
    for _ in range(500):
        sim.state
    states = (time.process_time() - began) / 500
    print(f"env-step {1e6 * steps:.1f} us, reset + step {1e6 * resets:.1f} us, state {1e6 * states:.1f} us")


if __name__ == "__main__":
    pace()
