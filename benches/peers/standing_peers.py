"""The scenes of `standing_scenes.py` in MuJoCo, Rapier, Drake and our own program: how feet and box creep, how deep shapes overlap, and CPU time."""

from __future__ import annotations

import json
import math
import os
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import catena
from measure import clocked
from scene import quaternion, rotation_matrix
from standing_scenes import GRAVITY, Scene, turned, urdf

REPEATS = 3
# Runs of more than LONG seconds are not repeated.
LONG = 3.0
STEPS = (1e-2, 1e-3)
# Our own runs are broken off after this wall time (s).
PATIENCE = 60.0
RAPIER = Path(os.environ.get("RAPIER_STANDING", Path(__file__).parent / "rapier" / "target" / "release" / "standing"))
# Rotation and origin of each link.
Places = list[tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Measured:
    """A row of the table; the cost is CPU time of the stepping loop, or of our whole process."""

    scene: str
    method: str
    setting: str
    creep: float  # of the foot or of the box that goes farthest, over the second half of the run [m/s]
    moved: float  # how far it is at the end from where it was after a second [m]
    overlap: float  # the deepest at the end [m]
    cpu_seconds_per_simulated_second: float


def instants(scene: Scene) -> list[float]:
    """When one looks [s]: after a second, at half of the run and at its end."""
    return [1.0, 0.5 * scene.duration, scene.duration]


def _watched(scene: Scene, places: Places) -> np.ndarray:
    """The feet, as far as they slide, or the box."""
    if scene.floor:
        return np.array(
            [(turn @ link.shape.at + at)[:2] for link, (turn, at) in zip(scene.links, places) if link.shape]
        )
    return np.array([places[-1][1]])


def _overlap(scene: Scene, places: Places) -> float:
    if scene.floor:
        feet = [(link.shape, turn @ link.shape.at + at) for link, (turn, at) in zip(scene.links, places) if link.shape]
        return max(shape.radius - at[2] for shape, at in feet)
    thick = scene.links[0].shape.half[0] + scene.links[-1].shape.half[0]
    return max(thick - abs(places[-1][1][0] - pad[1][0]) for pad in places[:-1])


def _row(scene: Scene, method: str, setting: str, at: Callable[[float], Places], cost: float) -> Measured:
    """`at` gives the places at an instant."""
    first, half, end = map(at, instants(scene))
    apart = [np.linalg.norm(_watched(scene, end) - _watched(scene, one), axis=1).max() for one in (half, first)]
    creep, moved, overlap = apart[0] / (0.5 * scene.duration), apart[1], _overlap(scene, end)
    if not math.isfinite(creep + moved + overlap):
        creep = moved = overlap = math.inf
    return Measured(scene.name, method, setting, creep, moved, overlap, cost / scene.duration)


def _words(numbers) -> str:
    return " ".join(repr(float(number)) for number in np.asarray(numbers).ravel())


def _mujoco_document(scene: Scene) -> str:
    """The scene as MuJoCo's own format: feet touch the floor alone, pads and box each other."""

    def body(number: int) -> str:
        link = scene.links[number]
        joint = "<freejoint/>"
        if link.kind != "floating":
            kind = "hinge" if link.kind == "revolute" else "slide"
            joint = f'<joint name="{link.name}" type="{kind}" axis="{_words(link.axis)}"/>'
        moments = np.array(link.inertia)[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        shape = ""
        if link.shape:
            size = f'type="sphere" size="{link.shape.radius!r}"'
            if link.shape.half:
                size = f'type="box" size="{_words(link.shape.half)}"'
            touches = 'contype="1" conaffinity="2"' if scene.floor else ""
            shape = f'<geom {size} pos="{_words(link.shape.at)}" friction="{scene.friction!r}" condim="3" {touches}/>'
        below = "".join(body(child) for child, other in enumerate(scene.links) if other.parent == number)
        return (
            f'<body name="{link.name}" pos="{_words(link.place)}" quat="{_words(quaternion(turned(link.pitch)))}">{joint}'
            f'<inertial pos="{_words(link.center)}" mass="{link.mass!r}" fullinertia="{_words(moments)}"/>{shape}{below}</body>'
        )

    floor = f'<geom type="plane" size="0 0 1" friction="{scene.friction!r}" condim="3" contype="2" conaffinity="1"/>'
    jointed = [link.name for link in scene.links if link.kind != "floating"]
    motor = f'kp="{scene.stiffness!r}" kv="{scene.damping!r}"'
    motors = [
        f'<position joint="{name}" {motor}/>' if scene.stiffness else f'<motor joint="{name}"/>' for name in jointed
    ]
    bodies = "".join(body(number) for number, link in enumerate(scene.links) if link.parent < 0)
    return (
        f'<mujoco><compiler angle="radian"/><option cone="elliptic" gravity="0 0 {-GRAVITY}"/><worldbody>'
        f"{floor if scene.floor else ''}{bodies}</worldbody><actuator>{''.join(motors)}</actuator></mujoco>"
    )


def mujoco(scene: Scene) -> Iterator[Measured]:
    """MuJoCo with its default contacts and with stiff ones, by the integrator it recommends and by the one for motors and contacts together."""
    import mujoco as engine

    schemes = {"implicitfast": engine.mjtIntegrator.mjINT_IMPLICITFAST, "discrete": engine.mjtIntegrator.mjINT_DISCRETE}
    for softness in ("default", "stiff"):
        for scheme, integrator in schemes.items():
            for step in STEPS:
                spec = engine.MjSpec.from_string(_mujoco_document(scene))
                spec.option.timestep, spec.option.integrator = step, integrator
                if softness == "stiff":
                    spec.option.noslip_iterations = 10 if scheme == "implicitfast" else 0
                    for geom in spec.geoms:
                        geom.solref, geom.solimp = [2.0 * step, 1.0], [0.9999, 0.9999, 0.001, 0.5, 2.0]
                model = spec.compile()
                best, seen = math.inf, {}
                for _ in range(REPEATS):
                    data, cost = engine.MjData(model), 0.0
                    data.ctrl[:] = scene.target if scene.stiffness else scene.effort
                    before = 0.0
                    for time in instants(scene):
                        cost += clocked(partial(engine.mj_step, model, data, nstep=round((time - before) / step)))
                        engine.mj_kinematics(model, data)
                        links = [data.body(link.name) for link in scene.links]
                        seen[time] = [(link.xmat.reshape(3, 3).copy(), link.xpos.copy()) for link in links]
                        before = time
                    best = min(best, cost)
                    if best > LONG:
                        break
                noslip = ", noslip" if spec.option.noslip_iterations else ""
                yield _row(scene, f"MuJoCo, {softness}{noslip}, {scheme}", f"step={step!r}", seen.__getitem__, best)


# Drake's point contact has one point for two boxes that are pressed on each other; so the cube is compliant and the pads are rigid, as hydroelastic
# contact requires.
_DRAKE = '<drake:proximity_properties>{how}<drake:mu_static value="{mu!r}"/><drake:mu_dynamic value="{mu!r}"/></drake:proximity_properties>'
_SOFT = (
    '<drake:compliant_hydroelastic/><drake:hydroelastic_modulus value="1e8"/><drake:mesh_resolution_hint value="0.01"/>'
)


def drake(scene: Scene) -> Iterator[Measured]:
    """Drake's discrete plant: feet by point contact, the box by hydroelastic contact; motors inside of its solver."""
    from pydrake.geometry import HalfSpace
    from pydrake.math import RigidTransform
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
    from pydrake.multibody.tree import PdControllerGains
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    for approximation in ("lagged", "sap"):
        for step in STEPS:
            builder = DiagramBuilder()
            config = MultibodyPlantConfig(
                time_step=step,
                contact_model="point" if scene.floor else "hydroelastic_with_fallback",
                discrete_contact_approximation=approximation,
            )
            plant, _ = AddMultibodyPlant(config, builder)
            plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -GRAVITY])
            models = []
            for tree in scene.trees():
                soft = scene.links[tree[0]].kind == "floating" and not scene.floor
                how = "" if scene.floor else _SOFT if soft else "<drake:rigid_hydroelastic/>"
                text = urdf(scene, tree, _DRAKE.format(how=how, mu=scene.friction))
                text = text.replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" ', 1)
                models += Parser(plant).AddModelsFromString(text, "urdf")
            if scene.floor:
                friction = CoulombFriction(scene.friction, scene.friction)
                plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", friction)
            for link in scene.links:
                if link.kind != "floating":
                    motor = plant.AddJointActuator(f"{link.name}_motor", plant.GetJointByName(f"{link.name}_joint"))
                    if scene.stiffness:
                        motor.set_controller_gains(PdControllerGains(p=scene.stiffness, d=scene.damping))
            plant.Finalize()
            diagram = builder.Build()
            best, seen = math.inf, {}
            for _ in range(REPEATS):
                simulator = Simulator(diagram)
                context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
                for link in scene.links:
                    if link.kind == "floating":
                        body = plant.GetBodyByName(link.name)
                        plant.SetFloatingBaseBodyPoseInWorldFrame(context, body, RigidTransform(np.array(link.place)))
                for model in models:
                    count = plant.num_actuators(model)
                    if count and scene.stiffness:
                        wanted = np.repeat([scene.target, 0.0], count)
                        plant.get_desired_state_input_port(model).FixValue(context, wanted)
                    elif count:
                        plant.get_actuation_input_port(model).FixValue(context, np.full(count, scene.effort))
                simulator.Initialize()
                cost = 0.0
                for time in instants(scene):
                    cost += clocked(partial(simulator.AdvanceTo, time))
                    poses = [plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(link.name)) for link in scene.links]
                    seen[time] = [(pose.rotation().matrix(), pose.translation()) for pose in poses]
                best = min(best, cost)
                if best > LONG:
                    break
            contact = "point" if scene.floor else "hydroelastic"
            yield _row(scene, f"Drake, {contact}, {approximation}", f"step={step!r}", seen.__getitem__, best)


