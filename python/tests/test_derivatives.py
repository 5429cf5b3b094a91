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


PENDULUM = """<robot name="pendulum"><link name="base"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>"""


def test_a_fit_refuses_combinations_of_numbers_that_the_data_cannot_tell_and_names_them(tmp_path):
    # (I + m l²) θ̈ = −m g l sin θ − d θ̇: only m l/(I + m l²) and d/(I + m l²) move it.
    (tmp_path / "pendulum.urdf").write_text(PENDULUM)
    model = catena.load(tmp_path / "pendulum.urdf").with_params({"joint.hinge.damping": 0.05})
    t, sim = np.linspace(0, 4, 201), catena.Sim(model, tolerance=1e-10)
    sim.q[0], data = 1.2, [1.2]
    for _ in t[1:]:
        sim.step(0.02)
        data.append(sim.q[0])
    data = (np.array(data) + np.random.default_rng(0).normal(size=201) * 1e-3)[:, None]
    guess = model.with_params({"joint.hinge.damping": 0.02})
    damping, *body = "joint.hinge.damping", "link.rod.mass", "link.rod.inertia.iyy", "link.rod.center_of_mass.z"
    for keys, named, left in (
        ([damping, *body[:2]], f"{damping}, {body[0]} and {body[1]} cannot be told", "2 numbers of them; leave out 1"),
        ([damping, *body], f"{damping}, {', '.join(body[:2])} and {body[2]} cannot be told", "2 numbers of them; leave out 2"),
        # The start is told by itself.
        (["start.q.hinge", *body], f"{', '.join(body[:2])} and {body[2]} cannot be told", "2 numbers of them; leave out 1"),
    ):
        with pytest.raises(catena.InputError) as refused:
            catena.fit(guess, t, data, keys, q=[1.2])
        assert str(refused.value).startswith(named) and left in str(refused.value), refused.value
    # As many as are told are found: three standard deviations hold 99.7 % of fits; the noise of this one is always the same.
    found = catena.fit(guess, t, data, [damping, body[1]], q=[1.2])
    assert all(abs(found.values[key] - true) < 3 * found.deviations[key] for key, true in ((damping, 0.05), (body[1], 0.01)))


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


def by_events(run, weights):
    """A loss of all samples and of the times and velocities of all events, with random weights."""
    n = run.v.shape[1]
    of_q, of_v = (weights.normal(size=(len(run.t), n)) for _ in range(2))
    events = {number: (weights.normal(), weights.normal(size=n), weights.normal(size=n)) for number in range(len(run.events))}
    value = (of_q * run.q).sum() + (of_v * run.v).sum() + sum(dt * run.events[number]["t"] for number, (dt, _, _) in events.items())
    return value, of_q, of_v, events


def test_gradients_against_time_are_the_forward_derivatives(arm):
    # The arm meets a limit at 0.687 s; the samples are ends of steps of both.
    fixed = dict(stages=5, step=0.01)
    keys = ["start.q", "start.v", "link.forearm.mass", "link.wrist.inertia.ixx", "gravity.z"]
    forward = arm.sensitivity(keys, duration=0.8, **fixed)
    times = forward.t[::7]
    said = []

    def loss(run):
        said.append(by_events(run, np.random.default_rng(5)))
        return said[0]

    found = arm.gradient(keys, times, loss, duration=0.8, **fixed)
    assert found.keys == forward.keys and len(found.samples.events) == len(forward.events) >= 1
    value, of_q, of_v, events = said[0]
    # The impact is solved from other first guesses.
    assert found.value == value and np.allclose(found.samples.q, forward.q[::7], rtol=0, atol=1e-13)
    parts = [of_q[:, :, None] * forward.dq[::7], of_v[:, :, None] * forward.dv[::7]]
    for number, (dt, dq, dv) in events.items():
        event = forward.events[number]
        parts += [dt * event["dt"], dq[:, None] * event["dq"], dv[:, None] * event["dv"]]
    sums = sum(part.reshape(-1, len(found.keys)).sum(axis=0) for part in parts)
    sizes = sum(np.abs(part.reshape(-1, len(found.keys))).sum(axis=0) for part in parts)
    # The same products in another order, for steps and impacts of the same run.
    assert np.all(np.abs(found.by - sums) <= 1e-12 * sizes)
    again = arm.gradient(keys, times, lambda run: said[0], duration=0.8, every=5, **fixed)
    assert np.array_equal(again.by, found.by)


