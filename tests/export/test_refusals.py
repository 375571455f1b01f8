"""Invalid specs, functions and results are rejected with one sentence, which names the problem and says what
to do."""

import functools
import os
import re
import resource
from pathlib import Path
from typing import Dict, List, NamedTuple, Tuple

import numpy as np
import pytest
import torch
import torchvision
from torch import Tensor, nn
from torch.nn import functional as F

import chiasm.runtime
from chiasm.export import ExportError, Spec, TensorSpec, Tolerance, export, image, isas
from chiasm.export.catalog import catalog
from chiasm.export.checks.arguments import check_call, check_inputs
from chiasm.export.errors import plain
from chiasm.export.example_inputs import GOLDEN, fit, make
from chiasm.export.formats import native_cache

IMAGE = Spec("test.op", [image()])


def plus(input: Tensor) -> Tensor:
    return input + 1


def numbers(**spec: object) -> Spec:
    return Spec("test.op", [TensorSpec("input", ("N",))], **spec)


def of(*shape: object, **tensor: object) -> Spec:
    return Spec("test.op", [TensorSpec("input", shape, **tensor)])


SPECS = {
    "dtype": (of("N", dtype="float8"), "input 'input': dtype 'float8' is not one of bool, uint8"),
    "dtypes": (numbers(dtypes=("float8",)), "dtypes: dtype 'float8'"),
    "32 bits without a sign": (of("N", dtype="uint32"), "uint32.*convert to int64"),
    "complex": (of("N", dtype="complex64"), "complex64.*real and the imaginary"),
    "the same dtype twice": (numbers(dtypes=("float32", "float32")), "different dtypes"),
    "no limits": (of("Q"), "symbol 'Q' has no limits: add symbols="),
    "limits the wrong way round": (numbers(symbols={"N": (10, 2)}), r"symbols\['N'\].*got \(10, 2\)"),
    "limits from 0": (numbers(symbols={"N": (0, 2)}), "1 <= min"),
    "one limit": (numbers(symbols={"N": 7}), "got 7"),
    "limits of text": (numbers(symbols={"N": (1, "x")}), "got"),
    "no range": (numbers(symbols={"N": (5, 5)}), "write 5 into the shape"),
    "name with /": (Spec("a/b", [image()]), "name: .*got 'a/b'"),
    "name with ..": (Spec("../b", [image()]), "got '../b'"),
    "name that ends with a newline": (Spec("a.b\n", [image()]), "name"),
    "no name": (Spec("", [image()]), "name"),
    "long name": (Spec("x" * 300, [image()]), "200"),
    "version": (numbers(version="one"), "version: .*'one'"),
    "no inputs": (Spec("test.op", []), "inputs: expected at least one"),
    "no outputs": (Spec("test.op", [image()], []), "outputs: expected at least one"),
    "inputs of one name": (Spec("test.op", [image(), image()]), "'input' is the name of two"),
    "output named as input": (
        Spec("test.op", [image()], [TensorSpec("input")]),
        "'input' is the name of two",
    ),
    "input named self": (Spec("test.op", [image("self")]), "identifier"),
    "input named by a keyword": (Spec("test.op", [image("lambda")]), "identifier"),
    "input outside ASCII": (Spec("test.op", [image("größe")]), "identifier"),
    "negative size": (of("B", -3), "-3 is neither"),
    "expression": (of("B", "2*H"), r"'2\*H' is neither"),
    "symbol with a space": (of("a b"), "'a b' is neither"),
    "symbol that is a keyword": (of("if"), "'if' is neither"),
    "too many dimensions": (of(*[2] * 9), "9 dimensions"),
    "range the wrong way round": (of("N", range=(2.0, 1.0)), "range: expected"),
    "range of NaN": (of("N", range=(float("nan"), 1.0)), "range: expected"),
    "range of one number": (of("N", range=5), "range: expected"),
    "version of many digits": (numbers(version="9" * 20 + ".0.0"), "version: expected"),
    "inputs of nothing": (numbers(make_inputs=lambda g, sizes, dtype: {}), "make_inputs: expected"),
    "inputs of a number": (numbers(make_inputs=lambda g, sizes, dtype: 5), "make_inputs: .* got 5"),
    "inputs that fail": (numbers(make_inputs=lambda g, sizes, dtype: 1 / 0), "make_inputs fails"),
    "range beyond the dtype": (of("N", dtype="uint8", range=(0, 300)), "does not fit into uint8"),
    "text that cannot be written": (of("N", description="\ud800"), "description"),
    "unknown configuration": (Spec("test.op", [image()], config={"nope": 1}), "'nope'"),
    "tensor as configuration": (
        Spec("test.op", [image()], config={"k": torch.ones(3)}),
        "a tensor is an input",
    ),
    "configuration that is no dict": (Spec("test.op", [image()], config=[1]), "config: expected a dict, got"),
    "size that no tensor has": (of("B", 2**70), "1180591620717411303424 is neither"),
    "sizes that no memory has": (of(2**40, 2**40), r"'input': an example of shape .* cannot be made"),
    "limits that no memory has": (
        Spec("test.op", [image()], symbols={"H": (2**31, 2**32), "W": (2**31, 2**32)}),
        r"'input': an example of shape \(1, \d+, 2147483648, 2147483648\) cannot be made",
    ),
    "infinite configuration": (Spec("test.op", [image()], config={"k": float("inf")}), "finite"),
    **{
        f"{type(value).__name__} as configuration": (
            Spec("test.op", [image()], config={"k": [(1, value)]}),
            rf"config\['k'\]: expected a finite .* or list of such, got {re.escape(repr([(1, value)]))}",
        )
        for value in ({2}, b"x", 2j, {2: 3})
    },
    "an input outside a list": (
        Spec("test.op", image()),
        r"inputs: expected at least one TensorSpec in a list \(.*, got TensorSpec\(name='input'",
    ),
    "an output outside a list": (
        Spec("test.op", [image()], TensorSpec("output")),
        r"outputs: expected at least one TensorSpec in a list \(.*, got TensorSpec\(name='output'",
    ),
    "one size as shape": (
        Spec("test.op", [TensorSpec("input", 3)]),
        r"input 'input': shape: expected a tuple of numbers and symbols .*, got 3",
    ),
    "text as shape": (Spec("test.op", [TensorSpec("input", "BN")]), "shape: expected a tuple .*, got 'BN'"),
    "another number of names than of sizes": (
        Spec(
            "test.op",
            [TensorSpec("like", ("OH", "OW"), "uint8", sizes=("a", "b", "c"))],
            symbols={"OH": (1, 9), "OW": (1, 9)},
        ),
        r"input 'like': sizes: expected .* or of one for each of the 2, got \('a', 'b', 'c'\)",
    ),
    "gradients of text": (
        Spec("test.op", [image()], gradients="input"),
        "gradients: expected None or a tuple of inputs' names .*, got 'input'",
    ),
    "dtypes of a number": (numbers(dtypes=5), "dtypes: expected a tuple of different dtypes .*, got 5"),
    "limits that are no dict": (numbers(symbols=7), "symbols: expected a dict, got int"),
    "tolerances that are no dict": (numbers(tolerances=[1]), "tolerances: expected a dict, got list"),
    "input that the function does not have": (
        Spec("test.op", [image("other")]),
        r"does not take the spec's inputs \['other'\]",
    ),
    "gradients": (Spec("test.op", [image()], gradients=("nope",)), "'nope' is not a floating input"),
    "tolerance": (
        Spec("test.op", [image()], tolerances={"float32": Tolerance(float("nan"), 0)}),
        "tolerances",
    ),
}


