"""States are values: simulations go on from them bit for bit, are copied and pickled; runs that are interrupted give what they have."""

import copy
import os
import pickle
import signal
import threading

import catena
import numpy as np
import pytest


@pytest.fixture(params=["arm7.urdf", "quadruped_dropped.toml", "four_bar_2.toml"])
def sim(request, robots):
    sim = catena.Sim(catena.load(robots / request.param), tolerance=1e-6)
    sim.step(0.12)
    return sim


def go_on(sim):
    for _ in range(3):
        sim.step(0.02)
    return np.array(sim.q), np.array(sim.v)


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(one, other))


def test_a_simulation_and_its_copies_go_on_from_a_state_bit_for_bit(sim):
    state, other = sim.state, sim.copy()
    assert state() is state and np.array_equal(state.q, sim.q) and state.time == sim.time == 0.12
    expected = go_on(sim)
    assert np.array_equal(state.q, other.q), "a state does not follow the simulation"
    for goes in (other, copy.deepcopy(other)):
        goes.state = state
        assert same(go_on(goes), expected)
    sim.state = state
    assert sim.time == 0.12 and same(go_on(sim), expected)


def test_a_reset_is_a_new_simulation_bit_for_bit(sim):
    sim.reset()
    assert same(go_on(sim), go_on(catena.Sim(sim.model, tolerance=1e-6)))


def test_efforts_and_targets_are_part_of_a_state(robots):
    sim = catena.Sim(catena.load(robots / "arm7_held.toml"), tolerance=1e-6)
    assert sim.model.motor_names == [f"joint{number}" for number in range(1, 8)]
    sim.set_efforts([0, 1, 0, 2, 0, 0, 0])
    sim.set_target("joint3", 0.4)
    sim.step(0.5)
    # It is on its way to 0.4 with a stiff motor.
    assert abs(sim.q["joint3"] - 0.4) < 0.05
    state = sim.state
    assert state.targets == {"joint3": 0.4} and list(state.efforts) == [0, 1, 0, 2, 0, 0, 0]
    expected = go_on(sim)
    sim.set_targets(np.zeros(7))
    sim.set_efforts(None)
    sim.step(0.5)
    assert abs(sim.q["joint3"]) < 0.05
    sim.state = state
    assert same(go_on(sim), expected)
    for wrong, message in [(dict(joint="elbow", target=0.0), "no motor"), (dict(joint="joint1", target=float("nan")), "is nan")]:
        with pytest.raises(catena.InputError, match=f"(?i){message}"):
            sim.set_target(**wrong)
    with pytest.raises(catena.InputError, match="3 numbers where 7"):
        sim.set_targets([1, 2, 3])


def test_models_simulations_states_and_results_are_pickled(sim, robots):
    model = pickle.loads(pickle.dumps(sim.model))
    assert model.name == sim.model.name and model.joint_names == sim.model.joint_names
    other = pickle.loads(pickle.dumps(sim))
    assert other.time == sim.time and np.array_equal(other.q, sim.q) and np.array_equal(other.v, sim.v)
    state = pickle.loads(pickle.dumps(sim.state))
    other.state = state
    # It begins anew from the same numbers, within the tolerance: only a state in memory knows more.
    for one, two in zip(go_on(other), go_on(sim)):
        assert np.allclose(one, two, rtol=0, atol=1e-4)
    result = catena.Sim(sim.model).run(0.15, rate=100)
    again = pickle.loads(pickle.dumps(result))
    assert np.array_equal(again.q, result.q) and np.array_equal(again.energy, result.energy) and again.summary == result.summary
    assert str(again) == str(result)
    assert all(np.array_equal(again.contacts[column], result.contacts[column]) for column in result.contacts)
    joint = sim.model.joint_names[-1]
    assert np.array_equal(again.reactions[joint], result.reactions[joint])
    with pytest.raises(catena.InputError, match="pickled"):
        again.save("never.mcap")


def test_pickled_models_have_their_options_and_numbers(robots):
    model = catena.load(robots / "arm7.urdf", gravity=(0, 0, -1.62), params={"flange.mass": 3.0}).with_params({"wrist.mass": 2.0})
    again = pickle.loads(pickle.dumps(model))
    q = np.full(7, 0.3)
    assert np.array_equal(again.gravity_efforts(q), model.gravity_efforts(q))
    assert again.params["link.flange.mass"] == 3.0 and again.params["link.wrist.mass"] == 2.0


def test_a_state_of_another_model_is_refused(arm, double_pendulum):
    with pytest.raises(catena.InputError, match="arm7"):
        catena.Sim(double_pendulum).state = catena.Sim(arm).state
    with pytest.raises(catena.InputError, match="a state is wanted"):
        catena.Sim(arm).state = 3


def test_a_run_after_a_run_has_reactions(double_pendulum):
    sim = catena.Sim(double_pendulum)
    sim.q["shoulder"] = 0.5
    sim.run(0.2)
    result = sim.run(0.2)
    # It is begun elsewhere, and not driven: the last sample of one is the first of the next.
    assert result.reactions["elbow"].shape == (13, 6) and np.isfinite(result.reactions["elbow"]).all()


