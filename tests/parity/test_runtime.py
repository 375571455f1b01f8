"""The Python API of the runtime: what goes in, what comes out, and what it says where it cannot.

Most tests write their own little bundles, with a TorchScript and an ONNX artifact; those at the end take exported ones from
CHIASM_TEST_BUNDLES (default: build/bundles).
"""

import doctest
import gc
import hashlib
import importlib
import io
import json
import os
import subprocess
import sys
import threading
import time
import weakref
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from safetensors.numpy import save
from torch import Tensor, nn

pytest.importorskip("chiasm._runtime", reason="the Python module is not built: cmake --build --preset release")
import chiasm.runtime as runtime
from chiasm.runtime import ChiasmError, Code

BACKENDS = ("torch", "onnx")
ROOT = Path(__file__).resolve().parents[2]
EXPORTED = Path(os.environ.get("CHIASM_TEST_BUNDLES", ROOT / "build" / "bundles"))


class Scale(nn.Module):
    def forward(self, x: Tensor, scale: Tensor, keep: Tensor) -> tuple[Tensor, Tensor]:
        y = torch.where(keep, x * scale, torch.zeros_like(x))
        return y, torch.logical_not(keep)


def scale_onnx(dtype: int) -> bytes:
    make, info = onnx.helper.make_node, onnx.helper.make_tensor_value_info
    nodes = [
        make("Mul", ["x", "scale"], ["scaled"]),
        make("Sub", ["x", "x"], ["zero"]),
        make("Where", ["keep", "scaled", "zero"], ["y"]),
        make("Not", ["keep"], ["dropped"]),
    ]
    shape, mask = ["H", "W"], onnx.TensorProto.BOOL
    graph = onnx.helper.make_graph(
        nodes,
        "scale",
        [info("x", dtype, shape), info("scale", dtype, []), info("keep", mask, shape)],
        [info("y", dtype, shape), info("dropped", mask, shape)],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 18)], ir_version=10)
    return model.SerializeToString()


def scripted(module: nn.Module) -> bytes:
    buffer = io.BytesIO()
    torch.jit.save(torch.jit.script(module), buffer)
    return buffer.getvalue()


def tensor(name: str, dtype: str, shape: list) -> dict:
    return {"name": name, "dtype": dtype, "shape": shape, "description": "", "layout": "", "color": "", "range": None}


def artifact(backend: str, form: str, file: str, data: bytes, dtypes: list[str], **more) -> dict:
    sha256 = hashlib.sha256(data).hexdigest()
    entry = {"backend": backend, "format": form, "file": file, "size": len(data), "sha256": sha256}
    return entry | {"dtypes": dtypes, "device": "any"} | more


TOLERANCES = {d: {"atol": 1e-6, "rtol": 1e-6} for d in ("float32", "float64")}


def write_bundle(folder: Path, name: str, methods: dict, files: dict[str, bytes], golden: dict, cases: list[dict]) -> Path:
    path = folder / f"{name}.chiasm"
    path.mkdir()
    files = files | {"golden.safetensors": save(golden)}
    for file, data in files.items():
        (path / file).write_bytes(data)
    data = files["golden.safetensors"]
    manifest = {
        "schema_version": 1,
        "name": name,
        "version": "1.2.3",
        "summary": "for tests",
        "reference": "NumPy",
        "created": "2025-01-01T00:00:00Z",
        "producer": {},
        "config": {"answer": 42},
        "symbols": {"H": {"min": 1, "max": 4096}, "W": {"min": 1, "max": 4096}},
        "dtypes": ["float32", "float64"],
        "methods": {name: {"tolerances": TOLERANCES} | method for name, method in methods.items()},
        "golden": {
            "file": "golden.safetensors",
            "size": len(data),
            "sha256": hashlib.sha256(data).hexdigest(),
            "cases": cases,
        },
    }
    (path / "manifest.json").write_text(json.dumps(manifest))
    return path


