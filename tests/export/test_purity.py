"""An op is a function of its inputs: code that writes into them, keeps state or draws random numbers is
rejected, with its name and line."""

import copy
import random
import re
import time
from pathlib import Path
from typing import List, Tuple

import numpy as np
import pytest
import torch
from torch import Tensor, nn
from torch.nn import functional as F

import chiasm.runtime
from chiasm.export import ExportError, Spec, TensorSpec, export, frame, image
from chiasm.export.checks.script_purity import check_script

ANY = ("torchscript", "onnx")
COUNT = [0]
KEPT = torch.zeros(1)
NORM = nn.BatchNorm2d(3)


def by_slice(frame: Tensor) -> Tensor:
    frame[:, :, 0] = 0
    return frame + 1


def in_place(input: Tensor) -> Tensor:
    return input.mul_(2)


def operator(input: Tensor) -> Tensor:
    input += 1
    return input


def out_form(input: Tensor) -> Tensor:
    return torch.add(input, 1, out=input)


def by_view(input: Tensor) -> Tensor:
    part = input.reshape(-1)[1:]
    part.zero_()
    return input + 1


def same_dtype(input: Tensor) -> Tensor:
    copied = input.to(torch.float32).contiguous()
    copied.mul_(2)
    return copied


def data(input: Tensor) -> Tensor:
    input.data.mul_(2)
    return input + 1


def resized(input: Tensor) -> Tensor:
    input.resize_(3)
    return input + 1


def swallowed(input: Tensor) -> Tensor:
    try:
        input.mul_(2)
    except Exception:
        return input
    return input + 1


def several(input: Tensor) -> Tensor:
    torch._foreach_add_([input], 1.0)
    return input + 1


def by_numpy(input: Tensor) -> Tensor:
    input.numpy()[:] = 0
    return input + 1


def in_a_loop(input: Tensor) -> Tensor:
    def body(k: Tensor, x: Tensor) -> Tuple[Tensor, Tensor]:
        x[0] = 1
        return k + 1, x.clone()

    return torch.while_loop(lambda k, x: k < 3, body, (torch.zeros((), dtype=torch.int64), input))[1]


def scripted_branch(input: Tensor) -> Tensor:
    if torch.jit.is_scripting():
        input.mul_(2)
    return input + 1


def scripted_list(input: Tensor) -> Tensor:
    if torch.jit.is_scripting():
        for part in [input + 1, input]:
            part.mul_(2)
    return input + 1


def exported_branch(input: Tensor) -> Tensor:
    if torch.compiler.is_exporting():
        input.mul_(2)
    return input + 1


WRITES = [
    (by_slice, ANY, "frame[:, :, 0] = 0"),
    (in_place, ANY, "input.mul_(2)"),
    (operator, ANY, "input += 1"),
    (out_form, ANY, "out=input"),
    (by_view, ANY, "part.zero_()"),
    (same_dtype, ANY, "copied.mul_(2)"),
    (data, ANY, "input.data.mul_(2)"),
    (resized, ANY, "resize_"),
    (swallowed, ("onnx",), "input.mul_(2)"),
    (several, ("onnx",), "_foreach_add_"),
    (by_numpy, ("onnx",), ""),
    (in_a_loop, ("onnx",), ""),
    (scripted_branch, ANY, "input.mul_(2)"),
    (scripted_list, ANY, "part.mul_(2)"),
    (exported_branch, ("onnx",), ""),
]


@pytest.mark.parametrize(("fn", "formats", "line"), WRITES, ids=[w[0].__name__ for w in WRITES])
def test_writing_into_an_input(fn, formats, line: str, tmp_path: Path) -> None:
    tensor = frame() if fn is by_slice else image()
    for some in {formats, formats[:1]}:
        with pytest.raises(ExportError) as caught:
            export(fn, Spec("test.op", [tensor]), tmp_path, formats=some)
        message = str(caught.value)
        assert (
            message.startswith(f"test.op: it changes its input {tensor.name!r}")
            and f"{tensor.name} = {tensor.name}.clone()" in message
        )
        assert not line or re.search(rf"at {re.escape(__file__)}:\d+: .*{re.escape(line)}", message), message
    assert not list(tmp_path.iterdir())


def draws(input: Tensor) -> Tensor:
    return input + torch.rand_like(input)


