"""Batches on clusters of Dask: one that is begun here, and a scheduler with workers as a user starts them."""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests import batches
from tests.batches import FLAGS, OPTIONS
from tests.support import wait_until

import graphstipple as gs
from graphstipple.batches import cluster, engines, local
from graphstipple.batches.memory import Admission
from graphstipple.batches.work import Task

distributed = pytest.importorskip("distributed")

DASK = Path(sys.executable).with_name("dask")


@pytest.fixture(scope="module")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return batches.make(tmp_path_factory.mktemp("photos"))


def test_a_cluster_of_this_machine_with_a_worker_that_is_killed(photos: Path, tmp_path: Path) -> None:
    out, results, pids = tmp_path / "out", [], []
    with cluster.local(2, dashboard=False) as client:
        pids = list(client.run(os.getpid).values())
        for result in gs.batch(photos, out, OPTIONS, scheduler=client):
            results.append(result)
            if len(results) == 50:
                os.kill(pids[0], signal.SIGKILL)
        batches.check(results)
        assert batches.drawn(out) == batches.expected()
        again = list(gs.batch(photos, out, OPTIONS, scheduler=client))
        batches.check(again)
        assert sum(result.kept for result in again) == 190
        # A photo that ends its workers is given up, and no other.
        tasks = (Task(address, (address,)) for address in ("a", "deadly", "b"))
        came = {task.address: done for task, done in cluster.draw(tasks, batches.deadly, client, Admission(100, 4), local.Stop())}
        assert came.pop("deadly").sentence == "deadly: it ended its worker each time that it was tried"
        assert {done.kind for done in came.values()} == {"drawn"}
        log = tmp_path / "log"
        wanted = [10, 60, 90, 101, 10, 80]
        tasks = (Task(str(log), (str(size),)) for size in wanted)
        came = list(cluster.draw(tasks, batches.greedy, client, Admission(100, 4), local.Stop()))
        assert [task.names for task, done in came if done.kind == "failed"] == [("101",)]
        spans = [[int(word) for word in line.split()] for line in log.read_text().splitlines()]
        assert len(spans) == len(wanted) - 1
        for begin, _, _ in spans:
            assert sum(granted for first, last, granted in spans if first <= begin <= last) <= 100


def test_the_cluster_is_reached_from_this_machine_alone() -> None:
    psutil = pytest.importorskip("psutil")
    with cluster.local(1, dashboard=False) as client:
        assert client.scheduler_info()["address"].startswith("tcp://127.0.0.1:")
        me = psutil.Process()
        sockets = [it for process in [me, *me.children(recursive=True)] for it in process.net_connections("inet")]
        listening = {it.laddr.ip for it in sockets if it.status == psutil.CONN_LISTEN}
        assert listening == {"127.0.0.1"}