def write_scale(folder: Path, golden_offset: float = 0.0) -> Path:
    script = scripted(Scale())
    single, double = scale_onnx(onnx.TensorProto.FLOAT), scale_onnx(onnx.TensorProto.DOUBLE)
    kinds = ["float32", "float64"]
    shape = ["H", "W"]
    inputs = [tensor("x", "T", shape), tensor("scale", "T", []), tensor("keep", "bool", shape)]
    methods = {
        "forward": {
            "inputs": inputs,
            "outputs": [tensor("y", "T", shape), tensor("dropped", "bool", shape)],
            "artifacts": [
                artifact("torch", "torchscript", "scale.pt", script, kinds),
                artifact("onnx", "onnx", "scale32.onnx", single, ["float32"], opset=18),
                artifact("onnx", "onnx", "scale64.onnx", double, ["float64"], opset=18),
            ],
        },
        "vjp": {
            "inputs": [*inputs, tensor("grad_y", "T", shape)],
            "outputs": [tensor("grad_x", "T", shape), tensor("grad_scale", "T", [])],
            "artifacts": [artifact("torch", "torchscript", "scale.pt", script, kinds, autograd=True)],
        },
    }
    x, keep = np.arange(6, dtype=np.float32).reshape(2, 3), np.array([[True, False, True], [False, True, True]])
    golden = {"a/x": x, "a/scale": np.array(3, np.float32), "a/keep": keep}
    golden |= {"a/y": np.where(keep, x * 3, 0).astype(np.float32) + np.float32(golden_offset), "a/dropped": ~keep}
    files = {"scale.pt": script, "scale32.onnx": single, "scale64.onnx": double}
    return write_bundle(folder, "test.scale", methods, files, golden, [{"prefix": "a", "method": "forward", "dtype": "float32"}])


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> runtime.Bundle:
    return runtime.open(write_scale(tmp_path_factory.mktemp("bundles")))


@pytest.fixture(params=BACKENDS)
def method(request: pytest.FixtureRequest, bundle: runtime.Bundle) -> runtime.Method:
    return bundle.method(backend=request.param)


def example(dtype: type = np.float32) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    generator = np.random.default_rng(0)
    return generator.random((5, 7)).astype(dtype), np.asarray(2, dtype), generator.random((5, 7)) > 0.5


# Metadata


def test_info(bundle: runtime.Bundle) -> None:
    assert (bundle.name, bundle.version, bundle.methods) == ("test.scale", "1.2.3", ["forward", "vjp"])
    assert bundle.info["config"] == {"answer": 42}
    inputs, outputs = bundle.signature("forward")
    assert [i.name for i in inputs] == ["x", "scale", "keep"] and [o.name for o in outputs] == ["y", "dropped"]
    assert inputs[0].dtypes == ["float32", "float64"] and inputs[0].shape == ["H", "W"] and inputs[0].range is None
    assert "x: float32|float64[H, W]" in repr(inputs[0])
    assert "test.scale" in repr(bundle)


def test_method_says_what_it_runs(bundle: runtime.Bundle) -> None:
    method = bundle.method(backend="onnx", dtype=np.float64)
    assert (method.name, method.backend, method.artifact) == ("forward", "onnx", "scale64.onnx")
    assert "'x'" in repr(method) and "onnx" in repr(method)


@pytest.mark.parametrize("dtype", ["float64", np.float64, np.dtype("float64"), torch.float64])
def test_dtype_has_many_spellings(bundle: runtime.Bundle, dtype: object) -> None:
    assert bundle.method(backend="onnx", dtype=dtype).artifact == "scale64.onnx"


def test_backends_are_listed() -> None:
    listed = {b.name: b for b in runtime.backends()}
    assert list(listed) == ["native", "torch", "onnx"]
    for backend in listed.values():
        assert backend.available or backend.problem
    assert listed["torch"].engine_version.startswith("libtorch 2.")
    assert listed["onnx"].engine_version.startswith("onnxruntime 1.")