def permutes(input: Tensor) -> Tensor:
    return input[:, :, torch.randperm(input.shape[2])]


def tosses(input: Tensor) -> Tensor:
    return torch.bernoulli(input)


def drops(input: Tensor) -> Tensor:
    return F.dropout(input)


def seeded(input: Tensor) -> Tensor:
    return input + torch.rand(1, generator=torch.Generator().manual_seed(0))


def draws_in_script(input: Tensor) -> Tensor:
    if torch.jit.is_scripting():
        return input + torch.rand_like(input)
    return input + 1


def draws_in_graph(input: Tensor) -> Tensor:
    return input + torch.rand_like(input) if torch.compiler.is_exporting() else input + 1


@pytest.mark.parametrize(
    ("fn", "formats"),
    [
        (draws, ANY),
        (permutes, ANY),
        (tosses, ANY),
        (drops, ANY),
        (seeded, ("onnx",)),
        (draws_in_script, ("torchscript",)),
        (draws_in_graph, ("onnx",)),
    ],
)
def test_random_numbers(fn, formats, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="it draws random numbers") as caught:
        export(fn, Spec("test.op", [image()]), tmp_path, formats=formats)
    assert "operator aten." in str(caught.value) and "an input of the op" in str(caught.value)
    assert fn is draws_in_graph or f"at {__file__}:" in str(caught.value)


def counts(input: Tensor) -> Tensor:
    COUNT[0] += 1
    return input * COUNT[0]


def pythons_random(input: Tensor) -> Tensor:
    return input * random.random()


def numpys_random(input: Tensor) -> Tensor:
    return input * float(np.random.rand())


def clock(input: Tensor) -> Tensor:
    return input * (time.perf_counter_ns() % 1000003)


def accumulates(input: Tensor) -> Tensor:
    KEPT.add_(1)
    return input + KEPT


def norm(input: Tensor) -> Tensor:
    return NORM(input)


class Counter(nn.Module):
    def __init__(self, how: str) -> None:
        super().__init__()
        self.how = how
        self.count = 0
        self.register_buffer("number", torch.zeros(()))
        self.register_buffer("mean", torch.zeros(3))
        self.register_buffer("var", torch.ones(3))

    def forward(self, input: Tensor) -> Tensor:
        if self.how == "add":
            self.number.add_(1)
            return input + self.number
        if self.how == "replace":
            self.number = self.number + 1
            return input + self.number
        if self.how == "replace unseen":
            self.number = self.number + 1
            return input + 1
        if self.how == "count":
            self.count += 1
            return input + self.count
        return F.batch_norm(input, self.mean, self.var, training=True)


