"""Error of a derivative over its CPU time: exact ones of catena, differences of runs of catena, and of MuJoCo where it is installed.

The derivative is that of the end of a double pendulum by its start. A file name as an argument gets the chart, which needs matplotlib.

python python/examples/derivative_chart.py [CHART.svg]
"""

import sys
import time
from pathlib import Path

import catena
import numpy as np

FILE = Path(__file__).parents[2] / "robots" / "double_pendulum.urdf"
START, DURATION = np.array([1.0, 0.4]), 1.0
model = catena.load(FILE)


def exact(stages, step):
    run = model.sensitivity("start.q.shoulder", START, [0.0, 0.0], duration=DURATION, stages=stages, step=step)
    return run.dq[-1][:, 0]


def timed(work):
    """The result, and the CPU time of one call [s]."""
    calls, began = 0, time.process_time()
    while time.process_time() - began < 0.05:
        done, calls = work(), calls + 1
    return done, (time.process_time() - began) / calls


def best_difference(end):
    """Central differences over the width with the least error, which nobody knows beforehand."""
    found = []
    for width in 10.0 ** np.arange(-9, -1):
        moved = np.array([width, 0.0])
        found.append(timed(lambda: (end(START + moved) - end(START - moved)) / (2 * width)))
    return min(found, key=lambda one: abs(one[0] - truth).max())


def of_catena(tolerance):
    return lambda q: np.asarray(catena.rollout(model, q[None], duration=DURATION, tolerance=tolerance, threads=1).q)[0, -1]


def of_mujoco(mujoco, step):
    spec = mujoco.MjSpec.from_string(FILE.read_text())
    other = spec.compile()
    other.opt.timestep, other.opt.integrator = step, mujoco.mjtIntegrator.mjINT_RK4
    other.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(other)

    def end(q):
        mujoco.mj_resetData(other, data)
        data.qpos[:] = q
        for _ in range(round(DURATION / step)):
            mujoco.mj_step(other, data)
        return data.qpos.copy()

    return end


truth = exact(9, 0.01)
lines = {}
for stages, steps in ((3, (0.1, 0.05, 0.025, 0.0125)), (5, (0.2, 0.1, 0.05, 0.025)), (9, (0.5, 0.25, 0.125, 0.0625))):
    lines[f"catena, exact, {stages} stages"] = [timed(lambda: exact(stages, step)) for step in steps]
lines["catena, differences of runs"] = [best_difference(of_catena(tolerance)) for tolerance in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)]
try:
    import mujoco
except ImportError:
    print("MuJoCo is not installed, and is left out")
else:
    lines["MuJoCo, RK4, differences of runs"] = [best_difference(of_mujoco(mujoco, step)) for step in (1e-2, 5e-3, 2e-3, 1e-3)]
for name, points in lines.items():
    for found, cost in points:
        print(f"{name:34} {1e3 * cost:9.3f} ms   error {abs(found - truth).max():.1e}")

if len(sys.argv) > 1:
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 5.2), layout="constrained")
    for name, points in lines.items():
        axes.loglog([1e3 * cost for _, cost in points], [max(abs(found - truth).max(), 1e-16) for found, _ in points], "o-", label=name)
    axes.set(xlabel="CPU time [ms]", ylabel="error of ∂q/∂q₀ [rad/rad]", title="Derivative of the end of a double pendulum by its start")
    axes.grid(alpha=0.3)
    # Beside the axes no point is covered, wherever the points are.
    figure.legend(loc="outside lower center", ncols=2)
    figure.savefig(sys.argv[1])
