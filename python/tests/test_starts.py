"""Starts and accuracy as the command line has them: holding motors, keyframes, logs, runs without an estimate."""

import pickle

import catena
import numpy as np
import pytest

KEYFRAMES = """<mujoco>
  <worldbody>
    <body name="rod"><joint name="hinge" type="hinge" axis="0 1 0"/><geom type="capsule" size="0.05" fromto="0 0 0 0 0 -1"/></body>
  </worldbody>
  <keyframe><key name="up" qpos="0.5"/></keyframe>
</mujoco>"""


def test_motors_hold_an_arm_where_it_starts(robots):
    limp, held = (catena.load(robots / "arm7.urdf", hold=hold) for hold in (None, True))
    assert not limp.motor_names and held.motor_names == held.joint_names
    # Motors of 10 Hz give way to the weight by g / (2π 10 Hz)² = 2.5 mm at the tip, a few hundredths of a radian at most; a limp arm falls.
    fallen, stood = (np.abs(catena.Sim(model, tolerance=1e-4).run(0.5).q[-1]).max() for model in (limp, held))
    assert stood < 0.05 < fallen
    assert pickle.loads(pickle.dumps(held)).motor_names == held.motor_names
    stiff = catena.load(robots / "arm7.urdf", hold={"kp": 1e5, "kd": 1e3})
    assert np.abs(catena.Sim(stiff, tolerance=1e-4).run(0.5).q[-1]).max() < 1e-2
    for hold, words in [({"ki": 1}, "no gain 'ki'"), ("firmly", "hold is 'firmly'"), ({"kp": -1.0}, "kp")]:
        with pytest.raises(catena.InputError, match=words):
            catena.load(robots / "arm7.urdf", hold=hold)


def test_a_keyframe_is_the_start(tmp_path):
    (tmp_path / "rod.xml").write_text(KEYFRAMES)
    assert catena.Sim(catena.load(tmp_path / "rod.xml", keyframe="up")).q["hinge"] == 0.5
    with pytest.raises(catena.InputError, match="up"):
        catena.load(tmp_path / "rod.xml", keyframe="down")


def test_a_run_goes_on_where_a_log_was(double_pendulum, tmp_path):
    first = catena.Sim(double_pendulum)
    first.q[:] = [0.4, -0.2]
    result = first.run(1.0, rate=100, log=tmp_path / "first.mcap")
    sim = catena.Sim(double_pendulum)
    for time, sample in [(0.25, 25), (None, -1)]:
        sim.start_from(tmp_path / "first.mcap", time)
        assert sim.time == 0 and np.array_equal(sim.q, result.q[sample]) and np.array_equal(sim.v, result.v[sample])
    with pytest.raises(catena.InputError, match="is no number"):
        sim.start_from(tmp_path / "first.mcap", float("nan"))
    with pytest.raises(catena.InputError, match="missing.mcap"):
        sim.start_from(tmp_path / "missing.mcap")


def test_without_an_estimate_a_run_takes_fewer_steps_and_says_so(double_pendulum):
    with_it, without = (catena.Sim(double_pendulum, estimate=estimate) for estimate in (True, False))
    for sim in (with_it, without):
        sim.q[:] = [0.4, -0.2]
    told, untold = with_it.run(1.0), without.run(1.0)
    assert told.summary["accuracy"] is not None and untold.summary["accuracy"]["estimated"] is None
    # Both are within some times the tolerance of 1e-6 m of each other; the rods have lengths of about a metre.
    assert np.abs(told.q[-1] - untold.q[-1]).max() < 1e-4
    rolled = catena.rollout(double_pendulum, np.array([[0.4, -0.2]]), duration=1.0, estimate=False)
    assert np.array_equal(rolled.q[0, -1], untold.q[-1])
