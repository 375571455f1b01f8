"""The demo's inputs: photographs that ship inside scikit-image, and what each op needs besides."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import skimage
import torch
from PIL import Image

from chiasm.export import samples
from chiasm.export.spec import Spec

DATA = Path(skimage.__file__).parent / "data"


def photograph(name: str) -> np.ndarray:
    """An RGB uint8 array (H, W, 3)."""
    return np.asarray(Image.open(DATA / name).convert("RGB"))


def scenes(spec: Spec) -> list[tuple[str, dict[str, torch.Tensor]]]:
    """(label, inputs) of the runs that the demo makes of one op; the first one gives the pictures."""
    astronaut, cat, coffee = photograph("astronaut.png"), photograph("chelsea.png"), photograph("coffee.png")
    pairs = np.stack([coffee[60:315, 100:451], coffee[80:335, 140:491]])  # a batch of two, both sides odd
    return [
        ("astronaut 512x512", inputs(spec, astronaut[None])),
        ("cat 300x451", inputs(spec, cat[None])),
        ("coffee 2 of 255x351", inputs(spec, pairs)),
    ]


def inputs(spec: Spec, images: np.ndarray) -> dict[str, torch.Tensor]:
    """The op's inputs for photographs (B, H, W, 3): images where it takes images, else sampled values."""
    batch, height, width, _ = images.shape
    sizes = samples.fit(spec, {"B": batch, "C": 3, "H": height, "W": width, "N": 1000, "OH": height * 3 // 4, "OW": width * 3 // 4})
    made = samples.make(spec, sizes, spec.variants()[0])
    for tensor in spec.inputs:
        if tensor.layout == "HWC":
            made[tensor.name] = torch.from_numpy(images[0, :, :, ::-1].copy())
        elif tensor.layout == "NCHW":
            planes = torch.from_numpy(images.transpose(0, 3, 1, 2).copy()).float() / 255.0
            if tensor.shape[1] == 1:
                planes = (planes * torch.tensor([0.299, 0.587, 0.114]).view(1, 3, 1, 1)).sum(1, keepdim=True)
            made[tensor.name] = planes
    return made | special(spec, made, sizes)


def special(spec: Spec, made: dict[str, torch.Tensor], sizes: dict[str, int]) -> dict[str, torch.Tensor]:
    """Values that make a better picture, or a fairer comparison, than random ones."""
    names = {t.name for t in spec.inputs}
    if "sigma" in names:
        return {"sigma": torch.full((sizes["B"], 2), 1.5)}
    if "mean" in names:
        return {"mean": torch.tensor([0.485, 0.456, 0.406]), "std": torch.tensor([0.229, 0.224, 0.225])}
    if "M" in names:
        height, width = sizes["H"], sizes["W"]
        tilt = torch.tensor([[0.72, -0.16, 0.14 * width], [0.12, 0.68, 0.02 * height], [0.12 / width, -0.1 / height, 1.0]])
        return {"M": tilt.expand(sizes["B"], 3, 3).contiguous()}
    if "img2" in names:  # a slightly darker, noisier copy
        noise = torch.rand(made["img1"].shape, generator=torch.Generator().manual_seed(2))
        return {"img2": (made["img1"] * 0.9 + 0.1 * noise).clamp(0, 1)}
    return {}
