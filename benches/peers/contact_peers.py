"""The scenes of `contact_scenes.py` in MuJoCo, in Rapier and in our own program: where bodies end, and CPU time."""

from __future__ import annotations

import json
import math
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

import catena
from contact_scenes import Scene
from measure import clocked

REPEATS = 5
# Runs of more than LONG seconds are not repeated; a ladder of steps ends with the first of more than LONGEST.
LONG, LONGEST = 0.3, 8.0
STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)

RAPIER = Path(os.environ.get("RAPIER_CONTACTS", Path(__file__).parent / "rapier" / "target" / "release" / "contacts"))


@dataclass(frozen=True)
class Measured:
    """A row of the table; the cost is CPU time of the stepping loop, or of our whole process."""

    scene: str
    method: str
    setting: str
    error: float  # largest distance of a centre of mass from its exact place [m]
    cpu_seconds_per_simulated_second: float


def _row(scene: Scene, method: str, setting: str, places: np.ndarray, cost: float) -> Measured:
    distances = np.linalg.norm(places - np.array(scene.answer), axis=1)
    error = float(distances.max()) if np.isfinite(distances).all() else math.inf
    return Measured(scene.name, method, setting, error, cost / scene.duration)


def _text(numbers: tuple[float, ...]) -> str:
    return " ".join(map(repr, numbers))


# Name, time constant of contacts in steps (None: MuJoCo's default), damping ratio, noslip iterations.
SOFTNESS = (
    ("MuJoCo, default", None, 1.0, 0),
    ("MuJoCo, stiff", 2.0, 1.0, 0),
    ("MuJoCo, stiff, noslip", 2.0, 1.0, 10),
)


def mujoco(scene: Scene) -> Iterator[Measured]:
    """MuJoCo with implicitfast and the elliptic cone; with restitution, `stiff` has its damping ratio from it."""
    import mujoco as engine

    bodies = []
    for body in scene.bodies:
        size = f'type="sphere" size="{body.radius!r}"' if body.radius else f'type="box" size="{_text(body.half)}"'
        bodies.append(
            f'<body pos="{_text(body.position)}"><freejoint/><inertial pos="0 0 0" mass="{body.mass!r}" '
            f'diaginertia="{_text(body.inertia())}"/><geom {size} friction="{scene.friction!r}" condim="3"/></body>'
        )
    document = (
        f'<mujoco><option integrator="implicitfast" cone="elliptic" gravity="{_text(scene.gravity)}"/><worldbody>'
        f'<geom type="plane" size="0 0 1" friction="{scene.friction!r}" condim="3"/>{"".join(bodies)}'
        "</worldbody></mujoco>"
    )
    for name, constant, ratio, noslip in SOFTNESS:
        if noslip and not scene.friction:
            continue
        if scene.restitution:
            # A spring and damper of this ratio give back the fraction `restitution` of the speed; four steps resolve their motion.
            logarithm = math.log(scene.restitution)
            ratio = -logarithm / math.hypot(math.pi, logarithm)
            constant = constant and 4.0 / ratio
        for wanted in STEPS:
            count = round(scene.duration / wanted)
            spec = engine.MjSpec.from_string(document)
            spec.option.timestep, spec.option.noslip_iterations = scene.duration / count, noslip
            for geom in spec.geoms if constant else []:
                geom.solref = [constant * spec.option.timestep, ratio]
                geom.solimp = [0.9999, 0.9999, 0.001, 0.5, 2.0]
            model = spec.compile()
            best, places = math.inf, np.zeros(0)
            for _ in range(REPEATS):
                data = engine.MjData(model)
                for number, body in enumerate(scene.bodies):
                    data.qvel[6 * number : 6 * number + 6] = (*body.velocity, *body.spin)
                best = min(best, clocked(partial(engine.mj_step, model, data, nstep=count)))
                places = data.qpos.reshape(-1, 7)[:, :3].copy()
                if best > LONG:
                    break
            yield _row(scene, name, f"step={scene.duration / count!r}", places, best)
            if best > LONGEST:
                break


