"""Rapier (rapier3d-f64): reduced-coordinate multibody joints and impulse joints, by the small program in `rapier/`.

The program is found as `rapier/target/release/rapier-runner`, or where the variable RAPIER_RUNNER says.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from measure import Run, Setting, steps_of
from scene import Body, Scene, quaternion, rotation_matrix

_RUNNER = Path(
    os.environ.get("RAPIER_RUNNER", Path(__file__).parent / "rapier" / "target" / "release" / "rapier-runner")
)
if not _RUNNER.is_file():
    raise ImportError(
        "rapier-runner is not built: cargo build --release --manifest-path benches/peers/rapier/Cargo.toml"
    )

METHODS = {"rapier-multibody": "step", "rapier-impulse": "step"}


class Peer:
    """A scene in Rapier."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.folder = tempfile.TemporaryDirectory()
        self.file = Path(self.folder.name) / "scene.json"
        self.file.write_text(json.dumps(_document(scene)))

    def run(self, method: str, setting: Setting) -> Run:
        """One call of the program; it builds the world anew for every repetition."""
        steps, _ = steps_of(self.scene, setting)
        command = [str(_RUNNER), str(self.file), method.removeprefix("rapier-"), str(steps), "1"]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise RuntimeError(ended.stderr.strip().splitlines()[-1])
        answer = json.loads(ended.stdout)
        try:
            placements = [
                _placement(body, np.array(end["quaternion"], dtype=float), np.array(end["origin"], dtype=float))
                for body, end in zip(self.scene.bodies, answer["bodies"], strict=True)
            ]
        except (TypeError, ValueError) as error:
            raise RuntimeError("the end state is not finite") from error
        return Run(answer["cpu_seconds"], placements, steps)


def _placement(body: Body, turned: np.ndarray, center: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rotation = rotation_matrix(turned)
    return rotation, center - rotation @ np.array(body.center_of_mass)


def _document(scene: Scene) -> dict:
    """The scene with every frame moved to the centre of mass.

    Rapier moves the origin of a floating root by the velocity of its centre of mass, so they had better be the same.
    """
    bodies = []
    for body, (rotation, origin), (linear, angular) in zip(
        scene.bodies, scene.placements(), scene.twists(), strict=True
    ):
        if body.kind == "floating" and body.parent >= 0:
            raise NotImplementedError("floating joints inside the tree are not set up here")
        center = np.array(body.center_of_mass)
        parent_center = np.array(scene.bodies[body.parent].center_of_mass) if body.parent >= 0 else np.zeros(3)
        moments, axes = np.linalg.eigh(np.array(body.inertia))
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        align = _align_with_x(np.array(body.axis)) if body.kind != "floating" else np.eye(3)
        bodies.append(
            {
                "parent": body.parent,
                "kind": body.kind,
                "mass": body.mass,
                "principal_moments": moments.tolist(),
                "principal_frame": quaternion(axes).tolist(),
                "origin": (origin + rotation @ center).tolist(),
                "quaternion": quaternion(rotation).tolist(),
                "linear_velocity": (linear + np.cross(angular, rotation @ center)).tolist(),
                "angular_velocity": angular.tolist(),
                "joint_on_parent": {
                    "position": (np.array(body.frame_position) - parent_center).tolist(),
                    "quaternion": quaternion(np.array(body.frame_rotation) @ align).tolist(),
                },
                "joint_on_body": {"position": (-center).tolist(), "quaternion": quaternion(align).tolist()},
                "position": body.position[0],
                "velocity": body.velocity[0],
            }
        )
    return {"duration": scene.duration, "gravity": scene.gravity, "bodies": bodies}


def _align_with_x(axis: np.ndarray) -> np.ndarray:
    """A rotation whose first column is the axis."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    second = np.cross(helper, axis)
    second /= np.linalg.norm(second)
    return np.column_stack([axis, second, np.cross(axis, second)])
