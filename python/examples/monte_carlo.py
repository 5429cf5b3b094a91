"""Monte-Carlo: how the uncertainty of a start and of a mass spreads in a double pendulum.

python python/examples/monte_carlo.py
"""

import time
from pathlib import Path

import catena
import numpy as np

model = catena.load(Path(__file__).parents[2] / "robots" / "double_pendulum.urdf")
random = np.random.default_rng(1)
runs = 5000

q0 = random.normal([1.0, 0.0], 0.01, (runs, 2))
began = time.perf_counter()
out = catena.rollout(model, q0, duration=2.0, rate=5)
took = time.perf_counter() - began
print(f"{runs} runs of 2 s in {took:.2f} s, {1e3 * took / runs:.3f} ms each, {len(out.failures)} failed")
for t, shoulder in zip(out.t, out.q["shoulder"].T):
    print(f"{t:.1f} s: shoulder at {shoulder.mean():+.4f} ± {shoulder.std():.4f} rad")

print("with another mass of the lower arm:")
mass = model.params["link.lower_arm.mass"]
for factor in (0.9, 1.0, 1.1):
    varied = model.with_params({"lower_arm.mass": factor * mass})
    end = catena.rollout(varied, q0, duration=2.0).q["shoulder"][:, -1]
    print(f"{factor * mass:.3f} kg: {end.mean():+.4f} ± {end.std():.4f} rad")
