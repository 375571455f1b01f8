"""Which panels an op gets, and the caption under them."""

from __future__ import annotations

from collections.abc import Callable

from .compared import COMPARED
from .frames import FRAMES
from .geometry import GEOMETRY
from .images import gradient, images, kernels, keypoints, labels, picture
from .matches import MATCHES
from .model import Panel, Shown, numbers
from .patches import PATCHES
from .pieces import PIECES
from .scores import SCORES
from .solid import volumes
from .statistics import histogram, joint_density, matrices, whitening


def panels(shown: Shown) -> list[Panel]:
    """Inputs first."""
    parts = sorted(name for name in SPECIAL if shown.spec.name.startswith(name))
    return SPECIAL[parts[-1]](shown) if parts else images(shown)


def caption(shown: Shown, made: list[Panel]) -> str:
    """Configuration, values of the inputs and outputs that are no pictures, and how values were mapped to
    colours."""
    said = [", ".join(f"{k}={v!r}" for k, v in shown.spec.config.items())]
    seen = {name for p in made for name in (*p.label.split(", "), *p.label.split()[:1])}
    said += [
        numbers(n, t) for n, t in shown.inputs.items() if 0 < t.numel() <= 9 and n not in seen and n != "M"
    ]
    said += [numbers(n, t) for n, t in shown.outputs.items() if t.numel() <= 4 and n not in seen]
    labels = {p.note: [q.label for q in made if q.note == p.note] for p in made if p.note}
    said += [
        note if len(names) == len(made) else f"{', '.join(dict.fromkeys(names))}: {note}"
        for note, names in labels.items()
    ]
    return "; ".join(s for s in said if s)


#: By the beginning of an op's name: what has no image to show, or another than its layout says.
SPECIAL: dict[str, Callable[[Shown], list[Panel]]] = {
    "contrib.connected_components": labels,
    "contrib.interp": picture,
    "enhance.count_histogram": histogram,
    "enhance.histogram": histogram,
    "enhance.histogram2d": joint_density,
    "enhance.image_histogram2d": histogram,
    "enhance.linear_transform": whitening,
    "enhance.zca_mean": matrices,
    "enhance.zca_whiten": whitening,
    "feature.dog_response": volumes,
    "feature.dog_response_single": images,
    "feature.harris_keypoints": keypoints,
    "filters.gaussian": kernels,
    "filters.gaussian_blur2d": picture,
    "filters.get_": kernels,
    "filters.spatial_gradient": gradient,
    **GEOMETRY,
    **PIECES,
    **FRAMES,
    **PATCHES,
    **MATCHES,
    **COMPARED,
    **SCORES,
}
