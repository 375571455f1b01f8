"""The section of docs/use_cases.md on the runs."""

from __future__ import annotations

import numpy as np

from ..use_cases import settings_table
from .descent import Level
from .runs import AGREEING, ERROR_APART, Judged
from .scenes import Scene
from .score import NEAR_ENOUGH, depth_at_full_size, score, semi_global
from .settings import Settings

ABOUT = {
    "room": (
        "Three views of planes and balls with photographs on them, rendered by `studies/depth/raycast.py`,"
        " with exact depth."
    ),
    "motorcycle": "The stereo pair of scikit-image (Middlebury 2014), reduced, with its measured disparity.",
}


def section(
    settings: Settings,
    results: list[tuple[Scene, list[Level], list[Judged]]],
    exporting: float,
    running: float,
) -> list[str]:
    """Lines of Markdown; exporting, running: the seconds for each."""
    lines = [
        (
            "Section 4.3 of the paper: the depth of a reference view is the one with which the other views,"
            " warped to it, look like it. The loss is a weighted sum of"
        ),
        (
            "(1 - SSIM) / 2 and absolute differences over the pixels that a view covers, plus an edge-aware"
            " smoothness. Gradient descent with momentum"
        ),
        (
            "minimises it, from the coarsest scale to the finest. The unknown is the inverse depth, in units"
            " of the pixels by which it moves points in"
        ),
        (
            "the farthest view: so one learning rate suits all scales and units of length. The rate falls to"
            " 0 at every scale, because the loss has kinks,"
        ),
        (
            "at which a constant rate never converges. `studies/depth/step.py` has a whole step (loss,"
            " gradient, update); it is exported as"
        ),
        (
            "one bundle, which Python and a C++ program without torch (`studies/depth/depth.cpp`) call in a"
            " loop."
        ),
        "",
        (
            "*error* is the mean of |depth - truth| / truth over the pixels with a known depth, *within* the"
            " share of these pixels with an error below"
        ),
        (
            f"{NEAR_ENOUGH:.0%}; *seen* are the known pixels that are visible in every view, neither occluded"
            " nor outside its image. For these numbers,"
        ),
        "the depth of a scale is enlarged to the finest.",
        "",
    ]
    for scene, levels, judged in results:
        lines += [
            f"### {scene.name.capitalize()}",
            "",
            ABOUT[scene.name],
            "",
            f"![{scene.name}](use_cases/depth_{scene.name}.png)",
            "",
        ]
        lines += [
            *_scales(scene, levels),
            "",
            *_not_reached(scene, settings, levels),
            "",
            *_engines(judged),
            "",
        ]
    lines += [
        "### Python and C++",
        "",
        ("All engines ran on one thread. The run fails unless, after the whole optimisation,"),
        (
            f"{AGREEING:.0%} of the pixels have a depth within 1% of eager Python's, and the error is within"
            f" {ERROR_APART:.1%} of eager Python's."
        ),
        (
            "These tolerances are wider than rounding errors, because at a kink the last digit decides the"
            " direction of a step, and momentum continues it."
        ),
        "`tests/studies/test_depth.py` checks single steps with tolerances of rounding. Native code, which is"
        " the same in Python and C++, "
        + ("gave both the same bits." if _same_native_bits(results) else "did not give both the same bits."),
        "",
        (
            f"The optimisations took {running / 60:.1f} minutes, the export of the bundles before"
            f" {exporting / 60:.1f} (they are cached)."
        ),
        "",
        (
            "The scales, the iterations, the use of momentum, and the size and number of the room's views are"
            " the paper's settings; the weights"
        ),
        (
            "of SSIM and absolute differences are those of C. Godard et al. (CVPR 2017). The other settings"
            " are ours, chosen on these scenes, as is the falling rate."
        ),
        "",
    ]
    return lines + settings_table(settings)


def _same_native_bits(results: list[tuple[Scene, list[Level], list[Judged]]]) -> bool:
    native = [
        [j.run.depth for j in judged if j.run.engine.endswith("native code")] for _, _, judged in results
    ]
    return all(np.array_equal(*depths) for depths in native)


def _scales(scene: Scene, levels: list[Level]) -> list[str]:
    lines = ["| scale | loss | error | within | error, seen | within, seen |", "|---|---|---|---|---|---|"]
    for level in levels:
        s = score(depth_at_full_size(level.inverse_depth, scene), scene)
        size = f"{level.images.shape[-1]}x{level.images.shape[-2]}"
        lines.append(
            f"| {size} | {level.loss:.4f} | {s.error:.2%} | {s.within:.1%} | {s.seen_error:.2%} |"
            f" {s.seen_within:.1%} |"
        )
    return lines


def _not_reached(scene: Scene, settings: Settings, levels: list[Level]) -> list[str]:
    depth, known = depth_at_full_size(levels[-1].inverse_depth, scene), np.isfinite(scene.depth)
    s = score(depth, scene)
    wrong = known & ~(np.abs(depth - scene.depth) / scene.depth < NEAR_ENOUGH)
    seen, blind = (known & scene.seen).sum() / known.sum(), (wrong & ~scene.seen).sum() / wrong.sum()
    lines = [
        (
            f"The depth of {known.mean():.1%} of the pixels is known, and every view sees {seen:.1%} of"
            f" these. The error is {NEAR_ENOUGH:.0%} or more for"
        ),
        (
            f"{1 - s.within:.1%} of the known pixels; {blind:.0%} of these are not visible in every view, so"
            " the loss compares different points there."
        ),
        (
            "The paper shows its result, for another scene, only as a picture, so there are no numbers to"
            " compare with."
        ),
    ]
    if scene.name == "motorcycle":
        peer, share = semi_global(scene, settings)
        p = score(peer, scene)
        lines += [
            "",
            (
                "For comparison, OpenCV's semi-global matching tries all disparities instead of descending."
                " It finds a depth for"
            ),
            (
                f"{share:.1%} of the pixels, with an error of {p.error:.2%} ({p.seen_error:.2%} for the seen"
                f" ones). {p.within:.1%} of the known pixels"
            ),
            (
                f"are within {NEAR_ENOUGH:.0%} ({p.seen_within:.1%} of the seen ones); for gradient descent,"
                f" {s.within:.1%} ({s.seen_within:.1%})."
            ),
        ]
    return lines


def _engines(judged: list[Judged]) -> list[str]:
    lines = [
        (
            "The same optimisation by each engine; the last three columns are the relative differences of"
            f" its depth from that of {judged[0].run.engine}:"
        ),
        "",
        (
            "| engine | seconds | ms per step, finest scale | loss | error | within | median | 99% below"
            " | pixels within 1% |"
        ),
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for j in judged:
        apart = (
            f"{j.difference.median:.1e} | {j.difference.most:.1e} | {j.difference.within:.1%}"
            if j is not judged[0]
            else " | | "
        )
        cost = f"{j.run.seconds:.0f} | {j.run.milliseconds:.1f} | {j.run.loss:.5f}"
        lines.append(f"| {j.run.engine} | {cost} | {j.score.error:.2%} | {j.score.within:.1%} | {apart} |")
    return lines
