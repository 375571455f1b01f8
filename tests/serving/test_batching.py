"""Requests that Triton passes together: each is answered as if it had come alone."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
import tritonclient.http as http_client

import chiasm.runtime

from .server import BUNDLES, Server, tensors

RANDOM = np.random.default_rng(11)
TOGETHER = """
max_batch_size: 64
instance_group { count: 1 kind: KIND_CPU }
dynamic_batching { preferred_batch_size: 8 max_queue_delay_microseconds: 5000000 }
"""
SHAPES = [(3, 8, 9), (1, 31, 17), (3, 480, 640), (3, 8, 9), (2, 64, 64), (4, 100, 30), (3, 33, 65), (1, 8, 8)]


@pytest.fixture
def sobel(server: Server) -> str:
    server.serve("sobel", "filters.sobel", config=TOGETHER)
    return "sobel"


def counts(server: Server, model: str) -> dict[str, Any]:
    statistics = server.statistics(model)
    return {
        "requests": statistics["inference_count"],
        "executions": statistics["execution_count"],
        "failures": statistics["inference_stats"]["fail"]["count"],
        "batches": {b["batch_size"]: b["compute_infer"]["count"] for b in statistics["batch_stats"]},
        "times": statistics["inference_stats"],
    }


def counts_after(server: Server, model: str, before: dict[str, Any]) -> dict[str, Any]:
    """The changed counts: Triton counts an execution after its answers are sent."""
    for _ in range(500):
        after = counts(server, model)
        if after["executions"] > before["executions"]:
            return after
        time.sleep(0.01)
    raise AssertionError("no execution was counted")


def ask_at_once(server: Server, model: str, images: list[np.ndarray]) -> list[Any]:
    """The result of each of eight simultaneous requests: an array, or the error."""
    with ThreadPoolExecutor(len(images)) as pool:
        return list(pool.map(lambda image: ask(server, model, image), images))


def ask(server: Server, model: str, image: np.ndarray) -> Any:
    """Send a request by a new client, because a client is for one thread."""
    with http_client.InferenceServerClient(f"127.0.0.1:{server.http_port}") as client:
        try:
            return client.infer(model, tensors(http_client, {"input": image})).as_numpy("output")
        except http_client.InferenceServerException as error:
            return error


def right(image: np.ndarray) -> np.ndarray:
    method = chiasm.runtime.open(BUNDLES / "filters.sobel.chiasm").method(backend="native", num_threads=1)
    return np.asarray(method(image))


def test_eight_of_different_shapes_at_once(server: Server, sobel: str) -> None:
    images = [RANDOM.random((1, *shape), np.float32) for shape in SHAPES]
    before = counts(server, sobel)
    answers = ask_at_once(server, sobel, images)
    for image, answer in zip(images, answers):
        assert isinstance(answer, np.ndarray), answer
        assert answer.tobytes() == right(image).tobytes() and answer.shape == image.shape
    after = counts_after(server, sobel, before)
    assert after["requests"] - before["requests"] == 8
    assert after["executions"] - before["executions"] == 1
    assert after["batches"][8] - before["batches"].get(8, 0) == 1


def test_one_bad_of_eight_fails_alone(server: Server, sobel: str) -> None:
    images = [RANDOM.random((1, *shape), np.float32) for shape in SHAPES]
    images[3] = images[3][:, :, :4]  # an image must have eight rows
    before = counts(server, sobel)
    answers = ask_at_once(server, sobel, images)
    bad = answers.pop(3)
    assert isinstance(bad, http_client.InferenceServerException) and bad.status() == "400"
    assert "input 'input': expected shape (B, C, H, W), got (1, 3, 4, 9): H must be from" in str(bad)
    for image, answer in zip(images[:3] + images[4:], answers):
        assert isinstance(answer, np.ndarray), answer
        assert answer.tobytes() == right(image).tobytes()
    after = counts_after(server, sobel, before)
    assert after["failures"] - before["failures"] == 1
    assert after["executions"] - before["executions"] == 1
    assert after["batches"][7] - before["batches"].get(7, 0) == 1


def test_all_bad(server: Server, sobel: str) -> None:
    answers = ask_at_once(server, sobel, [np.zeros((1, 3, 4, 4), np.float32)] * 8)
    assert all(isinstance(a, http_client.InferenceServerException) and a.status() == "400" for a in answers)


def test_samples_of_one_request(server: Server) -> None:
    server.serve("plain", "filters.sobel")
    images = RANDOM.random((5, 3, 20, 30), np.float32)
    before = counts(server, "plain")
    answer = server.http.infer("plain", tensors(http_client, {"input": images})).as_numpy("output")
    assert answer.tobytes() == right(images).tobytes()
    after = counts_after(server, "plain", before)
    assert after["requests"] - before["requests"] == 5  # Triton counts samples
    assert after["batches"][5] - before["batches"].get(5, 0) == 1


def test_times_are_reported(server: Server) -> None:
    server.serve("plain", "filters.sobel")
    before = counts(server, "plain")
    for _ in range(5):
        server.http.infer(
            "plain", tensors(http_client, {"input": RANDOM.random((1, 3, 480, 640), np.float32)})
        )
    times = counts_after(server, "plain", before)["times"]
    for kind in ("compute_input", "compute_infer", "compute_output", "success"):
        assert times[kind]["count"] > 0 and times[kind]["ns"] > 0, kind
    assert times["compute_infer"]["ns"] < times["success"]["ns"]
    metrics = server.metrics()
    assert 'nv_inference_compute_infer_duration_us{model="plain",version="1"}' in metrics
