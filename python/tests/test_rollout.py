"""Many runs: the same bits as single ones whatever the threads, and the lock of Python released."""

import threading
import time

import catena
import numpy as np
import pytest


def test_runs_are_those_of_sims_whatever_the_number_of_threads(double_pendulum):
    rng = np.random.default_rng(3)
    q0, v0 = rng.uniform(-1, 1, (2, 6, 2))
    one, three = (catena.rollout(double_pendulum, q0, v0, duration=1.0, rate=10, threads=threads) for threads in (1, 3))
    assert one.q.shape == (6, 11, 2) and one.failures == {}
    assert np.array_equal(one.q, three.q) and np.array_equal(one.v, three.v)
    for run in range(6):
        sim = catena.Sim(double_pendulum)
        sim.q, sim.v = q0[run], v0[run]
        single = sim.run(1.0, rate=10)
        assert np.array_equal(single.q, one.q[run]) and np.array_equal(single.t, one.t)
    assert one.q["elbow"].shape == (6, 11)


def test_other_threads_go_on_while_runs_are_made(double_pendulum):
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    began = time.perf_counter()
    while time.perf_counter() - began < 0.3:
        catena.rollout(double_pendulum, np.full((400, 2), 1.0), duration=2.0, threads=1)
    during = counted[0] - before
    done.set()
    thread.join()
    # Some three hundred where the lock is free; a lock that is held lets it count once a call at most.
    assert during > 20


def test_runs_that_fail_are_told_and_the_others_go_on(arm):
    q0 = np.zeros((3, 7))
    q0[1, 1] = 1e12
    out = catena.rollout(arm, q0, duration=0.1)
    assert list(out.failures) == [1] and "joint2" in out.failures[1]
    assert np.isnan(out.q[1]).all() and np.isfinite(out.q[[0, 2]]).all()


@pytest.mark.parametrize(
    ("q0", "v0", "message"),
    [
        (np.zeros((2, 3)), None, "q0: rows of 3 numbers where 2 are wanted"),
        (np.zeros(2), None, "an array \\(runs, n\\) is wanted"),
        (np.zeros((2, 2)), np.zeros((3, 2)), "q0 has 2 rows and v0 3"),
        (np.full((2, 2), np.nan), None, 'q0: the number for "shoulder" is NaN'),
        ([["a", "b"]], None, "could not convert"),
    ],
)
def test_wrong_arrays_are_named(double_pendulum, q0, v0, message):
    with pytest.raises(catena.InputError, match=message):
        catena.rollout(double_pendulum, q0, v0, duration=0.1)


def test_controls_targets_and_feedback_are_those_of_steps(robots):
    model = catena.load(robots / "arm7_held.toml")
    q0, _ = model.start()
    rng = np.random.default_rng(5)
    controls, targets = rng.uniform(-2, 2, (2, 4, 7)), rng.uniform(-0.5, 0.5, (2, 4, 7))
    gain = 0.3 * np.eye(7, 14)
    out = catena.rollout(
        model, q0, duration=0.25, rate=16, controls=controls, targets=targets, feedback=gain, reference=np.full(14, 0.1), threads=2, energies=True
    )
    assert out.q.shape == (2, 5, 7) and out.energies.shape == (2, 5, 4)
    for run in range(2):
        sim = catena.Sim(model)
        for tick in range(4):
            sim.set_targets(targets[run, tick])
            sim.set_efforts(controls[run, tick] - gain @ (np.concatenate([sim.q, sim.v]) - 0.1))
            sim.step_to(0.0625 * (tick + 1))
            # numpy adds up the products of the gain in another order: roundings, which the stiff motors do not amplify.
            assert np.allclose(out.q[run, tick + 1], sim.q, rtol=0, atol=1e-11)
            assert np.allclose(out.v[run, tick + 1], sim.v, rtol=0, atol=1e-9)
        assert np.allclose(out.energies[run, -1].sum(), sim.energy()["total"], rtol=1e-12, atol=0)


def test_runs_have_numbers_warnings_and_contacts_of_their_own(robots):
    model = catena.load(robots / "quadruped_dropped.toml")
    q0, _ = model.start()
    out = catena.rollout(model, q0, duration=0.15, rate=100, params={"gravity.z": [-9.81, -1.62]}, contacts=True)
    # The feet of the first meet the floor after 0.101 s; on the moon they fall for longer.
    assert 0.1 < out.contacts[0]["t"][0] < 0.12 and len(out.contacts[1]["t"]) == 0
    assert out.contacts[0]["force"].shape == (len(out.contacts[0]["pair"]), 3)

    bars = catena.load(robots / "four_bar_2.toml")
    q0, _ = bars.start()
    starts = np.array([q0, q0])
    starts[1, 0] += 0.1
    with pytest.warns(RuntimeWarning, match="run 1: .*the start was adjusted"):
        out = catena.rollout(bars, starts, duration=0.01, warnings=True)
    assert list(out.warnings) == [1]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (dict(controls=np.zeros((2, 3, 1))), r"controls: an array of shape \(2, 3, 1\) where \(2, ticks, 2\)"),
        (dict(controls=np.zeros((3, 2)), targets=np.zeros((2, 0))), "targets"),
        (dict(feedback=np.zeros((2, 4))), "the period"),
        (dict(feedback=np.zeros((2, 3)), period=0.1), "feedback, a row a velocity: 6 numbers where 8"),
        (dict(params={"gravity.z": [1.0]}), "params, a number a run: 1 numbers where 2"),
        (dict(controls=np.full((3, 2), np.nan)), "is NaN"),
    ],
)
def test_wrong_inputs_are_named(double_pendulum, given, message):
    with pytest.raises(catena.InputError, match=message):
        catena.rollout(double_pendulum, np.zeros((2, 2)), duration=0.1, **given)