def test_a_gradient_through_an_impact_is_that_of_its_closed_form(robots):
    ball = catena.load(robots / "ball_dropped.toml")
    # t₁ = √(2 h/g), z(T) = e v₁ (T − t₁) − g (T − t₁)²/2 above its lowest place, v₁ = g t₁.
    g, e, T = 9.81, ball.params["obstacle.floor.restitution"], 0.6
    found = ball.gradient(["start.q", "floor.restitution"], [T], lambda run: (run.q[0, 2], np.eye(6)[[2]], None), stages=5, step=0.05)
    t1 = found.samples.events[found.samples.event("floor")]["t"]
    by_h = e * T / t1 - 2 * e + (T - t1) / t1
    exact = {"start.q.ball.z": by_h, "floor.restitution": g * t1 * (T - t1)}
    for key, slope in exact.items():
        own = [name for name in found.keys if name == key or name.endswith(".z") and key.endswith(".z")]
        assert abs(found.by[found.keys.index(own[0])] - slope) < 1e-11, (found.keys, found.by, exact)


def test_losses_that_do_not_fit_are_refused_and_exceptions_come_out(double_pendulum):
    fixed = dict(stages=5, step=0.02)
    with pytest.raises(catena.InputError, match=r"shape \(1, 2\)"):
        double_pendulum.gradient("start.q", [0.1], lambda run: (0.0, np.zeros((3, 2)), None), **fixed)
    with pytest.raises(catena.InputError, match="0 events with 'floor'"):
        double_pendulum.gradient("start.q", [0.1], lambda run: (0.0, None, None, {run.event("floor"): 1.0}), **fixed)
    with pytest.raises(ZeroDivisionError):
        double_pendulum.gradient("start.q", [0.1], lambda run: 1 / 0, **fixed)
    with pytest.raises(catena.InputError, match="times after its start"):
        double_pendulum.gradient("start.q", [-0.1, 0.1], lambda run: (0.0, None, None), **fixed)


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


def test_jax_has_the_gradient_against_time(double_pendulum):
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    jax.config.update("jax_enable_x64", True)
    import catena.jax

    motion = catena.jax.rollout(double_pendulum, KEYS, duration=0.4, step=0.02, against_time=True)
    value, gradient = loss_and_gradient(double_pendulum, KEYS)
    loss = lambda numbers: (motion(numbers)[0] ** 2).sum()
    numbers = jax.numpy.array(motion.values)
    assert np.isclose(loss(numbers), value, rtol=1e-13)
    # The same derivatives by the transpose: roundings of 20 steps.
    for of in (jax.grad(loss), jax.jit(jax.grad(loss))):
        assert np.allclose(of(numbers), gradient, rtol=1e-12)


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


def test_torch_has_the_gradient_against_time(double_pendulum):
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    import catena.torch

    motion = catena.torch.rollout(double_pendulum, KEYS, duration=0.4, step=0.02, against_time=True)
    _, gradient = loss_and_gradient(double_pendulum, KEYS)
    numbers = torch.tensor(motion.values, requires_grad=True)
    (motion(numbers)[0] ** 2).sum().backward()
    assert np.allclose(numbers.grad, gradient, rtol=1e-12)


