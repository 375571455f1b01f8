"""A horse on a meadow: the class of every pixel, and a possible result of a badly trained network."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from chiasm import filters
from gallery.geometric.setting import Inputs, Setting, mesh

SKY, HORSE, MEADOW, SUN, CLOUD, HILL = range(6)
IGNORED = -100


def truth(s: Setting) -> Tensor:
    """(H, W) of classes; the photograph is the silhouette of a horse."""
    gray = s.rgb[0].mean(0)
    x, y = (mesh(s.width, s.height) * torch.tensor([s.width / s.height, 1.0])).unbind(-1)

    def disk(cx: float, cy: float, rx: float, ry: float) -> Tensor:
        return ((x - cx) / rx) ** 2 + ((y - cy) / ry) ** 2 < 1

    made = torch.full_like(gray, SKY, dtype=torch.int64)
    for where, label in (
        (disk(0.7, 0.75, 0.9, 0.55), HILL),
        (disk(-0.95, -0.7, 0.16, 0.16), SUN),
        (disk(-0.2, -0.76, 0.4, 0.13), CLOUD),
        (y > 0.62, MEADOW),
        (gray < 0.5, HORSE),
    ):
        made[where] = label
    return made


def found(labels: Tensor, count: int) -> Tensor:
    """(count, H, W): probabilities of the classes, smooth and slightly displaced from the true places; the
    sun is classified as a cloud."""
    planes = functional.one_hot(labels, count).permute(2, 0, 1).float()
    if count > CLOUD:
        planes[CLOUD] += 0.7 * planes[SUN]
        planes[SUN] *= 0.3
    moved = functional.pad(planes[None], (7, 0, 2, 0), mode="replicate")[..., :-2, :-7]
    return filters.gaussian_blur2d(moved, (15, 15), (3.0, 3.0))[0]


def classes(s: Setting) -> Inputs:
    """Logits or the most likely class, and the truth. A part of the truth is ignored if the op supports it.
    With two classes, these are the horse and the rest."""
    pred, target = s.shape("pred"), s.shape("target")
    labels = truth(s)
    if "binary" in s.spec.name or pred[1:2] == (1,):
        labels = (labels == HORSE).long()
        shares = found(labels, 2)[1:]
        logits = 8 * shares - 4
    else:
        shares = found(labels, 6)
        logits = torch.log(shares + 0.02)
    if len(pred) == 3:
        logits = shares.argmax(0)
    if any("-100" in t.description for t in s.spec.inputs):
        labels[-40:-10, 12:60] = IGNORED
    made = {
        "pred": logits[None],
        "target": labels[None, None] if len(target) == 4 else labels[None],
        "labels": labels.clamp(max=4)[None],
    }
    rare = torch.tensor([0.5, 2.0, 0.5, 4.0, 2.0, 1.0])[: len(logits)]
    return {name: value.contiguous() for name, value in made.items()} | {
        "weight": rare,
        "pos_weight": 0.5 * rare,
    }


def silhouettes(s: Setting) -> Inputs:
    """Probabilities of the classes, and the true classes."""
    labels = truth(s)
    labels = (labels == HORSE).long() if s.shape("pred")[1] == 1 else labels
    shares = found(labels, 2)[1:] if s.shape("pred")[1] == 1 else found(labels, 6)
    return {"pred": shares[None].contiguous(), "target": labels[None, None]}


def heat_maps(s: Setting) -> Inputs:
    """Three hills, and their predictions: one is right, one is displaced, one is displaced and too wide."""
    grid = (mesh(s.width, s.height) + 1) / 2
    target = [(0.2, 0.3, 0.1), (0.5, 0.65, 0.1), (0.8, 0.4, 0.1)]
    pred = [(0.2, 0.3, 0.1), (0.56, 0.7, 0.1), (0.74, 0.52, 0.16)]

    def hills(places: list[tuple[float, float, float]]) -> Tensor:
        made = torch.stack(
            [
                torch.exp(-((grid - torch.tensor([x, y])) ** 2).sum(-1) / (2 * spread**2))
                for x, y, spread in places
            ]
        )
        return (made / made.sum((1, 2), keepdim=True))[None]

    return {"pred": hills(pred), "target": hills(target)}


def scores(s: Setting) -> Inputs:
    """Twelve samples of six classes: most are right, some are second or third."""
    random = torch.Generator().manual_seed(4)
    target = torch.randint(0, 6, (12,), generator=random)
    pred = torch.rand((12, 6), generator=random) + 0.55 * functional.one_hot(target, 6)
    return {"pred": pred / pred.sum(1, keepdim=True), "target": target}
