"""Controllers of Python: when they are asked, what they may answer, and how they fail."""

import catena
import numpy as np
import pytest


@pytest.fixture
def free(robots):
    return catena.load(robots / "pendulum.urdf", gravity=(0, 0, 0))


def test_a_controller_is_asked_at_a_fixed_rate_and_its_efforts_are_held(free):
    inertia = free.mass_matrix([0.0])[0, 0]
    asked = []

    def brake(t, q, v):
        asked.append(t)
        return [-2 * inertia * v[0]]

    sim = catena.Sim(free, tolerance=1e-9)
    sim.v["hinge"] = 1.0
    result = sim.run(1.0, controller=brake, control_rate=100)
    # Held over 0.01 s each: 0.98 a period, not e^(-0.02).
    assert abs(sim.v["hinge"] - 0.98**100) < 1e-11
    assert np.allclose(asked, np.arange(100) * 0.01, rtol=0, atol=1e-15)
    assert result.summary["energy"]["work"] < 0
    with pytest.raises(catena.InputError, match="a controller of a program"):
        result.reactions["hinge"]


def test_efforts_between_steps_are_felt(free):
    inertia = free.mass_matrix([0.0])[0, 0]
    sim = catena.Sim(free, tolerance=1e-9)
    sim.set_efforts([0.3])
    sim.step(1.0)
    sim.set_efforts(None)
    sim.step(1.0)
    assert abs(sim.v["hinge"] - 0.3 / inertia) < 1e-11
    assert abs(sim.q["hinge"] - 1.5 * 0.3 / inertia) < 1e-11


def test_a_controller_that_raises_ends_the_run_with_its_exception(free, tmp_path):
    def failing(t, q, v):
        if t > 0.35:
            raise KeyError("no more")

    sim = catena.Sim(free)
    with pytest.raises(catena.RunError, match=r"the controller failed at t = 0.4 s: KeyError: 'no more'") as raised:
        sim.run(1.0, log=tmp_path / "log.mcap", controller=failing, control_rate=10)
    assert isinstance(raised.value.__cause__, KeyError)
    assert sim.time == 0.4


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ([1.0, 2.0], "2 efforts for 1 degrees of freedom"),
        ([float("nan")], 'the effort on joint "hinge" is NaN'),
        ("push", "str"),
    ],
)
def test_answers_that_are_no_efforts_are_named(free, answer, message):
    with pytest.raises(catena.CatenaError, match=message):
        catena.Sim(free).run(0.1, controller=lambda t, q, v: answer, control_rate=10)


def test_what_a_controller_keeps_stays_as_it_was(free):
    kept, parts, times = [], [], []

    def watching(t, q, v):
        # Every other one is kept: whole, or a part of it.
        if len(times) % 4 == 0:
            kept.append((t, q))
        elif len(times) % 4 == 2:
            parts.append((t, q[:1]))
        times.append(t)

    sim = catena.Sim(free, tolerance=1e-9)
    sim.v["hinge"] = 1.0
    sim.run(1.0, controller=watching, control_rate=100)
    assert len(times) == 100 and len(kept) == len(parts) == 25
    # Free motion: q = t.
    for t, q in kept + parts:
        assert abs(q[0] - t) < 1e-12, t


def test_a_controller_that_asks_its_own_run_gets_an_error_not_a_deadlock(free):
    sim = catena.Sim(free)
    sim.set_controller(lambda t, q, v: sim._run.energy(), rate=10)
    with pytest.raises(catena.RunError, match="the run is being made"):
        sim.step(0.5)
