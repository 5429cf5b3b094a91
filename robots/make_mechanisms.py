#!/usr/bin/env python3
"""Writes the closed mechanisms of this folder that are too long or too exact to write by hand: a scene and its URDF.

    python3 robots/make_mechanisms.py four_bar --count 40     robots/four_bar_40.toml, robots/parts/four_bar_40.urdf
    python3 robots/make_mechanisms.py four_bar --count 40 --tree path --into /tmp      the same row on another spanning tree
    python3 robots/make_mechanisms.py scissors --count 40 --tree rails --into /tmp
    python3 robots/make_mechanisms.py ring --count 100
    python3 robots/make_mechanisms.py strandbeest
    python3 robots/make_mechanisms.py stewart

They move in the plane of x and z, with hinges about y, and are assembled at zero displacement unless the scene says
otherwise; every link frame is then parallel to the world's.
"""

import argparse
import math
import pathlib

FOLDER = pathlib.Path(__file__).parent
COLOURS = {
    "orange": "0.93 0.49 0.14 1",
    "blue": "0.16 0.42 0.72 1",
    "green": "0.27 0.6 0.35 1",
    "dark": "0.18 0.19 0.22 1",
    "steel": "0.55 0.58 0.62 1",
}


def number(value):
    """Seventeen digits: what is closed stays closed."""
    text = f"{value:.17g}"
    return text if float(text) != float(f"{value:.15g}") else f"{value:.15g}"


def numbers(*values):
    return " ".join(number(value + 0.0) for value in values)


def listed(values):
    return "[" + ", ".join(number(value + 0.0) for value in values) + "]"


class Robot:
    """A URDF being written."""

    def __init__(self, name, comment):
        colours = "".join(f'  <material name="{name}"><color rgba="{rgba}"/></material>\n' for name, rgba in COLOURS.items())
        self.name = name
        self.text = f'<?xml version="1.0"?>\n<!--\n{comment}\n-->\n<robot name="{name}">\n{colours}\n  <link name="base"/>\n'

    def rods(self, name, rods, colour, thickness):
        """A link made of straight rods (start, end, mass) with points (x, z): thin across, so that I = m l^2/12."""
        mass = sum(rod[2] for rod in rods)
        centre = [sum(m * (a[k] + b[k]) / 2 for a, b, m in rods) / mass for k in (0, 1)]
        xx = zz = xz = 0.0
        for a, b, m in rods:
            ends = [[p[k] - centre[k] for k in (0, 1)] for p in (a, b)]
            # Second moments of a line: m/6 (2 a a + 2 b b + a b + b a).
            second = lambda i, j: m / 6 * (2 * ends[0][i] * ends[0][j] + 2 * ends[1][i] * ends[1][j]
                                           + ends[0][i] * ends[1][j] + ends[1][i] * ends[0][j])
            # A little thickness about every axis, except across the plane of motion.
            xx, zz, xz = xx + second(0, 0), zz + second(1, 1), xz + second(0, 1)
        thin = mass * thickness**2 / 12
        visuals = ""
        for a, b, _ in rods:
            length, pitch = math.dist(a, b), math.atan2(b[0] - a[0], b[1] - a[1])
            visuals += (f'    <visual><origin xyz="{(a[0] + b[0]) / 2:.6g} 0 {(a[1] + b[1]) / 2:.6g}" rpy="0 {pitch:.6g} 0"/><geometry>'
                        f'<box size="{thickness:.3g} {thickness:.3g} {length:.6g}"/></geometry><material name="{colour}"/></visual>\n')
        self.text += f"""
  <link name="{name}">
    <inertial>
      <origin xyz="{numbers(centre[0], 0, centre[1])}" rpy="0 0 0"/>
      <mass value="{number(mass)}"/>
      <inertia ixx="{number(zz + thin)}" ixy="0" ixz="{number(-xz)}" iyy="{number(xx + zz)}" iyz="0" izz="{number(xx + thin)}"/>
    </inertial>
{visuals}  </link>
"""

    def hinge(self, name, parent, child, place, axis="0 1 0"):
        self.text += f"""  <joint name="{name}" type="continuous">
    <origin xyz="{numbers(place[0], 0, place[1])}" rpy="0 0 0"/>
    <parent link="{parent}"/>
    <child link="{child}"/>
    <axis xyz="{axis}"/>
  </joint>
"""

    def write(self):
        path = FOLDER / "parts" / f"{self.name}.urdf"
        path.write_text(self.text + "</robot>\n")


