"""Sweeps of Python: the rows of the command line, and on clusters the same bytes whatever is lost on the way.

Tests of a cluster are skipped where it is not installed: `pip install ray dask distributed` into the environment of pytest runs them.
"""

import os
import signal
import threading
import time

import catena
import pytest

# Each run of 5 ms takes fixed steps, so that no run is ready before it is checked.
SLOW = """
[sweep]
scene = "{robots}/double_pendulum.urdf"
seed = 2
samples = {samples}
rows_per_file = 64

[simulation]
duration = 2.0
stages = 4
step = {step}

[[vary]]
key = "positions.shoulder"
uniform = [-1.0, 1.0]
"""


def written(folder, robots, samples=200, step=1e-2):
    path = folder / "sweep.toml"
    path.write_text(SLOW.format(robots=robots, samples=samples, step=step))
    return path


def content(folder):
    """All files of a folder but its lock."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "sweep.lock"}


@pytest.fixture(scope="module")
def ray():
    """Ray on this machine, with two workers."""
    ray = pytest.importorskip("ray", reason="no Ray here: `pip install ray` to run this")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield "ray"
    ray.shutdown()


@pytest.fixture(scope="module")
def dask():
    """Dask on this machine, with two workers that are processes of their own."""
    distributed = pytest.importorskip("distributed", reason="no Dask here: `pip install dask distributed` to run this")
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        yield client


@pytest.fixture(params=["ray", "dask"])
def engine(request):
    return request.getfixturevalue(request.param)


def test_a_sweep_is_that_of_the_command_line_and_goes_on(tmp_path, robots):
    path, told = written(tmp_path, robots), []
    swept = catena.sweep(path, tmp_path / "out", jobs=2, progress=lambda done, runs: told.append((done, runs)))
    assert (swept.runs, swept.made, swept.failed, swept.first_failure) == (200, 200, 0, None)
    assert told[0] == (0, 200) and told[-1] == (200, 200)
    assert [file.name for file in swept.files] == [f"rows-{k:016}-{min(k + 63, 199):016}.csv" for k in range(0, 200, 64)]
    assert catena.sweep(path, tmp_path / "out").made == 0
    catena._catena.Sweep(str(path), {}).make(str(tmp_path / "part"), "2/3", 1, "csv", None)
    rows = b"".join(content(tmp_path / "part")[name].split(b"\n", 1)[1] for name in sorted(content(tmp_path / "part")) if name.endswith("csv"))
    whole = b"".join(file.read_bytes().split(b"\n", 1)[1] for file in swept.files)
    assert rows == b"\n".join(whole.split(b"\n")[66:133]) + b"\n"


def test_runs_that_fail_are_rows_and_counted(tmp_path, robots):
    path = written(tmp_path, robots, samples=40)
    path.write_text(path.read_text() + '\n[[vary]]\nkey = "lower_arm.mass"\nnormal = [0.0, 1.0]\n')
    swept = catena.sweep(path, tmp_path / "out")
    rows = [line.split(",") for line in swept.files[0].read_text().splitlines()]
    failed = [row for row in rows if "failed" in row]
    assert swept.made == 40 and 0 < swept.failed < 40 and swept.failed == len(failed)
    index, reason = swept.first_failure
    assert str(index) == failed[0][0] and "lower_arm" in reason


def test_what_progress_raises_ends_the_sweep_and_what_was_made_stays(tmp_path, robots):
    def raises(done, runs):
        if done:
            raise OSError("nobody listens")

    path = written(tmp_path, robots, samples=600, step=2e-4)
    with pytest.raises(OSError, match="nobody listens"):
        catena.sweep(path, tmp_path / "out", progress=raises)
    assert 0 < catena.sweep(path, tmp_path / "out").made < 600


def test_a_cluster_makes_the_bytes_of_one_machine(tmp_path, robots, engine):
    path, told = written(tmp_path, robots), []
    catena.sweep(path, tmp_path / "one")
    swept = catena.sweep(path, tmp_path / "many", engine=engine, shards=7, progress=lambda done, runs: told.append(done))
    assert (swept.runs, swept.made, swept.failed) == (200, 200, 0)
    assert told == sorted(told) and (told[0], told[-1]) == (0, 200) and len(told) == 8
    assert content(tmp_path / "many") == content(tmp_path / "one")
    assert catena.sweep(path, tmp_path / "many", engine=engine).made == 0


def holder(lock):
    """The process that has this file open."""
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            if any(os.readlink(f"/proc/{process}/fd/{fd}") == str(lock) for fd in os.listdir(f"/proc/{process}/fd")):
                return int(process)
        except OSError:
            pass
    return None


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="it finds the worker in /proc, which is not here")
def test_a_worker_that_is_killed_is_replaced_and_its_rows_stay(tmp_path, robots, engine):
    path, out, killed = written(tmp_path, robots, samples=400, step=1e-4), tmp_path / "many", []

    def kill():
        # One that has rows on the disk.
        while not killed:
            for journal in out.glob("shards/shard-*/*.journal"):
                worker = holder(journal.parent / "sweep.lock")
                if worker not in (None, os.getpid()) and journal.stat().st_size > 500:
                    os.kill(worker, signal.SIGKILL)
                    return killed.append(worker)
            time.sleep(0.01)

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        swept = catena.sweep(path, out, engine=engine, shards=3)
    finally:
        finished = not thread.is_alive()
        killed.append(None)
        thread.join()
    assert finished, "nobody was killed"
    assert swept.made < swept.runs == 400, "those of the worker that was killed are not made again"
    catena.sweep(path, tmp_path / "one")
    assert content(out) == content(tmp_path / "one")


def test_a_shard_that_cannot_be_made_is_named_and_the_others_stay(tmp_path, robots, engine):
    path, out = written(tmp_path, robots), tmp_path / "many"
    (out / "shards").mkdir(parents=True)
    with pytest.raises(catena.InputError, match="holds \"shards\""):
        catena.sweep(path, out, engine=engine)
    (out / "shards").rmdir()
    catena._catena.Sweep(str(path), {}).rows_in(str(out), None)
    (out / "shards").mkdir()
    (out / "shards" / "shard-2").write_text("not a folder")
    with pytest.raises(catena.RunError, match=r"1 of 4 shards failed.*shard 2: on \S+: .*not a folder"):
        catena.sweep(path, out, engine=engine, shards=4)
    (out / "shards" / "shard-2").unlink()
    with pytest.raises(catena.InputError, match="parts of 4 shards, not of 5"):
        catena.sweep(path, out, engine=engine, shards=5)
    assert catena.sweep(path, out, engine=engine).made == 50, "three of four were there"
    catena.sweep(path, tmp_path / "one")
    assert content(out) == content(tmp_path / "one")


def test_workers_refuse_other_files_and_other_versions(tmp_path, robots):
    from catena._clusters import Shard, make

    path = written(tmp_path, robots)
    mark = catena._catena.Sweep(str(path), {}).fingerprint
    shard = {"path": str(path), "packages": {}, "folder": str(tmp_path / "out"), "number": 1, "count": 2, "jobs": 1, "format": None}
    with pytest.raises(catena.InputError, match="the sweep was begun by 0.0.0"):
        make(Shard(**shard, version="0.0.0", fingerprint=mark))
    path.write_text(path.read_text().replace("seed = 2", "seed = 3"))
    with pytest.raises(catena.InputError, match="another one than where the sweep was begun"):
        make(Shard(**shard, version=catena.__version__, fingerprint=mark))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"engine": "slurm"}, "engine is 'slurm'"),
        ({"jobs": 0}, "jobs is 0: give 1 or more"),
        ({"shards": 3}, "shards are for clusters"),
        ({"format": "xml"}, '"xml" is neither csv nor parquet'),
    ],
)
def test_wrong_options_are_named(tmp_path, robots, given, message):
    with pytest.raises(catena.InputError, match=message):
        catena.sweep(written(tmp_path, robots), tmp_path / "out", **given)
    assert not (tmp_path / "out").exists()


def test_an_engine_that_is_not_installed_is_named(tmp_path, robots, monkeypatch):
    for engine, module in [("ray", "ray"), ("dask", "distributed")]:
        monkeypatch.setitem(__import__("sys").modules, module, None)
        with pytest.raises(catena.InputError, match=f'engine "{engine}": there is no .* install it with `pip install'):
            catena.sweep(written(tmp_path, robots), tmp_path / "out", engine=engine)


def test_a_key_that_does_not_exist_is_an_error_with_its_line(tmp_path, robots):
    path = written(tmp_path, robots)
    path.write_text(path.read_text().replace("positions.shoulder", "positions.shulder"))
    with pytest.raises(catena.InputError, match="sweep.toml:.*shulder"):
        catena.sweep(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
