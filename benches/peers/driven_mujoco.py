"""A robot of a URDF on a floor in MuJoCo, under a controller whose efforts are constant between its ticks."""

from __future__ import annotations

import re
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Ended:
    """The fastest of some runs: CPU time of the stepping loop a simulated second, deepest overlap at ends of steps (m), and the base (m)."""

    cpu_seconds: float
    overlap: float
    base: np.ndarray


class Engine:
    """The model, with its own contacts among its links and the default softness of contacts."""

    def __init__(
        self, urdf: Path, robots: Path, height: float, targets: dict[str, float], gains: tuple[float, float], friction: float
    ) -> None:
        import mujoco

        self.mujoco = mujoco
        spec = mujoco.MjSpec.from_string(self._text(urdf, robots))
        root = spec.worldbody.first_body()
        root.add_freejoint()
        root.pos = [0.0, 0.0, height]
        floor = spec.worldbody.add_geom()
        floor.type = mujoco.mjtGeom.mjGEOM_PLANE
        floor.size = [10.0, 10.0, 1.0]
        floor.friction = [friction, 0.005, 0.0001]
        self.model = spec.compile()
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.stiffness, self.damping = gains
        joints = [self.model.joint(name) for name in targets]
        self.places = np.array([joint.qposadr[0] for joint in joints])
        self.freedoms = np.array([joint.dofadr[0] for joint in joints])
        self.targets = np.array(list(targets.values()))
        # The largest efforts that the file gives joints.
        limits = np.array([self.model.jnt_actfrcrange[joint.id] for joint in joints])
        limited = np.array([self.model.jnt_actfrclimited[joint.id] for joint in joints], dtype=bool)
        self.bounds = np.where(limited[:, None], limits, [-np.inf, np.inf])

    @staticmethod
    def _text(urdf: Path, robots: Path) -> str:
        """The file without what is only drawn, and with the paths of its meshes."""
        text = urdf.read_text()
        for left_out in (r"<visual>.*?</visual>", r"<transmission.*?</transmission>"):
            text = re.sub(left_out, "", text, flags=re.DOTALL)
        package = str(robots.parents[1]) + "/"
        text = re.sub(r'filename="package://([^"]*)"', lambda found: f'filename="{package}{found.group(1)}"', text)
        compiler = '<mujoco><compiler strippath="false" discardvisual="true" fusestatic="false" balanceinertia="true"/></mujoco>'
        return re.sub(r"(<robot[^>]*>)", lambda found: found.group(1) + compiler, text, count=1)

    def run(self, duration: float, period: float, step: float, repeats: int) -> Ended:
        """Runs of this duration with this step (s); ticks are at the starts of steps where steps are longer than the period."""
        runs = [self._once(duration, period, step) for _ in range(repeats)]
        return min(runs, key=lambda run: run.cpu_seconds)

    def _once(self, duration: float, period: float, step: float) -> Ended:
        mujoco, model = self.mujoco, self.model
        model.opt.timestep = step
        data = mujoco.MjData(model)
        data.qpos[self.places] = self.targets
        ticks, substeps = (round(duration / period), round(period / step)) if step <= period else (round(duration / step), 1)
        deepest, begin = 0.0, time.process_time()
        for _ in range(ticks):
            errors = self.targets - data.qpos[self.places]
            efforts = self.stiffness * errors - self.damping * data.qvel[self.freedoms]
            data.qfrc_applied[self.freedoms] = np.clip(efforts, *self.bounds.T)
            mujoco.mj_step(model, data, substeps)
            if data.ncon:
                deepest = max(deepest, -float(data.contact.dist.min()))
        spent = time.process_time() - begin
        return Ended(spent / duration, deepest, data.qpos[:3].copy())
