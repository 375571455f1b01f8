"""A bundle opened in ONNX Runtime, and how the plug-in is found. The plug-in's results are tested in its own
build."""

import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnxruntime
import pytest

import chiasm.onnx
from chiasm.export.manifest import BundleError
from chiasm.onnx import plugin

from .conftest import SPEC

IMAGE = np.random.default_rng(0).random((1, 3, 21, 34), np.float32)


def test_importing_it_and_opening_a_session_needs_no_torch(light: Callable[[str], Path]) -> None:
    code = (
        "import sys, warnings; warnings.simplefilter('ignore'); import chiasm.onnx\nprint([i.name for i in"
        f" chiasm.onnx.session({str(light('filters.sobel'))!r}).get_inputs()], 'torch' in"
        " sys.modules)\nprint(chiasm.onnx.Node.__name__, 'torch' in sys.modules, 'prepend' in"
        " dir(chiasm.onnx))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["['input'] False", "Node True True"]


@pytest.mark.parametrize("method", ["forward", "vjp"])
def test_without_native_code_the_body_runs_and_a_warning_says_so(
    light: Callable[[str], Path], method: str
) -> None:
    sobel = light("filters.sobel")
    inputs = {"input": IMAGE} | ({"grad_output": IMAGE} if method == "vjp" else {})
    with pytest.warns(RuntimeWarning, match=r"filters\.sobel\.chiasm.*no native artifact"):
        fused = chiasm.onnx.session(sobel, method)
    flat = chiasm.onnx.session(sobel, method, fused=False)
    assert np.array_equal(fused.run(None, inputs)[0], flat.run(None, inputs)[0])


def test_without_the_plugin_the_body_runs_and_a_warning_says_what_to_do(
    bundle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plugin, "_folders", lambda: [tmp_path])
    with pytest.warns(
        RuntimeWarning, match=r"test\.scaled_difference\.chiasm.*libchiasm_ort\.so.*make build.*pip install"
    ):
        session = chiasm.onnx.session(bundle)
    gain = np.ones(1, np.float32)
    assert session.run(None, {"input": IMAGE, "gain": gain})[0].shape == (1, 3, 20, 34)


def test_the_flat_form_is_opened_in_the_dtype_asked_for_without_a_word(light: Callable[[str], Path]) -> None:
    sobel, preprocess = light("filters.sobel"), light("pipelines.preprocess")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        session = chiasm.onnx.session(
            sobel, dtype="float64", fused=False, options=options, providers=["CPUExecutionProvider"]
        )
        assert session.get_inputs()[0].type == "tensor(double)"
        assert chiasm.onnx.session(sobel, fused=False).get_inputs()[0].type == "tensor(float)"
        assert chiasm.onnx.session(preprocess, fused=False).get_inputs()[0].type == "tensor(uint8)"


@pytest.mark.filterwarnings("ignore")
def test_what_cannot_be_opened_is_named(light: Callable[[str], Path], tmp_path: Path) -> None:
    sobel = light("filters.sobel")
    with pytest.raises(BundleError, match=r"no method 'backward': it has forward, vjp"):
        chiasm.onnx.session(sobel, "backward")
    with pytest.raises(BundleError, match=r"float32, float64, got 'float16'"):
        chiasm.onnx.session(sobel, dtype="float16")
    with pytest.raises(BundleError, match=r"vjp.*float64.*no ONNX artifact"):
        chiasm.onnx.session(sobel, "vjp", "float64")
    with pytest.raises(BundleError, match=r"its own.*got 'float32'"):
        chiasm.onnx.session(light("pipelines.preprocess"), dtype="float32")
    with pytest.raises(BundleError, match="not a bundle"):
        chiasm.onnx.session(tmp_path)
    copy = tmp_path / sobel.name
    shutil.copytree(sobel, copy)
    for file in ("forward.float32.fused.onnx", "forward.float32.onnx"):
        data = (copy / file).read_bytes()
        (copy / file).write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
        with pytest.raises(BundleError, match=rf"{file}.*sha256"):
            chiasm.onnx.session(copy, fused="fused" in file)


def test_the_plugin_is_found_where_backends_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CHIASM_BACKEND_PATH", f"{tmp_path / 'none'}:{tmp_path}")
    (tmp_path / "libchiasm_ort.so").touch()
    assert chiasm.onnx.library() == tmp_path / "libchiasm_ort.so"
    root = Path(__file__).resolve().parents[2]
    assert root / "build" / "release" / "lib" in plugin._folders()


def test_a_missing_plugin_says_where_it_was_looked_for_and_what_to_do(
    light: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plugin, "_folders", lambda: [tmp_path / "here", tmp_path / "there"])
    for call in (
        chiasm.onnx.library,
        lambda: chiasm.onnx.register(onnxruntime.SessionOptions(), light(SPEC.name)),
    ):
        with pytest.raises(
            FileNotFoundError, match=r"here, .*there.*make build.*pip install.*CHIASM_BACKEND_PATH"
        ):
            call()


def test_registering_refuses_what_the_plugin_would_not_see(
    light: Callable[[str], Path], tmp_path: Path
) -> None:
    bundle = light(SPEC.name)
    options = onnxruntime.SessionOptions()
    options.add_session_config_entry("chiasm.bundles", "/elsewhere")
    with pytest.raises(ValueError, match=r"already \(/elsewhere\).*one call"):
        chiasm.onnx.register(options, bundle)
    with pytest.raises(BundleError, match="not a bundle"):
        chiasm.onnx.register(onnxruntime.SessionOptions(), [bundle, tmp_path])
    with pytest.raises(ValueError, match="at least one"):
        chiasm.onnx.register(onnxruntime.SessionOptions(), [])
    (tmp_path / "a:b").symlink_to(bundle)
    (tmp_path / "c:d").mkdir()
    shutil.copytree(bundle, tmp_path / "c:d" / bundle.name)
    with pytest.raises(ValueError, match="colon"):
        chiasm.onnx.register(onnxruntime.SessionOptions(), tmp_path / "c:d" / bundle.name)
