"""Random scenes of contact: runs one to four free bodies over a floor, a slope or boxes for a second, and lists what is wrong.

    python3 benches/random_scenes.py 200 400

A seed is always the same scene, which stays in its folder. Bodies are boxes, balls, cylinders, capsules and convex hulls, thrown, stacked or beside each
other; friction 0 to 1, restitution 0 to 0.8; tolerances of 1e-4 and 1e-6 m, or given steps. A row a scene is printed, and written to `rows.csv` of the
folder. What counts as wrong: a run that is not done within `--limit` seconds of CPU time, an energy error above 1e-6 of the largest kinetic energy, an
overlap deeper than 1e-11 m, a force more than 1e-9 N outside its cone. Needs Linux (`/proc`).
"""

import argparse
import csv
import json
import math
import os
import pathlib
import random
import resource
import signal
import subprocess
import time

DURATION = 1.0
# The exit code after Ctrl-C.
INTERRUPTED = 130
SHAPES = ["box", "ball", "cylinder", "capsule", "hull"]
COLUMNS = ["seed", "what", "cpu_s", "end_s", "steps", "first_order", "events", "energy", "overlap_m", "cone_n", "wrong"]


def hull(draw, half):
    """Corners of a random convex body in a box of these half edges (m), and no triangle without an area."""
    points = []
    for _ in range(12):
        point = [draw.gauss(0.0, 1.0) for _ in range(3)]
        length = math.sqrt(sum(x * x for x in point))
        points.append([h * x / length for h, x in zip(half, point)])
    faces = [(a, b, c) for a in range(4) for b in range(a) for c in range(b)]
    faces += [(0, 1, extra) for extra in range(4, len(points))]
    lines = ["v " + " ".join(f"{x:.12f}" for x in point) for point in points]
    return "\n".join(lines + ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]) + "\n"


def body(draw, kind, name, folder):
    """Writes a link of one shape; its half height where it stands and its half width (m)."""
    mass = math.exp(draw.uniform(math.log(0.2), math.log(5.0)))
    r, s, t = (draw.uniform(0.05, 0.3) for _ in range(3))
    if kind == "ball":
        shape, inertia, up, wide = f'<sphere radius="{r}"/>', [0.4 * mass * r * r] * 3, r, r
    elif kind in ("cylinder", "capsule"):
        # s is half the length, for a capsule half the length of its straight part. The inertia is that of a cylinder.
        across = mass * (r * r / 4 + s * s / 3)
        shape = f'<{kind} radius="{r}" length="{2 * s}"/>'
        inertia, up, wide = [across, across, mass * r * r / 2], s + (r if kind == "capsule" else 0.0), r
    else:
        inertia = [mass / 3 * (b * b + c * c) for b, c in ((s, t), (r, t), (r, s))]
        up, wide = t, math.hypot(r, s)
        shape = f'<box size="{2 * r} {2 * s} {2 * t}"/>'
        if kind == "hull":
            (folder / f"{name}.obj").write_text(hull(draw, (r, s, t)))
            shape, inertia = f'<mesh filename="{name}.obj"/>', [0.6 * x for x in inertia]
    moments = " ".join(f'{key}="{value}"' for key, value in zip(("ixx", "iyy", "izz"), inertia))
    link = (
        f'<robot name="{name}"><link name="{name}">'
        f'<inertial><mass value="{mass}"/><inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial>'
        f"<visual><geometry>{shape}</geometry></visual><collision><geometry>{shape}</geometry></collision>"
        "</link></robot>\n"
    )
    (folder / f"{name}.urdf").write_text(link)
    return up, wide


def ground(draw):
    """Obstacles: a floor, a slope, or a floor with boxes on it."""
    kind = draw.choice(["floor", "slope", "boxes"])
    normal = [0.0, 0.0, 1.0]
    if kind == "slope":
        tilt, turn = draw.uniform(0.02, 0.6), draw.uniform(-math.pi, math.pi)
        normal = [math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt)]
    text = f'[[obstacle]]\nname = "floor"\nshape = {{ type = "half_space", normal = {normal} }}\n'
    for number in range(3 if kind == "boxes" else 0):
        size = [draw.uniform(0.2, 1.0), draw.uniform(0.2, 1.0), draw.uniform(0.05, 0.4)]
        place = [draw.uniform(-1.0, 1.0), draw.uniform(-1.0, 1.0), 0.0]
        shape = f'{{ type = "box", size = {size} }}'
        pose = f"{{ position = {place}, rpy = [0, 0, {draw.uniform(-3, 3)}] }}"
        text += f'[[obstacle]]\nname = "block{number}"\nshape = {shape}\npose = {pose}\n'
    return kind, text