@pytest.mark.parametrize("name", SPECS)
def test_a_spec_that_says_what_cannot_be(name: str, tmp_path: Path) -> None:
    spec, message = SPECS[name]
    with pytest.raises(ExportError, match=message) as caught:
        export(plus, spec, tmp_path)
    assert "\n" not in str(caught.value).strip() and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"formats": "onnx"}, "formats: expected a sequence"),
        ({"formats": ()}, "formats"),
        ({"formats": ("tensorflow",)}, "formats"),
        ({"methods": ()}, "methods"),
        ({"methods": ("vjp",)}, "lacks 'forward'"),
        ({"methods": ("nope",)}, "methods"),
        ({"isas": ("i386",)}, "isas"),
    ],
)
def test_wrong_arguments(keywords: dict, message: str, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=message):
        export(plus, IMAGE, tmp_path, **keywords)
    with pytest.raises(ExportError, match="spec: expected a chiasm"):
        export(plus, "test.op", tmp_path)
    for path in (f"{tmp_path}/a\0b", 3, None, b"folder"):
        with pytest.raises(ExportError, match="path: expected the path of a folder"):
            export(plus, IMAGE, path)


def test_the_catalog_is_not_refused() -> None:
    for entry in catalog().values():
        check_call(entry.function(), entry.spec, ".", ("onnx",), ("x86-64-v3",), ("forward", "vjp"))


