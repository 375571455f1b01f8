"""`chiasm triton`: the written models are served, and existing files are not touched."""

from __future__ import annotations

import doctest
import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import tritonclient.grpc as grpc_client
from click.testing import CliRunner
from google.protobuf import text_format
from onnx import TensorProto, helper, numpy_helper
from tritonclient.grpc import model_config_pb2

import chiasm.runtime
import chiasm.triton
from chiasm.export.cli import main

from .server import BUNDLES, ROOT, Server, tensors

FRAME = np.random.default_rng(13).integers(0, 256, (333, 500, 3), np.uint8)
PREPARE, SOBEL = (BUNDLES / f"{name}.chiasm" for name in ("pipelines.preprocess", "filters.sobel"))


def network(path: Path, channels: int = 3, dtype: int = TensorProto.FLOAT) -> Path:
    """A convolution of stride two, on batches of images of 224 x 224."""
    weights = np.random.default_rng(1).standard_normal((2, channels, 3, 3)).astype(np.float32)
    graph = helper.make_graph(
        [helper.make_node("Conv", ["images", "weights"], ["features"], strides=[2, 2])],
        "network",
        [helper.make_tensor_value_info("images", dtype, ["N", channels, 224, 224])],
        [helper.make_tensor_value_info("features", dtype, ["N", 2, 111, 111])],
        [numpy_helper.from_array(weights, "weights")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)
    onnx.save_model(model, path)
    return path


def run(*arguments: str | Path) -> tuple[int, str]:
    done = CliRunner().invoke(main, ["triton", *map(str, arguments)])
    return done.exit_code, done.output


def in_turn(model: Path, frame: np.ndarray) -> np.ndarray:
    """The same chain without Triton."""
    images = chiasm.runtime.open(PREPARE).method(backend="native", num_threads=1)(frame)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    [features] = session.run(None, {"images": np.asarray(images)})
    return np.asarray(chiasm.runtime.open(SOBEL).method(backend="native", num_threads=1)(features))


def test_an_ensemble(server: Server, tmp_path: Path) -> None:
    model = network(tmp_path / "network.onnx")
    status, said = run(server.repository, "--ensemble", "chain", f"prepare={PREPARE}", model, SOBEL)
    assert status == 0, said
    for name in ("prepare", "network", "filters.sobel", "chain"):
        assert f"wrote {server.repository / name}" in said
    server.http.load_model("chain")  # and its parts with it
    answer = server.grpc.infer("chain", tensors(grpc_client, {"frame": FRAME}))
    expected = in_turn(model, FRAME)
    assert answer.as_numpy("output").tobytes() == expected.tobytes()
    small = np.zeros((4, 4, 3), np.uint8)
    with pytest.raises(grpc_client.InferenceServerException, match="H must be from 8 to 32768"):
        server.grpc.infer("chain", tensors(grpc_client, {"frame": small}))
    # The network itself reports invalid inputs
    wrong = np.zeros((1, 3, 224, 100), np.float32)
    with pytest.raises(grpc_client.InferenceServerException, match="images"):
        server.grpc.infer("network", tensors(grpc_client, {"images": wrong}))
    for name in ("chain", "network"):
        server.unload(name)


def passing(path: Path, before: str, *after: str) -> Path:
    """A network whose outputs `after` are its input times 1, 2 ..."""
    counts = [numpy_helper.from_array(np.array(i + 1, np.float32), f"count{i}") for i in range(len(after))]
    graph = helper.make_graph(
        [helper.make_node("Mul", [before, c.name], [out]) for c, out in zip(counts, after, strict=True)],
        "passing",
        [helper.make_tensor_value_info(before, TensorProto.FLOAT, ["N"])],
        [helper.make_tensor_value_info(out, TensorProto.FLOAT, ["N"]) for out in after],
        counts,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)
    onnx.save_model(model, path)
    return path


def test_names_that_are_taken(server: Server, tmp_path: Path) -> None:
    """In an ensemble, a name belongs to one tensor."""
    first = passing(tmp_path / "a.onnx", "x", "first.y", "y")
    second = passing(tmp_path / "b.onnx", "y", "x", "x_out", "first.y")
    assert run(server.repository, "--ensemble", "round", f"first={first}", f"second={second}")[0] == 0
    server.http.load_model("round")
    x = np.arange(5, dtype=np.float32)
    answer = server.grpc.infer("round", tensors(grpc_client, {"x": x}))
    # The second part takes `y`, which is twice the input
    for name, expected in (("x_out_2", 2 * x), ("x_out", 4 * x), ("first.y", 6 * x)):
        assert np.array_equal(answer.as_numpy(name), expected), name
    server.unload("round")


def test_names_between_parts_are_kept_apart(server: Server, tmp_path: Path) -> None:
    """`a` with the output `b.c`, and `a.b` with the output `c`."""
    parts = [("a", "i", "b.c"), ("a.b", "b.c", "c"), ("last", "c", "o")]
    files = [f"{name}={passing(tmp_path / f'{name}.onnx', x, y)}" for name, x, y in parts]
    assert run(server.repository, "--ensemble", "dots", *files)[0] == 0
    server.http.load_model("dots")
    x = np.arange(5, dtype=np.float32)
    assert np.array_equal(server.grpc.infer("dots", tensors(grpc_client, {"i": x})).as_numpy("o"), x)
    server.unload("dots")


def test_names_may_have_any_characters(tmp_path: Path) -> None:
    """protobuf reads the configurations as they are meant."""
    names = 'in "quotes" \\ \x01\n\x7f2', "lögits 日本 😀"
    status, said = run(tmp_path / "models", passing(tmp_path / "a.onnx", *names))
    assert status == 0, said
    text = (tmp_path / "models" / "a" / "config.pbtxt").read_text("utf-8")
    config = text_format.Parse(text, model_config_pb2.ModelConfig())
    assert (config.backend, config.input[0].name, config.output[0].name) == ("python", *names)


def test_an_output_that_no_part_takes_is_left_out(server: Server, tmp_path: Path) -> None:
    more = passing(tmp_path / "more.onnx", "i", "unused", "z")
    last = passing(tmp_path / "taking.onnx", "z", "o")
    assert run(server.repository, "--ensemble", "fewer", more, last)[0] == 0
    server.http.load_model("fewer")
    x = np.arange(5, dtype=np.float32)
    assert np.array_equal(server.grpc.infer("fewer", tensors(grpc_client, {"i": x})).as_numpy("o"), 2 * x)
    server.unload("fewer")


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    repository = tmp_path / "models"
    assert run(repository, f"edges={SOBEL}")[0] == 0
    before = {path: path.read_bytes() for path in repository.rglob("*") if path.is_file()}
    status, said = run(repository, f"new={SOBEL}", f"edges={PREPARE}")
    assert status == 1 and f"{repository / 'edges'} is there already" in said
    (repository / "dangling").symlink_to("nowhere")
    assert run(repository, f"dangling={SOBEL}")[0] == 1
    assert before == {path: path.read_bytes() for path in repository.rglob("*") if path.is_file()}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["models"]


def test_a_repository_that_is_a_mount() -> None:
    """Like a volume in a container: nothing can be moved into it from outside."""
    repository, name = Path("/dev/shm"), f"chiasm-test-{os.getpid()}"
    if not os.path.ismount(repository):
        pytest.skip(f"{repository} is no mount here")
    try:
        status, said = run(repository, f"{name}={SOBEL}")
        assert status == 0, said
        assert (repository / name / "1" / SOBEL.name / "manifest.json").is_file()
        assert (repository / name / "config.pbtxt").is_file()
        assert not [*repository.glob(".chiasm-triton-*"), *repository.parent.glob(".chiasm-triton-*")]
    finally:
        shutil.rmtree(repository / name, ignore_errors=True)


def test_all_models_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rename, repository = os.rename, tmp_path / "models"

    def full(source: Path, target: Path) -> None:
        if target.name == "second":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(source), None, str(target))
        rename(source, target)

    monkeypatch.setattr(os, "rename", full)
    status, said = run(repository, f"first={SOBEL}", f"second={SOBEL}")
    assert status == 1 and f"{repository / 'second'}: No space left on device" in said, said
    assert not list(repository.iterdir()) and [p.name for p in tmp_path.iterdir()] == ["models"]


