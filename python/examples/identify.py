"""Masses and friction of an arm from a log with noise: Gauss-Newton on exact derivatives, through the joint's sticking.

python python/examples/identify.py
"""

import tempfile
from pathlib import Path

import catena
import numpy as np

robots = Path(__file__).parents[2] / "robots"
scene = Path(tempfile.mkdtemp()) / "arm.toml"
scene.write_text(
    f'[[robot]]\nurdf = "{robots / "double_pendulum.urdf"}"\n'
    '[[joint]]\nname = "shoulder"\nfriction = 0.3\n[[joint]]\nname = "elbow"\nfriction = 0.1\n'
)
true = catena.load(scene)
start = [1.2, 0.4]
keys = ["upper_arm.mass", "lower_arm.mass", "shoulder.friction", "elbow.friction"]

# The measured motion: samples at 100 Hz with a noise of 1 mrad, over the 2 s in which no event grazes another.
run = true.sensitivity([], start, [0.0, 0.0], duration=2.0, stages=5, step=0.01)
t = np.linspace(0.0, 2.0, 201)
kept = np.searchsorted(run.t, t - 1e-9)
data = run.q[np.minimum(kept, len(run.t) - 1)] + 1e-3 * np.random.default_rng(1).standard_normal((len(t), 2))

# One mass is known, because motions under gravity tell ratios of masses and friction alone. The others begin a third off.
known = true.params["link.lower_arm.mass"]
guess = true.with_params({"lower_arm.mass": 1.3 * known, "shoulder.friction": 0.2, "elbow.friction": 0.14})
found = catena.fit(guess, t, data, keys[1:], q=start, v=[0.0, 0.0])
print(found)
for key in keys[1:]:
    name = next(name for name in true.params if name.endswith(key))
    print(f"{key}: {found.values[key]:.5f} ± {found.deviations[key]:.5f}, true {true.params[name]:.5f}")