# Inputs and outputs


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("backend", BACKENDS)
def test_numpy_in_numpy_out(bundle: runtime.Bundle, backend: str, dtype: type) -> None:
    x, scale, keep = example(dtype)
    y, dropped = bundle.method(backend=backend, dtype=dtype)(x, scale, keep)
    assert type(y) is np.ndarray and y.dtype == dtype and dropped.dtype == np.bool_
    assert y.flags.writeable and y.flags.c_contiguous
    np.testing.assert_array_equal(y, np.where(keep, x * scale, 0))
    np.testing.assert_array_equal(dropped, ~keep)


def test_torch_in_torch_out(method: runtime.Method) -> None:
    x, scale, keep = map(torch.from_numpy, example())
    y, dropped = method(x, scale, keep)
    assert isinstance(y, Tensor) and dropped.dtype == torch.bool
    torch.testing.assert_close(y, torch.where(keep, x * scale, 0.0))
    y += 1  # its own memory


def test_mixed_inputs_give_torch(method: runtime.Method) -> None:
    x, scale, keep = example()
    assert isinstance(method(torch.from_numpy(x), scale, keep)[0], Tensor)


def test_named_inputs_and_numbers(method: runtime.Method) -> None:
    x, _, keep = example()
    expected = np.where(keep, x * 3, 0)
    np.testing.assert_array_equal(method(x, keep=keep, scale=3)[0], expected)
    np.testing.assert_array_equal(method.run({"scale": 3.0, "x": x, "keep": keep})[0], expected)
    np.testing.assert_array_equal(method.run([x, np.float32(3), keep])[0], expected)


def test_a_number_takes_the_dtype_of_the_arrays(bundle: runtime.Bundle) -> None:
    x, _, keep = example(np.float64)
    assert bundle.method(backend="onnx", dtype="float64")(x, 3, keep)[0].dtype == np.float64


@pytest.mark.parametrize("returns, kind", [("numpy", np.ndarray), ("torch", Tensor), ("dlpack", runtime.Output)])
def test_returns(method: runtime.Method, returns: str, kind: type) -> None:
    inputs = example()
    y, _ = method.run(inputs, returns=returns)
    assert isinstance(y, kind)
    np.testing.assert_array_equal(np.asarray(y) if returns != "dlpack" else np.from_dlpack(y), method(*inputs)[0])


def test_output_speaks_dlpack(method: runtime.Method) -> None:
    y, dropped = method.run(example(), returns="dlpack")
    assert y.shape == (5, 7) and y.dtype == "float32" and dropped.dtype == "bool" and y.__dlpack_device__() == (1, 0)
    assert "dltensor_versioned" in repr(y.__dlpack__(max_version=(1, 0)))
    assert '"dltensor"' in repr(y.__dlpack__())
    array, other = np.from_dlpack(y), torch.from_dlpack(y)
    other[0, 0] = 7
    assert array[0, 0] == 7 and array.flags.writeable
    assert torch.from_dlpack(dropped).dtype == torch.bool
    with pytest.raises(BufferError):
        y.__dlpack__(copy=True)


class OnlyDLPack:
    def __init__(self, array: np.ndarray, versioned: bool) -> None:
        self.array, self.versioned = array, versioned

    def __dlpack__(self, **options: object) -> object:
        if not self.versioned and options:
            raise TypeError("unexpected keyword argument 'max_version'")
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        return (1, 0)


@pytest.mark.parametrize("versioned", [True, False])
def test_any_dlpack_object(method: runtime.Method, versioned: bool) -> None:
    x, scale, keep = example()
    y, _ = method(OnlyDLPack(x, versioned), scale, keep)
    np.testing.assert_array_equal(y, np.where(keep, x * scale, 0))


def test_read_only_arrays_are_read(method: runtime.Method) -> None:
    x, scale, keep = example()
    expected = method(x, scale, keep)[0]
    x.flags.writeable = False
    keep.flags.writeable = False
    np.testing.assert_array_equal(method(x, scale, keep)[0], expected)
    np.testing.assert_array_equal(method(OnlyDLPack(x, True), scale, keep)[0], expected)
    np.testing.assert_array_equal(method(memoryview(x), scale, keep)[0], expected)


