"""Functions under Kornia's names give Kornia's results, but for those that docs/kornia.md lists.

`make test-ops` installs Kornia (tools/kornia.sh); without it this is left out.
"""

import importlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from test_catalog import arguments
from torch import Tensor

from chiasm.export.catalog import Entry, catalog

sys.path.append(str(Path(__file__).resolve().parents[2] / ".deps/kornia"))
pytest.importorskip("kornia")

SIZES = {"B": 2, "C": 3, "H": 22, "W": 18, "N": 9, "OH": 8, "OW": 11}
#: Functions whose results differ, which docs/kornia.md explains.
DIFFERENT = {
    "color.lab_to_rgb",
    "color.luv_to_rgb",
    "color.normals_to_rgb255",
    "color.rgb_to_lab",
    "color.rgb_to_luv",
    "color.rgb_to_rgb255",
    "color.rgb_to_yuv",
    "color.rgb_to_yuv420",
    "color.rgb_to_yuv422",
    "color.rgba_to_bgr",
    "color.ycbcr_to_rgb",
    "color.yuv_to_rgb",
    "contrib.interp",
    "enhance.equalize",
    "enhance.equalize3d",
    "enhance.equalize_clahe",
    "enhance.jpeg_codec_differentiable",
    "enhance.posterize",
    "feature.extract_patches_from_pyramid",
    "feature.match_smnn_batched",
    "feature.perspective_transform_lafs",
    "filters.otsu_threshold",
    "geometry.bbox.bbox_to_mask3d",
    "geometry.calibration.solve_pnp_dlt",
    "geometry.conversions.ARKitQTVecs_to_ColmapQTVecs",
    "geometry.conversions.ColmapQTVecs_to_ARKitQTVecs",
    "geometry.conversions.rotation_matrix_to_quaternion",
    "geometry.epipolar.decompose_essential_matrix",
    "geometry.epipolar.find_essential",
    "geometry.epipolar.motion_from_essential",
    "geometry.epipolar.motion_from_essential_choose_solution",
    "geometry.epipolar.scale_intrinsics",
    "geometry.homography.find_homography_dlt",
    "geometry.homography.find_homography_dlt_iterated",
    "geometry.homography.find_homography_lines_dlt",
    "geometry.homography.find_homography_lines_dlt_iterated",
    "geometry.solvers.solve_cubic",
    "geometry.transform.build_laplacian_pyramid",
    "geometry.transform.get_affine_matrix3d",
    "geometry.transform.get_shear_matrix3d",
    "image.draw_rectangle",
    "metrics.accuracy",
}


def kornias(name: str) -> Callable[..., Any] | None:
    """Kornia's function of a spec's name, or the nearest one: modules below `geometry` are geometry's too."""
    family, *path = name.split(".")
    for module in (".".join(["kornia", family, *path[:-1]]), f"kornia.{family}"):
        try:
            found = getattr(importlib.import_module(module), path[-1], None)
        except ModuleNotFoundError:
            continue
        if inspect.isfunction(found):
            return found
    return None


def tensors_of(result: Any) -> list[Tensor]:
    if isinstance(result, Tensor):
        return [result]
    return [one for part in result for one in tensors_of(part)]


def is_near(a: Tensor, b: Tensor) -> bool:
    size = 1.0 + float(b[b.isfinite()].abs().max()) if bool(b.isfinite().any()) else 1.0
    return torch.allclose(a, b, rtol=1e-5, atol=1e-6 * size, equal_nan=True)


def shared() -> dict[str, tuple[Entry, Callable[..., Any]]]:
    """The specs without sizes in tensors, and Kornia's functions of their names."""
    plain = {n: e for n, e in catalog().items() if not any(t.sizes for t in e.spec.inputs)}
    found = {name: (entry, kornias(name)) for name, entry in plain.items() if not entry.spec.interleaved}
    return {name: (entry, theirs) for name, (entry, theirs) in found.items() if theirs is not None}


SHARED = shared()


@pytest.mark.parametrize("name", SHARED)
def test_results_are_kornias(name: str) -> None:
    entry, theirs = SHARED[name]
    made = arguments(entry, SIZES, "float64")
    given = dict(zip([t.name for t in entry.spec.inputs], made, strict=True)) | entry.spec.config
    copies = {n: v.clone() if isinstance(v, Tensor) else v for n, v in given.items()}
    try:
        wanted = tensors_of(theirs(**copies))
    except Exception as error:  # it takes fewer shapes, or other arguments
        pytest.skip(f"Kornia: {error}")
    found = tensors_of(entry.function()(**given))
    same = [a.shape == b.shape and is_near(a.double(), b.double()) for a, b in zip(found, wanted)]
    assert (len(found) == len(wanted) and all(same)) == (name not in DIFFERENT)