class CountsUnseen(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def forward(self, input: Tensor) -> Tensor:
        self.count += 1
        return input + 1


@pytest.mark.parametrize(
    ("fn", "message"),
    [
        (counts, "the same inputs give other results"),
        (pythons_random, "the same inputs give other results"),
        (numpys_random, "the same inputs give other results"),
        (clock, "the same inputs give other results"),
        (accumulates, r"keeps between calls\n.*KEPT.add_\(1\)"),
        (norm, r"keeps between calls\n.*return NORM\(input\)\n.*\n.*\.eval\(\)"),
        (Counter("add"), r"keeps between calls\n.*self.number.add_\(1\)"),
        (Counter("replace"), "keeps state in 'fn.number'"),
        (Counter("replace unseen"), "changes its buffer 'fn.number'"),
        (Counter("count"), "keeps state in 'fn.count'"),
        (Counter("norm"), r"keeps between calls\n.*training=True"),
        (CountsUnseen(), r"attribute 'count'\n.*self.count \+= 1"),
    ],
)
def test_state(fn, message: str, tmp_path: Path) -> None:
    before = copy.deepcopy(NORM.state_dict()), KEPT.clone()
    with pytest.raises(ExportError, match=message):
        export(fn, Spec("test.op", [image(channels=3)]), tmp_path, formats=["torchscript"])
    assert all(
        torch.equal(a, b) for a, b in zip(before[0].values(), NORM.state_dict().values())
    ) and torch.equal(before[1], KEPT)
    assert not list(tmp_path.iterdir())


# --- what is allowed ----------------------------------------------------------------------------------------


def own_copy(input: Tensor) -> Tensor:
    copied = input.clone()
    copied[:, 0] = 0
    result = torch.zeros_like(input)
    result[:, :, :] += copied
    parts: List[Tensor] = []
    for i in range(3):
        parts.append(copied * i)
    stacked = torch.stack(parts)
    stacked[0] += 1
    return result + stacked.sum(0)


def other_dtype(frame: Tensor) -> Tensor:
    numbers = frame.to(torch.float32)
    numbers.mul_(2)
    return numbers


def no_dropout(input: Tensor) -> Tensor:
    return F.dropout(input, 0.5, training=False) + 1


def without_gradients(input: Tensor) -> Tensor:
    with torch.no_grad():
        factor = input * 2
    return input + factor


@pytest.mark.parametrize("fn", [own_copy, other_dtype, no_dropout, without_gradients])
def test_writing_into_what_is_its_own(fn, tmp_path: Path) -> None:
    bundle = export(
        fn,
        Spec("test.own", [frame() if fn is other_dtype else image()]),
        tmp_path,
        formats=ANY,
        methods=["forward"],
    )
    x = (
        torch.rand(2, 3, 5, 7)
        if fn is not other_dtype
        else torch.randint(0, 255, (5, 7, 3), dtype=torch.uint8)
    )
    for backend in ("onnx", "torch"):
        torch.testing.assert_close(
            torch.from_numpy(chiasm.runtime.open(bundle).method("forward", backend=backend)(x.numpy())), fn(x)
        )


def as_it_is(input: Tensor) -> Tensor:
    return input


def whole_view(input: Tensor) -> Tensor:
    return input[:]


def reshaped(input: Tensor) -> Tensor:
    return input.reshape(input.shape)


def turned(input: Tensor) -> Tensor:
    return input.transpose(2, 3)


def twice(input: Tensor) -> Tuple[Tensor, Tensor]:
    result = input + 1
    return result, result


def listed(input: Tensor) -> List[Tensor]:
    return [input + 1, input]


@pytest.mark.parametrize("fn", [as_it_is, whole_view, reshaped, turned, twice, listed])
def test_results_that_are_inputs_are_copied(fn, tmp_path: Path) -> None:
    names = ["a", "b"] if fn in (twice, listed) else ["a"]
    formats = (*ANY, "native") if fn in (as_it_is, listed) else ANY
    bundle = export(
        fn,
        Spec("test.same", [image()], [TensorSpec(n) for n in names]),
        tmp_path,
        formats=formats,
        methods=None if fn is as_it_is else ["forward"],
    )
    x = np.random.default_rng(0).random((2, 3, 5, 7), np.float32)
    for backend in ("onnx", "torch", "native")[: len(formats)]:
        method = chiasm.runtime.open(bundle).method("forward", backend=backend)
        results = method(x)
        for got, want in zip(
            results if len(names) > 1 else [results],
            fn(torch.from_numpy(x)) if len(names) > 1 else [fn(torch.from_numpy(x))],
            strict=True,
        ):
            assert np.array_equal(got, want.numpy()) and not np.shares_memory(got, x)


def test_a_branch_that_training_alone_takes_is_not_read() -> None:
    class Net(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.norm, self.drop = nn.BatchNorm2d(3), nn.Dropout()

        def forward(self, input: Tensor) -> Tensor:
            return self.drop(self.norm(input))

    check_script("test.op", torch.jit.script(Net().eval()), {"input": ("float32",)})
    with pytest.raises(ExportError, match=r"random|keeps"):
        check_script("test.op", torch.jit.script(Net()), {"input": ("float32",)})


def test_an_unpacking_that_cannot_happen_is_read(tmp_path: Path) -> None:
    """PyTorch's encoder has branches for shapes of other lengths."""
    encoder = nn.TransformerEncoderLayer(8, 2, batch_first=True).eval()
    spec = Spec("test.encoder", [TensorSpec("input", ("B", "N", 8))], symbols={"N": (2, 64)})
    bundle = export(encoder, spec, tmp_path, formats=["torchscript"], methods=["forward"])
    x = torch.rand(2, 7, 8)
    got = chiasm.runtime.open(bundle).method("forward", backend="torch")(x)
    torch.testing.assert_close(got, encoder(x).detach())