def test_samples_that_are_not_what_the_spec_says() -> None:
    def sample(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        return {"input": torch.rand(3, sizes["N"])}

    spec = numbers(make_inputs=sample)
    sizes = fit(spec, GOLDEN)
    with pytest.raises(
        ExportError, match=r"make_inputs: input 'input'.*expected float32 \(8,\), got torch.float32 \(3, 8\)"
    ):
        check_inputs(spec, make(spec, sizes, "float32"), sizes, "float32")


# --- results ------------------------------------------------------------------------------------------------


def a_dict(input: Tensor) -> Dict[str, Tensor]:
    return {"output": input + 1}


def nested(input: Tensor) -> Tuple[Tensor, List[Tensor]]:
    return input + 1, [input + 2]


def nothing(input: Tensor):
    input + 1


def text(input: Tensor) -> str:
    return "x"


def number(input: Tensor) -> float:
    return 1.0


def none_at_all(input: Tensor):
    return ()


def unsigned(input: Tensor) -> Tensor:
    return (input * 100).to(torch.uint32)


def spectrum(input: Tensor) -> Tensor:
    return torch.fft.fft(input)


def sparse(input: Tensor) -> Tensor:
    return input.to_sparse()


def deep(input: Tensor) -> Tensor:
    return input.reshape(input.shape + (1,) * 5)


def fails(input: Tensor) -> Tensor:
    raise ValueError("\x1b[31mthe op's own words\x1b[0m")


def branches(input: Tensor) -> Tensor:
    return torch.cond(input.sum() > 1, torch.neg, torch.abs, (input,))


def loops(input: Tensor) -> Tensor:
    def goes_on(k: Tensor, x: Tensor) -> Tensor:
        return k < x.sum()

    def step(k: Tensor, x: Tensor) -> Tuple[Tensor, Tensor]:
        return k + 1, x * 0.5

    return torch.while_loop(goes_on, step, (torch.zeros(()), input))[1]


def leaves(input: Tensor) -> Tensor:
    raise SystemExit(0)


@pytest.mark.parametrize(
    ("fn", "message"),
    [
        (a_dict, "returns a dict: return a tuple of its tensors"),
        (nested, "returns a list as result 1: return one flat tuple"),
        (nothing, "returns nothing"),
        (text, "returns a str"),
        (number, "returns a float: return a tensor"),
        (none_at_all, "names 1 outputs, the op returns 0"),
        (unsigned, "result 0: dtype 'uint32'"),
        (spectrum, "result 0: dtype 'complex64'"),
        (sparse, "dense"),
        (deep, "9 dimensions"),
        (fails, r"test_refusals.py:\d+: raise ValueError.*\n.*because: ValueError: the op's own words$"),
        (branches, r"cannot be exported\n.*torch.cond(.*\n)+.*instead: .*torch.where"),
        (loops, r"cannot be exported\n.*k < x.sum(.*\n)+.*instead: .*loops, repeated"),
        (leaves, r"at .*raise SystemExit\(0\)"),
    ],
)
def test_results_that_are_no_outputs(fn, message: str, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=message):
        export(fn, IMAGE, tmp_path)
    assert not list(tmp_path.iterdir())


class Pair(NamedTuple):
    a: Tensor
    b: Tensor


def named(input: Tensor) -> Pair:
    return Pair(input + 1, input)


def test_a_named_tuple_is_a_tuple(tmp_path: Path) -> None:
    bundle = export(
        named,
        Spec("test.named", [image()], [TensorSpec("a"), TensorSpec("b")]),
        tmp_path,
        formats=["onnx", "torchscript"],
        methods=["forward"],
    )
    x = np.random.default_rng(0).random((1, 2, 3, 4), np.float32)
    for backend in ("onnx", "torch"):
        a, b = chiasm.runtime.open(bundle).method("forward", backend=backend)(x)
        assert np.array_equal(a, x + 1) and np.array_equal(b, x)


# --- functions ----------------------------------------------------------------------------------------------


def percentile(input: Tensor) -> Tensor:
    return input - np.percentile(input, 5)


def through_numpy(input: Tensor) -> Tensor:
    return torch.from_numpy(np.clip(input.numpy(), 0, 1))


def branches(input: Tensor) -> Tensor:
    if input.mean() > 0.5:
        return input + 1
    return input


def prints(input: Tensor) -> Tensor:
    print("size", input.shape)
    return input + 1


def untyped(input, k=2):
    return input + k


def starred(*args):
    return args[0]


def keywords(**kwargs):
    return kwargs["input"]


def no_constant(input: Tensor, k=object()) -> Tensor:  # noqa: B008
    return input + 1


def lacks_one(input: Tensor, k: float) -> Tensor:
    return input + k


def by_position(input: Tensor, /) -> Tensor:
    return input + 1


def generates(input: Tensor):
    yield input


def letterbox(input: Tensor) -> Tensor:
    h, w = input.shape[2], input.shape[3]
    scale = min(640 / h, 640 / w)
    return F.interpolate(input, size=(round(h * scale), round(w * scale)))


def third(input: Tensor) -> Tensor:
    return input[:, :, : int(input.shape[2] * 0.3)]


def seven(input: Tensor) -> Tensor:
    return input + torch.ones(7, 1, 1, 1)


def only_seven(input: Tensor) -> Tensor:
    return input.reshape(7, -1)


def _of_a_session() -> object:
    namespace = {"Tensor": Tensor}
    exec("def typed_in(input: Tensor) -> Tensor:\n    return input + 1", namespace)
    return namespace["typed_in"]


class Doubled(torch.autograd.Function):
    @staticmethod
    def forward(ctx, x):
        return x * 2

    @staticmethod
    def backward(ctx, gradient):
        return gradient * 2


def by_python(input: Tensor) -> Tensor:
    return Doubled.apply(input)


def of_another_library(input: Tensor) -> Tensor:
    boxes = input.new_zeros(1, 5)
    return torchvision.ops.roi_align(input, boxes, (2, 2))


class NeverEvaluates(nn.Module):
    def forward(self, input: Tensor) -> Tensor:
        return input + 1

    def train(self, mode: bool = True) -> nn.Module:
        raise RuntimeError("no train")


class Unreadable(nn.Module):
    def forward(self, input: Tensor) -> Tensor:
        return input + 1

    def __getattr__(self, name: str) -> Tensor:
        raise RuntimeError(f"no {name}")


class Holds(nn.Module):
    """A module with a buffer that is no plain tensor."""

    def __init__(self, buffer: Tensor) -> None:
        super().__init__()
        self.register_buffer("table", buffer)

    def forward(self, input: Tensor) -> Tensor:
        return input + 1


class Labelled(Tensor):
    """A tensor that torch cannot copy."""


@pytest.mark.parametrize(
    ("fn", "message"),
    [
        (Holds(torch.eye(3).to_sparse()), "its 'table' is sparse, expected a dense tensor: convert it"),
        (Holds(torch.quantize_per_tensor(torch.ones(3), 0.1, 0, torch.quint8)), "'table' is quantized"),
        (Holds(torch.nested.as_nested_tensor([torch.ones(2), torch.ones(3)])), "'table' is nested"),
        (Holds(torch.ones(3).as_subclass(Labelled)), "'table' is a Labelled.*as_subclass"),
        (
            of_another_library,
            r"to TorchScript: it calls an operator of torchvision.*\n"
            r".*test_refusals.py:\d+: .*roi_align.*\n.*torchvision.roi_align.default\n.*formats=\['onnx'\]",
        ),
        (by_python, r"return Doubled.apply\(input\)\n.*\n.*cannot hold an autograd.Function"),
        pytest.param(
            Unreadable(),
            r"fn: reading the attributes of Unreadable raises RuntimeError: no \w+: its __getattr__ should",
            id="Unreadable",  # pytest would read its name
        ),
        (NeverEvaluates(), r"NeverEvaluates.eval\(\) raises RuntimeError: no train: make it work"),
        (nn.Conv2d(3, 2, 1, device="meta"), "'weight' is on the device meta, expected cpu: give it values"),
        (nn.LazyConv2d(2, 1), "'weight' has no shape yet: call it once with an example"),
        (nn.DataParallel(nn.ReLU()), r"DataParallel\) has the module inside it: export fn.module"),
        (torch.compile(nn.ReLU()), "torch.compile made of a module: export fn._orig_mod"),
        (torch.jit.script(nn.ReLU()), "torch.jit.script made of a module: export that module"),
        (
            nn.utils.parametrizations.weight_norm(nn.Conv2d(3, 2, 1)),
            r"parametrized weights\n.*remove_parametrizations",
        ),
        (percentile, r"input - np.percentile\(input, 5\)\n.*\n.*torch.quantile"),
        (through_numpy, r"input.numpy\(\), 0, 1.*\n.*\n.*NumPy cannot be exported"),
        (branches, r"if input.mean\(\) > 0.5:\n.*\n.*torch.where"),
        (prints, r"it prints.*\n.*print\(\"size\".*\n.*remove the print"),
        (untyped, r"def untyped.*\n.*\n.*give the argument its type"),
        (lambda input: input + 1, "write a function with def"),
        (starred, r"\*args: name every argument"),
        (keywords, r"\*\*kwargs: name every argument"),
        (no_constant, "def no_constant"),
        (lacks_one, "missing.*'k'"),
        (by_position, "by position only"),
        (generates, "generator"),
        (nn.ReLU, r"give an instance, ReLU\(...\)"),
        (None, "expected a function"),
        (_of_a_session(), "put the function into a file"),
        (letterbox, r"F.interpolate\(input, size=\(round.*\n.*\n.*\+ - \* // only"),
        (third, r"int\(input.shape\[2\] \* 0.3\).*\n.*\n.*another input"),
        (seven, r"torch.ones\(7, 1, 1, 1\)\n.*B.*constant \(7\)"),
        (only_seven, r"fails when it is called, with input \(1, 3, 17, 22\)\n.*input.reshape\(7, -1\)"),
    ],
)
def test_functions_that_cannot_be_exported(
    fn, message: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    spec = Spec("test.op", [image(channels=3)]) if isinstance(fn, nn.Conv2d) else IMAGE
    with pytest.raises(ExportError, match=message) as caught:
        export(fn, spec, tmp_path, formats=["torchscript", "onnx"], methods=["forward"])
    assert (
        "\x1b" not in str(caught.value)
        and "site-packages" not in str(caught.value)
        and not list(tmp_path.iterdir())
    )
    printed = capfd.readouterr()
    assert not printed.err and (fn is prints or not printed.out), "nor does torch say it in its own words"


def peak(input: Tensor) -> Tensor:
    return input / input.max().item()


class Plus:
    def __call__(self, input: Tensor) -> Tensor:
        return input + 2


@pytest.mark.parametrize(
    ("fn", "same"),
    [
        (peak, peak),
        (Plus(), Plus()),
        (functools.partial(untyped, k=3), lambda x: x + 3),
        (torch.sigmoid, torch.sigmoid),
    ],
)
def test_functions_that_look_odd_and_can_be(fn, same, tmp_path: Path) -> None:
    bundle = export(fn, IMAGE, tmp_path, formats=["onnx"], methods=["forward"])
    x = torch.rand(2, 3, 4, 5, generator=torch.Generator().manual_seed(1)) * 7
    result = chiasm.runtime.open(bundle).method("forward", backend="onnx")(x.numpy())
    torch.testing.assert_close(torch.from_numpy(result), same(x))


def test_engines_colours_are_cut() -> None:
    assert plain("\x1b[96mstep\x1b[0m 2/3 \x1b]0;title\x07\x1bcend\r\x08") == "step 2/3 end"
    with pytest.raises(ExportError) as caught:
        export(
            torch.linalg.matrix_exp,
            Spec("test.op", [TensorSpec("A", ("B", 5, 5))]),
            Path("unused"),
            formats=["onnx"],
            methods=["forward"],
        )
    assert "linalg_matrix_exp" in str(caught.value) and "\x1b" not in str(caught.value)


def test_native_code_without_a_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(ExportError, match=r"^no-such-compiler cannot be run: No such file.*needs g\+\+"):
        export(plus, numbers(gradients=()), tmp_path, formats=("native",))
    for compiler, message in (
        ("true", "true did not write signature.o"),
        ("false", "exit status 1, without"),
    ):
        monkeypatch.setenv("CXX", compiler)
        with pytest.raises(ExportError, match=message):
            export(plus, numbers(gradients=()), tmp_path, formats=("native",))


def test_a_cache_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    for cache in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/nope")):
        monkeypatch.setenv("CHIASM_CACHE", str(cache))
        with pytest.raises(ExportError, match=f"cannot be kept in {cache}: .*: set CHIASM_CACHE to"):
            export(plus, numbers(gradients=()), tmp_path, formats=("native",))
    monkeypatch.delenv("CHIASM_CACHE")
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    with pytest.raises(ExportError, match=r"cannot be kept in .*\.cache/chiasm: Not a directory"):
        export(plus, numbers(gradients=()), tmp_path, formats=("native",))


def test_what_is_damaged_in_the_cache_is_compiled_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CHIASM_CACHE", str(tmp_path / "cache"))

    def code() -> bytes:
        bundle = export(plus, numbers(gradients=()), tmp_path, formats=("native",), methods=("forward",))
        return (bundle / "forward.float32.x86-64-v3.pt2").read_bytes()

    good = code()
    [entry] = (tmp_path / "cache" / "native").iterdir()
    for damage in ("flipped", "cut", "folder", "pipe"):
        entry.unlink()
        if damage == "flipped":
            entry.write_bytes(good[:1000] + bytes([good[1000] ^ 1]) + good[1001:])
        elif damage == "cut":
            entry.write_bytes(good[:1000])
        elif damage == "folder":
            (entry / "below").mkdir(parents=True)
        else:
            os.mkfifo(entry)
        assert code() == good == entry.read_bytes(), damage
    assert list(entry.parent.iterdir()) == [entry]


def test_a_full_disk_while_native_code_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CHIASM_CACHE", str(tmp_path / "cache"))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))  # no file can be larger
    try:
        with pytest.raises(ExportError, match=r"File too large\n  instead: make room on the disk"):
            export(plus, numbers(gradients=()), tmp_path, formats=("native",), methods=("forward",))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("seconds", ["99999999999999999999", "9999999999999", "253402300800", "-1", "soon"])
def test_a_time_that_is_none(seconds: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", seconds)
    begun: list[str] = []
    with pytest.raises(ExportError, match=f"SOURCE_DATE_EPOCH: expected seconds since 1970.*got '{seconds}'"):
        export(plus, IMAGE, tmp_path, formats=("onnx",), progress=begun.append)
    assert not begun


def test_native_code_without_the_libraries_that_it_is_linked_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isas, "LIBRARIES", tmp_path)
    native_cache._libraries_hash.cache_clear()
    try:
        with pytest.raises(
            ExportError,
            match=r"needs .*libchiasm_aoti\.a, which is not there: pip install chiasm-export.*make build",
        ):
            export(plus, numbers(gradients=()), tmp_path, formats=("native",))
    finally:
        native_cache._libraries_hash.cache_clear()


class Wordless(Exception):
    def __str__(self) -> str:
        raise RuntimeError("no words")


def wordless(input: Tensor) -> Tensor:
    raise Wordless


def test_an_exception_without_words_is_named(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="Wordless"):
        export(wordless, IMAGE, tmp_path)
