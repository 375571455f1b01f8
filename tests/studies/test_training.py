"""The training with several libraries' augmentation, small."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from gallery.cases import ROOT
from studies.training.report import apart, errors_apart, section
from studies.training.settings import SMALL
from studies.training.train import digits, train
from studies.training.ways import WAYS

KORNIA = (ROOT / ".deps" / "kornia" / "kornia").exists()
THERE = [name for name in WAYS if KORNIA or name != "Kornia"]


@pytest.mark.parametrize("name", [name for name in THERE if name != "none"])
def test_a_way_changes_each_image_on_its_own(name: str) -> None:
    torch.manual_seed(0)
    image = digits(SMALL, 0)[0][:1]
    changed = WAYS[name](SMALL)(image.expand(64, -1, -1, -1).clone())
    assert changed.shape == (64, *image.shape[1:]) and changed.dtype == torch.float32
    assert changed.min() >= 0 and changed.max() <= 1
    assert len(changed.flatten(1).unique(dim=0)) == 64


@pytest.mark.parametrize("name", [name for name in THERE if name != "none"])
def test_the_ways_have_one_distribution(name: str) -> None:
    torch.manual_seed(0)
    images = digits(SMALL, 0)[0]
    means = [
        torch.stack([WAYS[n](SMALL)(images).mean((0, 1)) for _ in range(4)]).mean(0) for n in ("chiasm", name)
    ]
    assert (means[0] - means[1]).abs().max() < 0.08


def test_a_short_training_learns_and_repeats() -> None:
    found = [train(WAYS["chiasm"](SMALL), SMALL, 0) for _ in range(2)]
    assert found[0] == found[1] > 0.5


def test_the_section_says_which_are_apart() -> None:
    found = {
        "none": [0.90, 0.91, 0.92],
        "Kornia": [0.95, 0.96, 0.97],
        "torchvision v2": [0.951, 0.961, 0.971],
        "chiasm": [0.949, 0.959, 0.969],
    }
    assert errors_apart(found["none"], found["Kornia"]) == pytest.approx(0.05 / (2e-4 / 3) ** 0.5)
    assert apart(found, SMALL) == []
    settings = replace(SMALL, seeds=(0, 1, 2))
    text = "\n".join(section(settings, found, 60.0))
    assert "No two libraries are more than 2 standard errors apart." in text
    assert "| Kornia and chiasm | 0.10% | 0.1 |" in text
    found["chiasm"] = [0.90, 0.91, 0.92]
    assert apart(found, SMALL) == [("Kornia", "chiasm"), ("torchvision v2", "chiasm")]
    assert "apart are Kornia and chiasm, torchvision v2 and chiasm" in "\n".join(
        section(settings, found, 60.0)
    )
