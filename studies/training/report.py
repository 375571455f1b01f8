"""The section of docs/use_cases.md on the trainings."""

from __future__ import annotations

import math
import statistics
from itertools import combinations
from textwrap import fill

from studies.use_cases import settings_table

from .settings import Settings

#: accuracies by augmentation, one per seed
Found = dict[str, list[float]]


def errors_apart(first: list[float], second: list[float]) -> float:
    """The difference of two means, in standard errors of this difference."""
    variances = [statistics.variance(values) / len(values) for values in (first, second)]
    difference = abs(statistics.mean(first) - statistics.mean(second))
    return difference / math.sqrt(sum(variances)) if difference else 0.0


def apart(found: Found, settings: Settings) -> list[tuple[str, str]]:
    """The pairs of libraries whose difference exceeds the limit."""
    libraries = [name for name in found if name != "none"]
    return [
        pair
        for pair in combinations(libraries, 2)
        if errors_apart(found[pair[0]], found[pair[1]]) > settings.limit
    ]


def section(settings: Settings, found: Found, seconds: float) -> list[str]:
    s = settings
    means = {name: statistics.mean(values) for name, values in found.items()}
    libraries = [name for name in found if name != "none"]
    different = apart(found, s)
    said = (
        f"No two libraries are more than {s.limit:g} standard errors apart."
        if not different
        else f"More than {s.limit:g} standard errors apart are "
        + ", ".join(map(" and ".join, different))
        + "."
    )
    return [
        fill(
            f"A network of three convolutions is trained on {s.train} of scikit-learn's 1,797 handwritten"
            f" digits, which are enlarged to {s.side} x {s.side}; accuracy is measured on the others. Each"
            f" batch of {s.batch} is augmented anew: affine map, resized crop, jitter of brightness and"
            " contrast, erasing. All libraries use the same ranges, and every image has its own parameters."
            " For one seed, the split, the initial network and the batches are the same for all libraries.",
            108,
        ),
        "",
        f"| augmentation by | accuracy, mean of {len(s.seeds)} seeds | standard deviation | per seed |",
        "|---|---|---|---|",
        *(
            f"| {name} | {means[name]:.2%} | {statistics.stdev(values):.2%} |"
            f" {', '.join(f'{value:.1%}' for value in values)} |"
            for name, values in found.items()
        ),
        "",
        "Differences, also in standard errors of the difference (Welch):",
        "",
        "| | difference | standard errors |",
        "|---|---|---|",
        *(
            f"| {a} and {b} | {abs(means[a] - means[b]):.2%} | {errors_apart(found[a], found[b]):.1f} |"
            for a, b in combinations(libraries, 2)
        ),
        *(
            f"| none and {name} | {abs(means['none'] - means[name]):.2%} |"
            f" {errors_apart(found['none'], found[name]):.1f} |"
            for name in libraries
        ),
        "",
        f"{said} The whole run took {seconds / 60:.1f} minutes.",
        "",
        *settings_table(s),
    ]
