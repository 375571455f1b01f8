"""The Python API of the runtime: errors of wrong calls, bundles and artifacts."""

import ctypes
import io
import os
import zipfile
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from scale_bundle import BACKENDS, artifact, example, scripted, tensor, write_bundle, write_scale

import chiasm.runtime as runtime
from chiasm.runtime import ChiasmError, Code


def test_run_into_refuses(method: runtime.Method) -> None:
    x, scale, keep = example()
    y, dropped = np.empty_like(x), np.empty_like(keep)
    for outputs, words in [
        ([np.empty((4, 7), np.float32), dropped], ["y", "4", "5"]),
        ([y.astype(np.float64), dropped], ["y", "float64", "float32"]),
        ([x, dropped], ["y", "overlap"]),
        ([torch._neg_view(torch.from_numpy(y)), dropped], ["y", "negative bit"]),
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


class Copied:
    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def __dlpack__(self, **options: object) -> object:
        return self.array.__dlpack__(**options, copy=True)  # NumPy's capsule says that it is a copy


def test_a_copy_is_read_but_not_written(method: runtime.Method) -> None:
    x, scale, keep = example()
    np.testing.assert_array_equal(method(Copied(x), scale, keep)[0], method(x, scale, keep)[0])
    outputs = [Copied(np.empty_like(x)), np.empty_like(keep)]
    with pytest.raises(ChiasmError, match="output 'y': its __dlpack__ returned a copy") as error:
        method.run_into((x, scale, keep), outputs)
    assert error.value.code == Code.INVALID_ARGUMENT


# Errors


class Unwilling:
    def __dlpack__(self, **options: object) -> object:
        raise KeyError("no")


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
        (lambda x: np.zeros((0, 7), np.float32), ["x", "must be from 1"]),
        (lambda x: torch.zeros(0, 7), ["x", "must be from 1"]),  # it has no data
        (lambda x: torch.from_numpy(x).t(), ["x"]),
        (lambda x: torch.from_numpy(x).requires_grad_(), ["x", "requires grad", "detach"]),
        (lambda x: torch._neg_view(-torch.from_numpy(x)), ["x", "negative bit", "resolve_neg"]),
        (lambda x: torch.empty((5, 7), device="meta"), ["x", "DLPack", "meta"]),
        (lambda x: torch.from_numpy(x).to_sparse(), ["x", "DLPack", "pass a dense"]),
        (lambda x: torch.quantize_per_tensor(torch.from_numpy(x), 0.1, 0, torch.quint8), ["x", "DLPack"]),
        (lambda x: Unwilling(), ["x", "DLPack", "KeyError: 'no'"]),
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


def test_bytes_of_bool_are_0_or_1(method: runtime.Method) -> None:
    x, scale, keep = example()
    keep.view(np.uint8)[1, 2] = 255
    with pytest.raises(ChiasmError, match=r"'keep'.*0 or 1, got 255 at element 9") as error:
        method(x, scale, keep)
    assert error.value.code == Code.INVALID_ARGUMENT


class Scatter(torch.nn.Module):
    def forward(self, x: torch.Tensor, keep: torch.Tensor) -> torch.Tensor:
        return x.masked_scatter(keep, x[0])  # fails if more than one row is kept


def test_errors_of_torch_have_no_stack(tmp_path: Path) -> None:
    """For code that is compiled for libtorch, whose error texts contain libtorch's stack."""
    x, keep = np.zeros((2, 3), np.float32), np.zeros((2, 3), bool)
    program = torch.export.export(Scatter(), (torch.from_numpy(x), torch.from_numpy(keep)))
    package = str(tmp_path / "scatter.pt2")
    torch._inductor.aoti_compile_and_package(program, package_path=package)
    data = Path(package).read_bytes()
    shape = [2, 3]
    forward = {
        "inputs": [tensor("x", "T", shape), tensor("keep", "bool", shape)],
        "outputs": [tensor("y", "T", shape)],
        "artifacts": [artifact("torch", "aotinductor", "scatter.pt2", data, ["float32"])],
    }
    golden = {"a/x": x, "a/keep": keep, "a/y": x}
    cases = [{"prefix": "a", "method": "forward", "dtype": "float32"}]
    path = write_bundle(tmp_path, "test.scatter", {"forward": forward}, {"scatter.pt2": data}, golden, cases)
    with pytest.raises(ChiasmError, match="Number of elements of source") as error:
        runtime.open(path).method()(x, ~keep)
    assert "raised from" not in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", ["input", "output"])
def test_a_graph_of_another_dtype_is_refused_when_it_is_loaded(kind: str, tmp_path: Path) -> None:
    x = np.zeros((2, 3), np.float32)
    types = {"input": onnx.TensorProto.FLOAT, "output": onnx.TensorProto.FLOAT, kind: onnx.TensorProto.DOUBLE}
    info = onnx.helper.make_tensor_value_info
    graph = onnx.helper.make_graph(
        [onnx.helper.make_node("Cast", ["x"], ["y"], to=types["output"])],
        "cast",
        [info("x", types["input"], [2, 3])],
        [info("y", types["output"], [2, 3])],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 18)], ir_version=10)
    data = model.SerializeToString()
    forward = {
        "inputs": [tensor("x", "T", [2, 3])],
        "outputs": [tensor("y", "T", [2, 3])],
        "artifacts": [artifact("onnx", "onnx", "cast.onnx", data, ["float32"])],
    }
    cases = [{"prefix": "a", "method": "forward", "dtype": "float32"}]
    path = write_bundle(
        tmp_path, "test.cast", {"forward": forward}, {"cast.onnx": data}, {"a/x": x, "a/y": x}, cases
    )
    name = {"input": "x", "output": "y"}[kind]
    with pytest.raises(
        ChiasmError, match=f"the graph's {kind} '{name}' is float64, the manifest says float32"
    ) as error:
        runtime.open(path).method()
    assert error.value.code == Code.CORRUPT


