"""Exudyn: redundant coordinates under generalised-alpha and the trapezoidal rule, and a kinematic tree under explicit RK.

The explicit solvers refuse joints in redundant coordinates, so they get Exudyn's minimal-coordinate tree. The clock runs
over `SolveDynamic`, which also assembles; on short scenes with few steps that is a part of the cost.
"""

from __future__ import annotations

import exudyn
import exudyn.graphics
import exudyn.itemInterface as items
import numpy as np
from exudyn.utilities import RigidBodyInertia

from measure import Run, Setting, clocked, steps_of
from scene import Scene

METHODS = {
    "exudyn-generalized-alpha": "step",
    "exudyn-trapezoidal": "step",
    "exudyn-tree-rk44": "step",
    "exudyn-tree-dopri5": "tolerance",
}
_SOLVERS = {
    "exudyn-generalized-alpha": exudyn.DynamicSolverType.GeneralizedAlpha,
    "exudyn-trapezoidal": exudyn.DynamicSolverType.TrapezoidalIndex2,
    "exudyn-tree-rk44": exudyn.DynamicSolverType.RK44,
    "exudyn-tree-dopri5": exudyn.DynamicSolverType.DOPRI5,
}
_TREE_JOINTS = {
    "revolute": (exudyn.JointType.RevoluteX, exudyn.JointType.RevoluteY, exudyn.JointType.RevoluteZ),
    "prismatic": (exudyn.JointType.PrismaticX, exudyn.JointType.PrismaticY, exudyn.JointType.PrismaticZ),
}


class Peer:
    """A scene in Exudyn; systems are built anew for every run."""

    def __init__(self, scene: Scene):
        self.scene = scene

    def run(self, method: str, setting: Setting) -> Run:
        """Builds the system and solves it over the whole duration."""
        container = exudyn.SystemContainer()
        system = container.AddSystem()
        tree = "-tree-" in method
        ends = self._add_tree(system) if tree else self._add_bodies(system)
        system.Assemble()

        simulation = exudyn.SimulationSettings()
        integration = simulation.timeIntegration
        integration.endTime = self.scene.duration
        integration.verboseMode = 0
        simulation.solutionSettings.writeSolutionToFile = False
        simulation.solutionSettings.sensorsWritePeriod = self.scene.duration
        if setting.kind == "step":
            # A step that fails is a failure; halving it in secret would blur the comparison.
            integration.automaticStepSize = False
            integration.numberOfSteps = steps_of(self.scene, setting)[0]
        else:
            integration.numberOfSteps = 1
            integration.automaticStepSize = True
            integration.explicitIntegration.dynamicSolverType = _SOLVERS[method]
            integration.absoluteTolerance = integration.relativeTolerance = setting.value
        if not tree:
            # Newton to rounding: this is about accuracy. A Jacobian kept over several steps is enough for it, and cheaper.
            integration.newton.relativeTolerance = 1e-10
            integration.newton.absoluteTolerance = 1e-12
            integration.newton.useModifiedNewton = True
        solved: list[bool] = []
        cpu = clocked(
            lambda: solved.append(system.SolveDynamic(simulation, solverType=_SOLVERS[method], showHints=False))
        )
        if not solved[0]:
            raise RuntimeError("the solver gave up")
        steps = system.sys["dynamicSolver"].it.currentStepIndex if "dynamicSolver" in system.sys else 0
        return Run(cpu, ends(), steps)

    def _add_bodies(self, system):
        """Rigid bodies with Euler parameters and a joint for each, and a function that reads where they end."""
        gravity = list(self.scene.gravity)
        ground = system.CreateGround()
        numbers = []
        rows = zip(self.scene.bodies, self.scene.placements(), self.scene.twists(), strict=True)
        for body, (rotation, origin), (linear, angular) in rows:
            center = np.array(body.center_of_mass)
            # The reference point is the centre of mass: it has the simplest equations.
            inertia = RigidBodyInertia(body.mass, np.array(body.inertia), com=np.zeros(3))
            arm = rotation @ center
            number = system.CreateRigidBody(
                inertia=inertia,
                referencePosition=list(origin + arm),
                referenceRotationMatrix=rotation,
                initialVelocity=list(linear + np.cross(angular, arm)),
                initialAngularVelocity=list(angular),
                gravity=gravity,
            )
            numbers.append(number)
            parent = ground if body.parent < 0 else numbers[body.parent]
            if body.kind == "floating":
                continue
            # A joint with a single axis leaves its axis where it is in the body.
            axis = rotation @ np.array(body.axis)
            create = system.CreateRevoluteJoint if body.kind == "revolute" else system.CreatePrismaticJoint
            create(bodyNumbers=[parent, number], position=list(origin), axis=list(axis), useGlobalFrame=True)

        def ends():
            placements = []
            for number, body in zip(numbers, self.scene.bodies, strict=True):
                center = np.array(
                    system.GetObjectOutputBody(number, exudyn.OutputVariableType.Position, [0.0, 0.0, 0.0])
                )
                matrix = np.array(
                    system.GetObjectOutputBody(number, exudyn.OutputVariableType.RotationMatrix, [0.0, 0.0, 0.0])
                ).reshape(3, 3)
                placements.append((matrix, center - matrix @ np.array(body.center_of_mass)))
            return placements

        return ends

    def _add_tree(self, system):
        """One object with a coordinate for each joint, and a function that reads where the bodies end."""
        bodies = self.scene.bodies
        kinds, transforms, offsets, aligns = [], [], [], []
        for body in bodies:
            if body.kind == "floating":
                raise NotImplementedError("the kinematic tree has no floating joint here")
            # The tree knows joints about x, y and z only: turn the body's frame so that its axis becomes z.
            align = _align_with_z(np.array(body.axis))
            parent = np.eye(3) if body.parent < 0 else aligns[body.parent]
            aligns.append(align)
            kinds.append(_TREE_JOINTS[body.kind][2])
            transforms.append(parent.T @ np.array(body.frame_rotation) @ align)
            offsets.append(parent.T @ np.array(body.frame_position))
        centers = [align.T @ np.array(body.center_of_mass) for body, align in zip(bodies, aligns, strict=True)]
        inertias = [align.T @ np.array(body.inertia) @ align for body, align in zip(bodies, aligns, strict=True)]
        count = len(bodies)
        node = system.AddNode(
            items.NodeGenericODE2(
                numberOfODE2Coordinates=count,
                referenceCoordinates=[0.0] * count,
                initialCoordinates=[body.position[0] for body in bodies],
                initialCoordinates_t=[body.velocity[0] for body in bodies],
            )
        )
        system.AddObject(
            items.ObjectKinematicTree(
                nodeNumber=node,
                jointTypes=kinds,
                linkParents=[body.parent for body in bodies],
                jointTransformations=exudyn.Matrix3DList(transforms),
                jointOffsets=exudyn.Vector3DList([list(offset) for offset in offsets]),
                linkInertiasCOM=exudyn.Matrix3DList(inertias),
                linkCOMs=exudyn.Vector3DList([list(center) for center in centers]),
                linkMasses=[body.mass for body in bodies],
                gravity=list(self.scene.gravity),
            )
        )

        def ends():
            end = system.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates)
            values = [float(value) for value in np.atleast_1d(end)]
            moved = Scene(self.scene.name, "", 0.0, self.scene.gravity, [_moved(b, v) for b, v in zip(bodies, values)])
            return moved.placements()

        return ends


def _moved(body, value):
    return type(body)(**{**vars(body), "position": [value]})


def _align_with_z(axis: np.ndarray) -> np.ndarray:
    """A rotation whose third column is the axis."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(helper, axis)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])
