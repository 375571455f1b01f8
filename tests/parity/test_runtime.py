"""The Python API of the runtime: inputs and outputs.

Most tests use a small bundle of their own (scale_bundle.py); those at the end use exported bundles from
CHIASM_TEST_BUNDLES (default: build/bundles).
"""

import doctest
import gc
import importlib
import os
import subprocess
import sys
import weakref
from pathlib import Path

import numpy as np
import pytest
import torch
from scale_bundle import BACKENDS, Scale, example, write_scale
from torch import Tensor

import chiasm.runtime as runtime

ROOT = Path(__file__).resolve().parents[2]
EXPORTED = Path(os.environ.get("CHIASM_TEST_BUNDLES", ROOT / "build" / "bundles"))


# Metadata


def test_info(bundle: runtime.Bundle) -> None:
    assert (bundle.name, bundle.version, bundle.methods) == ("test.scale", "1.2.3", ["forward", "vjp"])
    assert bundle.info["config"] == {"answer": 42}
    inputs, outputs = bundle.signature("forward")
    assert [i.name for i in inputs] == ["x", "scale", "keep"] and [o.name for o in outputs] == [
        "y",
        "dropped",
    ]
    assert (
        inputs[0].dtypes == ["float32", "float64"]
        and inputs[0].shape == ["H", "W"]
        and inputs[0].range is None
    )
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


@pytest.mark.parametrize("backend", BACKENDS)
def test_parts_of_larger_arrays(bundle: runtime.Bundle, backend: str) -> None:
    large, scale, _ = example()
    large = np.tile(large, (3, 6))
    x, keep = large[2:12:2, 3:24:3], (large > 0)[:5, 9:16]  # elements and rows have gaps between them
    results = np.zeros((9, 20), np.float32)
    method = bundle.method(backend=backend)
    expected = np.where(keep, x * scale, 0)
    np.testing.assert_array_equal(method(x, scale, keep)[0], expected)
    method.run_into([x, scale, keep], [results[1:6, 4:11], np.empty((5, 7), bool)])
    np.testing.assert_array_equal(results[1:6, 4:11], expected)
    results[1:6, 4:11] = 0
    assert not results.any()


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


@pytest.mark.parametrize(
    "returns, kind", [("numpy", np.ndarray), ("torch", Tensor), ("dlpack", runtime.Output)]
)
def test_returns(method: runtime.Method, returns: str, kind: type) -> None:
    inputs = example()
    y, _ = method.run(inputs, returns=returns)
    assert isinstance(y, kind)
    np.testing.assert_array_equal(
        np.asarray(y) if returns != "dlpack" else np.from_dlpack(y), method(*inputs)[0]
    )


def test_output_speaks_dlpack(method: runtime.Method) -> None:
    y, dropped = method.run(example(), returns="dlpack")
    assert (
        y.shape == (5, 7)
        and y.dtype == "float32"
        and dropped.dtype == "bool"
        and y.__dlpack_device__() == (1, 0)
    )
    assert "dltensor_versioned" in repr(y.__dlpack__(max_version=(1, 0)))
    assert '"dltensor"' in repr(y.__dlpack__())
    array, other = np.from_dlpack(y), torch.from_dlpack(y)
    other[0, 0] = 7
    assert array[0, 0] == 7 and array.flags.writeable
    assert torch.from_dlpack(dropped).dtype == torch.bool
    for copy in (True, "no"):
        with pytest.raises(BufferError):
            y.__dlpack__(copy=copy)
    for version in ("1.0", (1,), ("1", 0)):
        with pytest.raises(TypeError, match="max_version: expected a tuple"):
            y.__dlpack__(max_version=version)


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
    rows = [
        row
        for row in runtime.open(write_scale(tmp_path, golden_offset=0.25)).self_test()
        if row.passed is not None
    ]
    assert rows and all(row.passed is False and row.max_error == pytest.approx(0.25) for row in rows)


# Exported bundles


def exported() -> list[Path]:
    return sorted(EXPORTED.glob("*.chiasm")) if EXPORTED.is_dir() else []


@pytest.mark.skipif(not exported(), reason=f"no exported bundles in {EXPORTED}")
@pytest.mark.parametrize("path", exported(), ids=lambda path: path.stem)
def test_exported_bundles_prove_themselves(path: Path) -> None:
    rows = runtime.open(path).self_test()
    assert [row for row in rows if row.passed]
    assert not [row for row in rows if row.passed is False]


def test_a_run_leaves_torchs_threads_to_the_program(tmp_path: Path) -> None:
    program = """if True:
        import sys, threading
        import numpy as np, torch
        import chiasm.runtime
        torch.set_num_threads(1)
        method = chiasm.runtime.open(sys.argv[1]).method(backend="torch")
        method(np.zeros((2, 2), np.float32), np.ones((), np.float32), np.ones((2, 2), bool))
        later = threading.Thread(target=lambda: print(torch.get_num_threads()))
        later.start(), later.join()
    """
    command = [sys.executable, "-c", program, str(write_scale(tmp_path))]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    environment.pop("OMP_NUM_THREADS", None)
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=100, check=True)
    assert done.stdout == "1\n"


@pytest.mark.parametrize("backend", BACKENDS)
def test_daemon_threads_do_not_abort_the_end_of_a_process(tmp_path: Path, backend: str) -> None:
    program = """if True:
        import sys, threading, time
        import numpy as np
        import chiasm.runtime
        method = chiasm.runtime.open(sys.argv[1]).method(backend=sys.argv[2])
        def run():
            while True:
                method(np.zeros((2, 2), np.float32), np.ones((), np.float32), np.ones((2, 2), bool))
        for _ in range(3):
            threading.Thread(target=run, daemon=True).start()
        time.sleep(0.3)
    """
    command = [sys.executable, "-c", program, str(write_scale(tmp_path)), backend]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    for _ in range(3):
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=100)
        assert done.returncode == 0 and not done.stderr, done.stderr


@pytest.mark.skipif(not (EXPORTED / "filters.sobel.chiasm").is_dir(), reason="filters.sobel is not exported")
def test_docstrings(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "bundles").symlink_to(EXPORTED.resolve())
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(importlib.import_module("chiasm.runtime"))
    assert result.attempted > 5 and result.failed == 0
    result = doctest.testfile(str(ROOT / "docs" / "running.md"), module_relative=False)
    assert result.attempted > 5 and result.failed == 0
