"""chiasm's wheel and a pack of bundles in an environment with only NumPy; run by pip_install.sh."""

import subprocess
import sys
from importlib.metadata import distributions
from pathlib import Path

import numpy as np

import chiasm.runtime
from chiasm.extras import OPS


def python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


names = {d.name for d in distributions()} - {"pip", "setuptools"}
assert names == {"chiasm", "chiasm-bundles-some", "numpy"}, names

# The least CPU time of several runs: other processes may be running.
measure = "import time; t = time.process_time(); import chiasm.runtime; print(time.process_time() - t)"
seconds = min(float(python(measure).stdout) for _ in range(7))
print(f"import chiasm.runtime: {seconds * 1e3:.0f} ms")
assert seconds < 0.060, seconds

absent = (
    *((f"import chiasm.{family}", f"chiasm.{family}", "ops") for family in OPS),
    ("from chiasm import filters", "chiasm.filters", "ops"),
    ("import chiasm; chiasm.filters", "chiasm.filters", "ops"),
    ("import chiasm.geometry.transform", "chiasm.geometry", "ops"),
    ("from chiasm.export import Spec", "chiasm.export.spec", "export"),
    ("import chiasm.export.catalog", "chiasm.export.catalog", "export"),
)
for code, module, extra in absent:
    done = python(code)
    assert done.stderr.strip().splitlines()[-1] == (
        f"ModuleNotFoundError: {module} belongs to the distribution chiasm-ops, which is not installed: pip"
        f' install "chiasm[{extra}]" (bundles run without it: chiasm.runtime)'
    ), done.stderr
done = python("import chiasm.onnx")
assert 'pip install "chiasm[onnx]"' in done.stderr.strip().splitlines()[-1], done.stderr

command = Path(sys.executable).with_name("chiasm")
for arguments in (["verify", "x"], ["export", "filters.sobel"], []):
    done = subprocess.run([command, *arguments], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done
    assert 'pip install "chiasm[cli]"' in done.stderr
done = subprocess.run([command, "doctor"], capture_output=True, text=True, check=True)
print(done.stdout)
for line in (
    "backend    native: native code",
    'backend    torch: there is no plug-in libchiasm_torch.so: pip install "chiasm[torch]"',
    'ops        none: chiasm-ops is not installed: pip install "chiasm[ops]"',
    'backend    onnx: onnxruntime is not installed: pip install "chiasm[onnx]"',
    "bundles    chiasm-bundles-some 0.1.0: 2 in ",
):
    assert line in done.stdout, line
done = subprocess.run([command, "list", "--installed"], capture_output=True, text=True, check=True)
assert [line.split()[0] for line in done.stdout.splitlines()] == ["color.rgb_to_hsv", "filters.sobel"]

# The gradient of a ramp is its slope; sobel returns sqrt(slope^2 + 1e-6).
ramp = np.broadcast_to(np.linspace(0, 1, 65, dtype=np.float32), (1, 3, 48, 65)).copy()
edges = chiasm.runtime.open("filters.sobel").method("forward")(ramp)
np.testing.assert_allclose(edges[..., 1:-1], np.hypot(1 / 64, 1e-3), rtol=1e-5)
hsv = chiasm.runtime.open("color.rgb_to_hsv").method("forward")(np.full((1, 3, 8, 8), 0.25, np.float32))
np.testing.assert_array_equal(hsv[0, :, 0, 0], [0, 0, 0.25])
try:
    chiasm.runtime.open("filters.no_such_op")
except chiasm.runtime.ChiasmError as error:
    assert "chiasm list --installed" in str(error)
else:
    raise AssertionError("opened what is not there")