def rapier(scene: Scene, folder: Path) -> Iterator[Measured]:
    """Rapier with its default four iterations of the solver and with fifty, by the small program in `rapier/`."""
    file = folder / f"{scene.name}.json"
    bodies = [
        {
            "mass": body.mass,
            "inertia": body.inertia(),
            "half": body.half,
            "radius": body.radius,
            "position": body.position,
            "velocity": body.velocity,
            "spin": body.spin,
        }
        for body in scene.bodies
    ]
    document = {"duration": scene.duration, "gravity": scene.gravity, "friction": scene.friction}
    file.write_text(json.dumps({**document, "restitution": scene.restitution, "bodies": bodies}))
    for iterations in (4, 50):
        for wanted in STEPS:
            count, best, places = round(scene.duration / wanted), math.inf, np.zeros(0)
            for _ in range(REPEATS):
                command = [str(RAPIER), str(file), str(count), "1", str(iterations)]
                ended = subprocess.run(command, capture_output=True, text=True, check=True)
                found = json.loads(ended.stdout)
                best = min(best, found["cpu_seconds"])
                places = np.array(found["places"], dtype=float)
                if best > LONG:
                    break
            method = f"Rapier, {iterations} iterations"
            yield _row(scene, method, f"step={scene.duration / count!r}", places, best)
            if best > LONGEST:
                break


BODY = """<robot name="body"><link name="body"><inertial><mass value="{mass!r}"/>
<inertia ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{zz!r}"/></inertial>
<collision><geometry>{shape}</geometry></collision></link></robot>
"""


def write(scene: Scene, folder: Path) -> Path:
    """The file of a scene for our own program."""
    text = f"[scene]\nname = {scene.name!r}\ngravity = {list(scene.gravity)}\n"
    for number, body in enumerate(scene.bodies):
        shape = f'<sphere radius="{body.radius!r}"/>'
        if body.half:
            shape = f'<box size="{_text(tuple(2.0 * side for side in body.half))}"/>'
        xx, yy, zz = body.inertia()
        (folder / f"body{number}.urdf").write_text(BODY.format(mass=body.mass, xx=xx, yy=yy, zz=zz, shape=shape))
        text += f'[[robot]]\nname = "body{number}"\nurdf = "body{number}.urdf"\nbase = "floating"\n'
        text += f"pose = {{ position = {list(body.position)} }}\n"
        text += f"velocity = {{ linear = {list(body.velocity)}, angular = {list(body.spin)} }}\n"
    text += '[[obstacle]]\nname = "floor"\nshape = { type = "half_space" }\n'
    text += f'[contact]\npairs = "all"\nfriction = {scene.friction!r}\nrestitution = {scene.restitution!r}\n'
    file = folder / f"{scene.name}.toml"
    file.write_text(f"{text}[simulation]\nduration = {scene.duration!r}\n")
    return file


def _run(command: list[str]) -> tuple[np.ndarray, float, float]:
    """Where bodies end, in the order of the scene, and the least CPU times of the solver and of the process [s]."""
    solve, process, places = math.inf, math.inf, np.zeros(0)
    for _ in range(REPEATS):
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise catena.CatenaError(ended.stderr.strip() or f"catena ended with {ended.returncode}")
        report = json.loads(ended.stdout)
        solve, process = min(solve, report["solve_cpu_seconds"]), min(process, report["cpu_seconds"])
        places = np.array([link["center_of_mass"] for link in report["links"].values()])
        if process > LONG:
            break
    return places, solve, process


def answered(program: str, scene: Scene, folder: Path) -> Scene:
    """The scene with an answer: our own, at 1e-10 m, if there is no formula."""
    if scene.answer is not None:
        return scene
    places, *_ = _run([program, "simulate", str(write(scene, folder)), "--no-log", "--json", "--tolerance", "1e-10"])
    return replace(scene, answer=tuple(map(tuple, places)))


def ours(program: str, scene: Scene, folder: Path) -> Iterator[Measured]:
    """Our own program with tolerances from 1e-2 to 1e-12 m and with steps over events; `solve_cpu_seconds`, and the whole process."""
    command = [program, "simulate", str(write(scene, folder)), "--no-log", "--json"]
    for exponent in range(2, 13, 2):
        setting = f"1e-{exponent}"
        places, solve, process = _run([*command, "--tolerance", setting])
        yield _row(scene, "catena", f"tolerance={setting}", places, solve)
        yield _row(scene, "catena, whole process", f"tolerance={setting}", places, process)
    for step in STEPS:
        places, solve, _ = _run([*command, "--stages", "1", "--step", repr(step)])
        yield _row(scene, "catena, over events", f"step={step}", places, solve)
        if solve > LONGEST:
            break