@pytest.mark.parametrize(
    ("operator", "numbers", "code", "message"),
    [
        ("Reshape", [3, 2], Code.INTERNAL, "Got: 2 Expected: 3 .*Got: 3 Expected: 2 .*the model"),
        ("Gather", [1, 99], Code.INTERNAL, "idx=99 must be within"),
        ("Expand", [2**38, 2, 3], Code.OUT_OF_MEMORY, "Failed to allocate memory"),
        ("Expand", [2**62, 2, 3], Code.INTERNAL, "verflow"),
    ],
)
def test_a_graph_that_fails_while_it_runs_is_one_sentence(
    operator: str, numbers: list[int], code: Code, message: str, tmp_path: Path
) -> None:
    x = np.zeros((2, 3), np.float32)
    info, node = onnx.helper.make_tensor_value_info, onnx.helper.make_node
    last = "y" if operator == "Reshape" else "made"
    nodes = [node(operator, ["x", "numbers"], [last])]
    if last == "made":
        nodes += [node("ReduceSum", ["made"], ["sum"], keepdims=0), node("Add", ["x", "sum"], ["y"])]
    graph = onnx.helper.make_graph(
        nodes,
        "fails",
        [info("x", onnx.TensorProto.FLOAT, ["N", "M"])],
        [info("y", onnx.TensorProto.FLOAT, ["N", "M"])],
        [onnx.numpy_helper.from_array(np.array(numbers), "numbers")],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 18)], ir_version=10)
    data = model.SerializeToString()
    forward = {
        "inputs": [tensor("x", "T", [2, 3])],
        "outputs": [tensor("y", "T", [2, 3])],
        "artifacts": [artifact("onnx", "onnx", "fails.onnx", data, ["float32"])],
    }
    cases = [{"prefix": "a", "method": "forward", "dtype": "float32"}]
    path = write_bundle(
        tmp_path, "test.fails", {"forward": forward}, {"fails.onnx": data}, {"a/x": x, "a/y": x}, cases
    )
    method = runtime.open(path).method()
    for _ in range(2):
        with pytest.raises(
            ChiasmError, match=f"^running 'forward' on the onnx backend failed: .*{message}"
        ) as e:
            method(x)
        assert e.value.code == code and "\n" not in str(e.value) and "  " not in str(e.value)


def test_bytes_that_are_no_text_are_quoted(tmp_path: Path) -> None:
    path = write_scale(tmp_path)
    Path(os.fsdecode(os.fsencode(path) + b"/\xff.pt")).touch()
    with pytest.raises(ChiasmError, match=r"has '\\xff\.pt', which its manifest does not name"):
        runtime.open(path)


