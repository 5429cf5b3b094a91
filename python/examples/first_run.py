"""A first run: a start, a tolerance, arrays, a log for viewers and a page for the browser.

python python/examples/first_run.py
"""

from pathlib import Path
from tempfile import gettempdir

import catena

robots = Path(__file__).parents[2] / "robots"
out = Path(gettempdir())

model = catena.load(robots / "arm7.urdf")
sim = catena.Sim(model, tolerance=1e-6)
sim.q["joint2"] = 0.5
result = sim.run(2.0, rate=60)

print(result)
print("the flange ends at", result.poses["flange"][-1, :3], "m")
print("the first joint carries up to", abs(result.reactions["joint1"][:, :3]).max(), "N")
result.save(out / "first_run.mcap")
result.report(out / "first_run.html")
print("to be looked at:", out / "first_run.mcap", "and", out / "first_run.html")
