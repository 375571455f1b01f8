"""chiasm's wheel for aarch64 in a Python for aarch64; run by aarch64.sh, under qemu.

Usage: python aarch64.py BUNDLE..., of sobel and of rgb_to_hsv on frames.
"""

import platform
import sys
from pathlib import Path

import numpy as np

from chiasm import runtime

assert platform.machine() == "aarch64"
backends = {b.name: b.problem for b in runtime.backends()}
assert backends == {"native": "", "onnx": ""}, backends

for path in sys.argv[1:]:
    for backend in backends:
        rows = runtime.Bundle(path).self_test(backend=backend)
        assert any(row.passed for row in rows), rows
        print(f"{Path(path).stem} on {backend}: {rows}")

sobel = runtime.Bundle(next(path for path in sys.argv[1:] if "sobel" in path))
ramp = np.tile(np.arange(8, dtype=np.float32), (1, 1, 8, 1))
for backend in backends:
    # The central difference (x[i + 1] - x[i - 1]) / 2, by a smoothing kernel; the ends are replicated.
    result = sobel.method("forward", backend=backend)(ramp)
    expected = np.ones_like(ramp)
    expected[..., [0, -1]] = 0.5
    np.testing.assert_allclose(np.asarray(result), expected, atol=1e-3)
