"""The section of docs/use_cases.md."""

from __future__ import annotations

from statistics import median

import numpy as np

from studies.use_cases import settings_table

from .descent import in_pixels
from .figure import WHITE
from .pairs import corners_of
from .settings import Settings
from .trials import Run, Trial

CONTENDERS = {
    "gradient descent": "gradient descent, native",
    "ecc": "`findTransformECC`",
    "ecc_multi_scale": "`findTransformECCMultiScale`",
}


def page(settings: Settings, trials: list[Trial], runs: list[Run], seconds: float, opencv: str) -> list[str]:
    pair = trials[settings.shown].pair
    return [
        (
            "A homography between two photographs is learned from coarse to fine: at each level of a pyramid"
            " Adam minimises the mean absolute difference between the"
        ),
        (
            "warped source and the destination, over the pixels that the source covers. Each level starts"
            " from the result of the level before. A whole step (loss, gradient,"
        ),
        (
            "update) is one exported function, `studies/registration/step.py`; the pyramid and the final warp"
            " are exported functions too."
        ),
        "",
        *settings_table(settings),
        (
            "A pair is the centre part of a photograph and a view of the same photograph by a known"
            f" homography, {settings.width} x {settings.height} pixels, rendered by OpenCV at four times"
        ),
        (
            "the size. The error is the mean distance, in pixels of the full size, between the source's four"
            " corners and the same corners after the true homography to the destination"
        ),
        "and the estimated homography back.",
        "",
        (
            "![source, destination, warped source and its difference from the truth, level by"
            " level](use_cases/registration.png)"
        ),
        "",
        (
            f"The four rows of the paper's figure, for {pair.photograph} with corners moved by up to"
            f" {pair.reach:.0%} of the sides. The last row is the mean difference of the"
        ),
        f"channels between the source warped by the estimate and by the truth; white is {WHITE:g}.",
        "",
        *levels_table(settings, trials),
        *success_table(settings, trials, opencv),
        *runs_table(settings, runs),
        *verdict(settings, trials),
        (
            f"The run took {seconds / 60:.1f} minutes on {settings.threads}"
            f" thread{'s' * (settings.threads > 1)}."
        ),
    ]


def levels_table(settings: Settings, trials: list[Trial]) -> list[str]:
    """Errors after each level, by the displacement of the corners."""
    names = ["at first", *(f"1/{2**i}" if i else "full size" for i in reversed(range(settings.levels)))]
    lines = [
        (
            "Error of the corners in pixels after each level, median and maximum over"
            f" {settings.trials // len(settings.reaches)} pairs whose corners moved along each axis by"
            " up to:"
        ),
        "",
        f"| level | {' | '.join(f'{reach:.0%} of the sides' for reach in settings.reaches)} |",
        "|---" * (len(settings.reaches) + 1) + "|",
    ]
    for i, name in enumerate(names):
        errors = [[t.errors[i] for t in trials if t.pair.reach == reach] for reach in settings.reaches]
        lines.append(f"| {name} | {' | '.join(f'{number(median(e))}, {number(max(e))}' for e in errors)} |")
    return [*lines, ""]


def success_table(settings: Settings, trials: list[Trial], opencv: str) -> list[str]:
    """The number of pairs within the limit, by contender and by the displacement of the corners."""
    lines = [
        (
            f"Pairs, out of {len(trials)}, with a mean error below {settings.success:g} pixel. OpenCV"
            f" {opencv} gets the images in grey, with its default settings and the same start, the identity;"
        ),
        "the time is the median CPU time from the images to the homography.",
        "",
        (
            f"| | {' | '.join(f'up to {reach:.0%}' for reach in settings.reaches)} | all | median error of"
            " these | CPU ms |"
        ),
        "|---" * (len(settings.reaches) + 4) + "|",
    ]
    for key, name in CONTENDERS.items():
        shares = []
        for some in [*([t for t in trials if t.pair.reach == reach] for reach in settings.reaches), trials]:
            shares.append(f"{sum(succeeded(t, key, settings) for t in some)} of {len(some)}")
        errors = [t.results[key].error for t in trials if succeeded(t, key, settings)]
        ms = median(t.results[key].ms for t in trials)
        lines.append(
            f"| {name} | {' | '.join(shares)} | {number(median(errors)) if errors else '-'} | {ms:.0f} |"
        )
    return [*lines, ""]


def runs_table(settings: Settings, runs: list[Run]) -> list[str]:
    """The difference of each engine's homography from eager Python's."""
    lines = [
        (
            f"The pair of the picture by every engine, after {settings.levels * settings.iterations} steps"
            " each: the largest difference of an entry of the homography between normalised coordinates from"
        ),
        (
            f"eager Python's (tolerance: {settings.tolerance:g}), and the largest distance of the mapped"
            " corners in pixels. ONNX Runtime runs standard operators. In C++, exported bundles do everything"
        ),
        ("from the two image files on; neither Python nor a library of torch is in the process."),
        "",
        "| engine | difference | corners | CPU ms |",
        "|---|---|---|---|",
    ]
    for run in runs:
        apart = corners_apart(run.homography, runs[0].homography, settings)
        lines.append(f"| {run.engine} | {difference(run, runs):.1e} | {apart:.1e} | {run.ms:.0f} |")
    return [*lines, ""]


def verdict(settings: Settings, trials: list[Trial]) -> list[str]:
    """A summary of successes and failures."""
    ours, theirs, scales = ([t for t in trials if succeeded(t, key, settings)] for key in CONTENDERS)
    times = {key: median(t.results[key].ms for t in trials) for key in CONTENDERS}
    missed = [
        f"{t.pair.photograph} at up to {t.pair.reach:.0%} by {number(t.errors[-1])} pixels"
        for t in trials
        if not succeeded(t, "gradient descent", settings)
    ]
    return [
        (
            "The paper shows a picture of one pair and states neither errors nor a rate of success, so there"
            f" is no number to compare with. Here {len(ours)} of {len(trials)} pairs succeed, {len(theirs)}"
            f" with `findTransformECC` and {len(scales)} with `findTransformECCMultiScale`."
        ),
        f"Missed: {'; '.join(missed)}." if missed else "No pair is missed.",
        (
            "Gradient descent is slow: it takes"
            f" {times['gradient descent'] / times['ecc']:.0f} times as long as `findTransformECC` and"
            f" {times['gradient descent'] / times['ecc_multi_scale']:.0f} times as long as"
            " `findTransformECCMultiScale`."
        ),
        "",
    ]


def difference(run: Run, runs: list[Run]) -> float:
    return float(np.abs(run.homography - runs[0].homography).max())


def corners_apart(a: np.ndarray, b: np.ndarray, settings: Settings) -> float:
    """The largest distance, in pixels, between the corners as mapped by two homographies."""
    corners = np.column_stack([corners_of(settings.width, settings.height), np.ones(4)])
    ends = [corners @ in_pixels(h, settings).T for h in (a, b)]
    return float(
        np.linalg.norm(ends[0][:, :2] / ends[0][:, 2:] - ends[1][:, :2] / ends[1][:, 2:], axis=1).max()
    )


def succeeded(trial: Trial, contender: str, settings: Settings) -> bool:
    return trial.results[contender].error < settings.success


def number(value: float) -> str:
    """A number with two significant digits, if it is small, or rounded."""
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"
