"""Every wrong input is an exception that names it."""

import os

import catena
import numpy as np
import pytest


def test_unknown_names(arm):
    sim = catena.Sim(arm)
    for use in (lambda: sim.q["elbow"], lambda: sim.q.__setitem__("elbow", 1.0)):
        with pytest.raises(catena.InputError, match="there is no joint 'elbow'; the joints that move are 'joint1'"):
            use()
    result = sim.run(0.1)
    with pytest.raises(catena.InputError, match='there is no link "hand"'):
        sim.pose("hand")
    with pytest.raises(catena.InputError, match='there is no link "hand"'):
        result.poses["hand"]
    with pytest.raises(catena.InputError, match='there is no joint "elbow"'):
        result.reactions["elbow"]


def test_wrong_lengths_and_numbers(arm):
    sim = catena.Sim(arm)
    with pytest.raises(catena.InputError, match="q: 3 numbers where 7 are wanted"):
        sim.q = [0, 0, 0]
    with pytest.raises(catena.InputError, match="has one number"):
        sim.q["joint1"] = [1, 2]
    with pytest.raises(catena.InputError, match="q: 6 numbers where 7 are wanted"):
        arm.mass_matrix(np.zeros(6))
    with pytest.raises(catena.InputError, match="efforts: could not convert"):
        sim.set_efforts("push")
    with pytest.raises(catena.InputError, match="3 efforts for 7 degrees of freedom: give one for each, in the order of joint1, joint2, .*joint7$"):
        sim.set_efforts(np.zeros(3))
    with pytest.raises(catena.InputError, match='an effort on joint "joint2" is not finite'):
        sim.set_efforts([0, float("nan"), 0, 0, 0, 0, 0])
    # Efforts that are refused change nothing.
    sim.step(0.01)
    sim.q["joint3"] = float("nan")
    with pytest.raises(catena.InputError, match='q: the number for "joint3" is NaN'):
        sim.run(0.1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tolerance": -1.0}, "tolerance is -1: must be greater than zero"),
        ({"tolerance": float("nan")}, "tolerance is NaN"),
        ({"stages": 0, "step": 0.1}, "stages"),
        ({"keep": "nothing"}, "there is no rule"),
    ],
)
def test_wrong_options_of_runs(arm, options, message):
    with pytest.raises(catena.InputError, match=message):
        catena.Sim(arm, **options).run(0.1)


def test_numbers_that_no_run_can_have_are_refused_before_one_is_asked_for(arm):
    for options in ({"tolerance": -1.0}, {"tolerance": float("inf")}, {"stages": 3, "step": 0.0}):
        with pytest.raises(catena.InputError, match="must be greater than zero"):
            catena.Sim(arm, **options)


def test_what_is_no_model_or_no_number_is_named(arm):
    with pytest.raises(catena.InputError, match="model is 'arm.urdf': give a catena.Model"):
        catena.Sim("arm.urdf")
    for options, message in (
        ({"tolerance": "fine"}, "tolerance is 'fine': must be a number"),
        ({"stages": "3", "step": 0.1}, "stages is '3': must be a number"),
        ({"stages": 2.5, "step": 0.1}, "stages is 2.5: must be a whole number, 2 to 16 of the scheme, or 1"),
    ):
        with pytest.raises(catena.InputError, match=message):
            catena.Sim(arm, **options)
    assert catena.Sim(arm, stages=3.0, step=0.01).run(0.1).t[-1] == pytest.approx(0.1)
    # Nothing reads it: a controller is given to set_controller.
    with pytest.raises(AttributeError, match="controller"):
        catena.Sim(arm).controller = print


