"""An export leaves the module and the settings of the process as they were."""

import os
import random
import re
import warnings
from pathlib import Path
from typing import Callable, List

import numpy as np
import pytest
import torch
from torch import Tensor, nn
from torch.nn import functional as F

import chiasm.runtime
from chiasm.export import ExportError, Spec, export, image
from chiasm.export.checks.process_state import settings

ANY = ("torchscript", "onnx")


class Net(nn.Module):
    """A small network in the middle of its training, with everything that a module can hold."""

    def __init__(self, fails: bool = False) -> None:
        super().__init__()
        self.fails = fails
        self.conv, self.norm, self.drop, self.head = (
            nn.Conv2d(3, 4, 3, padding=1),
            nn.BatchNorm2d(4),
            nn.Dropout2d(),
            nn.Conv2d(4, 1, 1),
        )
        self.notes: List[int] = [1]
        with torch.no_grad():
            self.norm.running_mean.uniform_()
            self.norm.running_var.uniform_(0.5, 2.0)

    def forward(self, input: Tensor) -> Tensor:
        if self.fails:
            raise ValueError("no")
        return self.head(self.drop(F.relu(self.norm(self.conv(input)))))


def _state(net: nn.Module) -> tuple:
    return (
        [(n, m.training, sorted(vars(m)), len(m._forward_hooks)) for n, m in net.named_modules()],
        [
            (
                n,
                t.data_ptr(),
                t._version,
                t.requires_grad,
                t.detach().clone().tolist(),
                t.grad is None or t.grad.tolist(),
            )
            for n, t in (*net.named_parameters(), *net.named_buffers())
        ],
    )


@pytest.mark.parametrize("fails", [False, True])
def test_a_module_is_left_as_it_was(fails: bool, tmp_path: Path) -> None:
    net = Net(fails).train()
    net.norm.eval()
    net.head.weight.requires_grad_(False)
    net.conv.weight.grad = torch.ones_like(net.conv.weight)
    seen = []
    net.conv.register_forward_hook(lambda *_: seen.append(0))
    before, numbers = (
        _state(net),
        (
            torch.get_rng_state(),
            random.getstate(),
            np.random.get_state()[1].tolist(),
        ),
    )
    try:
        export(
            net,
            Spec("test.net", [image(channels=3)], symbols={"H": (8, 512), "W": (8, 512)}),
            tmp_path,
            formats=["onnx"],
            methods=["forward"],
        )
        assert not fails
    except ExportError:
        assert fails
    assert _state(net) == before
    assert (
        torch.equal(torch.get_rng_state(), numbers[0])
        and random.getstate() == numbers[1]
        and np.random.get_state()[1].tolist() == numbers[2]
    )


def test_a_networks_default_export(tmp_path: Path) -> None:
    """ONNX has no operator for the gradient of a convolution: the rest is exported, with a warning."""
    net = Net().train()
    spec = Spec("test.net", [image(channels=3)], symbols={"H": (8, 512), "W": (8, 512)})
    with pytest.warns(
        UserWarning,
        match=(
            r"test.net: exported without its gradient in the format onnx: operator"
            r" aten.convolution_backward.*methods=\('forward',\)"
        ),
    ) as caught:
        bundle = export(net, spec, tmp_path, formats=ANY)
    assert {Path(w.filename).name for w in caught if "test.net" in str(w.message)} == {Path(__file__).name}
    net.eval()
    x, g = torch.rand(2, 3, 11, 13), torch.rand(2, 1, 11, 13)
    leaf = x.clone().requires_grad_()
    want = net(leaf)
    opened = chiasm.runtime.open(bundle)
    for backend in ("onnx", "torch"):
        torch.testing.assert_close(
            torch.from_numpy(opened.method("forward", backend=backend)(x.numpy())),
            want.detach(),
            atol=1e-5,
            rtol=1e-4,
        )
    got = opened.method("vjp", backend="torch")(x.numpy(), g.numpy())
    torch.testing.assert_close(
        torch.from_numpy(got), torch.autograd.grad(want, leaf, g)[0], atol=1e-5, rtol=1e-4
    )
    with pytest.raises(ExportError, match="convolution_backward"):
        export(net, spec, tmp_path, formats=["onnx"], methods=["forward", "vjp"])
    with warnings.catch_warnings(), pytest.raises(KeyError):
        warnings.simplefilter("error", UserWarning)
        chiasm.runtime.open(export(net, spec, tmp_path, formats=["onnx"], methods=["forward"])).info[
            "methods"
        ]["vjp"]


