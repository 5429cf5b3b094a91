"""Sweeps: many runs of one scene in which numbers vary, on this machine or on a cluster."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from . import _catena
from ._clusters import Made, Shard, cluster_of
from ._errors import InputError, RunError

# Shards for each core of a cluster, unless the caller gives a number: the others even out hard shards.
_SHARDS_PER_CORE = 4

# Number of failed shards that are named.
_NAMED = 5


@dataclass(frozen=True)
class Swept:
    """The rows of a sweep.

    Attributes
    ----------
    folder : where they are
    runs : how many there are
    made : how many of them this call has made; attempts of a worker that was lost are not counted
    failed : how many of those made have failed; each has its reason in its row
    first_failure : index and reason of the first of those
    warnings : what was left out of the scene and why, and what else is worth knowing
    """

    folder: Path
    runs: int
    made: int
    failed: int
    first_failure: tuple[int, str] | None
    warnings: list[str]

    @property
    def files(self) -> list[Path]:
        """The files of rows, in the order of the index."""
        return sorted(path for path in self.folder.glob("rows-*") if path.suffix in (".csv", ".parquet"))

    def to_pandas(self):
        """All rows as a table of pandas."""
        import pandas

        read = {".csv": pandas.read_csv, ".parquet": pandas.read_parquet}
        return pandas.concat([read[path.suffix](path) for path in self.files], ignore_index=True)


def sweep(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    engine: object | None = None,
    shards: int | None = None,
    jobs: int | None = None,
    retries: int = 2,
    format: str | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Swept:
    """Makes all runs of a sweep file; called again with the same folder it goes on where it was stopped.

    The rows follow from the file alone: not from the engine, shards or threads, nor from workers that were lost on the way.

    Parameters
    ----------
    path : the sweep file (``doc/sweeps.md``)
    output : folder of the rows; made if it is not there
    engine : ``None`` is this machine; ``"ray"`` the cluster that ``ray.init`` has joined, or this machine if it was not called; ``"dask"`` the
        cluster of the current ``distributed.Client``, or give the client itself. Workers need this version of catena, and must see
        the sweep file, its scene and the folder under the same paths.
    shards : how many tasks the cluster is given; four for each of its cores
    jobs : threads of a task, 1; on this machine all cores
    retries : how often a task is begun again after its worker was lost or the run failed
    format : ``"csv"``, or ``"parquet"`` where it was compiled in
    packages : folders of ROS packages by name
    progress : is told how many of how many runs are done: twice a second on this machine, after each shard on a cluster

    Raises
    ------
    InputError : what is wrong with the sweep file, with its line, or with the folder; nothing was run
    RunError : a full disk, or which shards failed where and why. What was made stays.
    """
    for name, number, least in [("shards", shards, 1), ("jobs", jobs, 1), ("retries", retries, 0)]:
        if number is not None and number < least:
            raise InputError(f"{name} is {number}: give {least} or more")
    if engine is None and shards is not None:
        raise InputError("shards are for clusters: give an engine, or leave them out")
    # Workers have other current folders.
    path, output = os.path.abspath(path), Path(os.path.abspath(output))
    packages = {name: os.path.abspath(folder) for name, folder in dict(packages or {}).items()}
    cluster = None if engine is None else cluster_of(engine)
    read = _catena.Sweep(path, packages)
    if cluster is None:
        made, failed, first = read.make(output, "1/1", jobs, format, progress)
        return Swept(output, read.runs, made, failed, first, read.warnings)

    tell = progress or (lambda done, runs: None)
    if read.rows_in(output, format) == read.runs:
        tell(read.runs, read.runs)
        return Swept(output, read.runs, 0, 0, None, read.warnings)
    parts = output / "shards"
    begun = _begun(parts)
    count = shards or begun or min(read.runs, _SHARDS_PER_CORE * cluster.cores())
    if begun not in (None, count):
        raise InputError(
            f"{parts} has parts of {begun} shards, not of {count}: leave shards out to go on with them, or remove that folder"
        )
    todo = [
        Shard(path, packages, str(parts / f"shard-{number}"), number, count, jobs or 1, format, _catena.__version__, read.fingerprint)
        for number in range(1, count + 1)
    ]
    made, failures = [], {}
    tell(0, read.runs)
    with contextlib.closing(cluster.work(todo, retries)) as ended:
        for shard, result in ended:
            if isinstance(result, Exception):
                failures[shard.number] = result
            else:
                made.append(result)
                tell(sum(one.runs for one in made), read.runs)
    if failures:
        told = [f"shard {number}: {error}" for number, error in sorted(failures.items())]
        more = [f"and {len(told) - _NAMED} more"] if len(told) > _NAMED else []
        raise RunError(
            f"{len(told)} of {count} shards failed; what was made is in {parts}, and the same call goes on from there. "
            + "; ".join(told[:_NAMED] + more)
        ) from next(iter(failures.values()))
    _catena.merge([shard.folder for shard in todo], output)
    # Only files that are whole in their new place are removed from the old.
    if read.rows_in(output, format) != read.runs:
        raise RunError(f"{output} changed while rows were merged into it: call again")
    for shard in todo:
        shutil.rmtree(shard.folder)
    with contextlib.suppress(OSError):
        parts.rmdir()
    first = min((one.first_failure for one in made if one.first_failure), default=None)
    return Swept(output, read.runs, sum(one.made for one in made), sum(one.failed for one in made), first, read.warnings + _mixed_processors(made))


def _begun(parts: Path) -> int | None:
    """How many shards an earlier call has cut the sweep into, if there was one."""
    for manifest in sorted(parts.glob("shard-*/sweep.json")):
        with contextlib.suppress(OSError, ValueError, LookupError, TypeError):
            return int(json.loads(manifest.read_text())["shard"][1])
    return None


def _mixed_processors(made: list[Made]) -> list[str]:
    """Rows of processors with other vector instructions differ in their last bits."""
    hosts: dict[str, list[str]] = {}
    for one in made:
        hosts.setdefault(one.instructions, []).append(one.host)
    told = ", ".join(f"{kind} on {hosts[kind][0]} ({len(hosts[kind])} shards)" for kind in sorted(hosts))
    return [f"processors of several kinds, whose rows differ in their last bits: {told}"] if len(hosts) > 1 else []