def _aligned(axis: np.ndarray) -> np.ndarray:
    """A rotation whose first column is the axis."""
    second = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    second /= np.linalg.norm(second)
    return np.column_stack([axis, second, np.cross(axis, second)])


def _rapier_document(scene: Scene) -> dict:
    """The scene with every frame moved to the centre of mass and turned into the principal axes at the start."""
    bodies, placed = [], []
    for link in scene.links:
        turn, at = placed[link.parent] if link.parent >= 0 else (np.eye(3), np.zeros(3))
        at, turn = at + turn @ link.place, turn @ turned(link.pitch)
        placed.append((turn, at))
        moments, axes = np.linalg.eigh(np.array(link.inertia))
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        align, center = _aligned(np.array(link.axis)), np.array(link.center)
        above = np.array(scene.links[link.parent].center) if link.parent >= 0 else np.zeros(3)
        motor = {"stiffness": scene.stiffness, "damping": scene.damping, "target": scene.target}
        is_pushed = bool(scene.effort) and link.kind == "prismatic"
        shape = link.shape and {
            "at": (np.array(link.shape.at) - center).tolist(),
            "quaternion": [1.0, 0.0, 0.0, 0.0],
            "radius": link.shape.radius,
            "half": link.shape.half,
        }
        bodies.append(
            {
                "parent": link.parent,
                "kind": link.kind,
                "mass": link.mass,
                "principal_moments": moments.tolist(),
                "principal_frame": quaternion(axes).tolist(),
                "origin": (at + turn @ center).tolist(),
                "quaternion": quaternion(turn).tolist(),
                "linear_velocity": [0.0] * 3,
                "angular_velocity": [0.0] * 3,
                "joint_on_parent": {
                    "position": (np.array(link.place) - above).tolist(),
                    "quaternion": quaternion(turned(link.pitch) @ align).tolist(),
                },
                "joint_on_body": {"position": (-center).tolist(), "quaternion": quaternion(align).tolist()},
                "position": 0.0,
                "velocity": 0.0,
                "motor": motor if scene.stiffness and link.kind != "floating" else None,
                "force": (scene.effort * (turn @ link.axis)).tolist() if is_pushed else [0.0] * 3,
                "shape": shape,
            }
        )
    document = {"duration": scene.duration, "gravity": [0.0, 0.0, -GRAVITY], "bodies": bodies}
    return {**document, "friction": scene.friction, "floor": scene.floor, "instants": instants(scene)}


