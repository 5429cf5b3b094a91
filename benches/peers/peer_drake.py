"""Drake: the discrete MultibodyPlant and the continuous one under its error-controlled integrators.

The clock runs over one `Simulator.AdvanceTo`; plant, context and simulator are built before.
"""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

from measure import Run, Setting, clocked, steps_of
from scene import Scene

METHODS = {
    "drake-discrete": "step",
    "drake-runge-kutta3": "tolerance",
    "drake-runge-kutta5": "tolerance",
    "drake-radau3": "tolerance",
}
_SCHEMES = {
    "drake-runge-kutta3": "runge_kutta3",
    "drake-runge-kutta5": "runge_kutta5",
    "drake-radau3": "radau3",
}


class Peer:
    """A scene in Drake."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.continuous = self._plant(0.0)

    def _plant(self, time_step: float) -> MultibodyPlant:
        plant = MultibodyPlant(time_step)
        plant.mutable_gravity_field().set_gravity_vector(np.array(self.scene.gravity))
        if time_step > 0.0:
            # Outputs between steps are not used, so sampling them would waste time.
            plant.SetUseSampledOutputPorts(False)
        bodies = []
        for index, body in enumerate(self.scene.bodies):
            moments = np.array(body.inertia)
            about_center = RotationalInertia(
                moments[0, 0], moments[1, 1], moments[2, 2], moments[0, 1], moments[0, 2], moments[1, 2]
            )
            inertia = SpatialInertia.MakeFromCentralInertia(body.mass, np.array(body.center_of_mass), about_center)
            rigid = plant.AddRigidBody(body.name, inertia)
            bodies.append(rigid)
            parent = plant.world_body() if body.parent < 0 else bodies[body.parent]
            place = RigidTransform(RotationMatrix(np.array(body.frame_rotation)), np.array(body.frame_position))
            if body.kind == "floating":
                if body.parent >= 0:
                    raise NotImplementedError("floating joints inside the tree are not set up here")
                continue  # a body without a joint floats
            frame = plant.AddFrame(FixedOffsetFrame(f"place_{index}", parent.body_frame(), place))
            joint = RevoluteJoint if body.kind == "revolute" else PrismaticJoint
            plant.AddJoint(joint(f"joint_{index}", frame, rigid.body_frame(), np.array(body.axis)))
        plant.Finalize()
        return plant

    def _set_start(self, plant: MultibodyPlant, context) -> None:
        rows = zip(self.scene.bodies, self.scene.placements(), self.scene.twists(), strict=True)
        for index, (body, (rotation, origin), (linear, angular)) in enumerate(rows):
            if body.kind == "floating":
                rigid = plant.GetBodyByName(body.name)
                plant.SetFreeBodyPose(context, rigid, RigidTransform(RotationMatrix(rotation), origin))
                plant.SetFreeBodySpatialVelocity(context, rigid, SpatialVelocity(angular, linear))
                continue
            joint = plant.GetJointByName(f"joint_{index}")
            if body.kind == "revolute":
                joint.set_angle(context, body.position[0])
                joint.set_angular_rate(context, body.velocity[0])
            else:
                joint.set_translation(context, body.position[0])
                joint.set_translation_rate(context, body.velocity[0])

    def run(self, method: str, setting: Setting) -> Run:
        """One AdvanceTo over the whole duration."""
        if method == "drake-discrete":
            plant = self._plant(steps_of(self.scene, setting)[1])
        else:
            plant = self.continuous
        simulator = Simulator(plant)
        if method in _SCHEMES:
            config = SimulatorConfig(
                integration_scheme=_SCHEMES[method],
                accuracy=setting.value,
                max_step_size=self.scene.duration,
                use_error_control=True,
            )
            ApplySimulatorConfig(config, simulator)
        context = simulator.get_mutable_context()
        self._set_start(plant, context)
        simulator.Initialize()
        cpu = clocked(lambda: simulator.AdvanceTo(self.scene.duration))
        placements = []
        for body in self.scene.bodies:
            pose = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(body.name))
            placements.append((pose.rotation().matrix(), pose.translation()))
        return Run(cpu, placements, self._steps(simulator, method))

    @staticmethod
    def _steps(simulator: Simulator, method: str) -> int:
        if method == "drake-discrete":
            return simulator.get_num_discrete_updates()
        return simulator.get_integrator().get_num_steps_taken()