def test_wrong_calls_are_type_errors(method: runtime.Method) -> None:
    x, scale, keep = example()
    with pytest.raises(TypeError, match="takes 3 inputs, got 4"):
        method(x, scale, keep, x)
    with pytest.raises(TypeError, match="needs 'keep', which is missing"):
        method(x, scale)
    with pytest.raises(TypeError, match="has no input 'sigma'"):
        method(x, scale, keep, sigma=1)
    with pytest.raises(TypeError, match=r"has no input '\\ud800'"):
        method(x, scale, keep, **{"\ud800": 1})
    with pytest.raises(TypeError, match="got 'x' by position and by name"):
        method(x, x=x, scale=scale, keep=keep)


class Stream:
    def __cuda_stream__(self) -> tuple:
        return ()


class Refusal(Exception):
    def __str__(self) -> str:
        raise KeyError


class Refusing:
    def __init__(self, error: Exception) -> None:
        self.error = error

    def __dlpack__(self, **_: object) -> object:
        raise self.error


class NoInterface:
    __array_interface__ = 5


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"returns": "jax"}, "returns: expected 'numpy', 'torch' or 'dlpack', got 'jax'"),
        ({"returns": 5}, "got 5 (int)"),
        ({"returns": "\ud800"}, r"got '\ud800'"),
        ({"stream": "x"}, "stream: expected a cudaStream_t"),
        ({"stream": -1}, "got -1 (int)"),
        ({"stream": 1 << 70}, "stream: expected a cudaStream_t"),
        ({"stream": 1.5}, "got 1.5 (float)"),
        ({"stream": Stream()}, "got Stream"),
    ],
)
def test_options_of_a_run_that_it_does_not_know(method: runtime.Method, options: dict, words: str) -> None:
    with pytest.raises(ChiasmError) as error:
        method.run(example(), **options)
    assert error.value.code == Code.INVALID_ARGUMENT and words in str(error.value), str(error.value)


GET_POINTER = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
    ("PyCapsule_GetPointer", ctypes.pythonapi)
)


