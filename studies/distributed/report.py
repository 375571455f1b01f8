"""The section of docs/use_cases.md on several processes and a single one, and its picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from chiasm.geometry.transform import HomographyWarper
from gallery.layout import GAP, row_of
from gallery.panels import Panel
from studies.use_cases import PICTURES, settings_table

from .settings import Settings
from .work import batch, corners, corners_taken, corners_truly, moved

WIDTH = 980
Result = dict[str, Any]


def edges(results: list[Result]) -> Tensor:
    return torch.cat([result["edges"] for result in results])


def apart(settings: Settings, together: list[Result], alone: Result) -> float:
    """The largest difference of the corners, in pixels, between any process's homography and that of the
    single process."""
    there = corners_taken(alone["homography"], settings)
    return max(
        float(np.abs(corners_taken(result["homography"], settings) - there).max()) for result in together
    )


def check(settings: Settings, together: list[Result], alone: Result) -> None:
    """Raise RuntimeError unless the processes agree with the single process."""
    if not torch.equal(edges(together), alone["edges"]):
        raise RuntimeError(
            f"the pipeline's results differ by up to {(edges(together) - alone['edges']).abs().max():.3g}"
        )
    if not apart(settings, together, alone) <= settings.tolerance:
        raise RuntimeError(
            f"what was learned differs by {apart(settings, together, alone):.3g} pixels at the corners, more"
            f" than {settings.tolerance}"
        )


def section(settings: Settings, together: list[Result], alone: Result) -> list[str]:
    count, truly = len(settings.photographs), corners_truly(settings)
    difference = (edges(together) - alone["edges"]).abs().max()
    off, before = (
        np.linalg.norm(at - truly, axis=1).mean()
        for at in (corners_taken(alone["homography"], settings), corners(settings))
    )
    return [
        (
            f"{count} photographs of scikit-image are shared by {len(together)} processes, which `torchrun`"
            " starts and which communicate by gloo. Both kinds of work are compared with the result of"
        ),
        "a single process that does not use `torch.distributed`.",
        "",
        "![results of the processes](use_cases/distributed.png)",
        "",
        (
            "**A sent pipeline.** The first process composes `torch.nn.Sequential(MedianBlur, UnsharpMask,"
            " EqualizeClahe, RgbToGrayscale, Sobel)`, sends it to all as TorchScript,"
        ),
        f"with each one's share of the photographs ({' and '.join(str(len(r['edges'])) for r in together)}),"
        " and collects the results. They equal "
        + (
            "those of one process on the whole batch **bit for bit**."
            if difference == 0
            else f"those of one process on the whole batch up to {difference:.2g}."
        ),
        "",
        (
            "**A shared optimisation.** All photographs were moved by one homography."
            " `DistributedDataParallel(Homography())` learns it, each process from its own photographs, from"
            " coarse"
        ),
        (
            "to fine, like registration by gradient descent, but with squared differences; gradients are"
            " averaged at each step, in float64. A process's loss is weighted by its number of photographs,"
        ),
        (
            f"so shares need not be equal. After {settings.levels} x {settings.steps} steps, the mapped"
            f" corners are **{apart(settings, together, alone):.1e} pixels** from those of one process"
        ),
        (
            f"(allowed: {settings.tolerance:g}), and {off:.1e} pixels from the truth; at the start they were"
            f" {before:.1f} pixels from it."
        ),
        "",
        "| | host | photographs | pipeline, s | learning, s |",
        "|---|---|---|---|---|",
        *(_row(f"process {k}", result["host"], result) for k, result in enumerate(together)),
        _row("alone", "", alone),
        "",
        (
            "Each process has one thread. On several machines, start the same program on each, with the"
            " address of one of them:"
        ),
        "",
        "```",
        (
            "torchrun --nnodes 2 --nproc-per-node 2 --rdzv-backend c10d --rdzv-endpoint HOST:29400 -m"
            " studies.distributed.worker build/studies/distributed"
        ),
        "```",
        "",
        (
            "The machine of the first process reads `settings.json` in that folder, which `make"
            " study WHAT=distributed` writes, and writes `result.pt` there; the other machines receive"
        ),
        (
            "settings, op and photographs. This was not tested on several machines: a test starts two"
            " `torchrun`s on one machine, which find each other in this way."
        ),
        "",
        *settings_table(settings),
    ]


def _row(name: str, host: str, result: Result) -> str:
    return (
        f"| {name} | {host} | {len(result['edges'])} | {result['pipeline_seconds']:.2f} |"
        f" {result['learning_seconds']:.1f} |"
    )


def picture(settings: Settings, together: list[Result]) -> None:
    """Write a picture with one column per photograph: the photograph, its edges, and the overlay with the
    moved one in red and cyan, before and after learning."""
    photographs = batch(settings)
    targets = moved(photographs, settings)
    warp = HomographyWarper(photographs.size(2), photographs.size(3))
    brought = warp(photographs, together[0]["homography"].to(photographs))
    made, whose = edges(together), [k for k, result in enumerate(together) for _ in result["edges"]]
    rows = [
        [
            Panel(f"process {k}", _bytes(image), given=True)
            for k, image in zip(whose, photographs, strict=True)
        ],
        [Panel("edges", _bytes(image / made.max())) for image in made],
        [Panel("original, moved", _overlay(a, b)) for a, b in zip(photographs, targets, strict=True)],
        [Panel("as learned", _overlay(a, b)) for a, b in zip(brought, targets, strict=True)],
    ]
    strips = [row_of(row, len(row), WIDTH) for row in rows]
    sheet = Image.new("RGB", (WIDTH, sum(strip.height + GAP for strip in strips)), "white")
    top = 0
    for strip in strips:
        sheet.paste(strip, (0, top))
        top += strip.height + GAP
    PICTURES.mkdir(parents=True, exist_ok=True)
    sheet.quantize(256).save(PICTURES / "distributed.png", optimize=True)


def _bytes(image: Tensor) -> np.ndarray:
    """(C, H, W) as (H, W, 3)."""
    return (image.expand(3, -1, -1).permute(1, 2, 0).clamp(0, 1) * 255).round().byte().numpy()


def _overlay(first: Tensor, second: Tensor) -> np.ndarray:
    """The means of the channels, one in red, the other in cyan: grey where both agree."""
    return _bytes(torch.stack([first.mean(0), second.mean(0), second.mean(0)]))