@pytest.fixture
def interruptible():
    # Shells start what runs in the background with interrupts ignored, and so would this process be.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupted_run_gives_what_it_has(double_pendulum, interruptible):
    sim = catena.Sim(double_pendulum)
    sim.q[:] = [2.0, 1.0]
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt) as raised:
        sim.run(1e6, rate=10)
    timer.join()
    result = raised.value.result
    assert 0 < result.t[-1] <= sim.time < 1e6 and np.isfinite(result.q).all()


@pytest.mark.parametrize("ends", [KeyboardInterrupt, SystemExit])
def test_what_ends_a_program_comes_out_of_a_controller_with_what_the_run_has(double_pendulum, ends):
    def law(t, q, v):
        if t > 0.25:
            raise ends
        return None

    sim = catena.Sim(double_pendulum)
    with pytest.raises(ends) as raised:
        sim.run(1.0, rate=10, controller=law, control_rate=10)
    assert np.allclose(raised.value.result.t, [0, 0.1, 0.2, 0.3], rtol=0, atol=1e-12) and abs(sim.time - 0.3) < 1e-12
    sim = catena.Sim(double_pendulum)
    sim.set_controller(law, rate=10)
    with pytest.raises(ends):
        sim.step(1.0)


def test_a_failed_run_gives_what_it_has_and_names_controller_and_time(double_pendulum):
    sim = catena.Sim(double_pendulum)
    law = lambda t, q, v: [np.nan if t > 0.25 else 0.0, 0.0]  # noqa: E731
    with pytest.raises(catena.RunError, match=r'the controller failed at t = 0.3[0-9]* s: the effort on joint "shoulder" is NaN') as raised:
        sim.run(1.0, rate=10, controller=law, control_rate=10)
    assert np.allclose(raised.value.result.t, [0, 0.1, 0.2, 0.3], rtol=0, atol=1e-12)


def test_what_is_shown_is_short(sim):
    for one in (sim.model, sim, sim.state, catena.Sim(sim.model).run(0.01), catena.rollout(sim.model, [sim.model.start()[0]], duration=0.01)):
        assert len(repr(one)) < 100 and "\n" not in repr(one)


def test_efforts_of_sampled_motors_last_until_the_next_tick_in_runs_and_pickled_states(robots, tmp_path):
    scene = tmp_path / "sampled.toml"
    motor = 'kind = "position"\ntarget = 1.0\nkp = 8.0\nkd = 0.5\nperiod = 0.05'
    urdf = (robots / "pendulum.urdf").as_posix()
    scene.write_text(f'[scene]\ngravity = [0, 0, 0]\n\n[[robot]]\nurdf = "{urdf}"\n\n[[motor]]\njoint = "hinge"\n{motor}\n')
    model = catena.load(scene)
    new = lambda: catena.Sim(model, tolerance=1e-9)

    def told(result):
        return sum("between its ticks" in line for line in result.warnings)

    def at_end(sim):
        return np.array([sim.q[0], sim.v[0]])

    whole = new()
    assert not told(whole.run(0.7))
    parts = new()
    parts.run(0.33)
    assert not told(parts.run(0.37))
    steps = new()
    steps.run(0.12)
    steps.step(0.21)
    state = pickle.loads(pickle.dumps(steps.state))
    assert state.held == steps.state.held and len(state.held) == 1
    steps.run(0.37)
    pickled = new()
    pickled.state = state
    assert not told(pickled.run(0.37))
    stepped = new()
    stepped.state = state
    stepped.step(0.37)
    for sim in (parts, steps, pickled, stepped):
        # Constant accelerations between ticks, which steps of any length follow to rounding.
        assert np.abs(at_end(sim) - at_end(whole)).max() < 1e-13
    # From other coordinates nothing is known.
    moved = new()
    moved.state = state
    moved.q[0] += 0.1
    assert told(moved.run(0.37)) == 1


def test_joints_that_are_held_where_the_run_began_stay_held_there_in_runs_after_runs_and_in_pickles(robots, tmp_path):
    text = '[[robot]]\nurdf = "%s"\npositions = { shoulder = 0.5 }\nvelocities = { shoulder = 1.0 }\n'
    text += '[[motor]]\njoint = "*"\nkind = "position"\ntarget = "start"\nkp = 30\nkd = 1\n'
    (tmp_path / "held.toml").write_text(text % (robots / "double_pendulum.urdf").as_posix())
    model = catena.load(tmp_path / "held.toml")
    begin = lambda: catena.Sim(model, tolerance=1e-9)
    whole, parts, stepped, pickled, moved = (begin() for _ in range(5))
    whole.run(0.7)
    parts.run(0.3)
    parts.run(0.4)
    stepped.step(0.3)
    pickled.state = pickle.loads(pickle.dumps(stepped.state))
    moved.run(0.3)
    stepped.step(0.4)
    pickled.run(0.4)
    moved.q["shoulder"] += 0.1
    moved.run(0.4)
    # Tolerances of 1e-9 m at radii below 2 m.
    for sim in (parts, stepped, pickled):
        np.testing.assert_allclose(sim.q, whole.q, atol=1e-8)
    # What is moved by hand is another start.
    assert abs(moved.q["shoulder"] - whole.q["shoulder"]) > 0.01
