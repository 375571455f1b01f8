"""Chooses an op's panels, and writes the caption under them."""

from __future__ import annotations

from collections.abc import Callable

from chiasm.export.spec import Spec

from . import (
    compared,
    curves,
    frames,
    images,
    matches,
    patches,
    photographed,
    pieces,
    planar,
    scores,
    solid,
    statistics,
    tensors,
    views,
    warps,
)
from .model import Panel, Shown, numbers

#: The functions that draw the pictures that specs name.
PICTURES: dict[str, Callable[[Shown], list[Panel]]] = {
    "SIFT descriptors": patches.glyphs,
    "areas under a curve": scores.areas,
    "boxes": planar.plane_boxes,
    "boxes in space": solid.space_boxes,
    "classes": compared.each_class,
    "clusters": pieces.posterised,
    "comparison": compared.compared,
    "confusion matrix": scores.confusion,
    "dense descriptors": patches.dense,
    "depth images": solid.depth_images,
    "derivatives": images.gradient,
    "detected keypoints": frames.detected,
    "detections": scores.precisions,
    "drift": scores.drift,
    "ellipses of patches": patches.shapes,
    "epipolar lines": views.two_views,
    "epipolar lines on photographs": photographed.stereo_views,
    "fitted lines and planes": curves.fit,
    "fitted maps": planar.fitted,
    "heat maps": warps.rendered,
    "histogram": statistics.histogram,
    "image output": images.picture,
    "images": images.images,
    "images with values": compared.series,
    "joint density": statistics.joint_density,
    "kernels": images.kernels,
    "keypoints": images.keypoints,
    "labels": images.labels,
    "local affine frames": frames.frames,
    "maps of space": solid.space_maps,
    "maps of the plane": planar.plane_maps,
    "matches": matches.matches,
    "matrices": statistics.matrices,
    "mean colours": patches.means,
    "mean rotation": curves.mean_rotation,
    "orientations": patches.orientations,
    "overlaps": scores.overlaps,
    "pairs of planes": compared.pairs(compared.planes),
    "pairs of signals": compared.pairs(compared.signals),
    "patches": patches.extracted,
    "point clouds": solid.depth_clouds,
    "polynomials": curves.polynomials,
    "pose errors": scores.pose_errors,
    "proposed keypoints": frames.proposed,
    "quadrilaterals": planar.quadrilaterals,
    "ranking": scores.ranking,
    "registered views": matches.two_views,
    "reordered descriptor": patches.layouts,
    "rows of descriptors": patches.rows,
    "tensors": tensors.tensors,
    "terrain": pieces.terrain,
    "values of classes": scores.class_values,
    "volumes": solid.volumes,
    "warps": warps.warps,
    "whitening": statistics.whitening,
    "windows": pieces.windows,
}


def picture_of(spec: Spec) -> str:
    """The name of an op's picture: the spec's, or else images if the op returns any."""
    name = spec.picture or ("images" if any(t.layout for t in spec.outputs) else "tensors")
    if name not in PICTURES:
        raise ValueError(
            f"spec {spec.name!r}: the gallery has no picture {name!r}: add it to PICTURES in"
            " gallery/panels/choice.py, or name one of those there"
        )
    return name


def panels(shown: Shown) -> list[Panel]:
    """Inputs first."""
    return PICTURES[picture_of(shown.spec)](shown)


def caption(shown: Shown, made: list[Panel]) -> str:
    """The configuration, the values of inputs and outputs that are not pictures, and how values were mapped
    to colours."""
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
