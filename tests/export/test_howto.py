"""docs/howto: the steps of each page work, in a copy of the sources."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import torch

from chiasm.export.isas import ISAS

ROOT = Path(__file__).resolve().parents[2]


def blocks(page: str) -> list[str]:
    """The code blocks of a page, in order."""
    return re.findall(r"```\w+\n(.*?)```", (ROOT / "docs" / "howto" / page).read_text(), re.DOTALL)


def run(*command: object, **options: object) -> None:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, timeout=300, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_kernel_is_added(tmp_path: Path) -> None:
    declaration, source, test, lowering, commands = blocks("kernel.md")
    ignored = shutil.ignore_patterns("__pycache__", "*.so", "x86-64-*")
    for folder in (
        "include",
        "runtime/artifact",
        "runtime/base",
        "tests/kernels",
        "tests/ops",
        "python/chiasm",
    ):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=ignored)
    for file in ("tests/__init__.py", "tests/changes.py", "pyproject.toml"):
        shutil.copy(ROOT / file, tmp_path / file)
    with (tmp_path / "python/chiasm/primitives/kernels/declarations/frames.py").open("a") as declarations:
        declarations.write(declaration)
    (tmp_path / "runtime/artifact/kernels/invert.cpp").write_text(source)
    (tmp_path / "tests/kernels/invert_test.cpp").write_text(test)
    (tmp_path / "python/chiasm/primitives/images/inverting.py").write_text(lowering)
    (tmp_path / "use.py").write_text(USE)

    made = tmp_path / "made"
    for what, where in (("build", made), ("tests", made), ("docs", made / "kernels.md")):
        run(sys.executable, tmp_path / "runtime/artifact/generate.py", what, where)
    assert "## invert\n" in (made / "kernels.md").read_text()
    assert (
        "AOTITorchError aoti_torch_cpu_invert(AtenTensorHandle x_, double high, AtenTensorHandle* result)"
        in (made / "kernel_calls.cpp").read_text()
    )
    sources = [
        tmp_path / f
        for f in (
            "runtime/artifact/kernels/invert.cpp",
            "runtime/artifact/aoti/openmp.cpp",
            "tests/kernels/invert_test.cpp",
            "tests/kernels/threads.cpp",
        )
    ]
    flags = [
        "-std=c++20",
        "-O1",
        f"-march={next(iter(ISAS))}",
        "-fopenmp",
        "-Wall",
        "-Wextra",
        "-Werror",
        f"-I{made}",
        f"-I{tmp_path / 'runtime'}",
        f"-I{tmp_path / 'include'}",
    ]
    run("g++", *flags, *sources, "-lgtest", "-lgtest_main", "-o", tmp_path / "invert_test")
    run(tmp_path / "invert_test")
    link_for_python(tmp_path, flags)
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "python"), "CHIASM_ALL_TESTS": "1"}
    run(sys.executable, tmp_path / "use.py", env=environment)
    (tmp_path / "docs").mkdir()
    shutil.copy(made / "kernels.md", tmp_path / "docs")
    for line in commands.splitlines():
        if "-m pytest" in line:
            run(sys.executable, *shlex.split(line)[1:], "-q", env=environment, cwd=tmp_path)


def link_for_python(tree: Path, flags: list[str]) -> None:
    """What tests/kernels/CMakeLists.txt makes of the kernels for tests in Python, with this tree's others."""
    library = tree / "build/release/lib/libkernels_for_python.so"
    library.parent.mkdir(parents=True)
    sources = [
        tree / "made/kernel_calls.cpp",
        tree / "runtime/artifact/kernels/invert.cpp",
        *(tree / f"tests/kernels/{name}.cpp" for name in ("for_python", "calls", "threads")),
    ]
    archives = ROOT / "python/chiasm/artifact" / next(iter(ISAS))
    others = [archives / f"lib{name}.a" for name in ("chiasm_kernels", "chiasm_aoti", "gomp")]
    options = ["-O0", "-shared", "-fPIC", "-isystem", Path(torch.__file__).parent / "include"]
    local = "-Wl,--exclude-libs,ALL"  # else torch's functions of the same names would be called
    run("g++", *flags, *options, *sources, *others, local, "-lmvec", "-o", library)