def test_outputs_outlive_everything(tmp_path: Path) -> None:
    x, scale, keep = example()
    expected = np.where(keep, x * scale, 0)
    opened = runtime.open(write_scale(tmp_path))
    loaded = opened.method(backend="onnx")
    kept = [loaded(x, scale, keep)[0], loaded.run((x, scale, keep), returns="torch")[0]]
    kept.append(np.from_dlpack(loaded.run((x, scale, keep), returns="dlpack")[0]))
    del opened
    again = loaded(x, scale, keep)[0]
    del loaded
    gc.collect()
    for y in [*kept, again]:
        np.testing.assert_array_equal(np.asarray(y), expected)


def test_inputs_are_let_go(method: runtime.Method) -> None:
    x, scale, keep = example()
    before = sys.getrefcount(x)
    method(x, scale, keep)
    method(OnlyDLPack(x, True), scale, keep)
    assert sys.getrefcount(x) == before
    held = torch.from_numpy(x.copy())
    gone = weakref.ref(held)
    method(held, scale, keep)
    del held
    assert gone() is None


def test_odd_sizes_and_offsets(method: runtime.Method) -> None:
    memory = np.random.default_rng(1).random(4096).astype(np.float32)
    for height, width, start in [(1, 1, 1), (1, 17, 3), (13, 5, 0), (31, 33, 7)]:
        x = memory[start : start + height * width].reshape(height, width)
        keep = x > 0.3
        np.testing.assert_array_equal(method(x, 2, keep)[0], np.where(keep, x * 2, 0).astype(np.float32))


# run_into


@pytest.mark.parametrize("library", ["numpy", "torch"])
def test_run_into(method: runtime.Method, library: str) -> None:
    x, scale, keep = example()
    y, dropped = np.full_like(x, -1), np.zeros_like(keep)
    outputs = [y, dropped] if library == "numpy" else [torch.from_numpy(y), torch.from_numpy(dropped)]
    assert method.run_into((x, scale, keep), outputs) is None
    np.testing.assert_array_equal(y, np.where(keep, x * scale, 0))
    np.testing.assert_array_equal(dropped, ~keep)
    method.run_into({"x": x, "scale": 1, "keep": keep}, {"dropped": dropped, "y": y})
    np.testing.assert_array_equal(y, np.where(keep, x, 0))


def test_output_shapes(method: runtime.Method) -> None:
    assert method.output_shapes(*example()) == [((5, 7), "float32"), ((5, 7), "bool")]


def test_run_into_refuses(method: runtime.Method) -> None:
    x, scale, keep = example()
    y, dropped = np.empty_like(x), np.empty_like(keep)
    for outputs, words in [
        ([np.empty((4, 7), np.float32), dropped], ["y", "4", "5"]),
        ([y.astype(np.float64), dropped], ["y", "float64", "float32"]),
        ([x, dropped], ["y", "overlap"]),
        ([y, np.empty((7, 5), bool).T], ["dropped", "stride"]),
    ]:
        with pytest.raises(ChiasmError) as error:
            method.run_into((x, scale, keep), outputs)
        assert error.value.code == Code.INVALID_ARGUMENT
        assert all(word in str(error.value) for word in words), str(error.value)
    with pytest.raises(TypeError, match="'dropped', which is missing"):
        method.run_into((x, scale, keep), [y])
    y.flags.writeable = False
    with pytest.raises(ChiasmError, match="output 'y': the array is read-only"):
        method.run_into((x, scale, keep), [y, dropped])


