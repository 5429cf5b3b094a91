"""MuJoCo: Euler (semi-implicit), implicitfast and RK4, stepped inside the library (`mj_step` with a number of steps)."""

from __future__ import annotations

import mujoco
import numpy as np

from measure import Run, Setting, clocked, steps_of
from scene import Scene, quaternion

METHODS = {"mujoco-euler": "step", "mujoco-implicitfast": "step", "mujoco-rk4": "step"}
_INTEGRATORS = {
    "mujoco-euler": mujoco.mjtIntegrator.mjINT_EULER,
    "mujoco-implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "mujoco-rk4": mujoco.mjtIntegrator.mjINT_RK4,
}
_JOINTS = {"revolute": "hinge", "prismatic": "slide", "floating": "free"}


def _words(numbers) -> str:
    return " ".join(repr(float(number)) for number in np.asarray(numbers).ravel())


def document(scene: Scene) -> str:
    """The scene as MuJoCo's own format; the bodies nest as the tree does."""
    children: dict[int, list[int]] = {}
    for index, body in enumerate(scene.bodies):
        children.setdefault(body.parent, []).append(index)
    lines: list[str] = []
    # An explicit stack: chains are longer than Python likes to recurse. A string on it is a closing tag.
    stack: list[int | str] = list(reversed(children.get(-1, [])))
    while stack:
        index = stack.pop()
        if isinstance(index, str):
            lines.append(index)
            continue
        body = scene.bodies[index]
        moments = np.array(body.inertia)
        upper = [moments[0, 0], moments[1, 1], moments[2, 2], moments[0, 1], moments[0, 2], moments[1, 2]]
        place = f'pos="{_words(body.frame_position)}" quat="{_words(quaternion(np.array(body.frame_rotation)))}"'
        axis = "" if body.kind == "floating" else f' axis="{_words(body.axis)}"'
        lines.append(f'<body name="{body.name}" {place}>')
        lines.append(f'<joint name="joint_{index}" type="{_JOINTS[body.kind]}"{axis}/>')
        lines.append(
            f'<inertial pos="{_words(body.center_of_mass)}" mass="{body.mass!r}" fullinertia="{_words(upper)}"/>'
        )
        stack.append("</body>")
        stack.extend(reversed(children.get(index, [])))
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{_words(scene.gravity)}"/>'
        f"<worldbody>{''.join(lines)}</worldbody></mujoco>"
    )


class Peer:
    """A scene in MuJoCo."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.model = mujoco.MjModel.from_xml_string(document(scene))
        # The scene has no contacts and no limits, so MuJoCo need not check for them.
        for flag in (mujoco.mjtDisableBit.mjDSBL_CONTACT, mujoco.mjtDisableBit.mjDSBL_CONSTRAINT):
            self.model.opt.disableflags |= int(flag)
        self.data = mujoco.MjData(self.model)
        self.bodies = [self.model.body(body.name).id for body in scene.bodies]

    def run(self, method: str, setting: Setting) -> Run:
        """The whole duration in one call."""
        model, data = self.model, self.data
        model.opt.integrator = int(_INTEGRATORS[method])
        count, model.opt.timestep = steps_of(self.scene, setting)
        mujoco.mj_resetData(model, data)
        placed = self.scene.placements()
        for index, body in enumerate(self.scene.bodies):
            joint = data.joint(f"joint_{index}")
            if body.kind == "floating":
                # MuJoCo wants the angular velocity of a free joint in the body's axes.
                rotation, origin = placed[index]
                linear, angular = self.scene.twists()[index]
                joint.qpos, joint.qvel = [*origin, *quaternion(rotation)], [*linear, *(rotation.T @ angular)]
            else:
                joint.qpos, joint.qvel = body.position, body.velocity
        cpu = clocked(lambda: mujoco.mj_step(model, data, count))
        mujoco.mj_kinematics(model, data)
        placements = [(data.xmat[body].reshape(3, 3).copy(), data.xpos[body].copy()) for body in self.bodies]
        return Run(cpu, placements, steps=count)
