"""A photograph through a pipeline: colour to grey, blur, Sobel, back to bytes.

usage: edges.py BUNDLE PHOTO OUT.png        BUNDLE: chiasm export pipelines.edges -o bundles
"""

import sys

import numpy as np
from PIL import Image

from chiasm import runtime

if len(sys.argv) != 4:
    sys.exit(__doc__)
bundle, photo, out = sys.argv[1:]
edges = runtime.open(bundle).method("forward")
rgb = np.asarray(Image.open(photo).convert("RGB"))
bgr = np.ascontiguousarray(rgb[:, :, ::-1])  # (H, W, 3) as OpenCV has it
Image.fromarray(edges(bgr)).save(out)
print(f"{edges.name} on {edges.backend}: {rgb.shape} -> {out}")
