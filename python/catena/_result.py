"""What runs leave: arrays, tables, files, plots."""

from __future__ import annotations

import html
import json
import os
import sys
import tempfile
import webbrowser
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path

import numpy as np

from . import _catena
from ._errors import InputError
from ._named import NamedArray


class _ByName(Mapping):
    """Arrays that are worked out when somebody asks for them."""

    def __init__(self, names, work_out):
        self._names, self._work_out, self._known = names, work_out, {}

    def __getitem__(self, name):
        if name not in self._known:
            self._known[name] = self._work_out(name)
        return self._known[name]

    def __iter__(self):
        return iter(self._names)

    def __len__(self):
        return len(self._names)

    def __contains__(self, name):
        return name in self._names


class Result:
    """A run that has ended: samples at a fixed rate, and the report. Logs and pages can be written until it is pickled.

    Attributes
    ----------
    t : times of the samples (samples,) [s]
    q, v : positions and velocities (samples, n), by index or name of a joint: ``result.q["elbow"]``
    energy : total energy (samples,) [J], of the sampled q and v, which are interpolated inside of steps; ``energies`` has its parts. How well the
        scheme conserves it is ``summary["energy"]["max_relative_error"]``.
    poses : by link, x, y, z, w, x, y, z of its frame in the world (samples, 7)
    reactions : by joint, force and torque of the parent on the child, in the world (samples, 6) [N, N m]
    contact_forces : by pair, as ``"foot|floor"``, the force of all its contacts on the first of the two, in the world (samples, 3) [N]
    sensitivity : the derivatives of the run, if ``run`` was asked for them: a :class:`Sensitivity`
    summary : the report as a dict, as ``catena simulate --json`` prints it
    """

    def __init__(self, model, inner):
        self.model = model
        self._inner = inner
        self.t = inner.times
        q, v = inner.coordinates()
        self.q = NamedArray(q, model._inner.q_places())
        self.v = NamedArray(v, model._inner.v_places())
        parts = inner.energies()
        self.energies = dict(zip(("kinetic", "potential", "spring", "load"), parts.T))
        self.energy = parts.sum(axis=1)
        self.poses = _ByName(model.link_names, inner.poses)
        self.reactions = _ByName(model.joint_names, inner.reactions)
        self.contact_forces = _ByName(list(dict.fromkeys(model._inner.contact_pairs())), self._contact_force)
        self.summary = json.loads(inner.report)
        self.sensitivity = None

    def __reduce__(self):
        return _result, (self.model, self._inner.parts())

    @property
    def warnings(self) -> list[str]:
        """What is worth knowing about the run."""
        return self.summary["warnings"]

    @property
    def events(self) -> list[dict]:
        """The first thousand events: time, kind, joint or pair, impulse."""
        return self.summary["events"]["list"]

    @property
    def contacts(self) -> dict[str, np.ndarray]:
        """The closed contacts of all samples, as columns of a table with a row for each contact at each sample, in the order of time.

        ``t`` [s]; ``pair``, as ``"foot|floor"``; ``position`` of the point [m], ``normal`` from the second of the pair to the first, and ``force`` on the
        first [N], in the world (rows, 3); ``gap`` [m], negative where they overlap; ``sticks``, whether friction holds it.
        """
        samples, contacts = self._sampled_contacts
        return {"t": self.t[samples], **contacts}

    @cached_property
    def _sampled_contacts(self):
        """The sample of each closed contact, and the columns of ``contacts`` without the times."""
        samples, pairs, numbers, sticks = self._inner.contacts()
        numbers = numbers.reshape(len(pairs), 10)
        return np.array(samples, dtype=int), {
            "pair": np.array(pairs, dtype=str),
            "position": numbers[:, 0:3],
            "normal": numbers[:, 3:6],
            "force": numbers[:, 6:9],
            "gap": numbers[:, 9],
            "sticks": np.array(sticks, dtype=bool),
        }

    def _contact_force(self, name):
        if name not in self.contact_forces:
            known = ", ".join(self.contact_forces) or "none"
            raise InputError(f"there is no pair of shapes {name!r} that may touch; there are: {known}")
        samples, contacts = self._sampled_contacts
        of = contacts["pair"] == name
        force = np.zeros((len(self.t), 3))
        np.add.at(force, samples[of], contacts["force"][of])
        return force

    def _columns(self):
        columns = {"t": self.t}
        for name, array, symbol in [(name, self.q, "q") for name in self.q.keys()] + [(name, self.v, "v") for name in self.v.keys()]:
            part = array[name]
            if part.ndim == 1:
                columns[f"{symbol}.{name}"] = part
            else:
                columns |= {f"{symbol}.{name}.{index}": column for index, column in enumerate(part.T)}
        return columns | {"energy": self.energy}

    def to_pandas(self):
        """A table indexed by time with a column for each coordinate, ``q.JOINT`` and ``v.JOINT``, and the energy."""
        return table_of(self._columns())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the run to a file of this ending: ``.mcap`` (a log, for viewers and ``catena inspect``), ``.npz``, ``.parquet`` or ``.csv``.

        A file that is there is replaced when all of the new one is written.
        """
        path = os.fspath(path)
        ending = os.path.splitext(path)[1].lower()
        if ending == ".mcap":
            self._inner.save_log(path)
        else:
            save_columns(path, self._columns(), [".mcap"])

    def report(self, path: str | os.PathLike[str], *, mesh_limit: int = 200_000) -> None:
        """Writes a page that shows the run in 3-D with its curves and its report, in one HTML file that any browser opens."""
        self._inner.save_page(os.fspath(path), mesh_limit)

    def film(
        self,
        path: str | os.PathLike[str],
        *,
        size: tuple[int, int] | None = None,
        fps: float = 25.0,
        speed: float = 1.0,
        time: Iterable[float] | None = None,
        view: str | Iterable[float] = "corner",
        browser: bool = False,
        mesh_limit: int = 200_000,
    ):
        """Writes a film of the run, ``.gif`` or ``.mp4`` (by ffmpeg), or a picture of some instants, ``.png``; returns the number of pictures.

        Parameters
        ----------
        size : width and height [pixels]; 640 x 360 of a GIF, else 960 x 540
        fps : pictures in a second of the film
        speed : seconds of the run in a second of the film
        time : first and last instant of a film [s]; the instants of a PNG, which are side by side. The whole run, or its end
        view : ``"corner"``, ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, or the direction to the camera (x, y, z)
        browser : Chromium draws the pictures from the page, with arrows of contact forces, and takes ten times as long
        mesh_limit : most triangles of all meshes together
        """
        times = [] if time is None else np.atleast_1d(np.asarray(time, dtype=float)).tolist()
        side = view if isinstance(view, str) else ",".join(repr(float(number)) for number in view)
        return self._inner.save_film(os.fspath(path), size and tuple(size), fps, speed, times, side, browser, mesh_limit)

    def show(self, *, mesh_limit: int = 200_000):
        """Shows the page of the run: in a notebook below the cell, else in a browser from a temporary file, whose path is returned."""
        if _in_notebook():
            display = _import("IPython.display", "show in a notebook")
            display.display(display.HTML(self._frame(mesh_limit)))
            return None
        handle, path = tempfile.mkstemp(prefix="catena-", suffix=".html")
        os.close(handle)
        self.report(path, mesh_limit=mesh_limit)
        webbrowser.open(Path(path).as_uri())
        return path

    def _frame(self, mesh_limit):
        """The page as a part of another page."""
        page = html.escape(self._inner.page(mesh_limit), quote=True)
        return f'<iframe srcdoc="{page}" sandbox="allow-scripts" style="width: 100%; height: 600px; border: 1px solid #8884"></iframe>'

    def _repr_html_(self):
        """The page, for notebooks. A run that was pickled has no log to make it of, and is shown as text."""
        try:
            return self._frame(200_000)
        except InputError:
            return None

    def plot(self, joints: Iterable[str] | None = None, axes: object | None = None):
        """Draws positions and velocities over time with matplotlib; returns the axes."""
        pyplot = _import("matplotlib.pyplot", "plot")
        names = list(self.q.keys()) if joints is None else [joints] if isinstance(joints, str) else list(joints)
        if axes is None:
            _, axes = pyplot.subplots(2, 1, sharex=True, layout="constrained")
        for axis, array, label in zip(axes, (self.q, self.v), ("q [rad, m]", "v [rad/s, m/s]")):
            for name in names:
                part = array[name]
                axis.plot(self.t, part, label=name)
            axis.set_ylabel(label)
        axes[-1].set_xlabel("t [s]")
        axes[0].legend()
        return axes

    def __str__(self):
        return self._inner.text

    def __repr__(self):
        end = f"{self.t[-1]} s" if len(self.t) else "nothing"
        return f"<catena.Result of {self.model.name!r}: {len(self.t)} samples to {end}>"


def _result(model, parts):
    return Result(model, _catena.Recorded.of_parts(model._inner, parts))


def _in_notebook():
    """Whether a kernel of Jupyter runs this program."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


