"""Sweeps on a real Dask cluster on this machine give the same results, even if a worker is killed."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.analysis import survey
from hapkit_studio.analysis.cluster import ClusterError, cluster
from hapkit_studio.analysis.stability import rendered
from hapkit_studio.analysis.sweeps import sweep
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import StudioError
from tests.analysis import sweep_tasks
from tests.waiting import PATIENCE

ROOT = Path(__file__).resolve().parents[2]
CELLS = [0.25 * i for i in range(6000)]


class Dask:
    """A Dask scheduler and two workers, each in its own process."""

    def __init__(self, folder: Path):
        self._environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        self._folder = folder
        self.scheduler = self._start("scheduler", "--no-dashboard", "--host", "127.0.0.1", "--port", "0")
        self.address = self._address()
        self.workers = [self._worker(name) for name in ("one", "two")]

    def _start(self, what: str, *options: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "dask", what, *options]
        return subprocess.Popen(
            command, env=self._environment, cwd=self._folder, stderr=subprocess.PIPE, text=True
        )

    def _address(self) -> str:
        """Return the address printed by the scheduler."""
        assert self.scheduler.stderr is not None
        for line in self.scheduler.stderr:
            if "Scheduler at:" in line:
                return line.split("Scheduler at:")[1].strip()
        raise AssertionError("the scheduler ended without an address")

    def _worker(self, name: str) -> subprocess.Popen:
        options = ("--nworkers", "1", "--nthreads", "1", "--no-nanny", "--no-dashboard", "--name", name)
        return self._start("worker", self.address, *options)

    def close(self) -> None:
        for program in (*self.workers, self.scheduler):
            program.kill()
            program.communicate()


@pytest.fixture
def dask(tmp_path):
    pytest.importorskip("distributed")
    made = Dask(tmp_path)
    yield made
    made.close()


@pytest.mark.slow
def test_results_survive_a_killed_worker_and_a_lost_scheduler_is_reported(dask, capfd):
    setting, damping = LoopSettings(delay=0.4e-3), np.linspace(0.0, 20.0, 7)
    with ThreadPoolExecutor(2) as threads:  # compile before the workers start
        wanted = rendered.boundary(setting, damping, executor=threads)
        roots = sweep(sweep_tasks.busy_roots, CELLS, executor=threads)
    with cluster(dask.address, timeout=PATIENCE) as executor:
        executor.client.wait_for_workers(2, timeout=PATIENCE)
        assert (rendered.boundary(setting, damping, executor=executor) == wanted).all()
        placed = sweep(sweep_tasks.roots_and_place, CELLS, executor=executor, chunk=100)
        assert {place for _, place in placed} == {worker.pid for worker in dask.workers}

        reports = []

        def kill_in_the_middle(done, of):
            reports.append(done)
            if done > len(CELLS) // 3 and dask.workers[0].poll() is None:
                dask.workers[0].send_signal(signal.SIGKILL)
                dask.workers[0].wait(30.0)

        found = sweep(sweep_tasks.busy_roots, CELLS, executor=executor, progress=kill_in_the_middle, chunk=50)
        assert dask.workers[0].poll() == -signal.SIGKILL
        assert found == roots
        assert [root for root, _ in placed] == roots
        assert reports == sorted(reports)
        assert reports[-1] == len(CELLS)

        def kill_the_scheduler(done, of):
            if done:
                dask.scheduler.kill()

        with pytest.raises(StudioError, match="A part of the work was lost"):
            sweep(sweep_tasks.busy_roots, CELLS, executor=executor, progress=kill_the_scheduler, chunk=50)
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.slow
def test_a_survey_on_a_cluster_equals_a_local_one_even_if_a_worker_dies(dask, tmp_path):
    axes, there, here = survey.usual_axes(2, 1), tmp_path / "cluster", tmp_path / "here"

    def kill_in_the_middle(done, of):
        if done > of // 3 and dask.workers[0].poll() is None:
            dask.workers[0].send_signal(signal.SIGKILL)
            dask.workers[0].wait(30.0)

    with cluster(dask.address, timeout=PATIENCE) as executor:
        executor.client.wait_for_workers(2, timeout=PATIENCE)
        survey.compute(there, axes, executor, kill_in_the_middle)
    assert dask.workers[0].poll() == -signal.SIGKILL
    survey.compute(here, axes)
    np.testing.assert_array_equal(survey.read(there)[1], survey.read(here)[1])


def test_an_unreachable_scheduler_gives_a_one_line_error():
    pytest.importorskip("distributed")
    for address in ("tcp://127.0.0.1:1", "nonsense"):
        with (
            pytest.raises(ClusterError, match=f"No Dask scheduler answers at {address}: start one") as e,
            cluster(address, timeout=0.5),
        ):
            pass
        assert "\n" not in str(e.value)


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(ClusterError, match=r'pip install "hapkit-studio\[cluster\]"'),
        cluster("tcp://127.0.0.1:1"),
    ):
        pass
