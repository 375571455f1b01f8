"""Values with which native code would leave its memory are errors of the run, and proved indices cost
nothing."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Tuple

import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import ExportError, Spec, TensorSpec, example_inputs, export
from chiasm.export.tracing.graph import trace
from chiasm.export.tracing.module import bind_spec
from chiasm.primitives.resampling.taps import bilinear_taps
from tests.export.native_source import written

SIZE = 16


def lookups(
    table: Tensor, picked: Tensor, added: Tensor, put: Tensor, gathered: Tensor, divisor: Tensor
) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
    """Every use of an index, each with its own index; and the divisions of integers."""
    ones = torch.ones_like(added, dtype=table.dtype)
    sums = torch.zeros(SIZE, dtype=table.dtype).scatter_add(0, added, ones)
    marked = torch.zeros(SIZE, dtype=table.dtype)
    marked[put] = 2.0
    rows = torch.gather(table.reshape(4, -1), 1, gathered.reshape(1, -1))
    whole = torch.div(1000, divisor, rounding_mode="floor")
    return table[picked], sums, marked, rows, whole, 1000 % divisor


def integers(name: str, symbol: str, dtype: str = "int64") -> TensorSpec:
    return TensorSpec(name, (symbol,), dtype)


NAMES = ("table", "picked", "added", "put", "gathered", "divisor")


def sample_lookups_of(*names: str) -> Callable:
    """Makes example inputs with valid indices and divisors."""

    def sample(g: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        s = dict.fromkeys("PAQGD", 1) | sizes
        made = {
            "table": torch.rand(SIZE, generator=g, dtype=dtype),
            "picked": torch.randint(-SIZE, SIZE, (s["P"],), generator=g),
            "added": torch.randint(0, SIZE, (s["A"],), generator=g),
            "put": torch.randint(-SIZE, SIZE, (s["Q"],), generator=g),
            "gathered": torch.randint(0, SIZE // 4, (s["G"],), generator=g),
            "divisor": (
                torch.randint(1, 9, (s["D"],), generator=g)
                * (2 * torch.randint(0, 2, (s["D"],), generator=g) - 1)
            ),
        }
        return {name: made[name] for name in names}

    return sample


LOOKUPS = Spec(
    "test.lookups",
    [
        TensorSpec("table", (SIZE,)),
        integers("picked", "P"),
        integers("added", "A"),
        integers("put", "Q"),
        integers("gathered", "G"),
        integers("divisor", "D"),
    ],
    [TensorSpec(n) for n in ("values", "sums", "marked", "rows", "quotients", "remainders")],
    symbols=dict.fromkeys("PAQGD", (1, 1 << 16)),
    gradients=(),
    make_inputs=sample_lookups_of(*NAMES),
)


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export(lookups, LOOKUPS, tmp_path_factory.mktemp("lookups"), formats=("native",))


def made(**changed: Tensor) -> dict[str, Tensor]:
    sizes = dict(zip("PAQGD", (1001, 37, 7, 333, 61), strict=True))
    return example_inputs.make(LOOKUPS, sizes, "float32") | changed


@pytest.mark.parametrize("count", [1, 7, 8, 60001])
def test_allowed_values_give_what_eager_gives(bundle: Path, count: int) -> None:
    inputs = made(picked=torch.randint(-SIZE, SIZE, (count,)))
    method = runtime.open(bundle).method("forward", backend="native")
    for mine, eager in zip(method(*inputs.values()), lookups(*inputs.values()), strict=True):
        torch.testing.assert_close(torch.as_tensor(mine), eager)


FAR = [20000, 1 << 31, (1 << 62), -(1 << 63)]
WRONG = (
    [(n, i) for n in ("picked", "put") for i in (SIZE, -SIZE - 1, *FAR)]
    + [("added", i) for i in (SIZE, -1, -5, *FAR)]
    + [("gathered", i) for i in (4, -1, *FAR)]
)


@pytest.mark.parametrize(("name", "wrong"), WRONG)
@pytest.mark.parametrize("place", [0, 13, 60000])
def test_a_wrong_index_is_an_error_that_names_it_and_the_limit(
    bundle: Path, name: str, wrong: int, place: int
) -> None:
    index = torch.zeros(place + 5, dtype=torch.int64)
    index[place] = wrong
    limit = 4 if name == "gathered" else SIZE
    with pytest.raises((IndexError, RuntimeError)):
        lookups(*made(**{name: index}).values())
    method = runtime.open(bundle).method("forward", backend="native")
    with pytest.raises(
        runtime.ChiasmError, match=rf"index {wrong} is out of range for an axis of size {limit} \(aten\.\w+\)"
    ):
        method(*made(**{name: index}).values())
    right = made()  # the next run is right
    for mine, eager in zip(method(*right.values()), lookups(*right.values()), strict=True):
        torch.testing.assert_close(torch.as_tensor(mine), eager)


def by_magnitude(table: Tensor, index: Tensor) -> Tensor:
    """The absolute value of the smallest integer is that integer itself."""
    return table[index.abs().clamp(max=SIZE - 1)]


def test_a_magnitude_may_be_negative(tmp_path: Path) -> None:
    spec = Spec(
        "test.by_magnitude",
        [TensorSpec("table", (SIZE,)), integers("index", "P")],
        [TensorSpec("value")],
        symbols={"P": (1, 64)},
        gradients=(),
        make_inputs=lambda g, sizes, dtype: {
            "table": torch.rand(SIZE, generator=g, dtype=dtype),
            "index": torch.arange(sizes["P"]),
        },
    )
    method = runtime.open(export(by_magnitude, spec, tmp_path, formats=("native",))).method(
        "forward", backend="native"
    )
    table, index = torch.rand(SIZE), torch.arange(33) - 16
    torch.testing.assert_close(torch.as_tensor(method(table, index)), by_magnitude(table, index))
    index[5] = -(1 << 63)
    with pytest.raises(IndexError):
        by_magnitude(table, index)
    with pytest.raises(
        runtime.ChiasmError, match="index -9223372036854775808 is out of range for an axis of size 16"
    ):
        method(table, index)


def doubled(table: Tensor, index: Tensor) -> Tensor:
    """A sum that wraps around. A compiler that assumes no overflow would treat it as never negative."""
    positive = index.clamp(min=0)
    return table[(positive + positive).clamp(max=SIZE - 1)]


def test_a_sum_that_wraps_around_is_still_checked(tmp_path: Path) -> None:
    spec = Spec(
        "test.doubled",
        [TensorSpec("table", (SIZE,)), integers("index", "P")],
        [TensorSpec("value")],
        symbols={"P": (1, 64)},
        gradients=(),
        make_inputs=lambda g, sizes, dtype: {
            "table": torch.rand(SIZE, generator=g, dtype=dtype),
            "index": torch.arange(sizes["P"]) - 8,
        },
    )
    method = runtime.open(export(doubled, spec, tmp_path, formats=("native",))).method(
        "forward", backend="native"
    )
    table = torch.rand(SIZE)
    for place in (0, 32):
        index = torch.arange(33) % 8
        index[place] = (1 << 62) + 5
        with pytest.raises(IndexError):
            doubled(table, index)
        with pytest.raises(
            runtime.ChiasmError, match="index -9223372036854775798 is out of range for an axis of size 16"
        ):
            method(table, index)


def chosen(table: Tensor, index: Tensor) -> Tuple[Tensor, Tensor]:
    """A row chosen by a number from data, and a row chosen by an index without dimensions."""
    return table[index[0].item()] * 2.0, table.t()[:, index[index.argmax()]]


def looked_up_by(fn: Callable, name: str, folder: Path, formats: tuple[str, ...] = ("native",)) -> Path:
    """A bundle of a function of a table and an index."""
    spec = Spec(
        f"test.{name}",
        [TensorSpec("table", (SIZE, 4)), integers("index", "P")],
        [TensorSpec("first"), TensorSpec("second")],
        symbols={"P": (1, 64)},
        gradients=(),
        make_inputs=lambda g, sizes, dtype: {
            "table": torch.rand(SIZE, 4, generator=g, dtype=dtype),
            "index": torch.arange(sizes["P"]) % 8,
        },
    )
    return export(fn, spec, folder, formats=formats)


@pytest.mark.parametrize("wrong", [SIZE, 1 << 62, -SIZE - 1])
def test_a_number_from_data_is_a_checked_index(tmp_path: Path, wrong: int) -> None:
    bundle = looked_up_by(chosen, "chosen", tmp_path)
    method = runtime.open(bundle).method("forward", backend="native")
    table = torch.rand(SIZE, 4)
    for first in (3, -2):
        index = torch.tensor([first, 1, 5, 2])
        for mine, eager in zip(method(table, index), chosen(table, index), strict=True):
            torch.testing.assert_close(torch.as_tensor(mine), eager)
    index[0] = wrong
    with pytest.raises(IndexError):
        chosen(table, index)
    with pytest.raises(runtime.ChiasmError, match=f"index {wrong} is out of range for an axis of size 16"):
        method(table, index)


def computed(table: Tensor, index: Tensor) -> Tuple[Tensor, Tensor]:
    """Reads and writes by indices that are computed from data."""
    i = index[0].item()
    written = table.clone()
    written[i] = 7.0
    return table[i + 1] * 2.0 + table.select(0, i * 2), written


@pytest.mark.parametrize("wrong", [SIZE - 1, 100_000, 2**63 - 1, 1 << 62, -SIZE - 1])
def test_a_number_computed_from_data_is_a_checked_index(tmp_path: Path, wrong: int) -> None:
    bundle = looked_up_by(computed, "computed", tmp_path)
    method = runtime.open(bundle).method("forward", backend="native")
    table = torch.rand(SIZE, 4)
    for first in (0, 7, -2, -8):
        for mine, eager in zip(
            method(table, torch.tensor([first])), computed(table, torch.tensor([first])), strict=True
        ):
            torch.testing.assert_close(torch.as_tensor(mine), eager)
    with pytest.raises((IndexError, RuntimeError)):
        computed(table, torch.tensor([wrong]))
    said = r"index -?\d+ is out of range for an axis of size 16|Expected u0 [<>]= -?\d+ but received -?\d+"
    with pytest.raises(runtime.ChiasmError, match=said):
        method(table, torch.tensor([wrong]))


def laid_out(table: Tensor, index: Tensor) -> Tuple[Tensor, Tensor]:
    return torch.as_strided(table, [3], [1], index[0].item()) * 2.0, table * 2.0


def test_strides_from_data_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"aten.as_strided\n.*data decide where it reads"):
        looked_up_by(laid_out, "laid_out", tmp_path)


def beside_libtorch(table: Tensor, index: Tensor) -> Tuple[Tensor, Tensor]:
    """A lookup and a write, in code that calls libtorch for `bucketize`."""
    bucket = torch.bucketize(table[0, 0], table[:, 2].contiguous())
    return table[index] * 2.0 + bucket, table.index_put([index], torch.full([1], 5.0)) + bucket


def test_code_that_needs_libtorch_checks_too(tmp_path: Path) -> None:
    bundle = looked_up_by(beside_libtorch, "beside_libtorch", tmp_path)
    method = runtime.open(bundle).method("forward", backend="torch")
    assert method.artifact.endswith(".pt2")
    table = torch.rand(SIZE, 4)
    index = torch.tensor([3, 15, 0, -16, -1])
    for mine, eager in zip(method(table, index), beside_libtorch(table, index), strict=True):
        torch.testing.assert_close(mine, eager)
    for wrong in (SIZE, 1 << 40, -SIZE - 1):
        with pytest.raises(
            runtime.ChiasmError, match=f"index {wrong} is out of range for an axis of size 16"
        ):
            method(table, torch.tensor([0, wrong]))


def by_libtorch(table: Tensor, index: Tensor) -> Tuple[Tensor, Tensor]:
    """A write that libtorch makes."""
    rows = index[:, None].expand(index.shape[0], 4)
    greatest = table.scatter_reduce(0, rows, torch.ones_like(rows, dtype=table.dtype), "amax")
    return greatest, greatest + 1.0


def test_what_libtorch_refuses_is_an_error(tmp_path: Path) -> None:
    bundle = looked_up_by(by_libtorch, "by_libtorch", tmp_path)
    method = runtime.open(bundle).method("forward", backend="torch")
    assert method.artifact.endswith(".pt2")
    table = torch.rand(SIZE, 4)
    index = torch.tensor([3, 15, 0])
    for mine, eager in zip(method(table, index), by_libtorch(table, index), strict=True):
        torch.testing.assert_close(mine, eager)
    for wrong in (SIZE, 1 << 40, -1):
        with pytest.raises(RuntimeError, match="out of bounds"):
            by_libtorch(table, torch.tensor([0, wrong]))
        with pytest.raises(runtime.ChiasmError, match=r"index -?\d+ is out of bounds"):
            method(table, torch.tensor([0, wrong]))


def rounded_up(table: Tensor, place: Tensor) -> Tensor:
    """float32 cannot represent the limit of the clamp, and the nearest number is too large by one."""
    return table[place.clamp(0, 2**24 + 3).to(torch.int64)]


def test_a_limit_that_float32_rounds_proves_nothing(tmp_path: Path) -> None:
    spec = Spec(
        "test.rounded_up",
        [TensorSpec("table", (2**24 + 4,), "uint8", range=(0, 255)), TensorSpec("place", ("P",))],
        symbols={"P": (1, 64)},
        gradients=(),
    )
    method = runtime.open(export(rounded_up, spec, tmp_path, formats=("native",))).method("forward")
    table = torch.zeros(2**24 + 4, dtype=torch.uint8)
    assert method(table, torch.rand(9)).tolist() == [0] * 9
    with pytest.raises(
        runtime.ChiasmError, match="index 16777220 is out of range for an axis of size 16777220"
    ):
        method(table, torch.full((9,), 1e9))


def from_the_beginning(table: Tensor, index: Tensor) -> Tuple[Tensor, Tensor]:
    """Operators that do not count negative indices from the end."""
    return table.index_select(0, index), torch.zeros(SIZE).index_add(
        0, index, torch.ones_like(index, dtype=torch.float32)
    )


@pytest.mark.parametrize("place", [0, 32])
def test_an_operator_that_takes_no_negative_index_refuses_it(tmp_path: Path, place: int) -> None:
    spec = Spec(
        "test.from_the_beginning",
        [TensorSpec("table", (SIZE,)), integers("index", "P")],
        [TensorSpec("picked"), TensorSpec("added")],
        symbols={"P": (1, 64)},
        gradients=(),
        make_inputs=lambda g, sizes, dtype: {
            "table": torch.rand(SIZE, generator=g, dtype=dtype),
            "index": torch.arange(sizes["P"]) % SIZE,
        },
    )
    method = runtime.open(export(from_the_beginning, spec, tmp_path, formats=("native",))).method(
        "forward", backend="native"
    )
    table, index = torch.rand(SIZE), torch.arange(33) % SIZE
    for mine, eager in zip(method(table, index), from_the_beginning(table, index), strict=True):
        torch.testing.assert_close(torch.as_tensor(mine), eager)
    index[place] = -1
    with pytest.raises((IndexError, RuntimeError)):
        from_the_beginning(table, index)
    with pytest.raises(
        runtime.ChiasmError, match=r"index -1 is out of range for an axis of size 16 \(aten.(gather|scatter)"
    ):
        method(table, index)


def before_the_last(table: Tensor, index: Tensor) -> Tensor:
    """An index that is proved for sizes from 2 on, which PyTorch assumes, but is -1 for a size of 1."""
    return table[index.clamp(0, table.size(0) - 2)]


def test_a_size_of_one_is_no_size_of_two(tmp_path: Path) -> None:
    spec = Spec(
        "test.before_the_last",
        [TensorSpec("table", ("N",)), integers("index", "P")],
        [TensorSpec("value")],
        symbols={"N": (1, 64), "P": (1, 64)},
        gradients=(),
        make_inputs=lambda g, sizes, dtype: {
            "table": torch.rand(sizes["N"], generator=g, dtype=dtype),
            "index": torch.arange(sizes["P"]),
        },
    )
    method = runtime.open(export(before_the_last, spec, tmp_path, formats=("native",))).method(
        "forward", backend="native"
    )
    for size in (1, 2, 9):
        backing = torch.arange(size + 8.0)
        table, index = backing[8:], torch.arange(33) - 5
        torch.testing.assert_close(torch.as_tensor(method(table, index)), before_the_last(table, index))


@pytest.mark.parametrize("place", [0, 13, 60000])
def test_a_division_by_zero_is_an_error(bundle: Path, place: int) -> None:
    divisor = torch.ones(place + 5, dtype=torch.int64)
    divisor[place] = 0
    with pytest.raises(RuntimeError):
        lookups(*made(divisor=divisor).values())
    with pytest.raises(runtime.ChiasmError, match="an integer was divided by zero"):
        runtime.open(bundle).method("forward", backend="native")(*made(divisor=divisor).values())


def cut_off(a: Tensor, b: Tensor) -> Tensor:
    # a loaded divisor is 1 in the unused lanes
    return torch.div(a, b, rounding_mode="trunc") + torch.fmod(a, b) + a % b + a % (b - 1)


@pytest.mark.parametrize("dtype", [torch.int8, torch.uint8, torch.int32])
def test_no_lane_beyond_a_row_is_a_divisor(tmp_path: Path, dtype: torch.dtype) -> None:
    name = str(dtype).removeprefix("torch.")

    def sample(generator: torch.Generator, sizes: dict[str, int], _: torch.dtype) -> dict[str, Tensor]:
        return {x: torch.randint(2, 100, (sizes["N"],), generator=generator).to(dtype) for x in ("a", "b")}

    tensors = [TensorSpec(x, ("N",), name) for x in ("a", "b")]
    spec = Spec("test.cut_off", tensors, symbols={"N": (1, 99)}, gradients=(), make_inputs=sample)
    method = runtime.open(export(cut_off, spec, tmp_path, formats=["native"])).method(backend="native")
    for n in range(1, 70):
        given = list(sample(torch.Generator().manual_seed(n), {"N": n}, dtype).values())
        assert torch.equal(torch.as_tensor(method(*given)), cut_off(*given)), n
    with pytest.raises(runtime.ChiasmError, match="an integer was divided by zero"):
        method(given[0], torch.zeros(69, dtype=dtype))


def pick(table: Tensor, picked: Tensor) -> Tensor:
    return table[picked]


def test_every_backend_refuses_in_one_bundle(tmp_path: Path) -> None:
    """Every backend refuses, including the node that runs native code inside ONNX Runtime."""
    spec = replace(
        LOOKUPS,
        name="test.pick",
        inputs=LOOKUPS.inputs[:2],
        outputs=(TensorSpec("values"),),
        make_inputs=sample_lookups_of("table", "picked"),
    )
    opened = runtime.open(export(pick, spec, tmp_path))
    for options in (
        {"backend": "native"},
        {"backend": "onnx"},
        {"backend": "onnx", "fused": False},
        {"backend": "torch"},
    ):
        method = opened.method("forward", **options)
        table = torch.rand(SIZE)
        torch.testing.assert_close(torch.as_tensor(method(table, torch.tensor([-1, 3]))), table[[-1, 3]])
        with pytest.raises(runtime.ChiasmError, match="99"):
            method(table, torch.tensor([0, 99]))


@pytest.mark.parametrize(
    "edit",
    [
        lambda m: m["symbols"]["P"].update(max=1 << 20),
        lambda m: m["methods"]["forward"]["inputs"][0]["shape"].__setitem__(0, SIZE + 1),
        lambda m: m["methods"]["forward"]["inputs"][0]["shape"].append(1),
        lambda m: m["methods"]["forward"]["inputs"][1].update(dtype="int32"),
        lambda m: m["methods"]["forward"]["inputs"][1].update(name="other"),
        lambda m: m["methods"]["forward"]["inputs"].reverse(),
        lambda m: m["methods"]["forward"]["inputs"].append(
            {**m["methods"]["forward"]["inputs"][0], "name": "more"}
        ),
        lambda m: m["methods"]["forward"]["outputs"].pop(),
        lambda m: m["methods"]["forward"]["outputs"][0]["shape"].__setitem__(0, "P + 1"),
        lambda m: m["methods"]["forward"]["outputs"][1].update(dtype="float64"),
    ],
)
def test_a_manifest_that_disagrees_with_the_code_is_refused(
    bundle: Path, tmp_path: Path, edit: Callable[[dict], object]
) -> None:
    changed = tmp_path / bundle.name
    changed.mkdir()
    for file in bundle.iterdir():
        (changed / file.name).write_bytes(file.read_bytes())
    manifest = json.loads((changed / "manifest.json").read_text())
    edit(manifest)
    (changed / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(runtime.ChiasmError, match="the native code was compiled for"):
        runtime.open(changed).method("forward", backend="native")


# --- what is proved costs nothing ---------------------------------------------------------------------------


def loops_of(fn: Callable, spec: Spec, monkeypatch: pytest.MonkeyPatch) -> str:
    """The C++ that AOTInductor writes for an op."""
    example = example_inputs.make(spec, example_inputs.fit(spec, example_inputs.EXAMPLE), spec.variants()[0])
    program = trace(bind_spec(fn, spec), spec, list(spec.inputs), example, "native")
    return written(program, spec, monkeypatch)


def flipped(image: Tensor, index: Tensor) -> Tensor:
    return image[torch.arange(image.shape[0] - 1, -1, -1)]


def clamped(image: Tensor, index: Tensor) -> Tensor:
    height, width = image.shape[0], image.shape[1]
    return image.reshape(height * width)[index.clamp(0, height - 1) * width + index.clamp(0, width - 1)]


def rounded(image: Tensor, index: Tensor) -> Tensor:
    number = torch.where(image == image, image, 0.0)  # NaN is not a valid index
    return image[:, 0][number.clamp(0, image.shape[0] - 1).to(torch.int64)]


def rounded_nan(image: Tensor, index: Tensor) -> Tensor:
    return image[:, 0][image.clamp(0, image.shape[0] - 1).to(torch.int64)]


def clamped_too_far(image: Tensor, index: Tensor) -> Tensor:
    return image[index.clamp(0, image.shape[0])]


def sampled(image: Tensor, index: Tensor) -> Tensor:
    height, width = image.shape[0], image.shape[1]
    taps, weights = bilinear_taps(image * width, image * height, height, width)
    return image.reshape(height * width)[taps[3]] * weights[3]


@pytest.mark.parametrize(
    ("fn", "checks"),
    [
        (flipped, False),
        (clamped, False),
        (rounded, False),
        (sampled, False),
        (rounded_nan, True),
        (clamped_too_far, True),
    ],
)
def test_only_what_is_not_proved_is_checked(
    fn: Callable, checks: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = Spec(
        "test.loops",
        [TensorSpec("image", ("H", "W")), TensorSpec("index", ("N",), "int64")],
        symbols={"H": (1, 8192), "W": (1, 8192)},
    )
    assert bool(re.search(r"chiasm::checked_index<", loops_of(fn, spec, monkeypatch))) == checks
