"""Make the working tree importable, and keep torch to one thread: the images are small."""

import sys
from pathlib import Path

import torch

ROOT = Path(__file__).parents[2]
for folder in (ROOT / "python", ROOT):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

torch.set_num_threads(1)