def loop(name, kind, link_a, place_a, link_b, place_b, axis=None):
    ends = []
    for key, link, place in (("a", link_a, place_a), ("b", link_b, place_b)):
        direction = f", axis = {axis}" if axis else ""
        ends.append(f'{key} = {{ link = "{link}", position = {listed(place)}{direction} }}')
    return f'\n[[loop]]\nname = "{name}"\ntype = "{kind}"\n' + "\n".join(ends) + "\n"


def four_bar(count, tree):
    """A02 of the IFToMM library: `count` parallelograms side by side, on a spanning tree.

    row      every crank stands on the ground and carries a coupler, whose end is a loop
    path     couplers hang on each other, cranks on couplers, and each crank but the first is pinned to the ground by a loop
    snake    crank, coupler, crank, coupler: one branch, pinned to the ground by loops
    """
    name = f"four_bar_{count}" + ("" if tree == "row" else f"_{tree}")
    robot = Robot(name, f"  The tree of robots/{name}.toml, written by make_mechanisms.py.\n"
                        "  Inertia: thin uniform rods, m l^2/12 about the hinges; the little along them takes no part in the motion.")
    ahead, loops, rates = "0 -1 0", "", {"crank0": -1.0}
    for i in range(count + 1):
        hangs = i > 0 and tree != "row"
        # A crank that hangs has its frame at its upper end.
        robot.rods(f"crank{i}", [((0, 0), (0, -1 if hangs else 1), 1.0)], "orange", 0.04)
        if hangs:
            robot.hinge(f"crank{i}", f"coupler{i - 1}", f"crank{i}", (1, 0), ahead)
            loops += loop(f"closure{i - 1}", "revolute", f"crank{i}", (0, 0, -1), "world", (i, 0, 0), "[0, 1, 0]")
        else:
            robot.hinge(f"crank{i}", "base", f"crank{i}", (i, 0), ahead)
            if i > 0:
                loops += loop(f"closure{i - 1}", "revolute", f"coupler{i - 1}", (1, 0, 0), f"crank{i}", (0, 0, 1), "[0, 1, 0]")
        rates[f"crank{i}"] = -1.0
        if i < count:
            robot.rods(f"coupler{i}", [((0, 0), (1, 0), 1.0)], "blue", 0.04)
            on_coupler = tree == "path" and i > 0
            place = (1, 0) if on_coupler else (0, 0) if hangs else (0, 1)
            robot.hinge(f"coupler{i}", f"coupler{i - 1}" if on_coupler else f"crank{i}", f"coupler{i}", place, ahead)
            rates[f"coupler{i}"] = 0.0 if on_coupler else 1.0
    robot.write()
    velocities = [f"{joint} = {rate}" for kind in ("crank", "coupler") for joint, rate in rates.items() if joint.startswith(kind)]
    command = f"four_bar --count {count}" + ("" if tree == "row" else f" --tree {tree}")
    plural = "" if count == 1 else "s"
    (FOLDER / f"{name}.toml").write_text(f"""# N-four-bar mechanism, N = {count}: {count} parallelogram{plural} of {2 * count + 1} uniform rods (1 m, 1 kg) that pass singular positions.
# Problem A02 of the IFToMM benchmark library: the cranks start upright, their tips at 1 m/s.
#
# Run:  catena simulate robots/{name}.toml
# Look: each time the rods lie in one line the mechanism could leave the parallelogram; inertia alone keeps it on.
# Made by make_mechanisms.py {command}.
[scene]
name = "{name}"

[[robot]]
name = "bars"
urdf = "parts/{name}.urdf"

[robot.velocities]
""" + "\n".join(velocities) + "\n" + loops + """
[simulation]
duration = 10.0
tolerance = 1e-6
""")