def test_the_gradient_of_batch_norm_is_in_every_format(tmp_path: Path) -> None:
    net = nn.Sequential(nn.BatchNorm2d(3), nn.ReLU())
    with torch.no_grad():
        net[0].running_var.uniform_(0.5, 2.0)
        net[0].weight.uniform_()
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="test.norm")
        bundle = export(
            net,
            Spec("test.norm", [image(channels=3)], symbols={"H": (8, 512), "W": (8, 512)}),
            tmp_path,
            formats=ANY,
        )
    x, g = torch.rand(2, 3, 9, 11), torch.rand(2, 3, 9, 11)
    leaf = x.clone().requires_grad_()
    [want] = torch.autograd.grad(net.eval()(leaf), [leaf], g)
    for backend in ("onnx", "torch"):
        torch.testing.assert_close(
            torch.from_numpy(
                chiasm.runtime.open(bundle).method("vjp", backend=backend)(x.numpy(), g.numpy())
            ),
            want,
            atol=1e-6,
            rtol=1e-5,
        )


def sets_dtype(input: Tensor) -> Tensor:
    torch.set_default_dtype(torch.float64)
    return input + 1


def sets_device(input: Tensor) -> Tensor:
    result = input + 1
    torch.set_default_device("meta")
    return result


def sets_threads(input: Tensor) -> Tensor:
    torch.set_num_threads(torch.get_num_threads() + 3)
    return input + 1


def sets_determinism(input: Tensor) -> Tensor:
    torch.use_deterministic_algorithms(True)
    return input + 1


def sets_anomalies(input: Tensor) -> Tensor:
    torch.autograd.set_detect_anomaly(True)
    return input + 1


def sets_denormals(input: Tensor) -> Tensor:
    torch.set_flush_denormal(True)
    return input + 1


def sets_errors(input: Tensor) -> Tensor:
    np.seterr(all="ignore")
    return input + 1


def sets_folder(input: Tensor) -> Tensor:
    os.chdir("/")
    return input + 1


SETTINGS = {
    sets_dtype: "torch's default dtype",
    sets_device: "torch's default device",
    sets_threads: "the number of torch's threads",
    sets_determinism: "whether torch is deterministic",
    sets_anomalies: "torch's detection of anomalies",
    sets_denormals: "whether the smallest numbers are taken for zero",
    sets_errors: "what NumPy does about errors",
    sets_folder: "the working folder",
}


@pytest.mark.parametrize(("op", "what"), SETTINGS.items(), ids=[op.__name__ for op in SETTINGS])
def test_settings_of_the_process_are_the_callers(
    op: Callable[[Tensor], Tensor], what: str, tmp_path: Path
) -> None:
    before = settings()
    line = op.__code__.co_firstlineno
    with pytest.raises(ExportError, match=f"it changes {what}, which is the process's") as refused:
        export(op, Spec("test.sets", [image()]), tmp_path, formats=ANY)
    assert re.search(rf"at {__file__}:({line + 1}|{line + 2}): (torch|np|os)\.", str(refused.value))
    assert settings() == before


def quietly(input: Tensor) -> Tensor:
    """Settings that change only in the op are its own; those of the trace alone are put back."""
    torch.manual_seed(3)
    torch.set_grad_enabled(False)
    if torch.compiler.is_exporting():
        torch.set_default_dtype(torch.float64)
    with torch.no_grad(), np.errstate(all="ignore"):
        return input + 1


def test_settings_are_put_back(tmp_path: Path) -> None:
    before, numbers = settings(), torch.get_rng_state()
    try:
        export(quietly, Spec("test.quietly", [image()]), tmp_path, formats=("onnx",), methods=("forward",))
    finally:
        assert settings() == before
        assert torch.equal(torch.get_rng_state(), numbers)