def test_derivatives_are_columns_of_tables_and_files(double_pendulum, tmp_path):
    pandas = pytest.importorskip("pandas")
    run = double_pendulum.sensitivity(["start.q.shoulder", "lower_arm.mass"], [0.5, 0.2], [0.0, 0.0], duration=0.4, stages=5, step=0.05)
    table = run.to_pandas()
    assert table.index.name == "t" and len(table.columns) == 2 + 2 + 2 * 2 * 2
    assert np.array_equal(table["dq.elbow/d.start.q.shoulder"], run.dq[:, 1, 0])
    assert np.array_equal(table["dv.shoulder/d.lower_arm.mass"], run.dv[:, 0, 1])
    assert np.array_equal(table["q.elbow"], run.q[:, 1]) and np.array_equal(table["v.shoulder"], run.v[:, 0])
    run.save(tmp_path / "run.csv")
    # Seventeen digits are the same double.
    assert np.array_equal(np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)[:, 1:], table.to_numpy())
    run.save(tmp_path / "run.npz")
    assert np.array_equal(np.load(tmp_path / "run.npz")["dq.elbow/d.lower_arm.mass"], run.dq[:, 1, 1])
    with pytest.raises(catena.InputError, match="none of .npz, .parquet, .csv"):
        run.save(tmp_path / "run.mcap")
    pytest.importorskip("pyarrow")
    run.save(tmp_path / "run.parquet")
    assert pandas.read_parquet(tmp_path / "run.parquet").equals(table)


