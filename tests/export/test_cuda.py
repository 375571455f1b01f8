"""Native code for GPUs: it can be exported without a GPU, needs only the driver, and runs if there is a
GPU."""

from __future__ import annotations

import re
import struct
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import ExportError, Spec, TensorSpec, export, image
from chiasm.export.manifest import read_manifest
from chiasm.runtime import ChiasmError

GPUS = ("sm_80", "sm_90")
EM_CUDA = 190  # e_machine of ELF files for GPUs

needs_gpu = pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device")


def looked_up(input: Tensor, index: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """A stencil, entries of a table by indices from data, and a view."""
    table = torch.linspace(0.0, 1.0, 12, dtype=input.dtype).square()
    return input[:, :, 1:] - input[:, :, :-1], table[index], input.flip([3])[:, :1]


def sample(generator: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    s = {"B": 2, "C": 3, "H": 8, "W": 9, "N": 5} | sizes
    return {
        "input": torch.rand(s["B"], s["C"], s["H"], s["W"], generator=generator, dtype=dtype),
        "index": torch.randint(-12, 12, (s["N"],), generator=generator),
    }


SPEC = Spec(
    "test.looked_up",
    [image(), TensorSpec("index", ("N",), "int64")],
    [TensorSpec("rows"), TensorSpec("entries"), TensorSpec("mirrored")],
    symbols={"H": (4, 4096), "W": (4, 4096)},
    make_inputs=sample,
)


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bundles")
    return export(looked_up, SPEC, folder, ["native"], ["x86-64-v3", *GPUS], methods=["forward"])


def artifacts(bundle: Path, device: str) -> list[dict[str, Any]]:
    listed = read_manifest(bundle)["methods"]["forward"]["artifacts"]
    return [a for a in listed if a["device"] == device]


def library_of(bundle: Path, artifact: dict[str, Any]) -> bytes:
    return zipfile.ZipFile(bundle / artifact["file"]).read("chiasm/op.so")


def test_each_gpu_has_an_artifact_with_its_code(bundle: Path) -> None:
    made = artifacts(bundle, "cuda")
    assert {a["sm"] for a in made} == {80, 90}
    for artifact in made:
        library = library_of(bundle, artifact)
        programs = []
        for found in list(re.finditer(b"\x7fELF", library))[1:]:
            (machine,) = struct.unpack_from("<H", library, found.start() + 18)
            (flags,) = struct.unpack_from("<I", library, found.start() + 48)
            programs.append((machine, flags & 0xFF))
        assert programs and set(programs) == {(EM_CUDA, artifact["sm"])}


def test_the_driver_is_found_when_it_runs(bundle: Path, tmp_path: Path) -> None:
    file = tmp_path / "op.so"
    file.write_bytes(library_of(bundle, artifacts(bundle, "cuda")[0]))
    needed = subprocess.run(["objdump", "-p", file], capture_output=True, text=True, check=True).stdout
    assert set(re.findall(r"NEEDED +(\S+)", needed)) <= {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}
    symbols = subprocess.run(["nm", "-D", file], capture_output=True, text=True, check=True).stdout
    assert not re.search(r" U (cu[A-Z]|cuda|aoti_torch)", symbols)
    assert re.findall(r" T (\w+)", symbols) == ["chiasm_native_entry"]


def test_the_cpu_is_served_by_the_same_bundle(bundle: Path) -> None:
    inputs = sample(torch.Generator().manual_seed(3), {"H": 11}, torch.float32)
    method = runtime.open(bundle).method(backend="native")
    assert method.artifact == artifacts(bundle, "cpu")[0]["file"]
    for mine, expected in zip(method(**inputs), looked_up(**inputs), strict=True):
        torch.testing.assert_close(mine, expected)


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_without_a_driver_the_error_says_so(bundle: Path) -> None:
    with pytest.raises(ChiasmError, match="there is no CUDA driver on this machine"):
        runtime.open(bundle).method(backend="native", device="cuda")


def test_what_needs_libtorch_is_refused(tmp_path: Path) -> None:
    def chosen(input: Tensor) -> Tensor:
        return torch.cholesky_inverse(input @ input.mT + torch.eye(4))

    spec = Spec("test.chosen", [TensorSpec("input", ("B", 4, 4))], [TensorSpec("output")])
    with pytest.raises(
        ExportError, match=r"\(sm_90\) needs libtorch's aoti_torch_cuda_\w+.*without --isa sm_90"
    ):
        export(chosen, spec, tmp_path, ["native"], ["sm_90"], methods=["forward"])


@needs_gpu
def test_it_runs(bundle: Path) -> None:
    method = runtime.open(bundle).method(backend="native", device="cuda")
    for sizes in {"H": 11}, {"B": 1, "H": 4, "W": 300, "N": 1}, {"B": 5, "C": 1}:
        inputs = sample(torch.Generator().manual_seed(3), sizes, torch.float32)
        results = method(**{name: value.cuda() for name, value in inputs.items()})
        for mine, expected in zip(results, looked_up(**inputs), strict=True):
            torch.testing.assert_close(mine.cpu(), expected)


@needs_gpu
def test_an_index_out_of_range_is_moved_to_the_nearest(bundle: Path) -> None:
    method = runtime.open(bundle).method(backend="native", device="cuda")
    inputs = sample(torch.Generator().manual_seed(3), {}, torch.float32)
    beyond = inputs | {"index": torch.tensor([12, 1 << 40, -13, -(1 << 40), 11])}
    within = inputs | {"index": torch.tensor([11, 11, 0, 0, 11])}
    got = method(**{name: value.cuda() for name, value in beyond.items()})
    torch.testing.assert_close(got[1].cpu(), looked_up(**within)[1])
