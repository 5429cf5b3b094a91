"""Runs are those of the command line, and their files say so."""

import json
import subprocess
import sys

import catena
import numpy as np
import pytest


def command(*words, cwd):
    return subprocess.run([sys.executable, "-m", "catena", *map(str, words)], cwd=cwd, capture_output=True, text=True)


def test_the_readme_s_five_lines_work(double_pendulum, tmp_path):
    sim = catena.Sim(double_pendulum, tolerance=1e-6)
    sim.q["shoulder"] = 0.5
    result = sim.run(2.0, rate=60)
    assert result.t.shape == (121,) and result.q.shape == (121, 2) and result.v.shape == (121, 2)
    assert result.q["shoulder"][0] == 0.5 and result.q["shoulder"].shape == (121,)
    assert result.poses["lower_arm"].shape == (121, 7) and result.reactions["elbow"].shape == (121, 6)
    # Conserved where steps end; samples inside of steps are interpolated, to some 1e-5 of velocities at this tolerance.
    assert result.summary["energy"]["max_relative_error"] < 1e-6
    assert np.ptp(result.energy) < 1e-4 * abs(result.energy[0])
    assert result.summary["duration"] == 2.0 and sim.time == 2.0
    assert np.array_equal(sim.q, result.q[-1]) and sim.q["elbow"] == result.q["elbow"][-1]


@pytest.mark.parametrize("name", ["double_pendulum.urdf", "four_bar_2.toml", "bouncing_pendulum.toml", "quadruped_dropped.toml"])
def test_report_and_log_are_those_of_the_command_line(robots, name, tmp_path):
    result = catena.Sim(catena.load(robots / name), tolerance=1e-6).run(0.25, rate=60)
    done = command("simulate", robots / name, "--duration", 0.25, "--tolerance", 1e-6, "--json", "-o", "log.mcap", cwd=tmp_path)
    theirs, ours = json.loads(done.stdout), dict(result.summary)
    for report in (theirs, ours):
        for clocked in ("wall_seconds", "cpu_seconds", "solve_cpu_seconds", "log"):
            report.pop(clocked, None)
        for island in report.get("islands", []):
            island.pop("solve_cpu_seconds", None)
    assert ours == theirs
    result.save(tmp_path / "ours.mcap")
    replayed = command("replay", "ours.mcap", cwd=tmp_path)
    assert replayed.returncode == 0, replayed.stderr
    compared = command("inspect", "ours.mcap", "--compare", "log.mcap", cwd=tmp_path)
    assert compared.returncode in (0, 2), compared.stderr


def test_contacts_carry_the_weight_of_what_stands(robots):
    model = catena.load(robots / "quadruped_dropped.toml")
    result = catena.Sim(model, tolerance=1e-6).run(3.0, rate=60)
    contacts, forces = result.contacts, result.contact_forces
    feet = sorted(set(contacts["pair"]))
    with_floor = {pair for pair in forces if pair.endswith("|floor")}
    assert len(feet) == 4 and with_floor == {*feet, "trunk|floor"}
    # The trunk does not reach the floor, and links do not reach each other.
    assert all(not forces[pair].any() for pair in set(forces) - set(feet))
    # The feet meet the floor after 0.101 s; before, no contact is closed.
    assert 0.1 < contacts["t"][0] < 0.12
    last = contacts["t"] == result.t[-1]
    assert last.sum() == 4 and contacts["sticks"][last].all()
    # No force is outside of its cone; no shape is deep in another.
    normal = (contacts["normal"] * contacts["force"]).sum(axis=1)
    across = np.linalg.norm(contacts["force"] - normal[:, None] * contacts["normal"], axis=1)
    assert (normal >= 0).all() and (across <= 0.8 * normal + 1e-10).all() and (contacts["gap"] >= -1e-12).all()
    # 11.2 kg; it still sinks into its knees by a micrometre a second or less.
    on_feet = sum(forces[foot][-1] for foot in feet)
    assert np.allclose(on_feet, [0, 0, 11.2 * 9.81], rtol=0, atol=1e-3)
    with pytest.raises(catena.InputError, match="front_left_foot"):
        forces["tail|floor"]
    assert len(catena.Sim(catena.load(robots / "double_pendulum.urdf")).run(0.1).contacts["t"]) == 0


