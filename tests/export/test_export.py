"""One call from a user's own function to a bundle: the bundle's content, reproducibility, and errors."""

import hashlib
import io
import json
import re
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Tuple

import jsonschema
import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from torch import Tensor, nn

import chiasm.runtime
from chiasm.export import ExportError, Spec, TensorSpec, example_inputs, export, frame, image
from chiasm.export.catalog import catalog
from chiasm.export.comparison import onnx_session
from chiasm.export.formats.native_cache import key
from chiasm.export.job import with_cotangents
from chiasm.export.manifest import BundleError, parse_manifest, read_manifest, schema, sha256
from chiasm.export.tracing.gradient import trace_vjp, vjp_module, vjp_signature
from chiasm.export.tracing.graph import output_specs, trace
from chiasm.export.tracing.module import bind_spec
from chiasm.filters import GaussianBlur2d, Sobel
from chiasm.primitives.geometry.consensus import model_costs

from .conftest import SPEC, scaled_difference

ROOT = Path(__file__).resolve().parents[2]


def test_native_loops_are_vectorised(bundle: Path, tmp_path: Path) -> None:
    """AOTInductor falls back to scalar loops silently."""
    with zipfile.ZipFile(bundle / "forward.float32.x86-64-v3.pt2") as archive:
        archive.extract("chiasm/op.so", tmp_path)
    code = subprocess.run(
        ["objdump", "-d", tmp_path / "chiasm" / "op.so"], capture_output=True, text=True, check=True
    ).stdout
    assert re.search(r"vmulps .*ymm", code)  # the scaling, eight values at a time


def metres(depth: Tensor, scale: float = 0.001) -> Tuple[Tensor, Tensor]:
    """The depth of a camera that measures millimetres, and a mask of missing measurements."""
    return depth.to(torch.float32) * scale, (depth.to(torch.int32) + (depth == 0).to(torch.int32) * 65535).to(
        torch.uint16
    )


def test_frames_of_sixteen_bits(tmp_path: Path) -> None:
    depth = TensorSpec("depth", ("B", 1, "H", "W"), dtype="uint16", range=(0, 65535))
    path = export(
        metres, Spec("test.metres", [depth], [TensorSpec("metres"), TensorSpec("filled")]), tmp_path
    )
    bundle = chiasm.runtime.open(path)
    frame = np.array([[0, 1, 1000, 32768, 65535]], np.uint16)[None, None]
    for backend in ("native", "torch", "onnx"):
        distance, filled = bundle.method("forward", backend=backend)(frame)
        np.testing.assert_array_equal(distance, frame.astype(np.float32) * np.float32(0.001))
        assert filled.dtype == np.uint16
        np.testing.assert_array_equal(filled, np.where(frame == 0, 65535, frame))