def scene(seed, folder):
    """Writes the scene of a seed; its path and a line about it."""
    draw = random.Random(seed)
    folder.mkdir(parents=True, exist_ok=True)
    count = draw.randint(1, 4)
    arrangement = draw.choice(["thrown", "stacked", "beside"])
    kinds = [draw.choice(SHAPES) for _ in range(count)]
    ground_kind, obstacles = ground(draw)
    friction = draw.choice([0.0, 0.1, 0.3, 0.5, 0.8, 1.0])
    restitution = draw.choice([0.0, 0.0, 0.3, 0.6, 0.8])
    accuracy = draw.choice(["tolerance = 1e-4", "tolerance = 1e-6", "stages = 5\nstep = 0.01"])
    text = f'[scene]\nname = "seed{seed}"\n'
    top = 0.0 if ground_kind == "floor" else 0.5
    right = 0.0
    for index, kind in enumerate(kinds):
        up, wide = body(draw, kind, f"{kind}{index}", folder)
        rpy, linear, angular = ([0.0] * 3 for _ in range(3))
        if arrangement == "thrown":
            place = [draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), 1.0 + 0.9 * index]
            rpy = [draw.uniform(-3, 3), draw.uniform(-1.5, 1.5), draw.uniform(-3, 3)]
            linear = [draw.uniform(-2, 2) for _ in range(3)]
            angular = [draw.uniform(-6, 6) for _ in range(3)]
        elif arrangement == "stacked":
            top += draw.choice([1e-3, 1e-2]) + up
            place = [draw.uniform(-0.03, 0.03), draw.uniform(-0.03, 0.03), top]
            top += up
        else:
            right += wide
            place = [right, draw.uniform(-0.05, 0.05), top + up + 1e-3]
            right += wide + draw.choice([1e-3, 0.05])
            linear = [draw.uniform(-1.0, 1.0), draw.uniform(-0.3, 0.3), 0.0]
        text += f'[[robot]]\nname = "b{index}"\nurdf = "{kind}{index}.urdf"\nbase = "floating"\n'
        text += f"pose = {{ position = {place}, rpy = {rpy} }}\n"
        text += f"velocity = {{ linear = {linear}, angular = {angular} }}\n"
    text += obstacles
    text += f'[contact]\npairs = "all"\nfriction = {friction}\nrestitution = {restitution}\n'
    text += f"[simulation]\nduration = {DURATION}\n{accuracy}\n"
    path = folder / "scene.toml"
    path.write_text(text)
    said = accuracy.replace("\n", " ")
    what = f"{' '.join(kinds)} {arrangement} {ground_kind} friction {friction} restitution {restitution} {said}"
    return path, what


def used_by(process):
    """CPU time of a process that runs (s)."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def run(command, limit):
    """The report of a run, its CPU time (s), and why it did not end well. What takes longer than the limit is interrupted, as by Ctrl-C."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    patience = limit
    while True:
        try:
            said, error = process.communicate(timeout=0.2)
            break
        except subprocess.TimeoutExpired:
            if used_by(process) > patience:
                # A run that does not heed it is killed.
                process.send_signal(signal.SIGINT if patience == limit else signal.SIGKILL)
                patience = limit + 5 if patience == limit else patience
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    wrong = {0: "", INTERRUPTED: "not done", -signal.SIGKILL: "killed"}.get(process.returncode)
    if wrong is None:
        wrong = f"exit {process.returncode}: {error.strip().splitlines()[-1]}"
    return json.loads(said) if said else None, used, wrong


def judge(report):
    """The figures of a report, and what is wrong with them."""
    energy = report["energy"]["max_relative_error"]
    overlap, cone = report["contact"]["max_penetration"], report["contact"]["max_cone_violation"]
    bounds = [("energy", energy, 1e-6), ("overlap", overlap, 1e-11), ("cone", cone, 1e-9)]
    return energy, overlap, cone, " ".join(name for name, value, bound in bounds if not value <= bound)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument("--catena", default="target/release/catena")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("random_scenes"))
    parser.add_argument("--limit", type=int, default=10, help="CPU time of a run (s)")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    with (options.folder / "rows.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(COLUMNS)
        for seed in range(options.first, options.last + 1):
            path, what = scene(seed, options.folder / str(seed))
            command = [options.catena, "simulate", str(path), "--no-log", "--json"]
            report, used, wrong = run(command, options.limit)
            row = [seed, what, f"{used:.2f}"] + [""] * 7 + [wrong]
            if report:
                steps, events = report["steps"], sum(report["events"]["counts"].values())
                figures = judge(report)
                row[3:10] = [f"{report['duration']:.4f}", steps, report["method"]["crowd"]["steps"], events]
                row[7:] = [f"{figure:.1e}" for figure in figures[:3]] + [" ".join([wrong, figures[3]]).strip()]
            rows.writerow(row)
            file.flush()
            print(*row, sep="  ", flush=True)


if __name__ == "__main__":
    main()