def test_refusals(tmp_path: Path) -> None:
    repository = tmp_path / "models"
    damaged = tmp_path / "damaged.chiasm"
    damaged.mkdir()
    (damaged / "manifest.json").write_text("{")
    other, leading_out = tmp_path / "other.chiasm", tmp_path / "leading_out.chiasm"
    for bundle in (other, leading_out):
        shutil.copytree(SOBEL, bundle)
    (other / "forward.pt").write_bytes(b"")
    (leading_out / "etc").symlink_to("/etc")
    no_model = tmp_path / "no.onnx"
    no_model.write_bytes(b"\xff" * 100)
    (tmp_path / "empty.onnx").write_bytes(b"")
    os.mkfifo(tmp_path / "pipe.onnx")
    four = network(tmp_path / "four.onnx", channels=4)
    hidden = onnx.load(four)
    outside = TensorProto(name="secret", data_type=1, dims=[1], data_location=TensorProto.EXTERNAL)
    hidden.graph.node.append(helper.make_node("Constant", [], ["unused"], value=outside))
    (tmp_path / "hidden.onnx").write_bytes(hidden.SerializeToString())
    for arguments, words in (
        ([tmp_path / "nothing.chiasm"], "expected a bundle (a folder NAME.chiasm) or a *.onnx file"),
        ([damaged], "manifest.json: not JSON"),
        ([other], "forward.pt"),
        ([leading_out], "'etc', which its manifest does not name"),
        ([no_model], "no.onnx"),
        ([tmp_path / "nothing.onnx"], "nothing.onnx: No such file"),
        ([tmp_path / "empty.onnx"], "empty.onnx: not an ONNX model: it has no outputs"),
        ([tmp_path / "hidden.onnx"], "hidden.onnx: the tensor 'secret' is in another file"),
        ([tmp_path / "pipe.onnx"], "pipe.onnx: not a regular file but a pipe"),
        ([f"a/b={SOBEL}"], "expected a bundle"),
        ([""], "expected [NAME=]BUNDLE, got an empty path"),
        (["edges="], "'edges=': expected [NAME=]BUNDLE, got an empty path"),
        ([f"..={SOBEL}"], "'..' cannot be a model's name"),
        ([f"a b={SOBEL}"], "'a b' cannot be a model's name"),
        ([f"{'a' * 256}={SOBEL}"], "expected up to 255 letters"),
        ([SOBEL, SOBEL], "two models would be called 'filters.sobel'"),
        ([f"same={PREPARE}", SOBEL, "--ensemble", "same"], "two models would be called 'same'"),
        ([SOBEL, "--ensemble", "one"], "expected two parts or more, got 1"),
        ([SOBEL, PREPARE, "--ensemble", "../x"], "'../x' cannot be a model's name"),
        (
            [f"a={PREPARE}", f"b={four}", "--ensemble", "c"],
            "output 'output' fp32 [1, 3, 224, 224] cannot become input 'images' fp32 [-1, 4, 224, 224]",
        ),
        ([f"a={SOBEL}", f"b={PREPARE}", "--ensemble", "c"], "cannot become input 'frame' uint8 [-1, -1, 3]"),
    ):
        status, said = run(repository, *arguments)
        assert status == 1 and words in said and "Traceback" not in said, said
    assert not repository.exists()
    assert run(repository)[0] == 2


def test_a_bundle_is_no_repository(tmp_path: Path) -> None:
    bundle = tmp_path / "sobel.chiasm"
    shutil.copytree(SOBEL, bundle)
    for repository in (bundle, bundle / "models"):
        status, said = run(repository, bundle)
        assert status == 2 and "is inside the bundle" in said, said
        with pytest.raises(chiasm.triton.RepositoryError, match="it is inside the bundle"):
            chiasm.triton.write(repository, [chiasm.triton.Part("sobel", bundle)])
    assert chiasm.runtime.open(bundle).name == "filters.sobel"


def test_a_repository_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "models").write_text("")
    assert run(tmp_path / "models", SOBEL)[0] == 2


def test_the_docstring(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    result = doctest.testmod(chiasm.triton)
    assert result.attempted and not result.failed


def test_nothing_heavy_is_imported() -> None:
    code = (
        "import sys, chiasm.triton; print({'torch', 'onnx', 'onnxruntime', 'tritonclient'} & {*sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
