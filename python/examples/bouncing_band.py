"""The band of uncertainty of a bouncing ball: height ± 3 standard deviations, from exact derivatives through its impacts.

python python/examples/bouncing_band.py
"""

from pathlib import Path

import catena
import numpy as np

model = catena.load(Path(__file__).parents[2] / "robots" / "ball_dropped.toml")
# Standard deviations of the restitution and of the height of the start.
spread = {"floor.restitution": 0.01, "robot.ball.pose.position.z": 0.005}
run = model.sensitivity(list(spread), duration=1.6, stages=9, step=0.02)
height = run.freedoms.index(next(name for name in run.freedoms if name.endswith(".z")))
band = np.sqrt(sum((run.dq[:, height, column] * sigma) ** 2 for column, sigma in enumerate(spread.values())))
for time, value, sigma in list(zip(run.t, run.q[:, height], band))[::8]:
    print(f"{time:5.2f} s  {value:7.4f} m ± {3 * sigma:.4f} m")
for event in run.events:
    sigma = np.sqrt(sum((by * sigma) ** 2 for by, sigma in zip(event["dt"], spread.values())))
    print(f"{event['what']} at {event['t']:.4f} s ± {3 * sigma:.4f} s")
for key, within, by in zip(run.keys, run.valid_within, run.bounded_by):
    print(f"{key}: the derivatives hold within {within:.2g} ({by})")
