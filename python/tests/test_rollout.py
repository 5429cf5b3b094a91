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
