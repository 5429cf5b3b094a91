"""Shards of a sweep on a cluster that the user has: Ray or Dask. Who places tasks and begins them again is the cluster."""

from __future__ import annotations

import socket
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from . import _catena
from ._errors import CatenaError, InputError, RunError


@dataclass(frozen=True)
class Shard:
    """A part of a sweep, as it is sent to a worker."""

    path: str
    packages: dict[str, str]
    folder: str
    number: int
    count: int
    jobs: int
    format: str | None
    version: str
    fingerprint: str

    @property
    def name(self) -> str:
        """For the cluster's own lists of tasks."""
        return f"catena-shard-{self.number}-of-{self.count}"


class Made(NamedTuple):
    """What a worker says of a shard: its rows, those that it made, those of them that failed, and where."""

    runs: int
    made: int
    failed: int
    first_failure: tuple[int, str] | None
    host: str
    instructions: str


def make(shard: Shard) -> Made:
    """What a worker does."""
    host = socket.gethostname()
    try:
        if _catena.__version__ != shard.version:
            raise InputError(f"catena {_catena.__version__} is installed, and the sweep was begun by {shard.version}: install that")
        sweep = _catena.Sweep(shard.path, shard.packages)
        if sweep.fingerprint != shard.fingerprint:
            raise InputError(
                f"{shard.path}, or a file that it names, is another one than where the sweep was begun: let all machines see the same files"
            )
        made, failed, first = sweep.make(shard.folder, f"{shard.number}/{shard.count}", shard.jobs, shard.format, None)
    except CatenaError as error:
        raise type(error)(f"on {host}: {error}") from None
    runs = sweep.runs * shard.number // shard.count - sweep.runs * (shard.number - 1) // shard.count
    return Made(runs, made, failed, first, host, _catena.instructions())


class RayCluster:
    """The cluster that this process has joined; Ray starts one on this machine if there is none."""

    def __init__(self):
        try:
            import ray
        except ImportError:
            raise InputError('engine "ray": there is no Ray here; install it with `pip install ray`') from None
        if not ray.is_initialized():
            ray.init()
        self._ray = ray

    def cores(self) -> int:
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))

    def work(self, shards: list[Shard], retries: int) -> Iterator[tuple[Shard, Made | Exception]]:
        """Has all shards made, and gives each with what came of it when it ends."""
        ray = self._ray
        task = ray.remote(max_retries=retries, retry_exceptions=[RunError])(make)
        waiting = {task.options(num_cpus=shard.jobs, name=shard.name).remote(shard): shard for shard in shards}
        try:
            while waiting:
                (reference,), _ = ray.wait(list(waiting), num_returns=1)
                shard = waiting.pop(reference)
                try:
                    yield shard, ray.get(reference)
                except ray.exceptions.RayTaskError as error:
                    yield shard, error.cause if isinstance(error.cause, Exception) else error
                except ray.exceptions.RayError as error:
                    yield shard, error
        finally:
            for reference in waiting:
                ray.cancel(reference)


class DaskCluster:
    """The cluster of a client of Dask."""

    def __init__(self, client=None):
        try:
            import distributed
        except ImportError:
            raise InputError('engine "dask": there is no Dask here; install it with `pip install dask distributed`') from None
        try:
            self._client = client or distributed.get_client()
        except ValueError:
            raise InputError('engine "dask": make a client first, such as distributed.Client("tcp://scheduler:8786")') from None
        self._as_completed = distributed.as_completed

    def cores(self) -> int:
        return max(1, sum(self._client.nthreads().values()))

    def work(self, shards: list[Shard], retries: int) -> Iterator[tuple[Shard, Made | Exception]]:
        """Has all shards made, and gives each with what came of it when it ends."""
        submit, waiting, call = self._client.submit, {}, uuid.uuid4().hex
        for shard in shards:
            waiting[submit(make, shard, pure=False, retries=retries, key=f"{shard.name}-{call}")] = shard
        try:
            for future in self._as_completed(list(waiting)):
                shard = waiting.pop(future)
                error = future.exception()
                yield shard, future.result() if error is None else error
        finally:
            self._client.cancel(list(waiting))


def cluster_of(engine) -> RayCluster | DaskCluster:
    """The cluster of this name, or of a client."""
    if engine == "ray":
        return RayCluster()
    if engine == "dask":
        return DaskCluster()
    if type(engine).__module__.partition(".")[0] == "distributed" and hasattr(engine, "submit"):
        return DaskCluster(engine)
    raise InputError(f"engine is {engine!r}: give 'ray', 'dask', a distributed.Client, or None for this machine")