class OnCuda:
    """An array that says that its memory is a GPU's: for calls that are refused before anything reads it."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def __dlpack__(self, **_: object) -> object:
        capsule = self.array.__dlpack__()
        ctypes.c_int32.from_address(GET_POINTER(capsule, b"dltensor") + 8).value = 2  # DLTensor.device
        return capsule


@pytest.mark.parametrize("stream", [True, "x", Stream()])
def test_a_stream_is_checked_before_outputs_are_made_for_it(method: runtime.Method, stream: object) -> None:
    x, scale, keep = example()
    with pytest.raises(ChiasmError, match="stream: expected a cudaStream_t"):
        method.run((OnCuda(x), scale, keep), returns="torch", stream=stream)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (NoInterface(), "NumPy does not take it (ValueError: "),
        (Refusing(ValueError("\ud800")), r"DLPack (ValueError: \ud800)"),
        (Refusing(Refusal()), "DLPack (Refusal: )"),
        (bytes(140), "got bytes; pass numpy.frombuffer"),
        (np.empty((1,) * 9), "has 9 dimensions, not 0 to 8"),
    ],
)
def test_objects_that_are_no_arrays(method: runtime.Method, given: object, words: str) -> None:
    _, scale, keep = example()
    with pytest.raises(ChiasmError) as error:
        method(given, scale, keep)
    assert str(error.value).startswith("input 'x': ") and words in str(error.value), str(error.value)


class Numbers(torch.nn.Module):
    def forward(self, x: torch.Tensor, n: torch.Tensor, flag: torch.Tensor, f: torch.Tensor) -> torch.Tensor:
        return torch.where(flag, x * n + f, x)


def test_numbers_that_a_dtype_cannot_hold(tmp_path: Path) -> None:
    dtypes = {"x": "float32", "n": "int64", "flag": "bool", "f": "float32"}
    inputs = [tensor(name, dtype, ["H"] if name == "x" else []) for name, dtype in dtypes.items()]
    program = scripted(Numbers())
    methods = {
        "forward": {
            "inputs": inputs,
            "outputs": [tensor("y", "float32", ["H"])],
            "artifacts": [artifact("torch", "torchscript", "program.pt", program, ["float32"])],
        }
    }
    golden = {
        f"a/{name}": np.ones([1] * (name in "xy"), dtypes.get(name, "float32")) for name in [*dtypes, "y"]
    }
    case = {"prefix": "a", "method": "forward", "dtype": "float32"}
    bundle = write_bundle(tmp_path, "test.numbers", methods, {"program.pt": program}, golden, [case])
    method, x = runtime.open(bundle).method(backend="torch"), np.ones(2, np.float32)
    for numbers in ((2, True, 1.0), (2.0, 1, 1), (True, 1.0, True)):
        np.testing.assert_array_equal(method(x, *numbers), x * numbers[0] + numbers[2])
    for name, value, words in (
        ("n", 2.7, "int64, got 2.7 (float)"),
        ("n", float("nan"), "int64, got nan (float)"),
        ("n", 1 << 63, "int64, got 9223372036854775808 (int)"),
        ("flag", 2, "bool, got 2 (int)"),
        ("flag", 0.3, "bool, got 0.3 (float)"),
        ("f", 1e39, "float32, got 1e+39 (float)"),
        ("f", 10**400, "float32, got int"),
        ("f", 10**5000, "float32, got int"),
    ):
        given = {"n": 2, "flag": True, "f": 1.0} | {name: value}
        with pytest.raises(ChiasmError) as error:
            method(x, **given)
        assert str(error.value) == f"input '{name}': expected a value of {words}"


def test_nobody_else_makes_its_objects(method: runtime.Method) -> None:
    """An object that was made by __new__ alone must not be used as if it were a method."""
    for cls in (type(method), type(method.inputs[0]), type(method.run(example(), returns="dlpack")[0])):
        for make in (cls, cls.__new__, type("Subclass", (cls,), {})):
            with pytest.raises(TypeError, match=r"only chiasm\.runtime makes"):
                make(*[cls] * (make is cls.__new__))


def test_what_is_no_list_of_runs(method: runtime.Method) -> None:
    for given, words in ((iter([]), "got list_iterator"), (None, "got None"), ({}, "got dict")):
        with pytest.raises(ChiasmError, match="inputs: expected a list or a tuple .*" + words):
            method.run_each(given, [])
        with pytest.raises(ChiasmError, match="outputs: expected a list or a tuple .*" + words):
            method.run_each([], given)


@pytest.mark.parametrize(
    "options, code, words",
    [
        ({"name": "backward"}, Code.NOT_FOUND, ["backward"]),
        ({"backend": "tensorrt"}, Code.UNAVAILABLE, ["libchiasm_tensorrt.so", "CHIASM_BACKEND_PATH"]),
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


@pytest.mark.parametrize("device", ["gpu", "cuda:x", "", "cuda:999999999999", "cuda:²", "cuda:-1", None])
def test_bad_device(bundle: runtime.Bundle, device: str) -> None:
    with pytest.raises(ValueError, match="device: expected 'cpu', 'cuda' or 'cuda:N', got"):
        bundle.method(device=device)


@pytest.mark.parametrize(
    "options, error, message",
    [
        ({"num_threads": 2**31}, ValueError, "num_threads: expected a number from 0 to 2147483647, got"),
        ({"num_threads": 1.5}, TypeError, "num_threads: expected a whole number, got 1.5"),
        ({"num_threads": -1}, ChiasmError, "-1"),
        ({"fused": "no"}, TypeError, "fused: expected a bool, got 'no'"),
        ({"warm_up": "x"}, TypeError, "warm_up: expected a bool, got 'x'"),
        ({"allow_native_code": "no"}, TypeError, "allow_native_code: expected a bool, got 'no'"),
        ({"backend": None}, TypeError, "backend: expected a str, got None"),
        ({"backend": "torch\0"}, ValueError, "backend: expected text without NUL"),
        ({"name": "forward\0"}, ValueError, "name: expected text without NUL"),
        ({"name": "\ud800"}, ValueError, r"name: expected text .* in UTF-8, got '\\ud800'"),
        ({"dtype": "float32\0"}, ValueError, "dtype: expected text"),
        ({"options": {"a\0": "b"}}, ValueError, "options: expected text"),
        ({"options": {1: "b"}}, TypeError, "options: expected a str, got 1"),
        ({"options": [("a", "b"), ("a", "c")]}, TypeError, "options: expected a dict of texts, got"),
    ],
)
def test_arguments_that_cpp_does_not_take(
    bundle: runtime.Bundle, options: dict, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message) as caught:
        bundle.method(**options)
    assert "\n" not in str(caught.value) and "0x" not in str(caught.value)


def test_arguments_of_the_module_that_cpp_does_not_take(bundle: runtime.Bundle) -> None:
    with pytest.raises(ValueError, match="count: expected a number from 0"):
        runtime.set_num_threads(2**40)
    with pytest.raises(ValueError, match="path: expected text without NUL"):
        runtime.open("x\0y")
    with pytest.raises(ValueError, match=r"path: expected text .* in UTF-8"):
        runtime.open(b"\xff")
    with pytest.raises(ValueError, match="name: expected text without NUL"):
        bundle.signature("forward\0")
    with pytest.raises(ValueError, match="keys: expected text"):
        runtime.set_trust("signed", ["\0"])
    with pytest.raises(TypeError, match="allow_native_code: expected a bool, got 'no'"):
        bundle.self_test(allow_native_code="no")
    with pytest.raises(TypeError, match="keys: expected a list"):
        runtime.set_trust("signed", "k.pub")


def test_a_self_test_of_a_backend_that_is_none(bundle: runtime.Bundle) -> None:
    with pytest.raises(ChiasmError, match=r"libchiasm_nope\.so") as error:
        bundle.self_test("nope")
    assert error.value.code == Code.UNAVAILABLE


def test_a_mask_is_not_left_out(method: runtime.Method) -> None:
    x, scale, keep = example()
    masked = np.ma.masked_array(x, x > 0)
    with pytest.raises(ChiasmError, match=r"input 'x': its mask would be left out; pass array\.filled"):
        method(masked, scale, keep)
    method(masked.data, scale, keep)


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


def zipped(compression: int = zipfile.ZIP_STORED, **files: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, data in files.items():
            archive.writestr(f"data/{name}.so" if name.startswith("lib") else name, data)
    return buffer.getvalue()


def damaged_zip() -> bytes:
    data = bytearray(zipped(liba=bytes(range(256)) * 64))
    data[0] ^= 0xFF  # the library's own header
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
        ("native", "aotinductor", zipped(zipfile.ZIP_DEFLATED, liba=b"x"), ["data/liba.so", "compressed"]),
        ("native", "aotinductor", damaged_zip(), ["damaged header", "data/liba.so"]),
        ("torch", "torchscript", b"no program", ["bad.bin"]),
        ("torch", "aotinductor", zipped(readme=b"text"), ["bad.bin"]),
        ("onnx", "onnx", b"no graph", ["bad.bin"]),
    ],
)
def test_a_bad_artifact_says_so(
    tmp_path: Path, backend: str, form: str, data: bytes, words: list[str]
) -> None:
    """Artifacts with a correct hash and wrong content: an exporter's bug, or an attacker's manifest."""
    more = {"device": "cpu"} | ({"isa": "x86-64-v3"} if backend == "native" else {})
    more |= {"needs": ["libtorch"]} if (backend, form) == ("torch", "aotinductor") else {}
    entry = artifact(backend, form, "bad.bin", data, ["float32"], **more)
    forward = {
        "inputs": [tensor("x", "T", ["H"])],
        "outputs": [tensor("y", "T", ["H"])],
        "artifacts": [entry],
    }
    cases = [{"prefix": "a", "method": "forward", "dtype": "float32"}]
    golden = {"a/x": np.ones(3, np.float32), "a/y": np.ones(3, np.float32)}
    path = write_bundle(tmp_path, "test.bad", {"forward": forward}, {"bad.bin": data}, golden, cases)
    with pytest.raises(ChiasmError) as error:
        runtime.open(path).method(backend=backend)
    assert form == "aotinductor" or error.value.code == Code.CORRUPT
    assert "bad.bin" in str(error.value)
    assert all(word in str(error.value) for word in words), str(error.value)
