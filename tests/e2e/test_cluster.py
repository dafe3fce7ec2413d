"""A batch on a Dask cluster: lost workers, workers with threads, a scheduler that dies."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from paint3d.cli.batches import cluster as batch_cluster
from paint3d.cli.batches.cluster import run_on_cluster
from paint3d.cli.batches.rows import Row
from paint3d.errors import InputError

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None, reason="distributed is not installed"
)

PATIENCE_S = 300
# Loaded by every worker: what rows do is told by their output's name.
PRELOAD = """
import os, signal, time
from pathlib import Path

from distributed import get_worker
from paint3d.cli.batches import cluster
from paint3d.cli.batches.rows import Outcome

def run(row):
    out = Path(row.arguments[1].removeprefix("--out="))
    if row.output == "always" or (row.output == "once" and not out.exists()):
        out.write_text("begun")
        os.kill(os.getpid(), signal.SIGKILL)
    if row.output == "long":
        time.sleep(600)
    out.write_text(get_worker().name)
    return Outcome(row.line, "", os.getpid(), str(out))

def dask_setup(worker):
    cluster.run_row = run
    if worker.name.endswith("blind"):
        os.chdir("/")
        cluster.os.path.isdir = lambda folder: False
"""


class Cluster:
    """A scheduler and workers, each a process."""

    def __init__(self, folder: Path, protocol: str = "tcp", **environment: str) -> None:
        self._folder, self._running, self._environment = folder, [], environment
        (folder / "preload.py").write_text(PRELOAD)
        known = folder / "scheduler.json"
        self.scheduler = self._start(
            "scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", known,
            "--protocol", protocol,
        )  # fmt: skip
        began = time.monotonic()
        while not (known.exists() and known.read_text().endswith("}")):
            assert time.monotonic() - began < PATIENCE_S, "there is no scheduler"
            time.sleep(0.05)
        self.address = json.loads(known.read_text())["address"]

    def add_worker(self, name: str, threads: int = 1) -> None:
        """One without a nanny, which would be a process more, and start another for a dead one."""
        self._start(
            "worker", self.address, "--name", name, "--nthreads", threads, "--no-dashboard",
            "--no-nanny", "--preload", self._folder / "preload.py",
            "--local-directory", self._folder,
        )  # fmt: skip

    def _start(self, kind: str, *arguments: object) -> subprocess.Popen:
        command = [sys.executable, "-W", "ignore", "-m", f"distributed.cli.dask_{kind}"]
        environment = {
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
            "PYTHONPATH": os.pathsep.join(sys.path),
        }
        running = subprocess.Popen(
            [*command, *map(str, arguments)],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, **environment, **self._environment}, cwd="/", start_new_session=True,
        )  # fmt: skip
        self._running.append(running)
        return running

    def close(self) -> None:
        for running in self._running:  # a group each
            with suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
        for running in self._running:
            running.wait(PATIENCE_S)


@pytest.fixture
def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    (tmp_path / "dask").mkdir()
    made = Cluster(tmp_path / "dask")
    yield made
    made.close()


def rows(*outputs: str) -> list[Row]:
    return [Row(k, name, ("write", f"--out={name}", "--", "永")) for k, name in enumerate(outputs)]


def test_a_row_that_loses_its_worker_is_run_by_another(cluster: Cluster) -> None:
    for name in "abcd":  # three die
        cluster.add_worker(name)
    outcomes = sorted(run_on_cluster(rows("x", "once", "y", "always", "z"), cluster.address))
    assert [outcome.message for outcome in outcomes[:3]] == ["", "", ""]
    assert outcomes[3].message == "its worker died, and another too"
    assert outcomes[4].message == ""


def test_threads_of_one_worker_find_the_files_of_the_batch(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cluster.add_worker("a", threads=2)
    other = tmp_path / "other"
    other.mkdir()
    here = run_on_cluster(rows(*"abcdef"), cluster.address)
    next(here)
    monkeypatch.chdir(other)
    assert len(list(run_on_cluster(rows(*"ghijkl"), cluster.address))) == 6
    assert len(list(here)) == 5
    assert {path.name for path in (tmp_path / "work").iterdir()} == set("abcdef")
    assert {path.name for path in other.iterdir()} == set("ghijkl")


def test_a_worker_that_does_not_see_the_folder_is_passed_over(cluster: Cluster) -> None:
    cluster.add_worker("blind")
    outcome = next(run_on_cluster(rows("x"), cluster.address))
    assert outcome.message == f"no worker sees the folder {Path.cwd()}"
    cluster.add_worker("seeing")
    from distributed import Client

    with Client(cluster.address) as client:
        client.wait_for_workers(2, PATIENCE_S)
    outcomes = list(run_on_cluster(rows(*"abcd"), cluster.address))
    assert [outcome.message for outcome in outcomes] == [""] * 4
    assert {path.read_text() for path in Path.cwd().iterdir()} == {"seeing"}


def test_a_scheduler_that_dies_is_named(cluster: Cluster) -> None:
    cluster.add_worker("a")
    coming = run_on_cluster(rows("x", "long", "y"), cluster.address)
    assert next(coming).message == ""
    os.killpg(cluster.scheduler.pid, signal.SIGKILL)
    with pytest.raises(InputError, match=f"the scheduler {cluster.address} no longer answers"):
        list(coming)


@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes a certificate")
def test_a_cluster_with_certificates_is_closed_to_those_without(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch_cluster, "PATIENCE_S", 5)
    key, certificate = tmp_path / "key.pem", tmp_path / "cert.pem"
    command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1"]
    command += ["-subj", "/CN=paint3d", "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(command, check=True, capture_output=True)
    settings = {"tls.ca-file": str(certificate), "require-encryption": "true"}
    for role in ("scheduler", "worker", "client"):
        settings |= {f"tls.{role}.cert": str(certificate), f"tls.{role}.key": str(key)}
    settings = {f"distributed.comm.{name}": text for name, text in settings.items()}
    told = {
        "DASK_" + name.upper().replace(".", "__").replace("-", "_"): text
        for name, text in settings.items()
    }
    cluster = Cluster(tmp_path, "tls", **told)
    try:
        assert cluster.address.startswith("tls://")
        with pytest.raises(InputError, match="does not answer"):
            list(run_on_cluster(rows("a"), cluster.address))
        cluster.add_worker("one")
        import dask

        with dask.config.set(settings):
            (outcome,) = run_on_cluster(rows("a"), cluster.address)
        assert outcome.message == ""
        assert Path(outcome.version).read_text() == "one"
    finally:
        cluster.close()