# Errors


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda x: x.astype(np.float64), ["x", "float64"]),
        (lambda x: x.astype(np.uint16), ["x", "uint16"]),
        (lambda x: x.astype(">f4"), ["x", ">f4"]),
        (lambda x: x.astype(np.complex64), ["x", "complex64"]),
        (lambda x: x[0], ["x"]),
        (lambda x: x[:, ::-1], ["x", "stride"]),
        (lambda x: np.asfortranarray(x), ["x", "stride"]),
        (lambda x: np.broadcast_to(x[:1], (5, 7)), ["x", "stride"]),
        (lambda x: np.zeros((5, 8), np.float32), ["8", "7"]),
        (lambda x: np.zeros((0, 7), np.float32), ["x", "0"]),
        (lambda x: torch.from_numpy(x).t(), ["x"]),
        (lambda x: torch.from_numpy(x).requires_grad_(), ["x", "requires grad", "detach"]),
        (lambda x: x.tolist(), ["x", "list", "array"]),
        (lambda x: None, ["x", "NoneType"]),
        (lambda x: "text", ["x", "str"]),
    ],
)
def test_bad_inputs_are_named(method: runtime.Method, change, words: list[str]) -> None:
    x, _, keep = example()
    with pytest.raises(ChiasmError) as error:
        method(change(x), np.float32(2), keep)
    assert error.value.code == Code.INVALID_ARGUMENT
    assert isinstance(error.value, RuntimeError)
    assert all(word in str(error.value) for word in words), str(error.value)


def test_wrong_calls_are_type_errors(method: runtime.Method) -> None:
    x, scale, keep = example()
    with pytest.raises(TypeError, match="takes 3 inputs, got 4"):
        method(x, scale, keep, x)
    with pytest.raises(TypeError, match="needs 'keep', which is missing"):
        method(x, scale)
    with pytest.raises(TypeError, match="has no input 'sigma'"):
        method(x, scale, keep, sigma=1)
    with pytest.raises(TypeError, match="got 'x' by position and by name"):
        method(x, x=x, scale=scale, keep=keep)
    with pytest.raises(ChiasmError, match="expected 'numpy', 'torch' or 'dlpack', got 'jax'"):
        method.run((x, scale, keep), returns="jax")


@pytest.mark.parametrize(
    "options, code, words",
    [
        ({"name": "backward"}, Code.NOT_FOUND, ["backward"]),
        ({"backend": "tensorrt"}, Code.INVALID_ARGUMENT, ["tensorrt"]),
        ({"dtype": "float31"}, Code.INVALID_ARGUMENT, ["float31"]),
        ({"backend": "native"}, Code.NOT_FOUND, ["native"]),
        ({"backend": "torch", "allow_native_code": False}, Code.FAILED_PRECONDITION, ["torch"]),
    ],
)
def test_loading_errors(bundle: runtime.Bundle, options: dict, code: Code, words: list[str]) -> None:
    with pytest.raises(ChiasmError) as error:
        bundle.method(**options)
    assert error.value.code == code
    assert all(word in str(error.value) for word in words), str(error.value)


def test_without_native_code_onnx_is_left(bundle: runtime.Bundle) -> None:
    assert bundle.method(allow_native_code=False).backend == "onnx"


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
@pytest.mark.parametrize("backend", ["auto", *BACKENDS])
def test_cuda_is_missed(bundle: runtime.Bundle, backend: str) -> None:
    with pytest.raises(ChiasmError) as error:
        bundle.method(backend=backend, device="cuda:0")
    assert error.value.code == Code.UNAVAILABLE


@pytest.mark.parametrize("device", ["gpu", "cuda:x", ""])
def test_bad_device(bundle: runtime.Bundle, device: str) -> None:
    with pytest.raises(ValueError, match="device"):
        bundle.method(device=device)


def test_no_bundle(tmp_path: Path) -> None:
    with pytest.raises(ChiasmError, match=r"nothing\.chiasm") as error:
        runtime.open(tmp_path / "nothing.chiasm")
    assert error.value.code == Code.NOT_FOUND


