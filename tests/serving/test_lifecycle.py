"""Models are loaded and unloaded while requests are in progress."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tritonclient.grpc as grpc_client
import tritonclient.http as http_client

import chiasm.runtime
from chiasm.export import signing

from .server import BUNDLES, Server, tensors, write_model

CYCLES = 200
ROUNDS = 5
MOST_GROWTH = 5 << 20
#: Environment variables with which freed memory goes back to the system, so that the process's memory is the
#: memory in use.
FRUGAL = {
    "MALLOC_ARENA_MAX": "1",
    "MALLOC_MMAP_THRESHOLD_": "65536",
    "MALLOC_TRIM_THRESHOLD_": "65536",
}
FRAME = np.random.default_rng(5).integers(0, 256, (480, 640, 3), np.uint8)


def right() -> bytes:
    method = chiasm.runtime.open(BUNDLES / "pipelines.edges.chiasm").method(backend="native", num_threads=1)
    return np.asarray(method(FRAME)).tobytes()


def infer(server: Server) -> bytes:
    return server.grpc.infer("edges", tensors(grpc_client, {"frame": FRAME})).as_numpy("output").tobytes()


def test_loading_and_unloading_frees_everything(tmp_path: Path) -> None:
    """Both by resident memory and by memory that is allocated but never touched."""
    with Server(tmp_path, "--model-control-mode=explicit", variables=FRUGAL) as server:
        server.add("edges", "pipelines.edges")
        expected = right()

        def cycle() -> None:
            server.http.load_model("edges")
            assert infer(server) == expected
            server.unload("edges")

        # The server's own memory grows for a while, on some machines longer than on others. A leak in each
        # cycle grows for ever.
        grown: list[dict[str, int]] = []
        for _ in range(ROUNDS):
            before = server.memory()
            for _ in range(CYCLES):
                cycle()
            grown.append({kind: bytes - before[kind] for kind, bytes in server.memory().items()})
            if all(growth < MOST_GROWTH for growth in grown[-1].values()):
                return
        pytest.fail(f"{CYCLES} cycles, again and again, grew the server by {grown} bytes")


def test_unloading_with_requests_on_the_way(server: Server) -> None:
    """Each request gets a correct answer or the error that there is no such model; none is lost."""
    server.add("edges", "pipelines.edges")
    expected, answers, count = right(), [], 300
    done = threading.Semaphore(0)

    def note(result: Any, error: Any) -> None:
        answers.append(error or result.as_numpy("output").tobytes())
        done.release()

    send: Callable[..., Any] = server.grpc.async_infer
    for _ in range(3):
        server.http.load_model("edges")
        answers.clear()
        for _ in range(count):
            send("edges", tensors(grpc_client, {"frame": FRAME}), note)
        server.unload("edges")
        for _ in range(count):
            assert done.acquire(timeout=120), f"{len(answers)} of {count} answers came"
        good = [a for a in answers if isinstance(a, bytes)]
        assert good and all(a == expected for a in good)
        for error in answers:
            assert isinstance(error, bytes) or "edges" in str(error), error


def test_shutdown_with_requests_on_the_way(tmp_path: Path) -> None:
    """The server's own exit status: 0 (checked where it is closed).

    By HTTP, because Triton's own gRPC endpoint sometimes crashes if requests are cancelled while it ends.
    """
    answers: list[Any] = []
    with Server(tmp_path, "--model-control-mode=explicit") as server:
        server.serve("edges", "pipelines.edges")
        expected = right()
        assert infer(server) == expected

        def ask() -> None:
            with http_client.InferenceServerClient(f"127.0.0.1:{server.http_port}") as client:
                for _ in range(25):
                    try:
                        result = client.infer("edges", tensors(http_client, {"frame": FRAME}))
                    except (http_client.InferenceServerException, OSError) as error:
                        answers.append(error)
                        return
                    answers.append(np.asarray(result.as_numpy("output")).tobytes())

        clients = [threading.Thread(target=ask) for _ in range(4)]
        for client in clients:
            client.start()
        while len(answers) < 4:
            assert any(client.is_alive() for client in clients)
    for client in clients:
        client.join()
    good = [a for a in answers if isinstance(a, bytes)]
    assert len(good) >= 4 and all(a == expected for a in good)
    assert "Segmentation" not in server.log() and "Signal (11)" not in server.log()


def test_a_repository_at_the_start(tmp_path: Path) -> None:
    """Without explicit model control: good models are served although another is bad."""
    write_model(tmp_path / "models" / "edges", "pipelines.edges")
    write_model(tmp_path / "models" / "bad")
    with Server(tmp_path, "--exit-on-error=false", "--strict-readiness=false") as server:
        assert infer(server) == right()
        states = {m["name"]: m for m in server.http.get_model_repository_index()}
        assert states["edges"]["state"] == "READY" and "NAME.chiasm" in states["bad"]["reason"]


def test_signed_bundles_alone(tmp_path: Path) -> None:
    """The process's trust policy also applies in a server."""
    public, secret = tmp_path / "key.pub", tmp_path / "key"
    subprocess.run(
        ["minisign", "-G", "-W", "-p", public, "-s", secret], check=True, stdout=subprocess.DEVNULL
    )
    policy = {"CHIASM_TRUST_POLICY": "signed", "CHIASM_TRUSTED_KEYS": str(public)}
    with Server(tmp_path, "--model-control-mode=explicit", variables=policy) as server:
        server.add("unsigned", "pipelines.edges")
        with pytest.raises(http_client.InferenceServerException, match="not signed"):
            server.http.load_model("unsigned")
        version = server.add("edges", "pipelines.edges")
        signing.sign(version / "pipelines.edges.chiasm", signing.read_secret_key(secret, str))
        server.http.load_model("edges")
        assert infer(server) == right()