def test_a_floating_link_has_the_derivatives_of_its_q_and_v(tmp_path):
    # The centre of mass is off the origin of the link: x_link = x_com - R r moves on a circle about it.
    (tmp_path / "one.urdf").write_text(
        '<robot name="one"><link name="t"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>'
        '<inertia ixx=".03" iyy=".04" izz=".05" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    model = catena.load(tmp_path / "one.urdf", base="floating", gravity=(0, 0, 0))
    q, v = model.start()
    w, t, r = 2.0, 0.5, 0.1
    v[5] = w
    keys = ["link.t.center_of_mass.x", "start.v.base.rz", "effort.base.y"]
    found = model.sensitivity(keys, q, v, duration=t, tolerance=1e-11)
    assert np.abs(found.dq[0]).max() < 1e-12, "the start does not depend on them"
    turned, time = w * t, np.array([np.sin(w * t), 1 - np.cos(w * t)])
    by_center = [time[1], turned - time[0], 0]
    by_spin = [r * t * time[0], r * t - r * t * np.cos(turned), 0]
    # The run is exact to 1e-11 m; the derivative by a length has that over a metre.
    assert np.allclose(found.dq[-1][:3, 0], by_center, rtol=0, atol=1e-9)
    assert np.allclose(found.dq[-1][:3, 1], by_spin, rtol=0, atol=1e-9)
    back = model.gradient(keys, [t], lambda run: (run.q[0, 1], np.eye(6)[[1]], None), q, v, tolerance=1e-11)
    assert np.allclose(back.by, found.dq[-1][1], rtol=0, atol=1e-10)
    # A force at the origin of the link along y turns it about its centre of mass.
    linear = model.linearize(q, np.zeros(6))
    row = linear.names.index
    assert np.isclose(linear.B[6 + row("base.rz"), linear.freedoms.index("base.y")], -r / 0.05, rtol=1e-12)
    assert np.allclose(linear.inertia, model.mass_matrix(q), rtol=0, atol=1e-13)


def test_every_parameter_of_programs_has_a_type():
    import inspect

    functions = [catena.load, catena.rollout, catena.fit, catena.sweep]
    for owner in (catena.Model, catena.Sim, catena.Result, catena.Sensitivity):
        functions += [own for name, own in vars(owner).items() if inspect.isfunction(own) and not name.startswith("_")]
    for function in functions:
        for name, given in inspect.signature(function).parameters.items():
            assert name == "self" or given.annotation is not inspect.Parameter.empty, f"{function.__qualname__}: {name}"


def test_rollouts_name_numbers_that_the_model_does_not_have(double_pendulum):
    with pytest.raises(catena.InputError, match="lower_arm.mess"):
        catena.rollout(double_pendulum, np.zeros((2, 2)), duration=0.1, params={"lower_arm.mess": [1.0, 2.0]})


def test_noise_shows_what_it_is():
    assert repr(catena.Noise(0.1, bias=0.2, seed=3)) == "<catena.Noise: deviation 0.1, bias 0.2, seed 3>"


def test_linear_equations_have_a_discrete_system_and_derivatives_of_their_frequencies(robots):
    linear = catena.load(robots / "damped_oscillator.toml").linearize(by=["spring.spring.stiffness"])
    # f = sqrt(k/m - (c/2m)^2)/(2 pi): df/dk = 1/(8 pi^2 m f).
    wanted = 1 / (8 * np.pi**2 * linear.frequencies[0])
    assert abs(linear.frequencies_by["spring.spring.stiffness"][0] - wanted) < 1e-9 * wanted
    a, b, b_targets = linear.discrete(0.1)
    # x'' + 4 x' + 100 x = u over 0.1 s; at rest under u = 100 it stays at 1.
    w = np.sqrt(96)
    first = np.exp(-0.2) * (np.cos(0.1 * w) + 2 / w * np.sin(0.1 * w))
    assert abs(a[0, 0] - first) < 1e-14 and b_targets.shape == (2, 0)
    assert np.allclose(a @ [1, 0] + b @ [100], [1, 0], rtol=0, atol=1e-13)
    with pytest.raises(catena.InputError, match="step"):
        linear.discrete(0.0)


def test_the_multipliers_of_an_oscillator_are_those_of_its_closed_form(robots):
    model = catena.load(robots / "damped_oscillator.toml")
    found = model.multipliers(0.3, stages=9, step=0.1)
    wanted = np.exp(0.3 * (-2 + 1j * np.sqrt(96)))
    assert np.abs(found.values - [wanted, np.conj(wanted)]).max() < 1e-12 and found.warnings == []
    assert abs(found.apart) > 0.01, "it does not come back"


def _robot(name, parts):
    return f'<robot name="{name}"><link name="base"/>{parts}</robot>'


def _link(name, mass, inertia, below=0.0):
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 {-below}"/><mass value="{mass}"/>'
        f'<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


CART = _robot(
    "cart_and_pole",
    _link("cart", 1, 0.01)
    + _link("pole", 0.2, 0.005, 0.25)
    + '<joint name="x" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="100" velocity="0"/></joint>'
    '<joint name="th" type="continuous"><parent link="cart"/><child link="pole"/><axis xyz="0 1 0"/><dynamics damping="0.003" friction="0.004"/></joint>',
)
LIMITED = _robot(
    "limited_pendulum",
    _link("rod", 0.5, 0.01, 0.3)
    + '<joint name="h" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/><limit lower="-0.3" upper="1.5" effort="0" velocity="0"/></joint>',
)
SLIDER = _robot(
    "slider",
    _link("mass", 1, 0.01)
    + '<joint name="x" type="prismatic"><parent link="base"/><child link="mass"/><axis xyz="1 0 0"/><limit lower="-5" upper="5" effort="0" velocity="0"/></joint>',
)
EVENTFUL = {
    # The scene, its robot, the numbers that are looked for, the samples in a second and their noise, and the largest factor of guesses.
    "pendulum on a cart with dry friction": ("positions = {th = 1.2}", CART, {"joint.th.damping": 0.003, "joint.th.friction": 0.004}, 50, 1e-3, 4.0),
    "pendulum with a limit": (
        'positions = {h = 1.0}\n[[joint]]\nname = "h"\nrestitution = 0.6\ndamping = 0.02',
        LIMITED,
        {"joint.h.damping": 0.02, "joint.h.restitution": 0.6},
        50,
        1e-3,
        1.6,
    ),
    "mass on a spring with dry friction": (
        'positions = {x = 0.3}\n[[spring]]\njoint = "x"\nstiffness = 80\ndamping = 0.3\nrest = 0\n[[joint]]\nname = "x"\nfriction = 1.0',
        SLIDER,
        {"spring.spring1.stiffness": 80.0, "joint.x.friction": 1.0},
        100,
        1e-4,
        2.0,
    ),
}


def _eventful(folder, scene, robot):
    (folder / "robot.urdf").write_text(robot)
    (folder / "scene.toml").write_text(f'[[robot]]\nurdf = "robot.urdf"\n{scene}\n')
    return catena.load(folder / "scene.toml")


@pytest.mark.parametrize("name", EVENTFUL)
def test_fits_through_events_find_the_numbers_from_wherever_they_begin(tmp_path, name):
    scene, robot, true, rate, noise, factor = EVENTFUL[name]
    model, keys = _eventful(tmp_path, scene, robot), list(true)
    motion = catena.Sim(model, tolerance=1e-8).run(3.0, rate=rate)
    for seed in range(6):
        random = np.random.default_rng(seed)
        guess = model.with_params({key: value * factor ** random.uniform(-1, 1) for key, value in true.items()})
        data = np.array(motion.q) + random.normal(0, noise, motion.q.shape)
        found = catena.fit(guess, motion.t, data, keys)
        assert found.converged and not found.warnings, (seed, found)
        apart = np.array([found.values[key] - true[key] for key in keys])
        # χ² of two numbers: one fit in 10 000 is further off; the noise of these is always the same.
        assert apart @ np.linalg.solve(found.covariance, apart) < 18.4, (seed, found)
        assert abs(found.rms / noise - 1) < 0.2, (seed, found)


def test_a_run_has_the_samples_that_are_asked_for_beside_its_events(tmp_path):
    scene, robot, true, *_ = EVENTFUL["pendulum with a limit"]
    model, fixed = _eventful(tmp_path, scene, robot), {"duration": 2.0, "stages": 5, "step": 0.02}
    alone = model.sensitivity(list(true), **fixed)
    met = alone.events[:3]
    for off in (0.0, 1e-13, -1e-13, 1e-9, -1e-9, 1e-7, -1e-7):
        times = [event["t"] + off for event in met]
        run = model.sensitivity(list(true), times=times, **fixed)
        rows = np.searchsorted(run.t, times)
        assert np.all(run.t[rows] == times)
        for row, event in zip(rows, met):
            # The event moves in time and the sample does not; some rad/s over the time between.
            assert np.allclose(run.q[row], event["q"], rtol=0, atol=1e-12 + 10 * abs(off))
            assert np.allclose(run.dq[row], event["dq"] - np.outer(event["v"], event["dt"]), rtol=0, atol=1e-9 + 1e3 * abs(off))
        # Steps of other lengths have errors of 1e-7 of the derivatives.
        assert np.allclose(run.dq[-1], alone.dq[-1], rtol=1e-6)


def test_a_fit_whose_trials_are_refused_is_not_told_as_converged(tmp_path):
    scene, robot, *_ = EVENTFUL["pendulum on a cart with dry friction"]
    model = _eventful(tmp_path, scene, robot)
    motion = catena.Sim(model.with_params({"joint.th.friction": 0.0, "joint.th.damping": 0.0}), tolerance=1e-8).run(3.0, rate=50)
    # A motion that grows has no friction.
    grown = np.array(motion.q) * (1 + 0.05 * np.array(motion.t))[:, None]
    with pytest.warns(RuntimeWarning, match="has not converged"):
        found = catena.fit(model, motion.t, grown, ["joint.th.friction"])
    assert not found.converged and len(found.warnings) == 1 and "not converged" in repr(found)
    # At a bound that says so, it has.
    bounded = catena.fit(model, motion.t, grown, ["joint.th.friction"], bounds={"joint.th.friction": (1e-4, 1.0)})
    assert bounded.converged and bounded.values["joint.th.friction"] == 1e-4
