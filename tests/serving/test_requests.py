"""Clients get the bits of chiasm.runtime, by every protocol and for every element type."""

from __future__ import annotations

import http.client
import json
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import tritonclient.grpc as grpc_client
import tritonclient.http as http_client
from torch import Tensor
from tritonclient.utils import shared_memory

import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export

from .server import BUNDLES, Server, parameter, post, tensors

RANDOM = np.random.default_rng(7)
FRAME = RANDOM.integers(0, 256, (480, 640, 3), np.uint8)
TYPES = ("bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "float16", "float32", "float64")


def expected(
    bundle: str | Path, inputs: Mapping[str, np.ndarray], backend: str = "native"
) -> list[np.ndarray]:
    path = bundle if isinstance(bundle, Path) else BUNDLES / f"{bundle}.chiasm"
    done = chiasm.runtime.open(path).method(backend=backend, num_threads=1)(*inputs.values())
    return [np.asarray(each) for each in (done if isinstance(done, tuple) else (done,))]


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def ask(server: Server, protocol: str, model: str, inputs: Mapping[str, np.ndarray], **options: Any) -> Any:
    module, client = (http_client, server.http) if protocol == "http" else (grpc_client, server.grpc)
    return client.infer(model, tensors(module, inputs), **options)


@pytest.fixture(scope="module")
def edges(server: Server) -> str:
    server.serve("edges", "pipelines.edges")
    return "edges"


@pytest.mark.parametrize("protocol", ["http", "grpc"])
@pytest.mark.parametrize("shape", [(8, 8, 3), (480, 640, 3), (1080, 1920, 3), (333, 77, 3)])
def test_frames(server: Server, edges: str, protocol: str, shape: tuple[int, ...]) -> None:
    inputs = {"frame": RANDOM.integers(0, 256, shape, np.uint8)}
    answer = ask(server, protocol, edges, inputs)
    assert same_bits(answer.as_numpy("output"), expected("pipelines.edges", inputs)[0])


@pytest.mark.parametrize("protocol", ["http", "grpc"])
def test_images_on_any_address(server: Server, protocol: str) -> None:
    """In HTTP, the bytes follow a header of any length: the length of the request's name changes their
    alignment."""
    server.serve("sobel", "filters.sobel")
    inputs = {"input": RANDOM.random((2, 3, 41, 53), np.float32)}
    for length in range(1, 9):
        answer = ask(server, protocol, "sobel", inputs, request_id="x" * length)
        assert same_bits(answer.as_numpy("output"), expected("filters.sobel", inputs)[0])


def test_large_tensors_in_pieces(server: Server) -> None:
    server.serve("sobel", "filters.sobel")
    inputs = {"input": RANDOM.random((2, 3, 1080, 1920), np.float32)}
    answer = ask(server, "http", "sobel", inputs)
    assert same_bits(answer.as_numpy("output"), expected("filters.sobel", inputs)[0])


def rolled(
    a: Tensor,
    b: Tensor,
    c: Tensor,
    d: Tensor,
    e: Tensor,
    f: Tensor,
    g: Tensor,
    h: Tensor,
    i: Tensor,
    j: Tensor,
) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
    """Tensors of every type, with their columns rotated by one."""
    return (
        torch.cat([a[:, 1:], a[:, :1]], 1),
        torch.cat([b[:, 1:], b[:, :1]], 1),
        torch.cat([c[:, 1:], c[:, :1]], 1),
        torch.cat([d[:, 1:], d[:, :1]], 1),
        torch.cat([e[:, 1:], e[:, :1]], 1),
        torch.cat([f[:, 1:], f[:, :1]], 1),
        torch.cat([g[:, 1:], g[:, :1]], 1),
        torch.cat([h[:, 1:], h[:, :1]], 1),
        torch.cat([i[:, 1:], i[:, :1]], 1),
        torch.cat([j[:, 1:], j[:, :1]], 1),
    )


def scaled(x: Tensor, factor: Tensor) -> tuple[Tensor, Tensor]:
    """x scaled by a number, and the mean of x."""
    return x * factor, x.mean()


@pytest.fixture(scope="module")
def own_bundles(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("own")
    every_type = Spec(
        "test.rolled",
        [TensorSpec(name, ("M", "N"), dtype) for name, dtype in zip("abcdefghij", TYPES)],
        [TensorSpec(f"{name}_out") for name in "abcdefghij"],
        symbols={"M": (1, 64), "N": (4, 512)},
    )
    numbers = Spec(
        "test.scaled",
        [TensorSpec("x", ("N",), "float32"), TensorSpec("factor", (), "float32")],
        [TensorSpec("output"), TensorSpec("mean")],
    )
    return (
        export(rolled, every_type, folder, formats=("onnx",), methods=("forward",)),
        export(scaled, numbers, folder, formats=("onnx",), methods=("forward",)),
    )


@pytest.mark.parametrize("protocol", ["http", "grpc"])
def test_every_type(server: Server, own_bundles: tuple[Path, Path], protocol: str) -> None:
    config = server.serve("rolled", own_bundles[0])
    assert [entry["data_type"] for entry in config["input"]] == [
        "TYPE_" + name.upper().replace("FLOAT", "FP") for name in TYPES
    ]
    inputs = {
        name: RANDOM.integers(0, 2 if dtype == "bool" else 100, (5, 9)).astype(dtype)
        for name, dtype in zip("abcdefghij", TYPES)
    }
    answer = ask(server, protocol, "rolled", inputs)
    for name, array in inputs.items():
        assert same_bits(answer.as_numpy(f"{name}_out"), np.roll(array, -1, axis=1))


@pytest.mark.parametrize("protocol", ["http", "grpc"])
def test_numbers_without_dimensions(server: Server, own_bundles: tuple[Path, Path], protocol: str) -> None:
    config = server.serve("scaled", own_bundles[1])
    assert config["input"][1]["dims"] == [1] and config["output"][1]["dims"] == [1]
    x = np.arange(7, dtype=np.float32)
    answer = ask(server, protocol, "scaled", {"x": x, "factor": np.array([3], np.float32)})
    assert np.array_equal(answer.as_numpy("output"), x * 3)
    assert np.array_equal(answer.as_numpy("mean"), [3])


def test_dims_of_a_number(server: Server, own_bundles: tuple[Path, Path]) -> None:
    config = "".join(
        f'input {{ name: "{name}" data_type: TYPE_FP32 dims: {dims} }}\n'
        for name, dims in (("x", [-1]), ("factor", [2]))
    )
    server.add("two_factors", own_bundles[1], config=config)
    words = r"input 'factor' of the configuration: the bundle has dims \[1\], got \[2\]"
    with pytest.raises(http_client.InferenceServerException, match=words):
        server.http.load_model("two_factors")


def test_bfloat16(server: Server) -> None:
    config = server.serve("grey", "color.rgb_to_grayscale", config=parameter("dtype", "bfloat16"))
    assert config["input"][0]["data_type"] == "TYPE_BF16"
    image = torch.rand(2, 3, 16, 20).bfloat16()
    request = grpc_client.InferInput("image", list(image.shape), "BF16")
    request._raw_content = image.view(torch.int16).numpy().tobytes()  # NumPy has no such type
    answer = server.grpc.infer("grey", [request])
    method = chiasm.runtime.open(BUNDLES / "color.rgb_to_grayscale.chiasm").method(dtype="bfloat16")
    wanted = torch.from_dlpack(method(image)).view(torch.int16).numpy().tobytes()
    assert answer.get_response().raw_output_contents[0] == wanted


def test_only_the_outputs_that_are_asked_for(server: Server, own_bundles: tuple[Path, Path]) -> None:
    server.serve("scaled", own_bundles[1])
    inputs = {"x": np.ones(4, np.float32), "factor": np.array([2], np.float32)}
    answer = ask(
        server, "grpc", "scaled", inputs, outputs=[grpc_client.InferRequestedOutput("mean")]
    ).get_response()
    assert [output.name for output in answer.outputs] == ["mean"]


@pytest.fixture
def region(server: Server) -> Iterator[tuple[str, Any]]:
    name = f"chiasm_{uuid.uuid4().hex}"
    handle = shared_memory.create_shared_memory_region(name, f"/{name}", 1 << 20)
    server.http.register_system_shared_memory(name, f"/{name}", 1 << 20)
    yield name, handle
    server.http.unregister_system_shared_memory(name)
    shared_memory.destroy_shared_memory_region(handle)


@pytest.mark.parametrize("protocol", ["http", "grpc"])
@pytest.mark.parametrize("offset", [0, 1, 64])
def test_system_shared_memory(server: Server, region: tuple[str, Any], protocol: str, offset: int) -> None:
    """Input and output in one region, also if neither tensor is aligned."""
    server.serve("sobel", "filters.sobel")
    name, handle = region
    image = RANDOM.random((1, 3, 64, 96), np.float32)
    shared_memory.set_shared_memory_region(handle, [image], offset=offset)
    module, client = (http_client, server.http) if protocol == "http" else (grpc_client, server.grpc)
    sent = module.InferInput("input", list(image.shape), "FP32")
    sent.set_shared_memory(name, image.nbytes, offset=offset)
    wanted = module.InferRequestedOutput("output")
    wanted.set_shared_memory(name, image.nbytes, offset=(1 << 19) + offset)
    client.infer("sobel", [sent], outputs=[wanted])
    got = shared_memory.get_contents_as_numpy(handle, np.uint8, [1 << 20])
    start = (1 << 19) + offset
    assert got[start : start + image.nbytes].tobytes() == expected("filters.sobel", {"i": image})[0].tobytes()


def test_overlapping_shared_memory_is_refused(server: Server, region: tuple[str, Any]) -> None:
    server.serve("sobel", "filters.sobel")
    name, handle = region
    image = RANDOM.random((1, 3, 64, 96), np.float32)
    shared_memory.set_shared_memory_region(handle, [image])
    sent = http_client.InferInput("input", list(image.shape), "FP32")
    sent.set_shared_memory(name, image.nbytes)
    wanted = http_client.InferRequestedOutput("output")
    wanted.set_shared_memory(name, image.nbytes, offset=64)
    with pytest.raises(http_client.InferenceServerException, match="overlap"):
        server.http.infer("sobel", [sent], outputs=[wanted])


def body(*inputs: dict[str, Any]) -> bytes:
    return json.dumps({"inputs": list(inputs)}).encode()


def test_refusals_are_400_and_say_why(server: Server, edges: str) -> None:
    frame = {"name": "frame", "datatype": "UINT8", "shape": [16, 16, 3], "data": [0] * 768}
    small = frame | {"shape": [4, 4, 3], "data": [0] * 48}
    status, text = post(server, edges, body(small))
    assert status == 400
    assert "input 'frame': expected shape (H, W, 3), got (4, 4, 3): H must be from 8 to 32768" in text
    for broken, words in (
        ([frame | {"shape": [0, 16, 3], "data": []}], "H must be from 8"),
        ([frame | {"shape": [16, 16, 4], "data": [0] * 1024}], "frame"),
        ([frame | {"shape": [1, 16, 16, 3]}], "frame"),
        ([frame | {"shape": [1] * 9 + [16, 16, 3]}], "frame"),
        ([frame | {"datatype": "FP32"}], "frame"),
        ([frame | {"datatype": "BYTES", "data": ["a"] * 768}], "frame"),
        ([frame | {"name": "image"}], "image"),
        ([frame, frame | {"name": "more"}], "more"),
        ([], "input"),
    ):
        status, text = post(server, edges, body(*broken))
        assert status == 400 and words in text, (status, text)
    assert post(server, edges, body(frame))[0] == 200  # the server still works


def test_lying_sizes(server: Server, edges: str) -> None:
    """A binary body whose length is not what its shape says."""
    for shape, sent in (
        ([16, 16, 3], 700),
        ([16, 16, 3], 800),
        ([32768, 32768, 3], 768),
        ([0, 8, 3], 768),
        ([1 << 40, 1 << 40, 3], 768),
    ):
        head = json.dumps(
            {
                "inputs": [
                    {
                        "name": "frame",
                        "datatype": "UINT8",
                        "shape": shape,
                        "parameters": {"binary_data_size": sent},
                    }
                ]
            }
        ).encode()
        status, text = post(server, edges, head + bytes(sent), len(head))
        assert status == 400 and "frame" in text, (status, text)


def test_negative_sizes(server: Server, edges: str) -> None:
    sent = grpc_client.InferInput("frame", [-16, -16, 3], "UINT8")
    sent._raw_content = bytes(768)
    with pytest.raises(grpc_client.InferenceServerException, match="frame") as refused:
        server.grpc.infer(edges, [sent])
    assert refused.value.status() == "StatusCode.INVALID_ARGUMENT"


def test_bodies_in_chunks(server: Server, edges: str) -> None:
    """A body that arrives in chunks is also stored in chunks in the server."""
    frame = RANDOM.integers(0, 256, (100, 200, 3), np.uint8)
    entry = {"name": "frame", "datatype": "UINT8", "shape": list(frame.shape)}
    output = {"name": "output", "parameters": {"binary_data": True}}
    head = json.dumps(
        {"inputs": [entry | {"parameters": {"binary_data_size": frame.nbytes}}], "outputs": [output]}
    ).encode()
    whole = head + frame.tobytes()
    connection = http.client.HTTPConnection("127.0.0.1", server.http_port)
    connection.request(
        "POST",
        f"/v2/models/{edges}/infer",
        (whole[start : start + 10_000] for start in range(0, len(whole), 10_000)),
        {"Inference-Header-Content-Length": str(len(head))},
        encode_chunked=True,
    )
    answer = connection.getresponse()
    data = answer.read()
    assert answer.status == 200, data
    start = int(answer.headers["Inference-Header-Content-Length"])
    assert data[start:] == expected("pipelines.edges", {"frame": frame})[0].tobytes()


def test_outputs_that_no_memory_holds(server: Server) -> None:
    """Outputs of four terabytes, for an input of a sparse gigabyte of shared memory."""
    server.serve("resized", "geometry.transform.resize.bilinear")
    name, side = f"chiasm_{uuid.uuid4().hex}", 32768
    path = Path("/dev/shm") / name
    with path.open("wb") as file:
        file.truncate(side * side)
    server.http.register_system_shared_memory(name, f"/{name}", side * side)
    try:
        image = grpc_client.InferInput("input", [1, 1024, 8, 8], "FP32")
        image.set_data_from_numpy(np.zeros((1, 1024, 8, 8), np.float32))
        like = grpc_client.InferInput("like", [side, side], "UINT8")
        like.set_shared_memory(name, side * side)
        with pytest.raises(grpc_client.InferenceServerException, match=r"alloc|memory"):
            server.grpc.infer("resized", [image, like])
    finally:
        server.http.unregister_system_shared_memory(name)
        path.unlink()
    assert server.http.is_server_live()


def test_damaged_requests(server: Server, edges: str) -> None:
    """Bodies with changed, missing and extra bytes: each gets an answer, and the server still works."""
    frame = RANDOM.integers(0, 256, (16, 16, 3), np.uint8)
    entry = {"name": "frame", "datatype": "UINT8", "shape": [16, 16, 3]}
    head = json.dumps({"inputs": [entry | {"parameters": {"binary_data_size": frame.nbytes}}]}).encode()
    whole = head + frame.tobytes()
    statuses = set()
    for _ in range(300):
        damaged = bytearray(whole)
        for _ in range(RANDOM.integers(1, 4)):
            at = int(RANDOM.integers(0, len(head) + 8))
            kind = RANDOM.integers(0, 3)
            if kind == 0:
                damaged[at] = int(RANDOM.integers(0, 256))
            elif kind == 1:
                del damaged[at : at + int(RANDOM.integers(1, 4))]
            else:
                damaged[at:at] = RANDOM.bytes(int(RANDOM.integers(1, 4)))
        status, text = post(server, edges, bytes(damaged), len(head))
        assert status == 200 or text, status
        statuses.add(status)
    assert {200, 400} <= statuses
    answer = ask(server, "http", edges, {"frame": frame})
    assert same_bits(answer.as_numpy("output"), expected("pipelines.edges", {"frame": frame})[0])