@pytest.mark.parametrize("file, backend", [("scale.pt", "torch"), ("scale32.onnx", "onnx")])
def test_a_changed_artifact_is_refused(tmp_path: Path, file: str, backend: str) -> None:
    path = write_scale(tmp_path)
    data = bytearray((path / file).read_bytes())
    data[len(data) // 2] ^= 1
    (path / file).write_bytes(data)
    with pytest.raises(ChiasmError, match=file) as error:
        runtime.open(path).method(backend=backend)
    assert error.value.code == Code.CORRUPT


def zipped(**files: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(f"data/{name}.so" if name.startswith("lib") else name, data)
    return buffer.getvalue()


def damaged_zip() -> bytes:
    data = bytearray(zipped(liba=bytes(range(256)) * 64))
    data[60] ^= 0xFF  # inside the deflated library
    return bytes(data)


@pytest.mark.parametrize(
    "backend, form, data, words",
    [
        ("native", "aotinductor", b"no zip archive at all", ["not a zip archive"]),
        ("native", "aotinductor", zipped(readme=b"text"), ["no shared library"]),
        (
            "native",
            "aotinductor",
            zipped(liba=b"x", libb=b"y"),
            ["two shared libraries", "data/liba.so", "data/libb.so"],
        ),
        ("native", "aotinductor", zipped(liba=b"not an ELF file"), ["cannot load the native code"]),
        ("native", "aotinductor", damaged_zip(), ["archive"]),
        ("torch", "torchscript", b"no program", ["bad.bin"]),
        ("torch", "aotinductor", zipped(readme=b"text"), ["bad.bin"]),
        ("onnx", "onnx", b"no graph", ["bad.bin"]),
    ],
)
def test_a_bad_artifact_says_so(tmp_path: Path, backend: str, form: str, data: bytes, words: list[str]) -> None:
    """Artifacts whose hash is right and whose content is not: an exporter's mistake, or an attacker's manifest."""
    more = {"device": "cpu"} | ({"isa": "x86-64-v3"} if backend == "native" else {})
    more |= {"needs": ["libtorch"]} if (backend, form) == ("torch", "aotinductor") else {}
    entry = artifact(backend, form, "bad.bin", data, ["float32"], **more)
    forward = {"inputs": [tensor("x", "T", ["H"])], "outputs": [tensor("y", "T", ["H"])], "artifacts": [entry]}
    cases = [{"prefix": "a", "method": "forward", "dtype": "float32"}]
    golden = {"a/x": np.ones(3, np.float32), "a/y": np.ones(3, np.float32)}
    path = write_bundle(tmp_path, "test.bad", {"forward": forward}, {"bad.bin": data}, golden, cases)
    with pytest.raises(ChiasmError) as error:
        runtime.open(path).method(backend=backend)
    assert "bad.bin" in str(error.value)
    assert all(word in str(error.value) for word in words), str(error.value)


# Gradients


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_vjp_is_torchs_gradient(bundle: runtime.Bundle, dtype: torch.dtype) -> None:
    vjp = bundle.method("vjp", dtype=dtype)
    x, keep = torch.rand(4, 6, dtype=dtype), torch.rand(4, 6) > 0.5
    scale, grad_y = torch.tensor(1.5, dtype=dtype), torch.rand(4, 6, dtype=dtype)
    leaves = [x.clone().requires_grad_(), scale.clone().requires_grad_()]
    expected = torch.autograd.grad(Scale()(*leaves, keep)[0], leaves, grad_y)
    for _ in range(2):
        grad_x, grad_scale = vjp(x, scale, keep, grad_y)
        torch.testing.assert_close(grad_x, expected[0])
        torch.testing.assert_close(grad_scale, expected[1])
    with torch.no_grad():
        torch.testing.assert_close(vjp(x, scale, keep, grad_y)[0], expected[0])


# Self-test


def test_self_test_passes(bundle: runtime.Bundle) -> None:
    rows = bundle.self_test()
    assert {row.backend for row in rows if row.passed} >= set(BACKENDS)
    assert not [row for row in rows if row.passed is False]
    assert "passed" in repr(rows[0])


def test_self_test_finds_other_numbers(tmp_path: Path) -> None:
    rows = [row for row in runtime.open(write_scale(tmp_path, golden_offset=0.25)).self_test() if row.passed is not None]
    assert rows and all(row.passed is False and row.max_error == pytest.approx(0.25) for row in rows)


# Threads


def test_one_method_in_many_threads(method: runtime.Method) -> None:
    def work(seed: int) -> bool:
        generator = np.random.default_rng(seed)
        for _ in range(30):
            x = generator.random((int(generator.integers(1, 60)), int(generator.integers(1, 60)))).astype(np.float32)
            keep = x > 0.5
            y, dropped = method(x, float(seed), keep)
            if not (np.array_equal(y, np.where(keep, x * np.float32(seed), 0)) and np.array_equal(dropped, ~keep)):
                return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(16)))


