"""Pinocchio: its articulated-body algorithm under RK4 and under an adaptive DOP853.

Pinocchio brings no integrator. The loops here are Python, and Python would be most of what is measured; therefore two
costs of the same run are written:

- `…`: evaluations × the CPU time of one `aba` inside the library. That time comes from `abaInParallel` with one thread,
  which evaluates a whole batch of states (sampled along the run) in one call. Runge–Kutta's own vector operations are left
  out, which favours Pinocchio.
- `…-python`: the loop as it runs, Python included.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.integrate import DOP853

from measure import Run, Setting, clocked, steps_of
from scene import Scene, quaternion

METHODS = {"pinocchio-rk4": "step", "pinocchio-dop853": "tolerance"}
_ALIGNED = {
    "revolute": (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
    "prismatic": (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
}
_UNALIGNED = {"revolute": pin.JointModelRevoluteUnaligned, "prismatic": pin.JointModelPrismaticUnaligned}
_BATCH = 512
_BATCH_REPEATS = 7


def _joint_model(kind: str, axis: list[float]):
    """The cheapest joint model there is for an axis, as Pinocchio's own URDF reader chooses it."""
    if kind == "floating":
        return pin.JointModelFreeFlyer()
    for index in range(3):
        if axis[index] == 1.0:
            return _ALIGNED[kind][index]()
    return _UNALIGNED[kind](np.array(axis))


class Peer:
    """A scene in Pinocchio."""

    def __init__(self, scene: Scene):
        self.scene = scene
        model = pin.Model()
        model.gravity.linear = np.array(scene.gravity)
        self.joints: list[int] = []
        for index, body in enumerate(scene.bodies):
            parent = 0 if body.parent < 0 else self.joints[body.parent]
            place = pin.SE3(np.array(body.frame_rotation), np.array(body.frame_position))
            joint = model.addJoint(parent, _joint_model(body.kind, body.axis), place, f"joint_{index}")
            inertia = pin.Inertia(body.mass, np.array(body.center_of_mass), np.array(body.inertia))
            model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
            self.joints.append(joint)
        self.model, self.data = model, model.createData()
        self.effort = np.zeros(model.nv)
        self.evaluations = 0
        self.free = [
            (model.joints[joint].idx_q, model.joints[joint].idx_v)
            for joint, body in zip(self.joints, scene.bodies, strict=True)
            if body.kind == "floating"
        ]
        self.start = self._start()
        self.evaluation_seconds: float | None = None

    def _start(self) -> np.ndarray:
        model, scene = self.model, self.scene
        position, velocity = pin.neutral(model), np.zeros(model.nv)
        for joint, body, (rotation, origin), (linear, angular) in zip(
            self.joints, scene.bodies, scene.placements(), scene.twists(), strict=True
        ):
            q, v = model.joints[joint].idx_q, model.joints[joint].idx_v
            if body.kind == "floating":
                if body.parent >= 0:
                    raise NotImplementedError("floating joints inside the tree are not set up here")
                frame = np.array(body.frame_rotation)
                position[q : q + 3] = body.position[:3]
                position[q + 3 : q + 7] = quaternion(frame.T @ rotation)[[1, 2, 3, 0]]
                velocity[v : v + 3], velocity[v + 3 : v + 6] = rotation.T @ linear, rotation.T @ angular
            else:
                position[q], velocity[v] = body.position[0], body.velocity[0]
        return np.concatenate([position, velocity])

    def slope(self, _time: float, state: np.ndarray) -> np.ndarray:
        """The state's derivative: positions (quaternions among them) and velocities."""
        self.evaluations += 1
        position, velocity = state[: self.model.nq], state[self.model.nq :]
        slope = np.empty_like(state)
        if self.free:
            position = position.copy()
        else:
            slope[: self.model.nq] = velocity
        for q, v in self.free:
            quaternion_slice = slice(q + 3, q + 7)
            position[quaternion_slice] /= np.linalg.norm(position[quaternion_slice])
            x, y, z, w = position[quaternion_slice]
            vector, spin = np.array([x, y, z]), velocity[v + 3 : v + 6]
            rotation = pin.Quaternion(w, x, y, z).toRotationMatrix()
            slope[:q], slope[q : q + 3] = velocity[:v], rotation @ velocity[v : v + 3]
            slope[q + 3 : q + 6] = 0.5 * (w * spin + np.cross(vector, spin))
            slope[q + 6] = -0.5 * vector @ spin
            slope[q + 7 : self.model.nq] = velocity[v + 6 :]
        slope[self.model.nq :] = pin.aba(self.model, self.data, position, velocity, self.effort)
        return slope

    def run(self, method: str, setting: Setting) -> Run:
        """Integrates from the start to the end."""
        if self.evaluation_seconds is None:
            self.evaluation_seconds = self._evaluation_seconds()
        self.evaluations = 0
        result: dict[str, np.ndarray | int] = {}
        loop = self._rk4 if method == "pinocchio-rk4" else self._dop853
        cpu = clocked(lambda: result.update(zip(("state", "steps"), loop(setting), strict=True)))
        state = result["state"]
        position = state[: self.model.nq].copy()
        for q, _ in self.free:
            position[q + 3 : q + 7] /= np.linalg.norm(position[q + 3 : q + 7])
        pin.forwardKinematics(self.model, self.data, position)
        placements = [
            (self.data.oMi[joint].rotation.copy(), self.data.oMi[joint].translation.copy()) for joint in self.joints
        ]
        library = self.evaluations * self.evaluation_seconds
        return Run(library, placements, result["steps"], {f"{method}-python": cpu})

    def _rk4(self, setting: Setting) -> tuple[np.ndarray, int]:
        count, step = steps_of(self.scene, setting)
        state = self.start.copy()
        for _ in range(count):
            first = self.slope(0.0, state)
            second = self.slope(0.0, state + 0.5 * step * first)
            third = self.slope(0.0, state + 0.5 * step * second)
            fourth = self.slope(0.0, state + step * third)
            state = state + step / 6 * (first + 2 * (second + third) + fourth)
        return state, count

    def _dop853(self, setting: Setting) -> tuple[np.ndarray, int]:
        # SciPy refuses relative tolerances under 100 roundings of a double.
        relative = max(setting.value, 2.3e-14)
        solver = DOP853(self.slope, 0.0, self.start, self.scene.duration, rtol=relative, atol=setting.value)
        steps = 0
        while solver.status == "running":
            message = solver.step()
            steps += 1
            if message is not None:
                raise RuntimeError(message)
        return solver.y, steps

    def _evaluation_seconds(self) -> float:
        """CPU time of one evaluation inside the library, the fastest of several batches."""
        model = self.model
        state, states = self.start, []
        step = self.scene.duration / (20 * _BATCH)
        for _ in range(_BATCH):
            states.append(state)
            # Any states near the motion will do: the cost does not depend on them.
            state = state + step * self.slope(0.0, state)
        batch = np.array(states).T
        position = np.asfortranarray(batch[: model.nq])
        velocity = np.asfortranarray(batch[model.nq :])
        effort, out = np.zeros((model.nv, _BATCH), order="F"), np.zeros((model.nv, _BATCH), order="F")
        pool = pin.ModelPool(model, 1)
        times = [
            clocked(lambda: pin.abaInParallel(1, pool, position, velocity, effort, out)) for _ in range(_BATCH_REPEATS)
        ]
        return min(times) / _BATCH