def test_all_that_runs_refuses_the_same_stages_and_tolerances(arm):
    q, v = arm.start()
    ways = (
        lambda **how: catena.Sim(arm, **how),
        lambda **how: catena.rollout(arm, q, v, 0.1, **how),
        lambda **how: arm.sensitivity("start.v", duration=0.1, **how),
        lambda **how: arm.multipliers(0.1, **how),
        lambda **how: arm.gradient("start.v", [0.1], lambda run: (0.0, None, None), **how),
    )
    for way in ways:
        for how, message in (
            ({"stages": 2.5, "step": 0.1}, "stages is 2.5: must be a whole number"),
            ({"stages": 3, "step": -0.1}, "step is -0.1: must be greater than zero"),
            ({"tolerance": "fine"}, "tolerance is 'fine': must be a number"),
            ({"tolerance": 1e-6, "stages": 3, "step": 0.01}, "give a tolerance, or stages and step"),
            ({"stages": 3}, "give a tolerance, or stages and step"),
        ):
            with pytest.raises(catena.InputError, match=message):
                way(**how)
    with pytest.raises(catena.InputError, match="stages is 2.5: must be a whole number"):
        catena.fit(arm, [0.0, 0.1], [q, q], ["start.v"], stages=2.5)


def test_wrong_options_together(arm):
    with pytest.raises(catena.InputError, match="a tolerance, or stages and step"):
        catena.Sim(arm, tolerance=1e-6, step=0.1)
    with pytest.raises(catena.InputError, match="duration is 0"):
        catena.Sim(arm).run(0.0)
    with pytest.raises(catena.InputError, match="rate is 0"):
        catena.Sim(arm).run(0.1, rate=0)
    with pytest.raises(catena.InputError, match="control_rate"):
        catena.Sim(arm).run(0.1, controller=print)
    with pytest.raises(catena.InputError, match="cannot step to"):
        catena.Sim(arm).step(-0.1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"base": "flying"}, "give 'fixed' or 'floating'"),
        ({"gravity": (0, 0)}, "gravity: 3 numbers are wanted"),
        ({"gravity": (0, 0, float("inf"))}, "gravity is inf"),
        ({"without": "weight"}, '"weight" cannot be left out'),
        ({"contact": "some"}, '"some" is not one of: none, environment, all'),
        ({"packages": {"arm": "/nowhere"}}, 'there is no folder "/nowhere"'),
        ({"params": {"joint1.mass": 1.0}}, "joint1.mass"),
        ({"params": {"flange.mass": "much"}}, "params: could not convert"),
    ],
)
def test_wrong_options_of_models(robots, options, message):
    with pytest.raises(catena.InputError, match=message):
        catena.load(robots / "arm7.urdf", **options)


def test_a_folder_that_is_not_there_and_a_full_disk(arm, tmp_path):
    result = catena.Sim(arm).run(0.1)
    for name in ("run.mcap", "run.npz", "run.html"):
        with pytest.raises(catena.CatenaError, match="there is no folder|cannot create"):
            (result.report if name.endswith("html") else result.save)(tmp_path / "missing" / name)
    if os.path.exists("/dev/full"):
        with pytest.raises(catena.RunError, match="/dev/full"):
            catena.Sim(arm).run(5.0, rate=1000, log="/dev/full")


def test_what_is_no_measurement_is_named_before_a_run_is_made(robots):
    pendulum = catena.load(robots / "friction_pendulum.toml")
    t, key = np.linspace(0.0, 1.0, 6), ["gravity.z"]
    torn = np.zeros((6, 1))
    torn[4] = np.nan
    for times, data, options, message in (
        (t, torn, {}, "data is nan at t = 0.8 s, column 0"),
        (t, np.zeros(7), {}, r"data has the shape \(7,\) for 6 times; give one row"),
        (t, np.zeros((6, 2)), {}, "data has 2 columns for 1 joints"),
        ([], [], {}, "t: give at least two"),
        (t * np.nan, np.zeros(6), {}, "t: give at least two"),
        (t, np.zeros(6), {"joints": ["elbow"]}, "there is no joint 'elbow'; the joints that move are"),
    ):
        with pytest.raises(catena.InputError, match=message):
            catena.fit(pendulum, times, data, key, **options)
