"""Fits, gradients and the examples that use derivatives of runs."""

import runpy
from pathlib import Path

import catena
import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_example_finds_masses_and_friction_from_noise():
    done = runpy.run_path(str(EXAMPLES / "identify.py"))
    found, true = done["found"], done["true"]
    assert found.rms < 1.1e-3
    for key in done["keys"][1:]:
        value = next(value for name, value in true.params.items() if name.endswith(key))
        # Three standard deviations hold 99.7 % of fits; the noise of this one is always the same.
        assert abs(found.values[key] - value) < 3 * found.deviations[key], key


def test_the_example_swings_the_pole_up():
    done = runpy.run_path(str(EXAMPLES / "swing_up.py"))
    efforts, off = done["swing_up"]()
    # Newton's method ends below 1e-9.
    assert off < 1e-9 and efforts.shape == (30,)


def test_the_band_of_a_bouncing_ball_is_that_of_its_closed_form():
    done = runpy.run_path(str(EXAMPLES / "bouncing_band.py"))
    run, speed = done["run"], np.sqrt(2 * 9.81 * 1.0)
    first, second = run.events[:2]
    # t₁ = √(2 h/g), t₂ = t₁ + 2 e √(2 g h)/g, by e and by h; differences of eighth order of the start leave some 1e-12.
    assert np.allclose(first["dt"], [0, 1 / speed], rtol=0, atol=1e-11)
    assert np.allclose(second["dt"], [2 * speed / 9.81, (1 + 2 * 0.8) / speed], rtol=0, atol=1e-11)


def test_a_number_that_the_data_does_not_tell_is_refused(robots):
    t = np.linspace(0, 0.2, 21)
    # The hinge turns about y.
    with pytest.raises(catena.InputError, match="does not depend"):
        catena.fit(catena.load(robots / "friction_pendulum.toml"), t, np.zeros((21, 1)), ["gravity.y"])


def test_a_run_has_the_derivatives_that_it_is_asked_for(double_pendulum):
    sim = catena.Sim(double_pendulum, stages=5, step=0.02)
    sim.q["shoulder"] = 0.3
    result = sim.run(0.4, rate=50, sensitivity=["lower_arm.mass"])
    own = result.sensitivity
    # They are those of the same steps.
    assert np.allclose(own.q[-1], result.q[-1], rtol=0, atol=1e-12) and own.dq.shape[1:] == (2, 1)
    q = [0.3, double_pendulum.start()[0][1]]
    assert np.array_equal(own.dq, double_pendulum.sensitivity("lower_arm.mass", q, [0.0, 0.0], duration=0.4, stages=5, step=0.02).dq)
    assert sim.run(0.1).sensitivity is None
    with pytest.raises(catena.InputError, match="from time 0 on"):
        sim.run(0.1, sensitivity="lower_arm.mass")


def loss_and_gradient(model, keys):
    """Σ q² of the samples and its gradient, by hand."""
    from catena._motion import Motion

    motion = Motion(model, keys, duration=0.4, step=0.02)
    q, _, dq, _ = motion(motion.values)
    return (q**2).sum(), 2 * np.einsum("tn,tnk->k", q, dq)


KEYS = ["lower_arm.mass", "start.q.shoulder"]


def test_jax_has_the_gradient(double_pendulum):
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    jax.config.update("jax_enable_x64", True)
    import catena.jax

    motion = catena.jax.rollout(double_pendulum, KEYS, duration=0.4, step=0.02)
    value, gradient = loss_and_gradient(double_pendulum, KEYS)
    loss = lambda numbers: (motion(numbers)[0] ** 2).sum()
    numbers = jax.numpy.array(motion.values)
    # The same sums in another order.
    assert np.isclose(loss(numbers), value, rtol=1e-13)
    assert np.allclose(jax.grad(loss)(numbers), gradient, rtol=1e-12)
    assert np.allclose(jax.jit(jax.jacfwd(loss))(numbers), gradient, rtol=1e-12)


def test_torch_has_the_gradient(double_pendulum):
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    import catena.torch

    motion = catena.torch.rollout(double_pendulum, KEYS, duration=0.4, step=0.02)
    value, gradient = loss_and_gradient(double_pendulum, KEYS)
    numbers = torch.tensor(motion.values, requires_grad=True)
    loss = (motion(numbers)[0] ** 2).sum()
    loss.backward()
    assert np.isclose(loss.item(), value, rtol=1e-13) and np.allclose(numbers.grad, gradient, rtol=1e-12)
    with pytest.raises(catena.InputError, match="float64"):
        motion(numbers.float())
