"""A configuration may add everything that the manifest does not define, but must not contradict it."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
import tritonclient.http as http_client

import chiasm.runtime

from .server import BUNDLES, Server, cores, parameter, tensors

NUMBERS = itertools.count()
IMAGE = {"input": np.random.default_rng(3).random((1, 3, 32, 48), np.float32)}


def refused(server: Server, *bundles: str | Path, config: str = "", model: str = "") -> str:
    """The server's error for a model. The name must be new: if Triton 2.51 fails to reload a model that it
    serves, it loses the model's new state, and waits for it at shutdown."""
    model = model or f"refused{next(NUMBERS)}"
    if bundles:
        server.add(model, *bundles, config=config)
    with pytest.raises(http_client.InferenceServerException) as error:
        server.http.load_model(model)
    assert server.http.is_server_live()
    return str(error.value)


def test_one_line_is_completed(server: Server) -> None:
    frames = server.serve("edges", "pipelines.edges")
    assert frames["max_batch_size"] == 0
    assert [(t["name"], t["data_type"], t["dims"]) for t in frames["input"] + frames["output"]] == [
        ("frame", "TYPE_UINT8", [-1, -1, 3]),
        ("output", "TYPE_UINT8", [-1, -1]),
    ]
    [group] = frames["instance_group"]
    assert (group["kind"], group["count"]) == ("KIND_CPU", cores())
    images = server.serve("sobel", "filters.sobel")
    assert images["max_batch_size"] == 4096
    assert [t["dims"] for t in images["input"] + images["output"]] == [[-1, -1, -1]] * 2
    numbers = server.serve("brighter", "enhance.adjust_brightness")
    factor = numbers["input"][1]
    assert (factor["dims"], factor["reshape"]) == ([1], {"shape": []})
    # `like` has no samples, so requests have all dimensions
    resized = server.serve("resized", "geometry.transform.resize.bilinear")
    assert resized["max_batch_size"] == 0
    assert [t["dims"] for t in resized["input"]] == [[-1, -1, -1, -1], [-1, -1]]


def test_numbers_of_a_batch(server: Server) -> None:
    server.serve("brighter", "enhance.adjust_brightness")
    inputs = {
        "image": np.full((2, 3, 8, 9), 0.25, np.float32),
        "factor": np.array([[0.5], [0.25]], np.float32),
    }
    answer = server.http.infer("brighter", tensors(http_client, inputs)).as_numpy("output")
    assert np.array_equal(answer[:, 0, 0, 0], [0.75, 0.5])


def test_instances_are_the_users(server: Server) -> None:
    config = server.serve("edges", "pipelines.edges", config="instance_group { count: 3 kind: KIND_CPU }")
    assert config["instance_group"][0]["count"] == 3
    words = refused(server, "pipelines.edges", config="instance_group { kind: KIND_MODEL }")
    assert "this backend runs on the CPU: expected KIND_CPU, got KIND_MODEL" in words


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("thread", "1", "unknown parameter 'thread'; there are method, backend, dtype, threads"),
        ("threads", "many", "parameter 'threads': expected a number from 0"),
        ("threads", "-1", "parameter 'threads': expected a number from 0"),
        ("threads", "99999999999999999999", "parameter 'threads': expected a number from 0"),
        ("threads", "", "parameter 'threads': expected a number from 0"),
        ("dtype", "float33", "parameter 'dtype': expected one of bool, uint8"),
        ("dtype", "int8", "int8"),
        ("warm_up", "yes", "parameter 'warm_up': expected true or false, got 'yes'"),
        ("allow_native_code", "0", "parameter 'allow_native_code': expected true or false, got '0'"),
        ("method", "backward", "backward"),
        ("backend", "tensorrt", "tensorrt"),
    ],
)
def test_wrong_parameters(server: Server, name: str, value: str, words: str) -> None:
    assert words in refused(server, "filters.sobel", config=parameter(name, value))


def running(server: Server, model: str) -> list[str]:
    """The metric of the running artifacts of a model, one line per version."""
    lines = [x for x in server.metrics().splitlines() if x.startswith("chiasm_model_info{")]
    return [x for x in lines if f'model="{model}"' in x]


def test_parameters(server: Server) -> None:
    """Each parameter has its effect, as the metric and the outputs show."""
    bundle = BUNDLES / "filters.sobel.chiasm"
    for backend, artifact in (("onnx", "forward.float64"), ("native", "forward.float64.x86-64-v3.pt2")):
        config = server.serve(
            "parameters",
            bundle,
            config=parameter("backend", backend)
            + parameter("dtype", "float64")
            + parameter("threads", "2")
            + parameter("warm_up", "true"),
        )
        assert config["input"][0]["data_type"] == "TYPE_FP64"
        [line] = running(server, "parameters")
        assert f'backend="{backend}"' in line and f'artifact="{artifact}' in line and line.endswith(" 1")
        image = IMAGE["input"].astype(np.float64)
        answer = server.http.infer("parameters", tensors(http_client, {"input": image})).as_numpy("output")
        method = chiasm.runtime.open(bundle).method(backend=backend, dtype="float64", num_threads=1)
        assert answer.tobytes() == np.asarray(method(image)).tobytes()
        server.unload("parameters")
        assert not running(server, "parameters")