def _import(module, what):
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.split(".")[0]
        raise InputError(f"{what} needs {package}: pip install {package}") from None


def table_of(columns):
    """A table of columns, indexed by their times ``t``."""
    pandas = _import("pandas", "to_pandas")
    return pandas.DataFrame(columns).set_index("t")


def save_columns(path, columns, others=()):
    """Writes columns to a file, ``.npz``, ``.parquet`` or ``.csv``; an error names the ``others`` that a file may end in."""
    path = os.fspath(path)
    ending = os.path.splitext(path)[1].lower()
    if ending == ".npz":
        _whole(path, lambda file: np.savez_compressed(file, **columns))
    elif ending == ".parquet":
        table = table_of(columns)
        _import("pyarrow", "save as .parquet")
        _whole(path, lambda file: table.to_parquet(file))
    elif ending == ".csv":
        rows = np.column_stack(list(columns.values()))
        _whole(path, lambda file: np.savetxt(file, rows, "%.17g", ",", header=",".join(columns), comments=""))
    else:
        raise InputError(f"cannot write {path}: its ending is none of {', '.join([*others, '.npz', '.parquet', '.csv'])}")


def _whole(path, write):
    """Writes a file that is not there before all of it is."""
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise InputError(f"cannot write {path}: there is no folder {folder}")
    handle, beside = tempfile.mkstemp(prefix=".catena-", suffix=os.path.splitext(path)[1], dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(beside, 0o666 & ~mask)
        os.replace(beside, path)
    except BaseException:
        os.unlink(beside)
        raise
