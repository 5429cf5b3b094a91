"""Crowds of contacts, against MuJoCo: grids of boxes and balls that fall, on a floor and in a bin, a wall and dominoes.

    python crowds.py FOLDER [SCENE ...]     writes the scene files and models, runs both for 1 s, and prints CPU seconds
    python crowds.py FOLDER --write         only writes them
"""

import json
import math
import pathlib
import random
import subprocess
import sys
import time

EDGE = 0.2
"""Edge of a box and diameter of a ball (m)."""
SPACING = (0.23, 0.23, 0.25)
FRICTION = 0.5
CATENA = pathlib.Path(__file__).resolve().parents[2] / "target" / "release" / "catena"
LONGEST = 120
"""A run that takes longer is given up (s)."""


def body(shape, size, place, turn=(0, 0, 0), velocity=(0, 0, 0), density=1000.0):
    return {"shape": shape, "size": size, "place": place, "turn": turn, "velocity": velocity, "density": density}


def grid(shape, side, layers):
    """Bodies in layers of side × side, a little off their places."""
    numbers = random.Random(1)
    size = (EDGE, EDGE, EDGE) if shape == "box" else (EDGE / 2,)
    middle = (side - 1) / 2

    def off(most):
        return numbers.uniform(-most, most)

    found = []
    for number in range(layers * side * side):
        z, rest = divmod(number, side * side)
        y, x = divmod(rest, side)
        place = (SPACING[0] * (x - middle) + off(0.01), SPACING[1] * (y - middle) + off(0.01), 0.15 + SPACING[2] * z)
        found.append(body(shape, size, place, (off(0.045), off(0.045), off(0.045))))
    return found


def walls(side):
    """Four half spaces around a grid: their names, points and normals."""
    half = 0.5 * SPACING[0] * side + 0.05
    return [
        ("east", (half, 0, 0), (-1, 0, 0)),
        ("west", (-half, 0, 0), (1, 0, 0)),
        ("north", (0, half, 0), (0, -1, 0)),
        ("south", (0, -half, 0), (0, 1, 0)),
    ]


def bricks(wide, high):
    """A wall of bricks in bond."""
    size = (0.4, 0.2, 0.2)
    return [
        body("box", size, (0.4 * x + 0.2 * (z % 2) - 0.2 * wide, 0, 0.1 + 0.2 * z)) for z in range(high) for x in range(wide)
    ]


def dominoes(count):
    """A row of them, the first of which leans forward on its lower edge."""
    lean = 0.22
    place = (0.022, 0, 0.1 * math.cos(lean) + 0.01 * math.sin(lean))
    size = (0.02, 0.1, 0.2)
    return [body("box", size, place, (0, lean, 0))] + [body("box", size, (0.1 * x, 0, 0.1)) for x in range(1, count)]


BALL = body("sphere", (0.15,), (0.05, -0.9, 0.55), velocity=(0, 7, 0.5), density=3000.0)
"""It strikes a wall."""

SCENES = {
    "boxes8": (grid("box", 2, 2), []),
    "boxes27": (grid("box", 3, 3), []),
    "boxes64": (grid("box", 4, 4), []),
    "boxes125": (grid("box", 5, 5), []),
    "balls27": (grid("sphere", 3, 3), []),
    "bin_balls8": (grid("sphere", 2, 2), walls(2)),
    "bin_balls27": (grid("sphere", 3, 3), walls(3)),
    "bin_balls64": (grid("sphere", 4, 4), walls(4)),
    "heap300": (grid("sphere", 5, 12), walls(5)),
    "wall": (bricks(32, 8), []),
    "wall_struck": (bricks(3, 4) + [BALL], []),
    "dominoes": (dominoes(20), []),
}


def listed(values):
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def scene_file(name, bodies, sides):
    out = [f'[scene]\nname = "{name}"\n\n[contact]\npairs = "all"\nfriction = {FRICTION}\n']
    out.append('[[obstacle]]\nname = "floor"\nshape = { type = "half_space" }\n')
    for side, point, normal in sides:
        shape = f'{{ type = "half_space", normal = {listed(normal)} }}'
        out.append(f'[[obstacle]]\nname = "{side}"\nshape = {shape}\npose = {{ position = {listed(point)} }}\n')
    for number, one in enumerate(bodies):
        size = one["size"]
        own = f"size = {listed(size)}" if one["shape"] == "box" else f"radius = {size[0]}"
        shape = f'{{ type = "{one["shape"]}", {own} }}'
        pose = f"{{ position = {listed(one['place'])}, rpy = {listed(one['turn'])} }}"
        velocity = f"{{ linear = {listed(one['velocity'])} }}"
        head = f'[[body]]\nname = "b{number}"\nshape = {shape}\ndensity = {one["density"]}'
        out.append(f"{head}\npose = {pose}\nvelocity = {velocity}\n")
    return "\n".join(out)