def test_gradients_in_many_threads(bundle: runtime.Bundle) -> None:
    vjp = bundle.method("vjp")

    def work(seed: int) -> bool:
        x = np.random.default_rng(seed).random((9, 11)).astype(np.float32)
        keep = x > 0.5
        return all(np.array_equal(vjp(x, seed, keep, x)[0], np.where(keep, x * seed, 0).astype(np.float32)) for _ in range(20))

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(8)))


def test_the_gil_is_released(method: runtime.Method) -> None:
    x = np.ones((4096, 4096), np.float32)
    keep = np.ones(x.shape, bool)
    method(x, 2, keep)
    started = threading.Event()
    span: list[float] = []

    def run() -> None:
        started.set()
        span.append(time.perf_counter())
        for _ in range(3):
            method(x, 2, keep)
        span.append(time.perf_counter())

    thread = threading.Thread(target=run)
    ticks = []
    thread.start()
    started.wait()
    while thread.is_alive():
        ticks.append(time.perf_counter())
        time.sleep(0.001)
    begin, end = span
    during = [tick for tick in ticks if begin + 0.1 * (end - begin) < tick < end - 0.1 * (end - begin)]
    assert len(during) >= 3, f"this thread was held up for {end - begin:.3f} s"


# The process


def run_python(code: str) -> str:
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_import_is_light() -> None:
    modules = "import sys, chiasm.runtime; print([m for m in ('torch', 'onnxruntime', 'numpy') if m in sys.modules])"
    assert run_python(modules) == "[]"


def test_torch_can_be_imported_after_its_backend(tmp_path: Path) -> None:
    path = str(write_scale(tmp_path))
    code = (
        "import sys, numpy as np, chiasm.runtime as r\n"
        f"m = r.open({path!r}).method(backend='torch')\n"
        "y = m(np.ones((2, 3), np.float32), 2, np.ones((2, 3), bool))[0]\n"
        "assert 'torch' not in sys.modules\n"
        "import torch\n"
        "t = m(torch.ones(2, 3), 2, torch.ones(2, 3, dtype=torch.bool))[0]\n"
        "x = torch.ones(3, requires_grad=True); x.square().sum().backward()\n"
        "print(float(y.sum()), float(t.sum()), float(x.grad.sum()))"
    )
    assert run_python(code) == "12.0 12.0 6.0"


def test_thread_policy_comes_first(tmp_path: Path) -> None:
    path = str(write_scale(tmp_path))
    code = (
        "import chiasm.runtime as r\n"
        "r.set_num_threads(3); assert r.get_num_threads() == 3\n"
        f"r.open({path!r}).method(backend='onnx')\n"
        "try: r.set_num_threads(2)\n"
        "except r.ChiasmError as e: print(e.code.name)"
    )
    assert run_python(code) == "FAILED_PRECONDITION"


# Exported bundles


def exported() -> list[Path]:
    return sorted(EXPORTED.glob("*.chiasm")) if EXPORTED.is_dir() else []


@pytest.mark.skipif(not exported(), reason=f"no exported bundles in {EXPORTED}")
@pytest.mark.parametrize("path", exported(), ids=lambda path: path.stem)
def test_exported_bundles_prove_themselves(path: Path) -> None:
    rows = runtime.open(path).self_test()
    assert [row for row in rows if row.passed]
    assert not [row for row in rows if row.passed is False]


@pytest.mark.skipif(not (EXPORTED / "filters.sobel.chiasm").is_dir(), reason="filters.sobel is not exported")
def test_docstrings(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "bundles").symlink_to(EXPORTED.resolve())
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(importlib.import_module("chiasm.runtime"))
    assert result.attempted > 5 and result.failed == 0
