"""Artifacts are compared with eager Python before they are delivered, at other sizes than the exported
one."""

from __future__ import annotations

import json
import os
import selectors
import signal
from pathlib import Path

import onnx
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

from chiasm import runtime
from chiasm.export import ExportError, Spec, TensorSpec, export, image
from chiasm.export.checks import trial

ON_IMAGES = {"symbols": {"H": (8, 64), "W": (8, 64)}, "gradients": ()}


def upright(input: Tensor) -> Tensor:
    if input.shape[2] > input.shape[3]:
        return input.transpose(2, 3).flip(3)
    return input.transpose(2, 3).flip(2)


def not_alone(input: Tensor) -> Tensor:
    return input * (2 if input.shape[0] == 1 else 3)


def large_ones_apart(input: Tensor) -> Tensor:
    x = input * 2
    if input.shape[2] * input.shape[3] > 3000:
        x = x + 1
    return x


def no_squares(input: Tensor) -> Tensor:
    if input.shape[2] == input.shape[3]:
        raise ValueError("square")
    return input * 2


def summed_windows(input: Tensor) -> Tensor:
    return F.avg_pool2d(input, 3, divisor_override=1)


@pytest.mark.parametrize("format", ["onnx", "native"])
@pytest.mark.parametrize(
    "fn, words",
    [
        (upright, ["if input.shape[2] > input.shape[3]", "input.shape[2] <= input.shape[3] alone", "H="]),
        (large_ones_apart, ["> 3000", "choose by torch.where"]),
        (no_squares, ["if input.shape[2] == input.shape[3]", "B=1, H=8, W=8"]),
        (not_alone, ["with B=1, H=17, W=22", "1122 of 1122 values differ"]),
    ],
)
def test_a_graph_that_is_wrong_at_another_size_is_refused(
    fn, words: list[str], format: str, tmp_path: Path
) -> None:
    with pytest.raises(ExportError) as refused:
        export(
            fn,
            Spec(f"trial.{fn.__name__}", [image(channels=3)], **ON_IMAGES),
            tmp_path,
            formats=[format],
            methods=["forward"],
        )
    assert all(word in str(refused.value) for word in words), str(refused.value)
    assert list(tmp_path.iterdir()) == []


def test_what_an_engine_ignores_is_found(tmp_path: Path) -> None:
    """torch.onnx drops this argument."""
    spec = Spec("trial.windows", [image(channels=3)], **ON_IMAGES)
    with pytest.raises(ExportError, match=r"forward\.float32\.onnx does not give"):
        export(summed_windows, spec, tmp_path, formats=["onnx"])


def exact_slope(input: Tensor) -> Tensor:
    return torch.atan(input.to(torch.float64)).to(input.dtype)


def test_an_operator_that_onnx_runtime_lacks_for_its_dtype_is_refused(tmp_path: Path) -> None:
    spec = Spec("trial.slope", [image(channels=3)], **ON_IMAGES)
    with pytest.raises(ExportError, match=r"(?s)float32\.onnx holds.*Atan.*instead: compute"):
        export(exact_slope, spec, tmp_path, formats=["onnx"], methods=["forward"])
    assert list(tmp_path.iterdir()) == []