def test_a_run_goes_on_where_the_last_one_ended(double_pendulum):
    whole, parts = (catena.Sim(double_pendulum, tolerance=1e-9) for _ in range(2))
    for sim in (whole, parts):
        sim.q[:] = [0.4, -0.2]
    end = whole.run(1.0).q[-1]
    parts.run(0.5)
    again = parts.run(0.5)
    assert again.t[0] == 0.5 and again.t[-1] == 1.0
    # Both are within the tolerance, in metres of arms of about one.
    assert np.allclose(again.q[-1], end, rtol=0, atol=1e-8)


def test_steps_and_changes_between_them(double_pendulum):
    sim = catena.Sim(double_pendulum, tolerance=1e-9)
    sim.q["elbow"] = 0.3
    reference = catena.Sim(double_pendulum, tolerance=1e-9)
    reference.q["elbow"] = 0.3
    for _ in range(4):
        sim.step(0.25)
    assert sim.time == 1.0
    assert np.allclose(sim.q, reference.run(1.0).q[-1], rtol=0, atol=1e-8)
    before = sim.energy()["total"]
    sim.v["shoulder"] += 1.0
    sim.step(0.1)
    # A push acts: the motion starts again from the written state.
    assert sim.energy()["total"] > before + 0.1
    sim.reset()
    assert sim.time == 0.0 and sim.q["elbow"] == 0.0


def test_q_and_v_are_the_same_memory_whatever_is_run(robots):
    sim = catena.Sim(catena.load(robots / "tumbling_body.urdf", base="floating", gravity=(0, 0, 0)))
    base = sim.model.joint_names[0]
    q, v, place = sim.q, sim.v, sim.q[base][:3]
    sim.v[base] = [1, 2, 3, 0, 0, 0.5]
    for _ in range(5):
        sim.step(0.1)
        assert sim.q is q and sim.v is v and np.shares_memory(place, q)
        # The origin of the frame is the centre of mass here, or turns about it: a pose taken once follows the present state.
        assert np.array_equal(place, sim.pose(sim.model.link_names[0])[:3])
    sim.run(0.5)
    assert sim.q is q and abs(sim.time - 1.0) < 1e-12 and np.array_equal(place, sim.q[base][:3])
    # A value written through a part that was taken once is the value the run continues from.
    place[:] = [7, 8, 9]
    result = sim.run(0.1, rate=10)
    assert np.array_equal(result.q[base][0, :3], [7, 8, 9])
    sim.reset()
    assert sim.q is q and np.array_equal(place, [0, 0, 0])


def test_results_become_tables_and_files(double_pendulum, tmp_path):
    sim = catena.Sim(double_pendulum)
    sim.q["shoulder"] = 1.0
    result = sim.run(0.5, rate=20)
    result.save(tmp_path / "run.npz")
    kept = np.load(tmp_path / "run.npz")
    assert np.array_equal(kept["q.shoulder"], result.q["shoulder"]) and np.array_equal(kept["t"], result.t)
    result.save(tmp_path / "run.csv")
    table = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    assert np.array_equal(table["energy"], result.energy)
    result.report(tmp_path / "run.html")
    assert "</html>" in (tmp_path / "run.html").read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.csv", "run.html", "run.npz"]
    with pytest.raises(catena.InputError, match="none of .mcap"):
        result.save(tmp_path / "run.xlsx")


def test_pandas_and_parquet(double_pendulum, tmp_path):
    pandas = pytest.importorskip("pandas")
    result = catena.Sim(double_pendulum).run(0.5, rate=20)
    table = result.to_pandas()
    assert list(table.columns) == ["q.shoulder", "q.elbow", "v.shoulder", "v.elbow", "energy"] and table.index.name == "t"
    pytest.importorskip("pyarrow")
    result.save(tmp_path / "run.parquet")
    assert pandas.read_parquet(tmp_path / "run.parquet").equals(table)