def test_the_command_begins_a_cluster(photos: Path, tmp_path: Path) -> None:
    done = batches.batch(photos / "deep", "-o", "out", "--cluster", "local", "-j", "2", *FLAGS, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    expected = {name.removeprefix("deep/"): data for name, data in batches.expected().items() if name.startswith("deep/")}
    assert batches.drawn(tmp_path / "out") == expected


@contextlib.contextmanager
def started(folder: Path, workers: int, *flags: object) -> Iterator[str]:
    """Start a scheduler and workers as a user does, and return the address."""
    where = ["--no-dashboard", "--host", "127.0.0.1", *map(str, flags)]
    file = folder / "scheduler.json"
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    commands = [[DASK, "scheduler", "--port", "0", "--scheduler-file", file, *where]]
    commands += [[DASK, "worker", "--scheduler-file", file, "--nthreads", "1", "--no-nanny", *where]] * workers
    with contextlib.ExitStack() as ending:
        for command in commands:
            process = subprocess.Popen(
                command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL
            )
            ending.callback(process.wait, 60)
            ending.callback(process.terminate)
            wait_until(lambda: file.exists() and file.read_text().endswith("}"))
        yield json.loads(file.read_text())["address"]


def test_a_scheduler_and_two_workers_as_a_user_starts_them(photos: Path, tmp_path: Path) -> None:
    with started(tmp_path, 2) as address:
        done = batches.batch(photos, "-o", tmp_path / "out", "--scheduler", address, *FLAGS, cwd=tmp_path)
        assert "190 drawn, 10 failed" in done.stderr, done.stderr
        assert batches.drawn(tmp_path / "out") == batches.expected()
        again = batches.batch(photos, "-o", tmp_path / "out", "--scheduler", address, *FLAGS, cwd=tmp_path)
        assert "190 kept, 10 failed" in again.stderr, again.stderr


def test_from_s3_to_s3_by_workers(photos: Path, tmp_path: Path, s3: str) -> None:
    import s3fs

    files = s3fs.S3FileSystem()
    files.mkdir("photos")
    files.mkdir("drawings")
    files.pipe({f"photos/in/{path.relative_to(photos).as_posix()}": path.read_bytes() for path in photos.glob("photo 0[01]*.png")})
    with started(tmp_path, 1) as address:
        done = batches.batch("s3://photos/in", "-o", "s3://drawings/out", "--scheduler", address, *FLAGS, cwd=tmp_path)
    expected = {name: data for name, data in batches.expected().items() if name.startswith(("photo 00", "photo 01"))}
    files.invalidate_cache()
    found = files.cat(files.find("drawings/out"))
    assert {name.removeprefix("drawings/out/"): data for name, data in found.items()} == expected, done.stderr


def certificate(folder: Path) -> tuple[str, str]:
    """Write a certificate that signs itself, and its key, and return their files."""
    x509 = pytest.importorskip("cryptography.x509")
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "of a test")])
    now = datetime.datetime.now(datetime.timezone.utc)
    builder = x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
    builder = builder.not_valid_before(now - datetime.timedelta(days=1)).not_valid_after(now + datetime.timedelta(days=1))
    made = builder.sign(key, hashes.SHA256())
    private = serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    (folder / "cert.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    (folder / "key.pem").write_bytes(key.private_bytes(serialization.Encoding.PEM, *private))
    return str(folder / "cert.pem"), str(folder / "key.pem")


def test_certificates_are_asked_for(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cert, key = certificate(tmp_path)
    tls = ("--tls-ca", cert, "--tls-cert", cert, "--tls-key", key)
    with started(tmp_path, 1, "--tls-ca-file", cert, "--tls-cert", cert, "--tls-key", key, "--protocol", "tls") as address:
        assert address.startswith("tls://")
        done = batches.batch(photos / "photo 001.png", "-o", tmp_path / "out", "--scheduler", address, *tls, *FLAGS, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert batches.drawn(tmp_path / "out") == {"photo 001.svg": batches.expected()["photo 001.svg"]}
        monkeypatch.setattr(cluster, "PATIENCE", 0.5)
        with pytest.raises(gs.GraphStippleError, match="there is no scheduler that answers"):
            cluster.connect(address.replace("tls:", "tcp:"))


def test_a_scheduler_that_is_not_there_is_one_sentence(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with pytest.raises(gs.GraphStippleError, match="there is no scheduler that answers"):
        next(gs.batch(photos, tmp_path / "out", scheduler="tcp://127.0.0.1:9"))


def test_a_worker_that_does_not_see_the_output_ends_the_batch(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with cluster.local(1, dashboard=False) as client:
        monkeypatch.setattr(cluster, "_look", _looked_elsewhere)
        with pytest.raises(gs.GraphStippleError, match="does not see the folder"):
            next(gs.batch(photos, tmp_path / "out", scheduler=client))
    assert batches.drawn(tmp_path / "out") == {}
    assert engines.memory_of("8GB") == 8 * 10**9


def _looked_elsewhere(mark: str) -> tuple[str, bool]:
    return gs.__version__, not Path(mark).exists()