def scissors(count, tree):
    """`count` cells of crossed rods that hang by one corner: all hinges but one between neighbouring cells close loops, on a spanning tree.

    comb     every cell carries the next one by its left hinge, and its two rods are joined in the middle
    rails    two branches of rods, joined in the middle of the first cell alone
    snake    one branch, down one rail and up the other
    """
    name = f"scissors_{count}_{tree}"
    robot = Robot(name, f"  The tree of {name}.toml, written by make_mechanisms.py.\n  Inertia: thin uniform rods, m l^2/12 across.")
    across, down = math.cos(0.4), math.sin(0.4)
    ends, hinges = {"base": None}, [("top", "base", "falling0", (0, 0))]
    for i in range(count):
        ends[f"falling{i}"] = ((0, -i * down), (across, -(i + 1) * down))
        ends[f"rising{i}"] = ((across, -i * down), (0, -(i + 1) * down))
        if i > 0:
            hinges.append((f"left{i}", f"rising{i - 1}", f"falling{i}", (0, -i * down)))
            hinges.append((f"right{i}", f"falling{i - 1}", f"rising{i}", (across, -i * down)))
        hinges.append((f"middle{i}", f"falling{i}", f"rising{i}", (across / 2, -(i + 0.5) * down)))
    joined = {"comb": ("middle", "left"), "rails": ("left", "right", "middle0"), "snake": ("left", "right", f"middle{count - 1}")}[tree]
    in_tree = [hinge for hinge in hinges if hinge[0] == "top" or hinge[0].startswith(joined)]
    origin, waiting = {"base": (0, 0)}, ["base"]
    while waiting:
        parent = waiting.pop()
        for hinge, a, b, place in in_tree:
            child = {a: b, b: a}.get(parent)
            if child is None or child in origin:
                continue
            origin[child] = place
            local = [(x - place[0], z - place[1]) for x, z in ends[child]]
            robot.rods(child, [(local[0], local[1], 1.0)], "orange" if child.startswith("f") else "blue", 0.04)
            robot.hinge(hinge, parent, child, (place[0] - origin[parent][0], place[1] - origin[parent][1]), "0 -1 0")
            waiting.append(child)
    robot.write()
    at = lambda link, place: (place[0] - origin[link][0], 0, place[1] - origin[link][1])
    closed = [hinge for hinge in hinges if hinge not in in_tree]
    loops = "".join(loop(hinge, "revolute", a, at(a, place), b, at(b, place), "[0, 1, 0]") for hinge, a, b, place in closed)
    (FOLDER / f"{name}.toml").write_text(f"""# A ladder of {count} cells of crossed rods (1 m, 1 kg) that hangs by one corner, swings and folds.
#
# Run:  catena simulate robots/{name}.toml
# Look: the same motion, in the same time, whichever hinges are loops.
# Made by make_mechanisms.py scissors --count {count} --tree {tree}.
[scene]
name = "{name}"

[[robot]]
name = "rods"
urdf = "parts/{name}.urdf"

[robot.velocities]
top = 0.5
{loops}
[simulation]
duration = 2.0
tolerance = 1e-6
""")


def ring(count):
    """A closed chain that hangs from one hinge and falls together."""
    name = f"ring_{count}"
    robot = Robot(name, f"  The tree of robots/{name}.toml, written by make_mechanisms.py.\n"
                        "  Inertia: thin uniform rods, m l^2/12 across.")
    length = 0.05
    for i in range(1, count + 1):
        robot.rods(f"link{i}", [((0, 0), (length, 0), 0.05)], "orange" if i % 2 else "blue", 0.01)
        parent, place = ("base", (0, 0)) if i == 1 else (f"link{i - 1}", (length, 0))
        robot.hinge(f"joint{i}", parent, f"link{i}", place)
    robot.write()
    # The first link hangs half a corner from level, so that the ring is symmetric below its hinge.
    turn = 2 * math.pi / count
    positions = [f"joint{i} = {number(turn / 2 if i == 1 else turn)}" for i in range(1, count + 1)]
    (FOLDER / f"{name}.toml").write_text(f"""# A closed chain of {count} links (5 cm, 50 g), one long loop: a regular polygon that hangs from its topmost hinge and collapses.
#
# Run:  catena simulate robots/{name}.toml
# Look: the ring stays closed to rounding, although {count} joints lie between the two ends of the loop.
# Made by make_mechanisms.py ring --count {count}.
[scene]
name = "{name}"

[[robot]]
name = "chain"
urdf = "parts/{name}.urdf"

[robot.positions]
""" + "\n".join(positions) + "\n" + loop("closure", "revolute", f"link{count}", (length, 0, 0), "world", (0, 0, 0), "[0, 1, 0]")
        + """
[simulation]
duration = 0.5
tolerance = 1e-6
""")