def test_floating_bases_have_quaternions(robots):
    model = catena.load(robots / "tumbling_body.urdf", base="floating", gravity=(0, 0, 0))
    sim = catena.Sim(model)
    assert sim.q.shape == (7,) and sim.v.shape == (6,)
    base = model.joint_names[0]
    sim.q[base] = [1, 2, 3, 0.5, 0.5, 0.5, 0.5]
    sim.v[base] = [0, 0, 0, 0.1, 0.2, 0.3]
    result = sim.run(1.0, rate=10)
    assert result.q[base].shape == (11, 7)
    assert np.allclose(np.linalg.norm(result.q[base][:, 3:], axis=1), 1, rtol=0, atol=1e-14)


def test_numbers_are_varied_without_files(arm):
    q = np.full(7, 0.3)
    heavier = arm.with_params({"flange.mass": 2 * arm.params["link.flange.mass"]})
    assert heavier.params["link.flange.mass"] == 2 * arm.params["link.flange.mass"], "what was set"
    assert heavier.mass_matrix(q)[0, 0] > arm.mass_matrix(q)[0, 0]
    moon = arm.with_params({"gravity.z": -9.81 / 6})
    assert np.allclose(moon.gravity_efforts(q), arm.gravity_efforts(q) / 6, rtol=1e-13, atol=0)
    with pytest.raises(catena.InputError, match="link.flange.mass"):
        arm.with_params({"flange.mas": 1.0})


def test_other_numbers_are_set_on_the_file_as_it_was_when_it_was_first_asked_for_them(tmp_path, robots):
    path = tmp_path / "arm.urdf"
    path.write_text((robots / "arm7.urdf").read_text())
    model = catena.load(path)
    mass = model.params["link.flange.mass"]
    path.unlink()
    heavier = model.with_params({"flange.mass": 2 * mass}).with_params({"gravity.z": -1.62})
    again = catena.load(robots / "arm7.urdf", params={"flange.mass": 2 * mass, "gravity.z": -1.62})
    q = np.full(7, 0.3)
    assert np.array_equal(heavier.gravity_efforts(q), again.gravity_efforts(q))
    assert not np.array_equal(heavier.gravity_efforts(q), model.gravity_efforts(q))


def test_the_equations_of_motion_fit_together(arm):
    rng = np.random.default_rng(7)
    q, v, tau = rng.uniform(-1, 1, (3, 7))
    a = arm.forward_dynamics(q, v, tau)
    assert np.allclose(arm.inverse_dynamics(q, v, a), tau, rtol=0, atol=1e-10)
    still = np.zeros(7)
    assert np.allclose(arm.inverse_dynamics(q, still, still), arm.gravity_efforts(q), rtol=0, atol=1e-10)
    step = 1e-6
    moved = (arm.pose("flange", q + step * v)[:3] - arm.pose("flange", q - step * v)[:3]) / (2 * step)
    # Central differences leave some step² and rounding/step.
    assert np.allclose(arm.jacobian("flange", q)[:3] @ v, moved, rtol=0, atol=1e-8)


def test_points_momentum_and_sensors_fit_together(arm):
    rng = np.random.default_rng(11)
    q, v, tau = rng.uniform(-1, 1, (3, 7))
    a, point = arm.forward_dynamics(q, v, tau), (0.1, 0.2, -0.3)
    jacobian = arm.jacobian("flange", q, point)
    assert np.allclose(jacobian @ v, arm.velocity("flange", q, v, point), rtol=0, atol=1e-12)
    there = jacobian @ a + arm.bias_acceleration("flange", q, v, point)
    assert np.allclose(there, arm.acceleration("flange", q, v, a, point), rtol=0, atol=1e-10)
    sim = catena.Sim(arm)
    sim.q, sim.v = q, v
    sim.set_efforts(tau)
    sensed = sim.sense()
    turn = quaternion_matrix(arm.pose("flange", q)[3:])
    # An accelerometer feels the acceleration less gravity, in its own frame.
    assert np.allclose(turn @ sensed.imu("flange", point)[:3], there[:3] + [0, 0, 9.81], rtol=0, atol=1e-8)
    assert np.allclose(turn @ sensed.imu("flange")[3:], arm.velocity("flange", q, v)[3:], rtol=0, atol=1e-12)
    mass = arm.momentum(q, v)[:3] / (arm.center_of_mass_jacobian(q) @ v)
    assert np.ptp(mass) < 1e-9 and arm.center_of_mass(q).shape == (3,) and sensed.contact_force("flange").tolist() == [0, 0, 0]
    noise, again = catena.Noise(0.1, bias=1.0, seed=3), catena.Noise(0.1, bias=1.0, seed=3)
    noisy = noise(sensed.imu("flange"))
    assert np.array_equal(noisy, again(sensed.imu("flange"))) and not np.array_equal(noise(noisy), noisy)