def lower_half(input: Tensor) -> Tensor:
    return input[:, :, input.shape[3] // 2 :] * 2.0


def test_an_assumption_that_does_not_matter_is_none(tmp_path: Path) -> None:
    """The trace guards on the slice's end, but the slice is the same for every end."""
    spec = Spec("trial.lower", [image(channels=3)], symbols={"H": (40, 64), "W": (8, 64)}, gradients=())
    bundle = export(lower_half, spec, tmp_path, formats=["onnx"])
    method = runtime.open(bundle).method("forward")
    for height, width in ((40, 9), (64, 64), (41, 40)):
        x = torch.rand(2, 3, height, width)
        torch.testing.assert_close(method(x), lower_half(x))


def doubled(input: Tensor) -> Tensor:
    return input * 2.0


@pytest.mark.parametrize(
    "source, words",
    [
        (f"import os; os.kill(os.getpid(), {int(signal.SIGSEGV)})", "ended their process (signal 11)"),
        ("import time; time.sleep(100)", "did not end in 1 s"),
    ],
)
def test_code_that_ends_its_process_does_not_end_the_export(
    source: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "process.py"
    file.write_text(f"import sys\nsys.stdin.readline()\n{source}\n")
    monkeypatch.setattr(trial, "_PROCESS", file)
    monkeypatch.setattr(trial, "_MOST_SECONDS", 1)
    monkeypatch.setattr(trial._Process, "_kept", None)
    with pytest.raises(ExportError) as refused:
        export(doubled, Spec("trial.doubled", [image()]), tmp_path / "out", formats=["onnx"])
    assert words in str(refused.value)
    monkeypatch.undo()
    assert export(doubled, Spec("trial.doubled", [image()]), tmp_path / "out", formats=["onnx"]).is_dir()


def tripled(input: Tensor) -> Tensor:
    return input * 3.0


def test_an_answer_that_comes_late_is_nobodys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = export(doubled, Spec("trial.doubled", [image()]), tmp_path, formats=["onnx"])
    second = export(tripled, Spec("trial.tripled", [image()]), tmp_path, formats=["torchscript"])

    def interrupted(*_: object) -> list[object]:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(selectors.DefaultSelector, "select", interrupted)
        with pytest.raises(KeyboardInterrupt):
            trial._Process.of_this().rows(first, "onnx")
    rows = trial._Process.of_this().rows(second, "torch")
    assert {row["artifact"] for row in rows} == {"forward.pt"}


def test_the_working_folder_holds_no_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "json.py").write_text("raise SystemExit(3)\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(trial._Process, "_kept", None)
    assert export(doubled, Spec("trial.doubled", [image()]), tmp_path, formats=["onnx"]).is_dir()


def test_what_is_asked_for_twice_is_made_once(tmp_path: Path) -> None:
    spec = Spec("trial.doubled", [image()], gradients=())
    made = export(doubled, spec, tmp_path, formats=["native", "native"], isas=["x86-64-v3"] * 2)
    artifacts = json.loads((made / "manifest.json").read_text())["methods"]["forward"]["artifacts"]
    assert len({a["file"] for a in artifacts}) == len(artifacts)


def test_a_policy_of_the_exporters_process_is_not_that_of_the_trial(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bundle that is being made is not signed yet."""
    monkeypatch.setattr(trial._Process, "_kept", None)
    monkeypatch.setitem(os.environ, "CHIASM_TRUST_POLICY", "signed")
    assert export(doubled, Spec("trial.doubled", [image()]), tmp_path, formats=["onnx"]).is_dir()


def quotients(a: Tensor, b: Tensor) -> Tensor:
    floor = torch.div(a, b, rounding_mode="floor") + torch.div(a, 7, rounding_mode="floor") + a // -5
    whole = torch.div(a, b, rounding_mode="trunc") + torch.div(a, -4, rounding_mode="trunc")
    return floor + whole + a % b + a % -3


def sample_quotients(g: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    signs = 2 * torch.randint(0, 2, (sizes["N"],), generator=g) - 1
    return {
        "a": torch.randint(-100, 100, (sizes["N"],), generator=g),
        "b": torch.randint(1, 9, (sizes["N"],), generator=g) * signs,
    }


def test_quotients_of_integers_in_onnx(tmp_path: Path) -> None:
    """Integers beyond float32's precision, of either sign, the smallest integer, and an error for zero."""
    integers = [TensorSpec(name, ("N",), "int64") for name in "ab"]
    spec = Spec("trial.quotients", integers, make_inputs=sample_quotients)
    method = runtime.open(export(quotients, spec, tmp_path, formats=["onnx"])).method("forward")
    a = torch.tensor([-(2**24) - 1, 2**24 + 1, -3074457345618258603, 7, -7, 7, -7, 0, 5, -5])
    b = torch.tensor([1, -1, 3, 2, 2, -2, -2, 4, -1, -1])
    torch.testing.assert_close(method(a, b), quotients(a, b), rtol=0, atol=0)
    least = torch.tensor([-(2**63)])
    assert method(least, torch.tensor([-1])).shape == (1,)  # PyTorch's own division ends the process
    with pytest.raises(runtime.ChiasmError):
        method(a, torch.zeros_like(b))


def centred(input: Tensor) -> Tensor:
    top = (20 - input.shape[2]) // 2
    return F.pad(input, (0, 0, top, 20 - input.shape[2] - top))


@pytest.mark.parametrize("format", ["onnx", "native"])
def test_a_negative_size_is_rounded_down(format: str, tmp_path: Path) -> None:
    spec = Spec("trial.centred", [image(channels=3)], **ON_IMAGES)
    method = runtime.open(export(centred, spec, tmp_path, formats=[format])).method("forward")
    for height in (8, 19, 33, 64):
        x = torch.rand(1, 3, height, 12)
        torch.testing.assert_close(method(x), centred(x), rtol=0, atol=0)


def pooled(input: Tensor) -> Tensor:
    return F.max_pool2d(input, 2) + torch.zeros(input.shape[2] // 2, input.shape[3] // 2)


@pytest.mark.parametrize("fn, rounds", [(pooled, False), (centred, True)])
def test_only_a_size_that_may_be_negative_is_rounded(fn, rounds: bool, tmp_path: Path) -> None:
    bundle = export(
        fn, Spec(f"trial.{fn.__name__}", [image(channels=3)], **ON_IMAGES), tmp_path, formats=["onnx"]
    )
    nodes = onnx.load(bundle / "forward.float32.onnx").graph.node
    assert any(node.op_type == "Div" for node in nodes)
    assert any(node.op_type == "Mod" for node in nodes) == rounds


def coarse(input: Tensor) -> Tensor:
    return input.half().float() + input.bfloat16().to(input.dtype)


def test_a_conversion_to_half_precision_rounds(tmp_path: Path) -> None:
    spec = Spec("trial.coarse", [image(channels=3)], gradients=())
    method = runtime.open(export(coarse, spec, tmp_path, formats=["native"])).method("forward")
    x = torch.rand(1, 3, 9, 17)
    torch.testing.assert_close(method(x), coarse(x), rtol=0, atol=0)
