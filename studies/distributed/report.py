"""What a run says of several processes and of one: its section of docs/use_cases.md, and a picture."""

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
    """By how many pixels the corners differ at most, of any process's homography and the one of one
    process."""
    there = corners_taken(alone["homography"], settings)
    return max(
        float(np.abs(corners_taken(result["homography"], settings) - there).max()) for result in together
    )


def check(settings: Settings, together: list[Result], alone: Result) -> None:
    """Raise RuntimeError unless processes and the one process agree."""
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
            f"{count} photographs of scikit-image are the work of {len(together)} processes, which `torchrun`"
            " starts and which talk by gloo. Both kinds of work are compared with"
        ),
        "one process's, that knows nothing of `torch.distributed`.",
        "",
        "![what the processes made](use_cases/distributed.png)",
        "",
        (
            "**A pipeline, sent.** The first process composes `torch.nn.Sequential(MedianBlur, UnsharpMask,"
            " EqualizeClahe, RgbToGrayscale, Sobel)`, sends it to all as TorchScript,"
        ),
        f"with each one's share of the photographs ({' and '.join(str(len(r['edges'])) for r in together)}),"
        " and gets back what they made. It is "
        + (
            "**bit for bit** what one process makes of the whole batch."
            if difference == 0
            else f"what one process makes of the whole batch to {difference:.2g}."
        ),
        "",
        (
            "**An optimisation by all.** All photographs were moved by one homography."
            " `DistributedDataParallel(Homography())` learns it, each process from its own photographs, from"
            " coarse"
        ),
        (
            "to fine as registration by gradient descent does, of squared differences; gradients are averaged"
            " at each step, in float64. A process's loss is weighed by how many photographs it has, so that"
        ),
        (
            f"shares need not be equal. After {settings.levels} x {settings.steps} steps the corners are"
            f" **{apart(settings, together, alone):.1e} pixels** from where one process takes them"
        ),
        (
            f"(allowed: {settings.tolerance:g}), and {off:.1e} pixels from the truth, from {before:.1f} at"
            " first."
        ),
        "",
        "| | host | photographs | pipeline, s | learning, s |",
        "|---|---|---|---|---|",
        *(_row(f"process {k}", result["host"], result) for k, result in enumerate(together)),
        _row("alone", "", alone),
        "",
        (
            "Each process has one thread. On several machines the same program is started on each, with the"
            " address of any one of them:"
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
            "The machine that gets the first process reads `settings.json` in that folder, which `make"
            " study WHAT=distributed` writes, and puts `result.pt` there; the others are"
        ),
        (
            "sent settings, op and photographs. Several machines were not at hand: a test starts two"
            " `torchrun`s on one, which find each other in this way."
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
    """A column a photograph: itself, its edges, and it beside the moved one in red and cyan, at first and
    after learning."""
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
        [Panel("it, the moved one", _overlay(a, b)) for a, b in zip(photographs, targets, strict=True)],
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