def test_gradients_are_served(server: Server) -> None:
    server.serve("gradient", "filters.sobel", config=parameter("method", "vjp"))
    inputs = {"input": IMAGE["input"], "grad_output": np.ones_like(IMAGE["input"])}
    answer = server.http.infer("gradient", tensors(http_client, inputs)).as_numpy("grad_input")
    bundle = server.repository / "gradient" / "1" / "filters.sobel.chiasm"
    method = chiasm.runtime.open(bundle).method("vjp", backend="native", num_threads=1)
    assert answer.tobytes() == np.asarray(method(*inputs.values())).tobytes()


def test_without_native_code(server: Server) -> None:
    server.serve("data_alone", "filters.sobel", config=parameter("allow_native_code", "false"))
    [line] = running(server, "data_alone")
    assert 'backend="onnx"' in line
    server.unload("data_alone")
    config = parameter("allow_native_code", "false") + parameter("backend", "native")
    assert "native: its artifacts are programs" in refused(server, "filters.sobel", config=config)


def entry(kind: str, name: str, data_type: str, dims: list[int]) -> str:
    return f'{kind} {{ name: "{name}" data_type: {data_type} dims: {dims} }}\n'


INPUT = entry("input", "input", "TYPE_FP32", [-1, -1, -1])
OUTPUT = entry("output", "output", "TYPE_FP32", [-1, -1, -1])


def test_whole_configurations(server: Server) -> None:
    """Complete configurations that equal the manifest, and that are narrower."""
    config = server.serve("sobel", "filters.sobel", config="max_batch_size: 8\n" + INPUT + OUTPUT)
    assert config["max_batch_size"] == 8 and config["input"][0]["dims"] == [-1, -1, -1]
    narrow = entry("input", "input", "TYPE_FP32", [3, 32, 48]) + entry(
        "output", "output", "TYPE_FP32", [3, 32, 48]
    )
    server.serve("sobel", "filters.sobel", config="max_batch_size: 8\n" + narrow)
    server.http.infer("sobel", tensors(http_client, IMAGE))
    with pytest.raises(http_client.InferenceServerException, match="shape"):
        server.http.infer("sobel", tensors(http_client, {"input": IMAGE["input"][:, :, :31]}))
    # Without a batch size, all dimensions
    every = entry("input", "input", "TYPE_FP32", [-1] * 4)
    config = server.serve("sobel", "filters.sobel", config=every)
    assert config["max_batch_size"] == 0 and config["output"][0]["dims"] == [-1] * 4


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (INPUT.replace('"input"', '"image"') + OUTPUT, "lacks the bundle's input 'input'"),
        (
            INPUT + entry("input", "mask", "TYPE_BOOL", [1]) + OUTPUT,
            "has an input 'mask'; the bundle has input",
        ),
        (INPUT.replace("FP32", "UINT8") + OUTPUT, "the bundle has TYPE_FP32, got TYPE_UINT8"),
        (INPUT.replace("FP32", "STRING") + OUTPUT, "the bundle has TYPE_FP32, got TYPE_STRING"),
        (
            INPUT + OUTPUT.replace("FP32", "FP16"),
            "output 'output' of the configuration: the bundle has TYPE_FP32",
        ),
        (
            INPUT.replace("[-1, -1, -1]", "[-1, -1]") + OUTPUT,
            "the bundle has dims [-1, -1, -1] besides the batch's, got [-1, -1]",
        ),
        (INPUT.replace("[-1, ", "[100000, ") + OUTPUT, "got [100000, -1, -1]"),
        ("max_batch_size: 5000", "the bundle takes at most 4096 samples at once"),
    ],
)
def test_configurations_that_contradict(server: Server, config: str, words: str) -> None:
    batch = "" if "max_batch" in config else "max_batch_size: 8\n"
    assert words in refused(server, "filters.sobel", config=batch + config)


def test_batches_of_what_has_no_samples(server: Server) -> None:
    words = refused(server, "pipelines.edges", config="max_batch_size: 8")
    assert "max_batch_size is 8, but by the bundle's manifest" in words


def test_what_is_no_bundle(server: Server) -> None:
    server.add("none")
    assert "expected a bundle, a folder NAME.chiasm, and found none" in refused(server, model="none")
    assert "expected one bundle, found 2" in refused(server, "filters.sobel", "pipelines.edges")
    config = server.serve(
        "two", "filters.sobel", "pipelines.edges", config='default_model_filename: "pipelines.edges.chiasm"'
    )
    assert config["input"][0]["name"] == "frame"
    (server.add("file") / "sobel.chiasm").write_text("not a folder")
    assert "sobel.chiasm" in refused(server, model="file")


@pytest.mark.parametrize("file", ["manifest.json", "forward.x86-64-v3.pt2"])
def test_damaged_bundles(server: Server, file: str) -> None:
    path: Path = server.add("damaged", "pipelines.edges") / "pipelines.edges.chiasm" / file
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    assert file in refused(server, model="damaged")
    path.unlink()
    assert file in refused(server, model="damaged")


def test_strict_configurations(tmp_path: Path) -> None:
    """A server that does not complete configurations requires complete ones, and still checks them."""
    with Server(tmp_path, "--model-control-mode=explicit", "--disable-auto-complete-config") as strict:
        assert "names no input or no output" in refused(strict, "filters.sobel")
        whole = "max_batch_size: 8\n" + INPUT + OUTPUT
        strict.serve("sobel", "filters.sobel", config=whole)
        strict.http.infer("sobel", tensors(http_client, IMAGE))
        words = refused(strict, "filters.sobel", config=whole.replace("FP32", "FP16"))
        assert "the bundle has TYPE_FP32, got TYPE_FP16" in words
