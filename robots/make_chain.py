#!/usr/bin/env python3
"""Writes the URDF of a chain of links to standard output.

    python3 robots/make_chain.py --links 10 > robots/chain_10.urdf
    python3 robots/make_chain.py --links 20 --tip-ratio 10000 --name heavy_tip_20 > heavy_tip_20.urdf

Each link is a uniform box of length l and square section (l/5)², stretched along x, with its joint at one end; the
joint axes repeat the pattern of --axes. Inertia of a box: m/12 (b² + c²). The chain hangs out level at zero displacement.
"""

import argparse

COLOURS = {"x": ("orange", "0.93 0.49 0.14 1"), "y": ("blue", "0.16 0.42 0.72 1"), "z": ("green", "0.27 0.6 0.35 1")}
AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def arguments():
    parser = argparse.ArgumentParser(description="Writes the URDF of a chain of links to standard output.")
    parser.add_argument("--links", type=int, default=10, help="number of links")
    parser.add_argument("--length", type=float, default=0.1, help="length of a link [m]")
    parser.add_argument("--mass", type=float, default=0.1, help="mass of the first link [kg]")
    parser.add_argument("--axes", default="yx", help="joint axes, repeated along the chain: letters x, y, z")
    parser.add_argument("--mass-ratio", type=float, default=1.0, help="mass of each link over that of the link before it")
    parser.add_argument("--tip-ratio", type=float, default=1.0, help="factor on the mass of the last link")
    parser.add_argument("--name", help="name of the robot (default chain_LINKS)")
    chosen = parser.parse_args()
    if chosen.links < 1 or min(chosen.length, chosen.mass, chosen.mass_ratio, chosen.tip_ratio) <= 0:
        parser.error("links, length, mass and ratios must be positive")
    if not chosen.axes or set(chosen.axes) - set(AXES):
        parser.error("axes must be letters x, y, z")
    return chosen


def number(value):
    return f"{value:.15g}"


def link(index, mass, length, colour):
    side = length / 5
    along, across = mass / 12 * 2 * side**2, mass / 12 * (length**2 + side**2)
    centre = f'<origin xyz="{number(length / 2)} 0 0" rpy="0 0 0"/>'
    return f"""  <link name="link{index}">
    <inertial>
      {centre}
      <mass value="{number(mass)}"/>
      <inertia ixx="{number(along)}" ixy="0" ixz="0" iyy="{number(across)}" iyz="0" izz="{number(across)}"/>
    </inertial>
    <visual>{centre}<geometry><box size="{number(0.94 * length)} {number(side)} {number(side)}"/></geometry><material name="{colour}"/></visual>
  </link>"""


def joint(index, axis, length):
    parent, place = ("base", 0) if index == 1 else (f"link{index - 1}", length)
    return f"""  <joint name="joint{index}" type="continuous">
    <origin xyz="{number(place)} 0 0" rpy="0 0 0"/>
    <parent link="{parent}"/>
    <child link="link{index}"/>
    <axis xyz="{AXES[axis]}"/>
  </joint>"""


def main():
    chosen = arguments()
    name = chosen.name or f"chain_{chosen.links}"
    side = number(chosen.length / 4)
    options = ", ".join(
        f"{option} {value}" for option, value in vars(chosen).items() if option != "name" and value is not None
    )
    print('<?xml version="1.0"?>')
    print(f"""<!--
  A chain of {chosen.links} links whose joint axes repeat "{chosen.axes}": what a solver pays per link, and what light twist
  joints or a heavy tip do to it.

  Run:    catena simulate robots/{name}.urdf
  Look:   the time per step in the report grows with the number of links and not with its square or cube.
  Made by make_chain.py ({options}).
  Inertia: uniform boxes of length l and section (l/5)^2, m/12 (b^2 + c^2).
-->""")
    print(f'<robot name="{name}">')
    for axis in sorted(set(chosen.axes)):
        colour, rgba = COLOURS[axis]
        print(f'  <material name="{colour}"><color rgba="{rgba}"/></material>')
    print('  <material name="dark"><color rgba="0.18 0.19 0.22 1"/></material>\n')
    print(f"""  <link name="base">
    <visual><geometry><box size="{side} {side} {side}"/></geometry><material name="dark"/></visual>
  </link>
""")
    for index in range(1, chosen.links + 1):
        axis = chosen.axes[(index - 1) % len(chosen.axes)]
        mass = chosen.mass * chosen.mass_ratio ** (index - 1)
        if index == chosen.links:
            mass *= chosen.tip_ratio
        print(link(index, mass, chosen.length, COLOURS[axis][0]))
        print(joint(index, axis, chosen.length))
        print()
    print("</robot>")


if __name__ == "__main__":
    main()