def apex(p, q, to_p, to_q, side):
    """The point at the given distances from p and q; to the left of the way from p to q if side is 1, else to the right."""
    d = math.dist(p, q)
    along = (to_p**2 - to_q**2 + d**2) / (2 * d)
    across = side * math.sqrt(to_p**2 - along**2)
    x, z = (q[0] - p[0]) / d, (q[1] - p[1]) / d
    return (p[0] + along * x - across * z, p[1] + along * z + across * x)


def strandbeest():
    """One leg of Theo Jansen's beach animal, with his eleven lengths in centimetres."""
    a, b, c, d, e, f, g, h, i, j, k, l, m = (
        0.01 * n for n in (38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 7.8, 15.0))
    crank, pivot = (0.0, 0.0), (-a, -l)
    pin = (m, 0.0)
    top = apex(pivot, pin, b, j, 1)
    back = apex(pivot, top, d, e, 1)
    low = apex(pivot, pin, c, k, -1)
    knee = apex(back, low, f, g, -1)
    foot = apex(knee, low, h, i, -1)
    robot = Robot("strandbeest_leg", "  The tree of robots/strandbeest_leg.toml, written by make_mechanisms.py.\n"
                                     "  Inertia: thin tubes of 0.4 kg/m, m l^2/12 across, put together.")
    members = [
        # link, parent, hinge, rods, colour
        ("crank", "base", crank, [(crank, pin)], "dark"),
        ("upper_rod", "crank", pin, [(pin, top)], "steel"),
        ("lower_rod", "crank", pin, [(pin, low)], "steel"),
        ("rocker", "base", pivot, [(pivot, top), (top, back), (back, pivot)], "orange"),
        ("link", "base", pivot, [(pivot, low)], "blue"),
        ("hanger", "rocker", back, [(back, knee)], "blue"),
        ("shank", "link", low, [(low, knee), (knee, foot), (foot, low)], "green"),
    ]
    origin = {"base": (0.0, 0.0)}
    for name, parent, place, rods, colour in members:
        origin[name] = place
        local = lambda p: (p[0] - place[0], p[1] - place[1])
        robot.rods(name, [(local(p), local(q), 0.4 * math.dist(p, q)) for p, q in rods], colour, 0.01)
        robot.hinge(f"{name}_hinge", parent, name, [place[n] - origin[parent][n] for n in (0, 1)])
    robot.write()
    in_link = lambda name, p: (p[0] - origin[name][0], 0.0, p[1] - origin[name][1])
    closures = [("top", "upper_rod", "rocker", top), ("low", "lower_rod", "link", low), ("knee", "hanger", "shank", knee)]
    (FOLDER / "strandbeest_leg.toml").write_text("""# One leg of Theo Jansen's strandbeest: seven links, three loops, one degree of freedom, with his eleven lengths in centimetres.
#
# Run:  catena simulate robots/strandbeest_leg.toml
# Look: a constant torque against a damper turns the crank; the foot draws the flat-bottomed path that it is known for.
# Made by make_mechanisms.py strandbeest.
[scene]
name = "strandbeest_leg"

[[robot]]
name = "leg"
urdf = "parts/strandbeest_leg.urdf"
""" + "".join(loop(n, "revolute", p, in_link(p, at), q, in_link(q, at), "[0, 1, 0]") for n, p, q, at in closures) + """
[[load]]
joint = "crank_hinge"
effort = 1.5

[[spring]]
name = "brake"
joint = "crank_hinge"
damping = 0.3

[simulation]
duration = 5.0
tolerance = 1e-6
""")