def quaternion(turn):
    """Rotation about the axes of the world, x first, as w, x, y, z."""
    (a, p), (b, q), (c, r) = ((math.cos(angle / 2), math.sin(angle / 2)) for angle in turn)
    return (a * b * c + p * q * r, p * b * c - a * q * r, a * q * c + p * b * r, a * b * r - p * q * c)


def model(name, bodies, sides, step=0.002):
    def text(values):
        return " ".join(repr(float(value)) for value in values)

    out = [f'<mujoco model="{name}"><option timestep="{step}" integrator="implicitfast" cone="elliptic"/>']
    out.append(f'<size memory="500M"/><default><geom friction="{FRICTION} 0 0" condim="3"/></default><worldbody>')
    out.append('<geom type="plane" size="0 0 1"/>')
    for _, point, normal in sides:
        out.append(f'<geom type="plane" size="0 0 1" pos="{text(point)}" zaxis="{text(normal)}"/>')
    for one in bodies:
        shape = f'type="{one["shape"]}" size="{text(x / 2 if one["shape"] == "box" else x for x in one["size"])}"'
        pose = f'pos="{text(one["place"])}" quat="{text(quaternion(one["turn"]))}"'
        out.append(f'<body {pose}><freejoint/><geom {shape} density="{one["density"]}"/></body>')
    start = text(x for one in bodies for x in (*one["velocity"], 0, 0, 0))
    places = text(x for one in bodies for x in (*one["place"], *quaternion(one["turn"])))
    out.append(f'</worldbody><keyframe><key qpos="{places}" qvel="{start}"/></keyframe></mujoco>')
    return "\n".join(out)


def run_mujoco(path, duration):
    """CPU seconds, and the deepest overlap at the end (m)."""
    import mujoco

    loaded = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(loaded)
    mujoco.mj_resetDataKeyframe(loaded, data, 0)
    start = time.process_time()
    while data.time < duration:
        mujoco.mj_step(loaded, data)
    spent = time.process_time() - start
    return spent, max((-contact.dist for contact in data.contact), default=0.0)


def run_catena(path, duration):
    """The report, or nothing if it takes too long."""
    words = ["simulate", str(path), "--contact", "all", "--duration", str(duration), "--tolerance", "1e-3"]
    command = [str(CATENA), *words, "--no-log", "--quiet", "--json"]
    try:
        done = subprocess.run(command, capture_output=True, timeout=LONGEST, check=False)
        return json.loads(done.stdout)
    except (subprocess.TimeoutExpired, json.JSONDecodeError):
        return None


def main(folder, names, only_write):
    folder.mkdir(parents=True, exist_ok=True)
    print("scene         catena s/s   steps over events (s)   residual   overlap (m)   MuJoCo s/s   its overlap (m)")
    for name in names:
        bodies, sides = SCENES[name]
        (folder / f"{name}.toml").write_text(scene_file(name, bodies, sides))
        (folder / f"{name}.xml").write_text(model(name, bodies, sides))
        if only_write:
            continue
        spent, deepest = run_mujoco(folder / f"{name}.xml", 1.0)
        report = run_catena(folder / f"{name}.toml", 1.0)
        if report is None:
            own = f"> {LONGEST}"
        else:
            method, contact = report["method"], report["contact"]
            own = f"{report['cpu_seconds']:10.3f} {method['crowd']['time_share'] * report['duration']:10.2f} {method['crowd']['worst_residual']:22.1e}"
            own += f" {contact['max_penetration']:12.1e}"
        print(f"{name:13} {own}   {spent:8.3f}   {deepest:.1e}", flush=True)


if __name__ == "__main__":
    words = sys.argv[1:]
    if not words:
        sys.exit(__doc__)
    chosen = [word for word in words[1:] if not word.startswith("--")]
    main(pathlib.Path(words[0]), chosen or list(SCENES), "--write" in words)
