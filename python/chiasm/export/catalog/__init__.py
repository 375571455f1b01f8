"""The catalog: every op that chiasm deploys, one spec each, in modules by family and subject.

An entry is a few declarative lines: see any of the modules. The function is found by the spec's name below
`chiasm`, or is named by `fn` where one function has several specs (a spec freezes its configuration).
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..spec import ErrorInput, Spec

#: Minimum sizes for ops that read neighbours: compiled code treats the borders separately from the middle,
#: which must not be empty.
STENCIL = {"H": (8, 32768), "W": (8, 32768)}
#: A reason for `special_values`: 0 times infinity is NaN.
ZERO_WEIGHTS = "some forms multiply by weights that are 0, which others leave out: NaN of what is not finite"


def rejected(
    argument: str, expected: str, *values: Any, error: type[Exception] = ValueError
) -> tuple[ErrorInput, ...]:
    """Values of an argument that an op rejects by "ARGUMENT: expected EXPECTED, got VALUE"."""
    return tuple(ErrorInput(argument, v, f"{argument}: expected {expected}, got {v}", error) for v in values)


def rejected_sizes(argument: str, count: int = 2) -> tuple[ErrorInput, ...]:
    """What ops reject as `count` sizes: one size too many, and a size that is not whole."""
    many = ErrorInput(argument, (3,) * (count + 1), f"{argument}: expected {count} numbers, got {count + 1}")
    return (many, *rejected(argument, "whole numbers", (3.0, 3, 3)[:count], error=TypeError))


def rejected_words(*arguments: str) -> tuple[ErrorInput, ...]:
    """A word that is none of the choices, for arguments that have some."""
    return tuple(ErrorInput(a, "other", f"{a}: expected one of") for a in arguments)


#: Public functions without a spec, and why; docs/coverage.md repeats it.
NOT_DEPLOYED = {
    **{
        f"filters.{name}": (
            "takes no tensor: its result is a constant, which an op that uses it has compiled into it (it"
            " scripts)"
        )
        for name in (
            "get_binary_kernel2d",
            "get_box_kernel1d",
            "get_box_kernel2d",
            "get_diff_kernel2d",
            "get_hanning_kernel1d",
            "get_hanning_kernel2d",
            "get_laplacian_kernel1d",
            "get_laplacian_kernel2d",
            "get_sobel_kernel2d",
            "get_spatial_gradient_kernel2d",
            "get_spatial_gradient_kernel3d",
            "laplacian_1d",
        )
    },
    **{
        f"color.{name}": (
            "a spec cannot say that one input is half as large as another: `color.planar_yuv_to_rgb`, whose"
            " chroma may have any size, is deployed for it"
        )
        for name in ("yuv420_to_rgb", "yuv422_to_rgb")
    },
    **{
        f"geometry.{name}": (
            "takes no tensor: its result is a constant, which an op that uses it has compiled into it (it"
            " scripts, and its sizes may be an image's)"
        )
        for name in (
            "conversions.normal_transform_pixel",
            "conversions.normal_transform_pixel3d",
            "grid.create_meshgrid",
            "grid.create_meshgrid3d",
        )
    },
    **{
        f"geometry.bbox.{name}": (
            f"returns a Python bool, whether all boxes are valid (it scripts): `geometry.bbox.is_{kind}`,"
            " which says it of each, is deployed for it"
        )
        for name, kind in (("validate_bbox", "bbox"), ("validate_bbox3d", "bbox3d"))
    },
    "feature.get_laf_descriptors": (
        "takes a module: `feature.get_laf_descriptors.sift`, with SIFT in its place, is deployed for it, and"
        " `LAFDescriptor` exports with any"
    ),
    "feature.only_matches": (
        "how many matches are left depends on the data (it scripts): the matchers, which return a row for"
        " each descriptor and a mask, are deployed for it"
    ),
    "geometry.epipolar.find_essential": (
        "the first output of `find_essential_5point`, which is deployed under its name"
    ),
    **{
        f"image.{name}": "takes or makes arrays of NumPy, text or files, which are eager Python's"
        for name in (
            "image_list_to_tensor",
            "image_to_string",
            "image_to_tensor",
            "print_image",
            "tensor_to_image",
        )
    },
    "contrib.compute_padding": (
        "takes no tensor: its result is an argument of `contrib.extract_tensor_patches` (it scripts)"
    ),
    "geometry.bbox.nms": (
        "how many boxes are left depends on the data (it scripts): `geometry.bbox.nms_fixed`, which returns"
        " all and a mask, is deployed for it"
    ),
    "ops.batched_nms": (
        "how many boxes are left depends on the data (it scripts): `ops.batched_nms_fixed`, with a fixed"
        " number of slots, is deployed for it"
    ),
    "ops.nms": "it is `geometry.bbox.nms`",
    "ops.remove_small_boxes": "how many boxes are left depends on the data (it scripts)",
}


#: Differentiable ops without a `vjp` in their bundles, and why; docs/coverage.md repeats it. Eager code and
#: TorchScript have their gradients.
NO_GRADIENT = {
    "contrib.diamond_square.normalized": (
        "the graph would be a copy of each of the loop's steps, of which large images have 15"
    ),
    "contrib.diamond_square.plain": (
        "the graph would be a copy of each of the loop's steps, of which large images have 15"
    ),
    "contrib.distance_transform": (
        "a loop until nothing changes, as many steps as the largest distance: no exported graph can go back"
        " through it"
    ),
    **{
        f"feature.detect_keypoints.{name}": (
            "minutes to compile: the same detector is deployed with its gradient for hessian and dog"
        )
        for name in ("harris", "gftt")
    },
    **{
        f"ops.{name}": (
            "its weight of the aspect ratio is a constant to the gradient, as its authors have it, so that it"
            " is no gradient of the value"
        )
        for name in ("complete_box_iou", "complete_box_iou_loss")
    },
    "filters.non_local_means": "the graph would be 121 copies of the loop's body",
    "geometry.epipolar.find_essential": "the graph would be a copy of each of the loops' steps",
    "pipelines.two_view_homography": (
        "an artifact of minutes to compile, whose parts are deployed with their gradients"
    ),
    "morphology.reconstruction": "a loop until nothing changes: no exported graph can go back through it",
}


@dataclass(frozen=True)
class Entry:
    """A spec and the path of its function below `chiasm`."""

    spec: Spec
    path: str

    def function(self) -> Callable[..., Any]:
        """The op."""
        module, _, name = self.path.rpartition(".")
        return getattr(importlib.import_module(f"chiasm.{module}"), name)


_entries: dict[str, Entry] = {}


def add(spec: Spec, fn: str | None = None) -> None:
    """Put an op into the catalog, and its form for frames if it has one."""
    for each in [spec] if spec.frames is None else [spec, spec.as_frames()]:
        if each.name in _entries:
            raise ValueError(f"the catalog has {each.name!r} already")
        _entries[each.name] = Entry(each, fn or spec.name)


def catalog() -> dict[str, Entry]:
    """All entries by name, in alphabetical order."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    return dict(sorted(_entries.items()))
