"""The same double pendulum in MuJoCo: how far apart the ends are, and what the runs cost.

pip install mujoco; python python/examples/compare_mujoco.py
"""

import sys
import time
from pathlib import Path

import catena
import numpy as np

try:
    import mujoco
    from mujoco import rollout as mujoco_rollout
except ImportError:
    sys.exit("this comparison needs MuJoCo: pip install mujoco")

file = Path(__file__).parents[2] / "robots" / "double_pendulum.urdf"
duration, runs = 2.0, 500
model = catena.load(file)
q0 = np.random.default_rng(1).uniform(-1, 1, (runs, 2))


def timed(work):
    began = time.perf_counter()
    done = work()
    return done, 1e3 * (time.perf_counter() - began) / runs


truth = catena.rollout(model, q0, duration=duration, tolerance=1e-12, threads=1).q[:, -1]
print("method                       ms a run   largest error [rad]")
for tolerance in (1e-4, 1e-6, 1e-9):
    out, cost = timed(lambda: catena.rollout(model, q0, duration=duration, tolerance=tolerance, threads=1))
    print(f"catena, tolerance {tolerance:.0e} m   {cost:8.3f}   {abs(out.q[:, -1] - truth).max():.1e}")

for name, integrator, step in (("RK4", "mjINT_RK4", 1e-3), ("Euler", "mjINT_EULER", 1e-3), ("default", "mjINT_EULER", 2e-3)):
    # Its converter of URDF files takes the frames of links as they are; the geometry is of no use here.
    text = file.read_text().replace("<robot ", '<robot ', 1)
    spec = mujoco.MjSpec.from_string(text)
    other = spec.compile()
    other.opt.timestep = step
    other.opt.integrator = getattr(mujoco.mjtIntegrator, integrator)
    other.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(other)
    full = np.zeros((runs, mujoco.mj_stateSize(other, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    full[:, 1:3] = q0
    (states, _), cost = timed(lambda: mujoco_rollout.rollout(other, data, full, nstep=round(duration / step)))
    print(f"MuJoCo {name}, {step:.0e} s{'':<10} {cost:8.3f}   {abs(states[:, -1, 1:3] - truth).max():.1e}")