def quaternion_matrix(quaternion):
    """The rotation of a quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_the_command_line_is_the_same(robots, tmp_path):
    version = command("--version", cwd=tmp_path)
    assert version.stdout.startswith(f"catena {catena.__version__} (")
    wrong = command("simulate", "nowhere.urdf", cwd=tmp_path)
    assert wrong.returncode == 2 and wrong.stderr.startswith("catena: error: nowhere.urdf")
    with pytest.raises(catena.InputError) as raised:
        catena.load("nowhere.urdf")
    assert wrong.stderr == f"catena: error: {raised.value}\n"


def test_the_linear_equations_of_an_oscillator_have_its_frequency_and_damping(robots):
    # x'' + 4 x' + 100 x = u.
    linear = catena.load(robots / "damped_oscillator.toml").linearize()
    assert np.allclose(linear.A, [[0, 1], [-100, -4]], rtol=0, atol=1e-12)
    assert np.allclose(linear.B, [[0], [1]], rtol=0, atol=1e-14)
    assert abs(linear.frequencies[0] - np.sqrt(96) / (2 * np.pi)) < 1e-14
    assert abs(linear.damping_ratios[0] - 0.2) < 1e-14
    assert linear.stable == ["yes"] and linear.shapes.shape == (1, 1)
    with pytest.raises(catena.InputError, match="rest"):
        catena.load(robots / "damped_oscillator.toml").linearize(v=[0.0], at="rest")


def test_a_run_has_its_derivatives_by_start_and_numbers(double_pendulum):
    run = double_pendulum.sensitivity(["start.q.shoulder", "lower_arm.mass"], duration=0.4, stages=5, step=0.05)
    assert run.dq.shape == (len(run.t), 2, 2) and run.keys == ["start.q.shoulder", "lower_arm.mass"]
    assert np.array_equal(run.dq[0], [[1, 0], [0, 0]])
    mass = dict(double_pendulum.params)["link.lower_arm.mass"]
    end = [double_pendulum.with_params({"lower_arm.mass": mass + by}).sensitivity([], duration=0.4, stages=5, step=0.05).q[-1] for by in (-1e-3, 1e-3)]
    # Central differences: the second order of 1e-4 of the mass.
    assert np.allclose((end[1] - end[0]) / 2e-3, run.dq[-1][:, 1], rtol=1e-6, atol=1e-8)


def test_sums_and_extremes_of_named_numbers_are_numbers_and_parts_are_arrays(robots):
    sim = catena.Sim(catena.load(robots / "double_pendulum.urdf"))
    sim.v[:] = [1.25, -2.5]
    assert round(sim.v.sum(), 1) == -1.2 and f"{sim.v.max():.2f}" == "1.25"
    assert isinstance(sim.v @ sim.v, float) and isinstance(sim.v.mean(), float)
    assert (2 * sim.v).shape == (2,) and isinstance(sim.v[:1], np.ndarray)


def test_motors_that_hold_may_hold_the_weight_besides(robots):
    hanging = catena.load(robots / "double_pendulum.urdf", hold={"kp": 50, "kd": 5, "gravity": 1})
    sim = catena.Sim(hanging)
    sim.q[:] = [0.7, 0.2]
    sim.run(0.5)
    # It is held where it began, without giving way.
    assert np.allclose(sim.q, [0.7, 0.2], atol=1e-9)
    with pytest.raises(catena.InputError, match="give kp, kd and gravity"):
        catena.load(robots / "double_pendulum.urdf", hold={"ki": 1})