def test_an_op_is_added(tmp_path: Path) -> None:
    source, names, spec, test, commands = blocks("op.md")
    shutil.copytree(
        ROOT / "python/chiasm",
        tmp_path / "python/chiasm",
        ignore=shutil.ignore_patterns("__pycache__", "x86-64-*"),
    )
    (tmp_path / "python/chiasm/enhance/vignette.py").write_text(source)
    family = tmp_path / "python/chiasm/enhance/__init__.py"
    before, lookup = family.read_text().split("__getattr__, ")
    family.write_text(f"{before}{names}\n__getattr__, {lookup}")
    with (tmp_path / "python/chiasm/export/catalog/enhance.py").open("a") as catalog:
        catalog.write(spec)
    shutil.copytree(ROOT / "tests/ops", tmp_path / "tests/ops", ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("tests/__init__.py", "tests/changes.py"):
        shutil.copy(ROOT / file, tmp_path / file)
    (tmp_path / "tests/ops/test_vignette.py").write_text(test)
    environment = os.environ | {"PYTHONPATH": f"{tmp_path / 'python'}:{tmp_path}", "PYTHONSAFEPATH": "1"}
    run(
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "-k",
        "vignette",
        tmp_path / "tests/ops/test_vignette.py",
        tmp_path / "tests/ops/test_error_inputs.py",
        env=environment,
        cwd=tmp_path,
    )
    run(sys.executable, "-c", DOCTEST, env=environment, cwd=tmp_path)
    (tmp_path / "tools").mkdir()
    run(sys.executable, shutil.copy(ROOT / "tools/stubs.py", tmp_path / "tools"), env=environment)
    assert "class Vignette(" in family.with_suffix(".pyi").read_text()
    export, verify = (
        line.split("-m chiasm.export ")[1].split()
        for line in commands.splitlines()
        if "chiasm.export" in line
    )
    run(
        sys.executable,
        "-m",
        "chiasm.export",
        *export,
        "-f",
        "onnx",
        "-f",
        "torchscript",
        env=environment,
        cwd=tmp_path,
    )
    run(sys.executable, "-m", "chiasm.export", *verify, env=environment, cwd=tmp_path)


#: The example of the op's docstring, and the gradient.
DOCTEST = """
import doctest, sys, torch
import chiasm.enhance
module = sys.modules["chiasm.enhance.vignette"]
failed, tried = doctest.testmod(module, extraglobs={"torch": torch})
assert tried and not failed
x = torch.rand(1, 2, 3, 4, dtype=torch.float64, requires_grad=True)
assert torch.autograd.gradcheck(module.vignette, x)
torch.jit.script(module.vignette)
"""

#: The trace for native code has the kernel, other traces have the definition.
USE = """
import torch
from torch import Tensor

from chiasm.primitives.core.target import exporting
from chiasm.primitives.images.inverting import inverted

x = torch.rand(2, 3, 5)
torch.testing.assert_close(inverted(x, 1.0), 1.0 - x)
class Inverted(torch.nn.Module):
    def forward(self, x: Tensor) -> Tensor:
        return inverted(x, 1.0)
for target, operator in (("native", "chiasm.invert.default"), ("onnx", "aten.rsub.Scalar")):
    with exporting(target):
        graph = torch.export.export(Inverted(), (x,)).graph
    assert [str(node.target) for node in graph.nodes if node.op == "call_function"] == [operator], graph
"""


#: A network that finds red squares of 32 x 32: for each cell, its redness as the score and the cell as the
#: box.
RED_SQUARES = """
class RedSquares(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.redness = nn.Conv2d(3, 1, 32, stride=32)
        with torch.no_grad():
            self.redness.weight.copy_(torch.tensor([1.0, -1.0, -1.0])[None, :, None, None] / 1024)
            self.redness.bias.zero_()

    def forward(self, image: Tensor) -> Tensor:
        red = self.redness(image)
        centre = torch.arange(10, device=image.device) * 32.0 + 16
        across = centre.expand_as(red)
        down = centre[:, None].expand_as(red)
        side = torch.full_like(red, 32.0)
        output = torch.cat([across, down, side, side, red.clamp(0.0, 1.0)], 1).flatten(2)
        return output.repeat(1, 1, 10)  # a thousand places


frame = np.zeros((384, 480, 3), np.uint8)  # two thirds of it are the network's input
squares = [(48, 96, 224), (240, 192, 255)]
for left, top, red in squares:
    frame[top : top + 48, left : left + 48, 2] = red
bundle = export_detector(RedSquares(), {folder!r})
found = detect(bundle, frame)
with torch.no_grad():
    expected = Detector(RedSquares())(torch.from_numpy(frame)[None])
assert [round(score * 255) for _, score, _ in found] == [255, 224], found
for (box, score, label), (left, top, red) in zip(found, squares[::-1]):
    np.testing.assert_allclose(box, [left, top, left + 48, top + 48], atol=1e-3)
np.testing.assert_allclose([b for b, _, _ in found], expected[0][0, :2].numpy(), atol=1e-3)
for opened in ("torch", "onnx", "native"):
    results = runtime.open(bundle).method("forward", backend=opened)(frame[None])
    for actual, wanted in zip(results, expected):
        np.testing.assert_allclose(actual, wanted.numpy(), atol=1e-3)

from pathlib import Path

from chiasm.export.workers import export_names

export_names(["pipelines.letterbox"], Path({folder!r}), ("native",), methods=("forward",))
bundle = {folder!r} + "/pipelines.letterbox.chiasm"
frames = [frame, frame[:200, :300].copy(), frame[5:].copy()]
alone = runtime.open(bundle).method("forward")
for image, back, frame in zip(*batch_of(bundle, frames), frames):
    expected_image, expected_back = alone(frame[None])
    np.testing.assert_array_equal(image, expected_image[0])
    np.testing.assert_array_equal(back, expected_back[0])
"""


#: The bundle to which the page adds a program of the toy engine for the same function.
SCALE = """
from torch import Tensor

from chiasm.export import Spec, TensorSpec, export

def scale(input: Tensor) -> Tensor:
    return input * 2.0 + 1.0

spec = Spec("my.scale", [TensorSpec("input", ("N",), "float32")], symbols={"N": (1, 1000)})
export(scale, spec, "bundles", ("torchscript",), methods=("forward",))
"""
RUN = """
import numpy as np

from chiasm import runtime

bundle = runtime.open("bundles/my.scale.chiasm")
x = np.array([0.0, 0.25, 4.0], np.float32)
assert [row.passed for row in bundle.self_test() if row.backend == "example"] == [True], bundle.self_test()
np.testing.assert_array_equal(bundle.method("forward", backend="example")(x), 2 * x + 1)
try:
    bundle.method("forward", backend="onnx")
except runtime.ChiasmError as error:  # the core offers it no artifact of another backend
    assert "onnx: the bundle has no artifact for it" in str(error), error
else:
    raise AssertionError("the onnx backend runs what is not its own")
"""


def test_a_backend_is_added(tmp_path: Path) -> None:
    (written,) = re.findall(r"```python\n(.*?)```", (ROOT / "docs/howto/backend.md").read_text(), re.DOTALL)
    sources = [ROOT / "runtime/backends/example/example.cpp", *(ROOT / "runtime/base").glob("*.cpp")]
    flags = ["-std=c++17", "-shared", "-fPIC", f"-I{ROOT / 'runtime'}", f"-I{ROOT / 'include'}"]
    run("g++", *flags, *sources, "-o", tmp_path / "libchiasm_example.so")
    environment = os.environ | {"CHIASM_BACKEND_PATH": str(tmp_path)}
    (tmp_path / "added.py").write_text(SCALE + written + RUN)
    run(sys.executable, tmp_path / "added.py", env=environment, cwd=tmp_path)


def change(folder: Path, file: str, block: str) -> None:
    """Make the change of a block in the form of a diff; each place must be there once."""
    lines = block.splitlines()
    old, new = ("\n".join(x[1:] for x in lines if x[0] in f" {sign}") for sign in "-+")
    text = (folder / file).read_text()
    assert text.count(old) == 1, f"{file} has no single place for this:\n{block}"
    (folder / file).write_text(text.replace(old, new))


def compiled(folder: Path, *files: Path) -> str:
    """What g++ says to sources in a copy of the tree, with the flags of cmake/ChiasmTargets.cmake."""
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-fsyntax-only"]
    folders = [f"-I{folder / 'runtime'}", f"-I{folder / 'include'}"]
    done = subprocess.run(["g++", *flags, *folders, *map(str, files)], capture_output=True, text=True)
    assert (done.returncode == 0) == (not done.stderr), done.stderr
    return done.stderr


#: The new type in C and C++, by the names that the page gives it.
WITH_UINT32 = """
#include "base/dtype.h"
#include "chiasm/chiasm.hpp"
static_assert(static_cast<int>(chiasm::dtype_of<uint32_t>) == CHIASM_UINT32, "");
static_assert(chiasm::base::kDTypeCount == CHIASM_UINT32 + 1, "");
static_assert(chiasm::base::kDTypes[CHIASM_UINT32].size == sizeof(uint32_t), "");
"""


def test_an_element_type_is_added(tmp_path: Path) -> None:
    page = (ROOT / "docs/howto/dtype.md").read_text()
    files = {}
    for title, text in re.findall(r"^## Step \d: `(.*?)`\n(.*?)(?=^## )", page, re.DOTALL | re.MULTILINE):
        files[title] = re.findall(r"```diff\n(.*?)```", text, re.DOTALL)
    assert len(files) == 3 and all(files.values()) and "a place in three files" in page
    for folder in ("include", "runtime/base", "runtime/core"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    for file, blocks_of_file in files.items():
        for block in blocks_of_file:
            change(tmp_path, file, block)
    (tmp_path / "with_uint32.cpp").write_text(WITH_UINT32)
    core = tmp_path / "runtime/core"
    sources = [f for f in core.glob("*.cpp") if '"base/dtype.h"' in f.read_text()]
    assert len(sources) > 5
    assert compiled(tmp_path, tmp_path / "with_uint32.cpp", core / "layout.cpp", *sources) == ""

    # the assertions that the page promises
    change(
        tmp_path, "include/chiasm/chiasm.h", "-#define CHIASM_API_VERSION 4u\n+#define CHIASM_API_VERSION 5u"
    )
    assert "freeze the new version's layout here too" in compiled(tmp_path, core / "layout.cpp")
    change(tmp_path, "runtime/base/dtype.h", "-\"U32\", 4, 1, 'u', 12\n+\"U32\", 1, 1, 'f', 12")
    assert "kElements has no line for a type" in compiled(tmp_path, core / "golden.cpp")


def test_a_detector_is_deployed(tmp_path: Path) -> None:
    source = "\n".join(blocks("detector.md")) + RED_SQUARES.replace("{folder!r}", repr(str(tmp_path)))
    (tmp_path / "detector.py").write_text(source)
    run(sys.executable, tmp_path / "detector.py", cwd=ROOT)
    run(sys.executable, "-m", "chiasm.export", "verify", tmp_path / "my.detector.chiasm", cwd=ROOT)
