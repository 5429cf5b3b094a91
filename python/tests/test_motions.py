"""Scenes whose joints are moved in time, by a [[motion]] or by the winch of a rope, in all that a simulation and environments do."""

import copy
import pickle

import catena
import numpy as np
import pytest

KAPITZA = """<robot name="kapitza"><link name="base"/>
<link name="pivot"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="rod"><inertial><origin xyz="0 0 0.3"/><mass value="0.2"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shaker" type="prismatic"><parent link="base"/><child link="pivot"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1e6" velocity="1e6"/></joint>
<joint name="hinge" type="continuous"><parent link="pivot"/><child link="rod"/><axis xyz="0 1 0"/><dynamics damping="0.002"/></joint></robot>"""

SHAKEN = """[[robot]]
urdf = "kapitza.urdf"
positions = { hinge = 0.3 }
[[motion]]
joint = "shaker"
position = { formula = "a*cos(w*t) + b*t", a = 0.02, b = 0.01, w = 50 }
"""

WINCH = """[[body]]
name = "ball"
shape = { type = "sphere", radius = 0.05 }
mass = 2
pose = { position = [0.6, 0, 0] }
[[rope]]
name = "rope"
points = [{ link = "world", position = [0, 0, 1] }, { link = "ball", position = [0, 0, 0] }]
length = { formula = "l - v*t", l = 1.16619037896906, v = 0.1 }
[contact]
pairs = "none"
"""

REFUSED = r"starts where its \[\[motion\]\] puts it; leave out the position and the velocity that are given"


def place(t):
    """Where the shaker is, and its velocity."""
    return 0.02 * np.cos(50 * t) + 0.01 * t, -np.sin(50 * t) + 0.01


@pytest.fixture(params=["shaken", "winch"])
def model(request, tmp_path):
    (tmp_path / "kapitza.urdf").write_text(KAPITZA)
    file = tmp_path / f"{request.param}.toml"
    file.write_text(SHAKEN if request.param == "shaken" else WINCH)
    return catena.load(file)


@pytest.fixture
def shaken(tmp_path):
    (tmp_path / "kapitza.urdf").write_text(KAPITZA)
    (tmp_path / "shaken.toml").write_text(SHAKEN)
    return catena.load(tmp_path / "shaken.toml")


def test_moved_joints_run_and_go_on(model):
    whole = catena.Sim(model, tolerance=1e-9).run(0.6)
    sim = catena.Sim(model, tolerance=1e-9)
    sim.run(0.25)
    sim.step(0.1)
    end = sim.run(0.25)
    # Both keep to the tolerance.
    assert abs(end.t[-1] - 0.6) < 1e-12 and np.abs(end.q[-1] - whole.q[-1]).max() < 1e-7
    moved = model.joint_names.index("shaker" if "shaker" in model.joint_names else "rope/length")
    wanted = place(0.6)[0] if "shaker" in model.joint_names else 1.16619037896906 - 0.06
    assert abs(sim.q[model.joint_names[moved]] - wanted) < 1e-12
    assert sim.sense() is not None and sim.energy()["total"] == sim.energy()["total"]


def test_states_of_moved_joints_are_values(model):
    sim = catena.Sim(model, tolerance=1e-8)
    sim.step(0.13)
    state, other, fresh = sim.state, copy.deepcopy(sim), catena.Sim(model, tolerance=1e-8)
    read = pickle.loads(pickle.dumps(sim))
    sim.step(0.1)
    fresh.state = state
    for goes in (other, fresh):
        goes.step(0.1)
        assert np.array_equal(goes.q, sim.q) and np.array_equal(goes.v, sim.v)
    read.step(0.1)
    # It begins anew from its numbers, and keeps to the tolerance.
    assert abs(read.time - 0.23) < 1e-12 and np.abs(read.q - sim.q).max() < 1e-6


def test_a_moved_joint_starts_where_its_motion_is_and_nowhere_else(shaken):
    sim = catena.Sim(shaken)
    sim.q["shaker"] = sim.q["shaker"]
    sim.q["hinge"] = 0.4
    sim.step(0.05)
    assert abs(sim.q["shaker"] - place(0.05)[0]) < 1e-14 and abs(sim.v["shaker"] - place(0.05)[1]) < 1e-12
    for numbers, name, by in ((sim.q, "shaker", 1e-6), (sim.v, "shaker", 1e-3)):
        numbers[name] += by
        with pytest.raises(catena.InputError, match=REFUSED):
            sim.step(0.01)
        numbers[name] -= by
    sim.v["hinge"] = 1.0
    sim.step(0.01)
    for part in ("q", "v"):
        sim = catena.Sim(shaken)
        getattr(sim, part)["shaker"] = 0.5
        with pytest.raises(catena.InputError, match=REFUSED):
            sim.run(0.1)


def test_a_start_from_a_log_puts_moved_joints_where_they_are_at_time_zero(model, tmp_path):
    sim = catena.Sim(model)
    result = sim.run(0.5, log=tmp_path / "run.mcap")
    other = catena.Sim(model)
    other.start_from(tmp_path / "run.mcap", 0.3)
    free = model.joint_names[1 if "shaker" in model.joint_names else 0]
    row = int(np.argmin(np.abs(result.t - 0.3)))
    assert np.allclose(other.q[free], result.q[free][row], atol=1e-9)
    other.step(0.1)
    other.reset()
    other.step(0.1)


def test_rollouts_have_moved_joints(shaken):
    runs = catena.rollout(shaken, [shaken.start()[0]], [shaken.start()[1]], duration=0.2, rate=10)
    sim = catena.Sim(shaken, estimate=False)
    sim.run(0.2)
    assert not runs.failures and np.abs(runs.q[0, -1] - sim.q).max() < 1e-5


def test_environments_have_moved_joints(shaken):
    pytest.importorskip("gymnasium")
    from catena.gym import Env, Task, VectorEnv

    def reward(q, v, action):
        return -q["hinge"] ** 2

    task = Task(shaken, period=0.02, joints=["hinge"], high=0.1, reward=reward, steps=20)
    env, envs = Env(task), VectorEnv(task, 2)
    seen, _ = env.reset(seed=1)
    many, _ = envs.reset(seed=1)
    assert np.array_equal(many[0], seen)
    for _ in range(20):
        seen, *_ = env.step([0.05])
        many, *_, infos = envs.step(np.full((2, 1), 0.05))
    assert "failure" not in infos and np.array_equal(infos["final_obs"][1], seen)
    assert abs(seen[0] - place(0.4)[0]) < 1e-12
    again, _ = env.reset()
    assert np.array_equal(again, many[0])
