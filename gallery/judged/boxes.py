"""Boxes around coins: the true ones, and detections."""

from __future__ import annotations

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from gallery.geometric.setting import Inputs, Setting

COINS = 12


def coins(s: Setting) -> tuple[Tensor, Tensor]:
    """x1, y1, x2, y2 of the largest coins (COINS, 4), and their classes, 1 to 4, by their area."""
    gray = s.rgb[0].mean(0).numpy()
    smooth = ndimage.gaussian_filter(gray, 1.0)
    shapes, _ = ndimage.label(ndimage.binary_fill_holes(smooth > ndimage.uniform_filter(smooth, 75) + 0.05))
    found = np.array([[x.start, y.start, x.stop, y.stop] for y, x in ndimage.find_objects(shapes)])
    area = (found[:, 2] - found[:, 0]) * (found[:, 3] - found[:, 1])
    largest = np.argsort(-area)[:COINS]
    classes = 1 + np.arange(COINS) * 4 // COINS
    return torch.from_numpy(found[largest]).float(), torch.from_numpy(classes)


def moved(boxes: Tensor, spread: float) -> Tensor:
    random = torch.Generator().manual_seed(1)
    return boxes + spread * torch.randn(boxes.shape, generator=random)


def detections(s: Setting) -> Inputs:
    """Most coins are detected, some twice, some with a wrong class, and one detection is not a coin."""
    true, classes = coins(s)
    nothing = torch.tensor([[4.0, 4.0, 30.0, 28.0], [100.0, 60.0, 130.0, 95.0]])
    found = torch.cat([moved(true[:-2], 2.0), moved(true[:2], 6.0), nothing])
    labels = torch.cat([classes[:-2], classes[:2], torch.tensor([1, 3])])
    labels[[4, 8]] = torch.tensor([1, 2])
    scores = torch.rand(len(found), generator=torch.Generator().manual_seed(0)) * 0.6 + 0.4
    scores[-2:] = torch.tensor([0.45, 0.8])
    made = {
        "pred_boxes": found,
        "pred_labels": labels,
        "pred_scores": scores,
        "gt_boxes": true,
        "gt_labels": classes,
    }
    made |= {"pred_mask": torch.arange(len(found)) != len(found) - 1, "gt_mask": torch.arange(len(true)) != 3}
    return {name: value[None].contiguous() for name, value in made.items()}


def boxes(s: Setting) -> Inputs:
    true, _ = coins(s)
    return {"boxes_1": true[:5].contiguous(), "boxes_2": moved(true[[1, 0, 4, 2]], 6.0)}