def rapier(scene: Scene, folder: Path) -> Iterator[Measured]:
    """Rapier's multibody joints with its default four iterations of the solver and with fifty, by the small program in `rapier/`."""
    file = folder / f"{scene.name}.json"
    file.write_text(json.dumps(_rapier_document(scene)))
    for iterations in (4, 50):
        for step in STEPS:
            best, seen = math.inf, {}
            for _ in range(REPEATS):
                command = [str(RAPIER), str(file), str(round(scene.duration / step)), str(iterations)]
                found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
                best = min(best, found["cpu_seconds"])
                for time, places in zip(instants(scene), found["places"], strict=True):
                    turns = [rotation_matrix(np.array(place["quaternion"], dtype=float)) for place in places]
                    middles = [np.array(place["origin"], dtype=float) for place in places]
                    centers = [np.array(link.center) for link in scene.links]
                    seen[time] = [(t, m - t @ c) for t, m, c in zip(turns, middles, centers, strict=True)]
                if best > LONG:
                    break
            yield _row(scene, f"Rapier, {iterations} iterations", f"step={step!r}", seen.__getitem__, best)


def ours(program: str, scene: Scene, folder: Path) -> Iterator[Measured]:
    """Our own program; `solve_cpu_seconds`, and the whole process, of runs without a log. Places are from the log of one more."""
    text = f"[scene]\nname = {scene.name!r}\ngravity = [0, 0, {-GRAVITY}]\n"
    for tree in scene.trees():
        root = scene.links[tree[0]]
        (folder / f"{root.name}.urdf").write_text(urdf(scene, tree))
        text += f'[[robot]]\nname = "{root.name}"\nurdf = "{root.name}.urdf"\n'
        if root.kind == "floating":
            text += f'base = "floating"\npose = {{ position = {list(root.place)} }}\n'
    prefix = len(scene.trees()) > 1
    for link in scene.links:
        if link.kind != "floating":
            joint = f"{link.name}/{link.name}_joint" if prefix else f"{link.name}_joint"
            motor = f'kind = "position"\ntarget = {scene.target!r}\nkp = {scene.stiffness!r}\nkd = {scene.damping!r}\n'
            text += f'[[motor]]\njoint = "{joint}"\n'
            text += motor if scene.stiffness else f'kind = "effort"\ntarget = {scene.effort!r}\n'
    text += '[[obstacle]]\nname = "floor"\nshape = { type = "half_space" }\n' if scene.floor else ""
    text += f'[contact]\npairs = "{"environment" if scene.floor else "all"}"\nfriction = {scene.friction!r}\n'
    file, log = folder / f"{scene.name}.toml", folder / f"{scene.name}.mcap"
    file.write_text(text)

    def run(words: list[str]) -> str:
        ended = subprocess.run([program, *words], capture_output=True, text=True, check=False, timeout=PATIENCE)
        if ended.returncode != 0:
            raise catena.CatenaError(ended.stderr.strip() or f"catena ended with {ended.returncode}")
        return ended.stdout

    def at(time: float) -> Places:
        links = json.loads(run(["inspect", str(log), "--at", repr(time), "--json"]))["links"]
        own = [links[f"{link.name}/{link.name}" if prefix else link.name] for link in scene.links]
        return [(rotation_matrix(np.array(link["orientation"])), np.array(link["position"])) for link in own]

    for exponent in (3, 6, 9):
        words = ["simulate", str(file), "--duration", repr(scene.duration), "--tolerance", f"1e-{exponent}"]
        solve, process = math.inf, math.inf
        try:
            for _ in range(REPEATS):
                report = json.loads(run([*words, "--no-log", "--json"]))
                solve, process = min(solve, report["solve_cpu_seconds"]), min(process, report["cpu_seconds"])
        except subprocess.TimeoutExpired:
            setting = f"tolerance=1e-{exponent}, broken off"
            yield Measured(scene.name, "catena", setting, math.inf, math.inf, math.inf, math.inf)
            return
        run([*words, "--quiet", "-o", str(log), "--rate", "1"])
        for method, cost in (("catena", solve), ("catena, whole process", process)):
            yield _row(scene, method, f"tolerance=1e-{exponent}", at, cost)
