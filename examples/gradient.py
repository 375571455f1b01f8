"""Gradient descent by a bundle's `vjp`: what was this image before it was blurred?

usage: gradient.py BUNDLE STEPS OUT.raw        BUNDLE: chiasm export filters.box_blur -o bundles
"""

import sys

import numpy as np

from chiasm import runtime

if len(sys.argv) != 4:
    sys.exit(__doc__)
bundle, steps, out = sys.argv[1], int(sys.argv[2]), sys.argv[3]
opened = runtime.open(bundle)
blur, vjp = opened.method("forward"), opened.method("vjp")

truth = np.zeros((1, 1, 32, 32), np.float32)
truth[..., 8:24, 12:20] = 1.0  # a bar
blurred = blur(truth)
guess = blurred.copy()
for _ in range(steps):
    difference = blur(guess) - blurred
    guess -= 0.5 * vjp(guess, difference)  # along the gradient of half the sum of squared differences
error = float(np.square(blur(guess) - blurred).sum())
guess.tofile(out)
print(f"{vjp.backend}: squared difference {error:.2e} after {steps} steps")
