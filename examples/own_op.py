"""An op of your own: written once, exported, run.

usage: own_op.py FOLDER OUT.raw        makes FOLDER/my.soft_threshold.chiasm; own_op.cpp runs it
"""

import sys

import numpy as np
import torch
from torch import Tensor

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export, image


def soft_threshold(image: Tensor, threshold: Tensor, gain: float = 1.0) -> Tensor:
    """Values nearer to zero than the threshold become zero; the others move towards zero by it."""
    limit = threshold[:, None, None, None]
    return gain * torch.sign(image) * torch.relu(image.abs() - limit)


if len(sys.argv) != 3:
    sys.exit(__doc__)
folder, out = sys.argv[1:]
spec = Spec(
    "my.soft_threshold",
    [image("image"), TensorSpec("threshold", ("B",), range=(0.0, 1.0))],
    config={"gain": 2.0},
)
bundle = export(soft_threshold, spec, folder)
op = runtime.open(bundle).method("forward")
ramp = np.linspace(-1, 1, 2 * 3 * 4 * 5, dtype=np.float32).reshape(2, 3, 4, 5)
result = op(ramp, np.array([0.25, 0.5], np.float32))
result.tofile(out)
print(f"{bundle.name} on {op.backend}: values from {result.min():.2f} to {result.max():.2f}")