def stewart():
    """A platform on six legs: seven robots of two URDFs."""
    angles = lambda spread: [math.radians(120 * (n // 2) + (spread if n % 2 else -spread)) for n in range(6)]
    low = [(0.5 * math.cos(t), 0.5 * math.sin(t), 0.0) for t in angles(12)]
    # Each leg goes to the platform's corner that is turned by 60 degrees less the spread.
    high = [(0.3 * math.cos(t), 0.3 * math.sin(t), 0.6) for t in angles(48)]
    retracted = 0.45
    text = ["""# A Stewart platform: a plate of 20 kg on six legs, each with two crossed hinges at the ground, a slide with a spring, and a
# ball joint at the plate. Seven robots of two URDFs, six loops, six degrees of freedom.
#
# Run:  catena simulate robots/stewart_platform.toml
# Look: the plate starts with a push and swings on its springs in all six directions; the dampers take the swing out.
# Made by make_mechanisms.py stewart.
[scene]
name = "stewart_platform"

[[robot]]
name = "plate"
urdf = "parts/stewart_plate.urdf"
base = "floating"
pose = { position = [0, 0, 0.6] }
"""]
    for n, (foot, head) in enumerate(zip(low, high), 1):
        x, y, z = (head[k] - foot[k] for k in range(3))
        length = math.sqrt(x * x + y * y + z * z)
        # Roll 0: the z axis of the leg is (sin p cos w, sin p sin w, cos p) for pitch p and yaw w.
        pitch, yaw = math.atan2(math.hypot(x, y), z), math.atan2(y, x)
        text.append(f"""
[[robot]]
name = "leg{n}"
urdf = "parts/stewart_leg.urdf"
pose = {{ position = {listed(foot)}, rpy = {listed((0.0, pitch, yaw))} }}
positions = {{ slide = {number(length - retracted)} }}
""")
    for n, head in enumerate(high, 1):
        text.append(loop(f"ball{n}", "spherical", f"leg{n}/rod", (0, 0, retracted), "plate/plate", (head[0], head[1], 0.0)))
        text.append(f"""
[[spring]]
name = "spring{n}"
joint = "leg{n}/slide"
stiffness = 5000.0
damping = 40.0
rest = {number(math.dist(low[n - 1], head) - retracted + 0.0075)}
""")
    text.append("""
# A steady sideways push at the edge of the plate.
[[load]]
link = "plate/plate"
position = [0.3, 0, 0]
force = [0, 30, 0]

[simulation]
duration = 5.0
tolerance = 1e-6
""")
    (FOLDER / "stewart_platform.toml").write_text("".join(text))


def main():
    parser = argparse.ArgumentParser(description="Writes closed mechanisms: a scene in this folder, its URDF in parts/.")
    parser.add_argument("mechanism", choices=["four_bar", "scissors", "ring", "strandbeest", "stewart"])
    parser.add_argument("--count", type=int, help="number of four-bars (default 1), of cells (default 10) or of links (default 100)")
    parser.add_argument("--tree", help="spanning tree: of four-bars row (default), path or snake, of scissors comb (default), rails or snake")
    parser.add_argument("--into", type=pathlib.Path, help="another folder")
    chosen = parser.parse_args()
    if chosen.into:
        global FOLDER
        FOLDER = chosen.into
        (FOLDER / "parts").mkdir(parents=True, exist_ok=True)
    if chosen.count is not None and chosen.count < (3 if chosen.mechanism == "ring" else 1):
        parser.error("too few")
    trees = {"four_bar": ["row", "path", "snake"], "scissors": ["comb", "rails", "snake"]}.get(chosen.mechanism, [None])
    tree = chosen.tree or trees[0]
    if tree not in trees:
        parser.error("no such tree")
    if chosen.mechanism == "four_bar":
        four_bar(chosen.count or 1, tree)
    elif chosen.mechanism == "scissors":
        scissors(chosen.count or 10, tree)
    elif chosen.mechanism == "ring":
        ring(chosen.count or 100)
    elif chosen.mechanism == "strandbeest":
        strandbeest()
    else:
        stewart()


if __name__ == "__main__":
    main()
