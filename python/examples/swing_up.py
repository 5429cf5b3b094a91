"""A swing-up by gradient: the efforts on a cart that bring its hanging pole upright to rest, from exact derivatives of every piece of the run.

The derivatives of a piece by its start and its effort are chained backwards (adjoints), so that one pass gives the derivatives of the end by all
efforts. Gauss-Newton steps of least norm then make the end upright.

    x_{k+1} = f(x_k, u_k)        dx_N/du_k = A_{N-1} ... A_{k+1} B_k        δu = −Jᵀ (J Jᵀ + λ)⁻¹ (x_N − x*)

python python/examples/swing_up.py
"""

import tempfile
from pathlib import Path

import catena
import numpy as np

ROBOT = Path(__file__).parents[2] / "robots" / "parts" / "cart_pole.urdf"
PIECES, PIECE = 30, 0.08
GOAL = np.array([0.0, np.pi, 0.0, 0.0])


def cart():
    """A cart of 1 kg under an effort that is a number of the model; nothing holds it at its limits."""
    scene = Path(tempfile.mkdtemp()) / "swing_up.toml"
    scene.write_text(
        f'[[robot]]\nname = "cart_pole"\nurdf = "{ROBOT}"\n[[joint]]\nname = "slide"\nlimit = [-100.0, 100.0]\n'
        '[[load]]\njoint = "slide"\neffort = 0.0\n'
    )
    return catena.load(scene, params={"cart.mass": 1.0})


def swing(model, efforts):
    """The end of the motion (4) under efforts, and its derivatives by all of them (4, pieces)."""
    x, pieces = np.zeros(4), []
    key = next(name for name in model.params if name.startswith("load.slide"))
    for effort in efforts:
        pushed = model.with_params({key: float(effort)})
        run = pushed.sensitivity(["start.q", "start.v", "effort.slide"], x[:2], x[2:], duration=PIECE, stages=5, step=PIECE / 2)
        x = np.concatenate([run.q[-1], run.v[-1]])
        pieces.append(np.concatenate([run.dq[-1], run.dv[-1]]))
    rows, slopes = np.eye(4), np.zeros((4, len(efforts)))
    for index in range(len(efforts) - 1, -1, -1):
        slopes[:, index] = rows @ pieces[index][:, 4]
        rows = rows @ pieces[index][:, :4]
    return x, slopes


def swing_up(iterations=60):
    """The efforts (pieces), and how far the end is from upright."""
    model = cart()
    efforts = 4.0 * np.sin(np.linspace(0.0, 3.0 * np.pi, PIECES))
    x, slopes = swing(model, efforts)
    damping = 1.0
    for _ in range(iterations):
        off = x - GOAL
        if np.abs(off).max() < 1e-9:
            break
        step = -slopes.T @ np.linalg.solve(slopes @ slopes.T + damping * np.eye(4), off)
        tried = swing(model, efforts + step)
        if np.linalg.norm(tried[0] - GOAL) < np.linalg.norm(off):
            efforts, (x, slopes), damping = efforts + step, tried, 0.2 * damping
        else:
            damping *= 5.0
    return efforts, np.abs(x - GOAL).max()


if __name__ == "__main__":
    efforts, off = swing_up()
    print("efforts on the cart [N]:", efforts.round(2))
    print(f"the pole is upright and at rest to {off:.1e}")