def test_native_code_brings_no_threads_and_no_torch(bundle: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(bundle / "forward.float32.x86-64-v3.pt2") as archive:
        archive.extract("chiasm/op.so", tmp_path)
    needed = subprocess.run(
        ["objdump", "-p", tmp_path / "chiasm" / "op.so"], capture_output=True, text=True, check=True
    ).stdout
    assert not re.search(r"NEEDED +(libgomp|libtorch|libc10|libonnxruntime)", needed)


def test_the_manifest_follows_the_schema_and_its_hashes_are_right(bundle: Path) -> None:
    manifest = json.loads((bundle / "manifest.json").read_text())
    jsonschema.validate(manifest, schema())
    entries = [
        *(a for m in manifest["methods"].values() for a in m["artifacts"]),
        manifest["golden"],
        *manifest["documents"].values(),
    ]
    for entry in entries:
        assert hashlib.sha256((bundle / entry["file"]).read_bytes()).hexdigest() == entry["sha256"]
    assert {p.name for p in bundle.iterdir()} == {e["file"] for e in entries} | {"manifest.json"}


def test_shapes_are_symbolic_and_derived(bundle: Path) -> None:
    forward = read_manifest(bundle)["methods"]["forward"]
    assert forward["inputs"][0]["shape"] == ["B", "C", "H", "W"]
    height = forward["outputs"][0]["shape"][2]
    assert eval(height, {"H": 100}) == 99  # one row less, in any notation


def test_onnx_has_the_arguments_names_the_opset_and_the_op_in_its_metadata(bundle: Path) -> None:
    model = onnx.load(bundle / "forward.float32.onnx")
    onnx.checker.check_model(model, full_check=True)
    assert [i.name for i in model.graph.input] == ["input", "gain"]
    assert [o.name for o in model.graph.output] == ["output"]
    assert [(o.domain, o.version) for o in model.opset_import] == [("", 18)]
    assert [d.dim_param for d in model.graph.input[0].type.tensor_type.shape.dim] == ["B", "C", "H", "W"]
    assert {p.key: p.value for p in model.metadata_props}["chiasm.op"] == "test.scaled_difference"
    assert str(Path.cwd()).encode() not in model.SerializeToString()


def test_native_code_exports_one_symbol_and_needs_no_engine(bundle: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(bundle / "forward.float32.x86-64-v3.pt2") as archive:
        (tmp_path / "op.so").write_bytes(archive.read("chiasm/op.so"))
    needed = subprocess.run(
        ["readelf", "-d", tmp_path / "op.so"], capture_output=True, text=True, check=True
    ).stdout
    libraries = re.findall(r"\(NEEDED\).*\[(.+)\]", needed)
    assert libraries and not [name for name in libraries if "torch" in name or "c10" in name]
    symbols = subprocess.run(
        ["nm", "-D", "--defined-only", tmp_path / "op.so"], capture_output=True, text=True, check=True
    ).stdout
    assert [line.split()[-1] for line in symbols.splitlines()] == ["chiasm_native_entry"]


def test_torchs_own_loader_refuses_a_torch_free_artifact(bundle: Path) -> None:
    with pytest.raises(Exception):  # noqa: B017 - whatever it throws: what matters is that it does not run it
        torch._inductor.aoti_load_package(str(bundle / "forward.float32.x86-64-v3.pt2"))


def test_exporting_twice_gives_the_same_manifest_but_for_times(tmp_path: Path) -> None:
    # In separate processes, like the command (TorchScript numbers types that a process scripts twice). Each
    # has its own cache, so that the op is compiled again.
    program = """
import os, sys
from tests.export.conftest import SPEC, export, scaled_difference
os.environ["CHIASM_CACHE"] = sys.argv[1]
print(export(scaled_difference, SPEC, sys.argv[1]))
"""
    manifests = []
    for folder in (tmp_path / "first", tmp_path / "second"):
        command = [sys.executable, "-W", "ignore", "-c", program, folder]
        done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
        assert len(list((folder / "native").iterdir())) == 2, "both methods are compiled"
        manifests.append(read_manifest(Path(done.stdout.strip())) | {"created": ""})
    assert manifests[0] == manifests[1]


def test_a_compilation_is_found_again_whatever_the_process_did_before() -> None:
    def key_of_trace() -> str:
        op = bind_spec(scaled_difference, SPEC)
        inputs = example_inputs.make(SPEC, example_inputs.fit(SPEC, example_inputs.EXAMPLE), "float32")
        outputs = output_specs(trace(op, SPEC, list(SPEC.inputs), inputs, "onnx"), SPEC, "float32")
        tensors, _ = vjp_signature(SPEC, outputs)
        example = with_cotangents(
            op, SPEC, example_inputs.fit(SPEC, example_inputs.EXAMPLE), "float32", tensors
        )
        program = trace_vjp(vjp_module(op, SPEC, outputs), SPEC, tensors, example)
        return key(program, SPEC, "x86-64-v3", "chiasm 1", True)

    assert key_of_trace() == key_of_trace()


@pytest.mark.parametrize("backend", ["native", "torch", "onnx"])
def test_every_backend_equals_eager_and_its_gradient(bundle: Path, backend: str) -> None:
    generator = torch.Generator().manual_seed(3)
    x = torch.rand(3, 2, 11, 17, generator=generator)
    gain = torch.rand(3, generator=generator) + 0.5
    opened = chiasm.runtime.open(bundle)
    expected = scaled_difference(x, gain, 2.0)
    torch.testing.assert_close(
        opened.method("forward", backend=backend)(x, gain), expected, atol=1e-6, rtol=1e-5
    )
    seed = torch.rand(expected.shape, generator=generator)
    leaves = x.clone().requires_grad_(), gain.clone().requires_grad_()
    want = torch.autograd.grad(scaled_difference(*leaves, 2.0), leaves, seed)
    for got, w in zip(opened.method("vjp", backend=backend)(x, gain, seed), want, strict=True):
        torch.testing.assert_close(got, w, atol=1e-5, rtol=1e-4)


def test_a_sequential_and_a_plain_function_export_by_the_same_call(tmp_path: Path) -> None:
    sequential = nn.Sequential(GaussianBlur2d((5, 5), (1.0, 1.0)), Sobel())

    def composed(input: Tensor) -> Tensor:
        return sequential[1](sequential[0](input)) * 2.0

    symbols = {"H": (8, 4096), "W": (8, 4096)}
    x = np.random.default_rng(0).random((1, 3, 30, 41), np.float32)
    first = export(
        sequential,
        Spec("test.sequential", [image()], symbols=symbols),
        tmp_path,
        formats=["torchscript", "onnx"],
    )
    got = chiasm.runtime.open(first).method("forward", backend="onnx")(x)
    torch.testing.assert_close(torch.from_numpy(got), sequential(torch.from_numpy(x)), atol=1e-5, rtol=1e-4)
    # a function that closes over modules cannot be scripted, but ONNX takes it
    second = export(composed, Spec("test.composed", [image()], symbols=symbols), tmp_path, formats=["onnx"])
    doubled = chiasm.runtime.open(second).method("forward", backend="onnx")(x)
    torch.testing.assert_close(torch.from_numpy(doubled), 2 * torch.from_numpy(got), atol=1e-5, rtol=1e-4)


def thirds(x: Tensor) -> Tensor:
    return torch.where(
        x < -1e300, torch.full_like(x, 1e-300), x * 0.1 + torch.full([], 2.0 / 3.0, dtype=x.dtype)
    )


def test_numbers_in_float64_graphs_are_not_rounded_to_float32(tmp_path: Path) -> None:
    bundle = export(
        thirds,
        Spec("test.thirds", [TensorSpec("x", ("N",))], dtypes=("float64",)),
        tmp_path,
        formats=("onnx",),
        methods=("forward",),
    )
    x = torch.tensor([-float("inf"), -1e200, 0.0, 1.0 / 7.0], dtype=torch.float64)
    [result] = onnx_session(bundle / "forward.float64.onnx")({"x": x})
    assert torch.equal(result, thirds(x))


def test_several_outputs_integer_outputs_and_uint8_input(tmp_path: Path) -> None:
    def brightest(frame: Tensor) -> Tuple[Tensor, Tensor]:
        """The brightest channel of each pixel, and its value."""
        top = frame.to(torch.float32).max(dim=-1)
        return top.indices, top.values / 255.0

    spec = Spec("test.brightest", [frame()], [TensorSpec("channel"), TensorSpec("value")], gradients=())
    made = export(brightest, spec, tmp_path, formats=["torchscript", "onnx"])
    manifest = read_manifest(made)
    assert [(t["dtype"], t["shape"]) for t in manifest["methods"]["forward"]["outputs"]] == [
        ("int64", ["H", "W"]),
        ("float32", ["H", "W"]),
    ]
    assert "vjp" not in manifest["methods"]
    image_ = np.random.default_rng(1).integers(0, 255, (13, 9, 3), np.uint8)
    for backend in ("torch", "onnx"):
        channel, value = chiasm.runtime.open(made).method("forward", backend=backend)(image_)
        assert np.array_equal(channel, image_.argmax(-1))
        assert np.allclose(value, image_.max(-1) / 255.0)


def passed_on(input: Tensor, matrix: Tensor) -> Tuple[Tensor, Tensor]:
    """An input unchanged, and another with an extra row."""
    return input.clone(), torch.cat([matrix, torch.zeros_like(matrix[:1])], 0)


def test_samples_that_are_parts_of_other_tensors(tmp_path: Path) -> None:
    """A former bug: native code was compiled for the strides of a sample, and read wrong elements of other
    inputs."""

    def sums(boxes: Tensor) -> Tensor:
        return boxes.sum(1)

    spec = Spec(
        "test.sums",
        [TensorSpec("boxes", ("N", 4))],
        gradients=(),
        make_inputs=lambda generator, sizes, dtype: {"boxes": torch.rand(sizes["N"], 5, dtype=dtype)[:, 1:]},
    )
    made = export(sums, spec, tmp_path, formats=["native"])
    boxes = np.arange(24, dtype=np.float32).reshape(6, 4)
    np.testing.assert_array_equal(chiasm.runtime.open(made).method()(boxes), boxes.sum(1))


def test_gradients_that_are_cotangents_or_parts_of_them(tmp_path: Path) -> None:
    spec = Spec(
        "test.passed_on",
        [TensorSpec("input", ("N",)), TensorSpec("matrix", (2, 3))],
        [TensorSpec("copy"), TensorSpec("longer")],
    )
    made = export(passed_on, spec, tmp_path, formats=["torchscript", "onnx"])
    random = np.random.default_rng(0)
    x, m, dx, dm = (random.random(shape, np.float32) for shape in ((5,), (2, 3), (5,), (3, 3)))
    for backend in ("torch", "onnx"):
        gradients = chiasm.runtime.open(made).method("vjp", backend=backend)(x, m, dx, dm)
        assert np.array_equal(gradients[0], dx) and np.array_equal(gradients[1], dm[:2])


# --- errors -------------------------------------------------------------------------------------------------


def uses_a_lambda(input: Tensor) -> Tensor:
    double = lambda t: t * 2  # noqa: E731
    return double(input)


def branches_on_data(input: Tensor) -> Tensor:
    if input.sum() > 0:
        return input + 1
    return input


def has_no_onnx_form(input: Tensor) -> Tensor:
    return torch.linalg.matrix_exp(input)


def freezes_a_size(input: Tensor) -> Tensor:
    return input.reshape(7, -1)


@pytest.mark.parametrize(
    ("fn", "formats", "expected"),
    [
        (uses_a_lambda, ["torchscript"], ["TorchScript", "double = lambda"]),
        (branches_on_data, ["onnx"], ["graph", "if input.sum() > 0:"]),
        (has_no_onnx_form, ["onnx"], ["ONNX", "matrix_exp"]),
    ],
)
def test_what_cannot_be_exported_is_named(fn, formats, expected, tmp_path: Path) -> None:
    spec = Spec(
        "test.bad", [TensorSpec("input", ("B", 5, 5))] if fn is has_no_onnx_form else [image()], gradients=()
    )
    with pytest.raises(ExportError) as caught:
        export(fn, spec, tmp_path, formats=formats)
    for part in ["test.bad", *expected]:
        assert part in str(caught.value)
    assert not any(tmp_path.iterdir()), "a failed export leaves nothing behind"


def test_a_size_that_the_code_fixes_is_named(tmp_path: Path) -> None:
    def first_seven(input: Tensor) -> Tensor:
        return input + torch.ones(7, 1, 1, 1)

    with pytest.raises(ExportError, match="B"):
        export(first_seven, Spec("test.bad", [image()], gradients=()), tmp_path, formats=["onnx"])


def _twice_with_places(x: Tensor) -> Tensor:
    """The number of elements is both a size in the graph and a size that the graph queries."""
    flat = x.reshape(-1)
    return (flat[:, None] * torch.ones([2])).flatten().unflatten(0, [flat.size(0), 2]) + torch.arange(
        x.numel()
    )[:, None]


def test_the_number_of_elements_is_a_size_like_others(tmp_path: Path) -> None:
    bundle = export(
        _twice_with_places, Spec("test.places", [TensorSpec("x", ("B", "N"))]), tmp_path, formats=["onnx"]
    )
    x = torch.rand(2, 5)
    assert onnx_session(bundle / "forward.float32.onnx")({"x": x})[0].equal(_twice_with_places(x))


def _costs_of_four(models: Tensor, planes: Tensor) -> Tensor:
    return model_costs(models[:, :4], planes, True)


def _costs_of_all(models: Tensor, planes: Tensor) -> Tensor:
    return model_costs(models, planes, True)


def test_an_export_leaves_no_trace_on_the_next() -> None:
    """torch.compile traces loops, keeps the result, and checks at the next call whether it fits: this is a
    guard on a free size."""
    models, planes = torch.rand(7, 30, 3, 3), torch.rand(7, 7, 11)
    for fn, least in (_costs_of_four, 6), (_costs_of_all, 1):
        tensors = [TensorSpec("models", ("B", "S", 3, 3)), TensorSpec("planes", ("B", 7, "N"))]
        spec = Spec(f"test.{fn.__name__}", tensors, symbols={"S": (least, 100)})
        op = bind_spec(fn, spec)
        program = trace(op, spec, tensors, {"models": torch.rand(7, 17, 3, 3), "planes": planes}, "onnx")
        torch.testing.assert_close(program.module()(models, planes), fn(models, planes))


def test_wrong_specs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="outputs"):
        export(
            scaled_difference,
            replace(SPEC, outputs=[TensorSpec("a"), TensorSpec("b")]),
            tmp_path,
            formats=["onnx"],
        )
    with pytest.raises(ExportError, match="formats"):
        export(scaled_difference, SPEC, tmp_path, formats=["tensorflow"])
    with pytest.raises(ExportError, match="identifier"):
        export(scaled_difference, Spec("test.bad", [image("not a name")]), tmp_path)
    with pytest.raises(ExportError, match="limits"):
        export(scaled_difference, Spec("test.bad", [TensorSpec("input", ("Q",))]), tmp_path)


def test_damaged_bundles_are_refused(bundle: Path, tmp_path: Path) -> None:
    from chiasm.export.verify import verify

    copy = tmp_path / bundle.name
    shutil.copytree(bundle, copy)
    target = copy / "forward.float32.onnx"
    data = target.read_bytes()
    target.write_bytes(data[:-1])
    with pytest.raises(BundleError, match=r"forward\.float32\.onnx.*truncated"):
        verify(copy)
    target.write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
    with pytest.raises(BundleError, match=r"forward\.float32\.onnx.*sha256"):
        verify(copy)
    manifest = json.loads((copy / "manifest.json").read_text())
    (copy / "manifest.json").write_text(json.dumps(manifest | {"schema_version": 99}))
    with pytest.raises(BundleError, match="99"):
        read_manifest(copy)
    (copy / "manifest.json").write_text("{")
    with pytest.raises(BundleError, match="not JSON"):
        read_manifest(copy)


def test_keys_of_a_manifest_are_compared_once(tmp_path: Path) -> None:
    count = 30_000
    keys = [*(f'"{i}": 0' for i in range(count)), f'"{count - 1}": 0']
    began = time.process_time()
    with pytest.raises(BundleError, match=f"the key '{count - 1}' occurs twice"):
        parse_manifest(tmp_path, f"{{{', '.join(keys)}}}".encode())
    assert time.process_time() - began < 2


def test_onnx_runtime_gets_the_bytes_that_were_checked(
    light: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    from chiasm.export.verify import verify

    session, given = onnxruntime.InferenceSession, set()

    def noted(model: bytes, *arguments: object, **options: object) -> onnxruntime.InferenceSession:
        given.add(sha256(model))
        return session(model, *arguments, **options)

    monkeypatch.setattr(onnxruntime, "InferenceSession", noted)
    bundle = light("filters.sobel")
    assert all(row.passed for row in verify(bundle) if "python" in row.backend)
    artifacts = [a for method in read_manifest(bundle)["methods"].values() for a in method["artifacts"]]
    assert given and given <= {a["sha256"] for a in artifacts if a["format"] == "onnx"}


def test_the_catalog_is_sound() -> None:
    for name, entry in catalog().items():
        assert entry.spec.name == name
        assert callable(entry.function())
        assert entry.spec.reference, f"{name} says nothing of what it was tested against"
        assert (entry.function().__doc__ or "").strip(), f"{name} has no docstring"


def test_torchscript_keeps_branches(bundle: Path) -> None:
    scripted = torch.jit.load(io.BytesIO((bundle / "forward.pt").read_bytes()))
    assert "scaled_difference" in str(scripted.inlined_graph) or "abs" in str(scripted.inlined_graph)
    assert (
        scripted(torch.rand(1, 1, 5, 6, dtype=torch.float64), torch.ones(1, dtype=torch.float64)).dtype
        == torch.float64
    )


def share(input: torch.Tensor) -> torch.Tensor:
    """Each element's share of the sum; 0 if the sum is 0."""
    return input / (input.sum() + 1e-300)


def test_onnx_keeps_a_term_that_is_zero_in_float32(tmp_path: Path) -> None:
    spec = Spec("test.share", [TensorSpec("input", ("N",), "float64")], gradients=())
    bundle = export(share, spec, tmp_path, formats=("onnx",))
    session = onnxruntime.InferenceSession(bundle / "forward.onnx", providers=["CPUExecutionProvider"])
    assert session.run(None, {"input": np.zeros(3)})[0].tolist() == [0.0, 0.0, 0.0]
    assert session.run(None, {"input": np.array([1e-300, 0.0])})[0].tolist() == [0.5, 0.0]


def test_sizes_of_a_trace_are_none_of_the_settings() -> None:
    """A former bug: the gradient of 7 x 7 bins was specialised to a batch of 7, the size of its trace."""
    spec = catalog()["ops.roi_align"].spec
    assert example_inputs.EXAMPLE["B"] in spec.config["output_size"]
    sizes = example_inputs.example(spec)
    assert not set(sizes.values()) & set(spec.config["output_size"])
    assert len(set(sizes.values())) == len(sizes)
    assert example_inputs.example(SPEC) == example_inputs.fit(SPEC, example_inputs.EXAMPLE)
