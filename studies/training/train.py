"""The data, the network, and one training."""

from __future__ import annotations

import numpy as np
import torch
from sklearn.datasets import load_digits
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, interpolate

from .settings import Settings
from .ways import Way


def digits(settings: Settings, seed: int) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Images and labels for training, and others for testing, in an order that depends on the seed."""
    pixels, classes = load_digits(return_X_y=True)
    images = torch.from_numpy(np.reshape(pixels, (-1, 1, 8, 8))).float() / 16.0
    size = [settings.side, settings.side]
    images = interpolate(images, size, mode="bilinear", align_corners=False).expand(-1, 3, -1, -1)
    order = torch.randperm(len(images), generator=torch.Generator().manual_seed(seed))
    images, labels = images[order].contiguous(), torch.from_numpy(np.asarray(classes))[order]
    n = settings.train
    return images[:n], labels[:n], images[n:], labels[n:]


def network(side: int) -> nn.Sequential:
    """Three convolutions and a linear layer."""

    def block(before: int, after: int) -> list[nn.Module]:
        convolution = nn.Conv2d(before, after, 3, padding=1, bias=False)
        return [convolution, nn.BatchNorm2d(after), nn.ReLU(), nn.MaxPool2d(2)]

    features = 32 * (side // 8) ** 2
    return nn.Sequential(*block(3, 16), *block(16, 32), *block(32, 32), nn.Flatten(), nn.Linear(features, 10))


def train(way: Way, settings: Settings, seed: int) -> float:
    """The accuracy after a training. For a seed, the initial network and the batches are the same for all
    libraries."""
    images, labels, others, truth = digits(settings, seed)
    torch.manual_seed(seed)
    model, batches = network(settings.side), torch.Generator().manual_seed(seed)
    optimizer = torch.optim.Adam(model.parameters(), settings.lr)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, settings.steps)
    for _ in range(settings.steps):
        chosen = torch.randint(len(images), (settings.batch,), generator=batches)
        with torch.no_grad():
            given = way(images[chosen])
        optimizer.zero_grad()
        cross_entropy(model(2.0 * given - 1.0), labels[chosen]).backward()
        optimizer.step()
        schedule.step()
    model.eval()
    with torch.no_grad():
        return float((model(2.0 * others - 1.0).argmax(1) == truth).float().mean())
