"""Ops that fit no other family."""

import math
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import Frames, Spec, TensorSpec, Tolerance, image
from . import STENCIL, add, rejected

# --- histogram ----------------------------------------------------------------------------------------------


def _make_interp(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    n = sizes["N"]
    # knots at even distances, moved by less than half of them, and values of x within and beyond
    knots = (torch.arange(n) + 0.6 * torch.rand(n, generator=generator, dtype=torch.float64)) / n
    x = (
        torch.rand((sizes["B"], sizes["C"], sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
        * 1.4
        - 0.2
    )
    return {
        "x": x.to(dtype),
        "xp": knots.to(dtype),
        "fp": torch.rand(n, generator=generator, dtype=torch.float64).to(dtype),
    }


add(
    Spec(
        "contrib.interp",
        [
            image("x"),
            TensorSpec("xp", ("N",), description="ascending knots"),
            TensorSpec("fp", ("N",), description="values at the knots"),
        ],
        [TensorSpec("output")],
        symbols={"N": (2, 1 << 20)},
        make_inputs=_make_interp,
        # slopes amplify the rounding of x, and the gradient of a knot is a sum over all values next to it
        tolerances={"float32": Tolerance(1e-4, 1e-4)},
        gradient_tolerances={"float32": Tolerance(1e-2, 1e-3)},
        peer=Peer("numpy", lambda np, x, xp, fp: np.interp(x, xp, fp), "batch"),
        special_values="a table with a NaN has no order",
        reference="numpy.interp",
        picture="image output",
    )
)

add(
    Spec(
        "contrib.histogram_matching",
        [
            image("source"),
            TensorSpec(
                "template",
                ("B", "C", "OH", "OW"),
                layout="NCHW",
                description="image whose histogram is wanted",
            ),
        ],
        [TensorSpec("output", layout="NCHW")],
        config={"per_plane": True},
        symbols={"OH": (1, 32768), "OW": (1, 32768)},
        gradients=(),
        peer=Peer(
            "skimage.exposure",
            lambda exposure, x, template: exposure.match_histograms(x, template),
            "planes",
            before=lambda x, template: (np.floor(255 * x + 0.5), np.floor(255 * template + 0.5)),
            after=lambda matched: matched / 255,
        ),
        reference="scikit-image match_histograms on bytes",
    )
)

# --- shapes -------------------------------------------------------------------------------------------------


def _shapes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Binary images with two of five pixels set, a density at which shapes are longest and most winding."""
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"image": (torch.rand(shape, generator=generator) < 0.4).to(dtype)}


def _sparse(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Binary images with few pixels set."""
    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"image": (torch.rand(shape, generator=generator) < 0.02).to(dtype)}


def _sparse_volumes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Binary volumes with few voxels set."""
    shape = (sizes["B"], sizes["C"], sizes["D"], sizes["H"], sizes["W"])
    return {"image": (torch.rand(shape, generator=generator) < 0.01).to(dtype)}


def _dense(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Binary images with few clear pixels, at least one in every plane: distances are finite."""
    made = 1.0 - _sparse(generator, sizes, dtype)["image"]
    made[:, :, 3, 5] = 0.0
    return {"image": made}


def _as_bytes(x: Any):
    return ((x > 0).astype(np.uint8),)


def _by_first_pixel(labels: Any) -> Any:
    """Labels as chiasm's: 1 + the index of a shape's first pixel."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    return np.where(labels > 0, 1 + np.reshape(first[inverse], labels.shape), 0)


_COMPONENTS = opencv(
    lambda cv2, x: cv2.connectedComponents(x)[1], "planes", before=_as_bytes, after=_by_first_pixel
)
_BINARY = image("image", description="binary image batch, set above 0")

add(
    Spec(
        "contrib.connected_components",
        [_BINARY],
        [
            TensorSpec(
                "labels",
                layout="NCHW",
                description="0 where not set, else 1 + the index of the shape's first pixel",
            )
        ],
        config={"num_iterations": 100},
        symbols=STENCIL,
        gradients=(),
        make_inputs=_shapes,
        peer=_COMPONENTS,
        reference="SciPy label up to the names of the labels",
        picture="labels",
        frames=Frames(),
    )
)

add(
    Spec(
        "contrib.connected_components_union_find",
        [_BINARY],
        [
            TensorSpec(
                "labels",
                layout="NCHW",
                description="0 where not set, else 1 + the index of the shape's first pixel",
            )
        ],
        symbols=STENCIL,
        gradients=(),
        make_inputs=_shapes,
        peer=_COMPONENTS,
        reference="SciPy label up to the names of the labels",
        picture="labels",
        frames=Frames(),
    )
)


def _with_stats(cv2: Any, x: np.ndarray) -> tuple[Any, ...]:
    count, labels, stats, centroids = cv2.connectedComponentsWithStats(x)
    _, first = np.unique(labels, return_index=True)
    order = np.concatenate([[0], 1 + np.argsort(first[1:])])
    rest = ((0, max(0, 64 - count)), (0, 0))
    rows = [np.pad(values[order][:64], rest) for values in (stats, centroids)]
    return np.argsort(order)[labels], count, *rows


add(
    Spec(
        "contrib.connected_components_with_stats",
        [_BINARY],
        [
            TensorSpec("labels", layout="NCHW", description="0 where not set, else the shape's number"),
            TensorSpec("count", description="number of labels, with the background's"),
            TensorSpec("boxes", description="left, top, width, height, area of each label"),
            TensorSpec("centroids", description="x and y of each label"),
        ],
        config={"max_labels": 64},
        symbols=STENCIL,
        gradients=(),
        make_inputs=_shapes,
        peer=opencv(_with_stats, "planes", before=_as_bytes),
        reference="OpenCV connectedComponentsWithStats, up to the order of the labels",
        picture="labels",
        frames=Frames(),
        errors=rejected("max_labels", "1 to 32767", 0, 32768),
    )
)

add(
    Spec(
        "contrib.distance_transform",
        [image("image", description="binary image batch, 1 on the shapes")],
        [TensorSpec("output", layout="NCHW", description="distance to the nearest shape")],
        config={"kernel_size": 3, "h": 0.35},
        symbols=STENCIL,
        gradients=(),
        make_inputs=_sparse,
        reference="the definition in NumPy float64; SciPy distance_transform_edt to within its approximation",
        errors=rejected("h", "a positive number", math.nan),
    )
)

add(
    Spec(
        "contrib.distance_transform.volume",
        [
            TensorSpec(
                "image",
                ("B", "C", "D", "H", "W"),
                layout="NCDHW",
                range=(0.0, 1.0),
                description="binary volumes, 1 on the shapes",
            )
        ],
        [TensorSpec("output", layout="NCDHW", description="distance to the nearest shape")],
        config={"kernel_size": 3, "h": 0.35},
        symbols={"D": (8, 4096), "H": (8, 32768), "W": (8, 32768)},
        gradients=(),
        make_inputs=_sparse_volumes,
        reference="the definition in NumPy float64, by SciPy's correlate",
    ),
    fn="contrib.distance_transform",
)

add(
    Spec(
        "contrib.distance_transform_edt",
        [_BINARY],
        [TensorSpec("output", layout="NCHW", description="distance to the nearest pixel that is not set")],
        symbols=STENCIL,
        gradients=(),
        make_inputs=_dense,
        peer=opencv(
            lambda cv2, x: cv2.distanceTransform(x, cv2.DIST_L2, cv2.DIST_MASK_PRECISE),
            "planes",
            before=_as_bytes,
        ),
        reference="SciPy distance_transform_edt",
        frames=Frames(),
    )
)

# --- patches ------------------------------------------------------------------------------------------------

_PATCHES = TensorSpec("patches", description="the windows, row after row")
_PATCHED: dict[str, Any] = {
    "picture": "windows",
    "config": {"window_size": (4, 3), "stride": (2, 3), "padding": (1, 2)},
    "symbols": STENCIL,
    "reference": "NumPy sliding_window_view",
}

_PADDED_TO_FIT: dict[str, Any] = {
    **_PATCHED,
    "config": {"window_size": (5, 4), "stride": (3, 5), "allow_auto_padding": True},
}


def _unfolded(F: Any, x: Tensor) -> Tensor:
    return F.unfold(x, (4, 3), padding=(1, 2), stride=(2, 3)).transpose(1, 2).unflatten(2, (-1, 4, 3))


def _folded(F: Any, patches: Tensor) -> Tensor:
    """The means where windows overlap."""
    columns = patches.flatten(2).transpose(1, 2)
    total, count = (F.fold(x, (16, 26), (4, 5), stride=(2, 3)) for x in (columns, torch.ones_like(columns)))
    return (total / count)[..., 1:, 2:-1]


add(
    Spec(
        "contrib.extract_tensor_patches.padded",
        [image()],
        [_PATCHES],
        peer=Peer("torch.nn.functional", _unfolded, "tensors", timed=False),
        **_PATCHED,
    ),
    fn="contrib.extract_tensor_patches",
)
add(
    Spec(
        "contrib.extract_tensor_patches.fitted",
        [image()],
        [_PATCHES],
        **_PADDED_TO_FIT,
    ),
    fn="contrib.extract_tensor_patches",
)
add(
    Spec(
        "contrib.combine_tensor_patches",
        [TensorSpec("patches", ("B", 56, "C", 4, 5), description="7 x 8 windows of an image of 15 x 23")],
        [TensorSpec("output", layout="NCHW", description="the image")],
        config={
            "original_size": (15, 23),
            "window_size": (4, 5),
            "stride": (2, 3),
            "unpadding": (1, 0, 2, 1),
        },
        peer=Peer("torch.nn.functional", _folded, "tensors", timed=False),
        reference="a loop in NumPy",
        picture="windows",
    )
)

# --- clusters and textures ----------------------------------------------------------------------------------


def _make_points(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Points around as many middles as there are centres; the initial centres are nearby."""
    count, clusters, axes = sizes["N"], sizes["K"], sizes["C"]
    middles = torch.rand((clusters, axes), generator=generator, dtype=torch.float64) * 10
    which = torch.randint(0, clusters, (count,), generator=generator)
    x = middles[which] + torch.randn((count, axes), generator=generator, dtype=torch.float64)
    start = middles + torch.randn((clusters, axes), generator=generator, dtype=torch.float64)
    return {"x": x.to(dtype), "centers": start.to(dtype)}


add(
    Spec(
        "contrib.kmeans",
        [
            TensorSpec("x", ("N", "C"), description="points"),
            TensorSpec("centers", ("K", "C"), description="first centres"),
        ],
        [
            TensorSpec("means", description="centres"),
            TensorSpec("labels", description="the nearest centre of each point"),
        ],
        config={"num_iterations": 8},
        symbols={"N": (2, 1 << 20), "K": (2, 4096)},
        gradients=("x",),
        make_inputs=_make_points,
        peer=Peer(
            "sklearn.cluster",
            lambda cluster, x, centers: cluster.KMeans(
                len(centers), init=centers, n_init=1, max_iter=8, tol=0
            ).fit(x),
            "batch",
            after=lambda found: (found.cluster_centers_, found.labels_),
            sizes={"N": 80, "K": 7},  # fewer clusters than points
            timed=False,
        ),
        reference="scikit-learn KMeans",
        picture="clusters",
    )
)

_RANDOM = image("random", range=(-1.0, 1.0), description="a random number for each pixel")
add(
    Spec(
        "contrib.diamond_square.plain",
        [_RANDOM],
        [TensorSpec("texture", layout="NCHW")],
        symbols=STENCIL,
        gradients=(),
        reference="the recursion in Python",
        picture="terrain",
    ),
    fn="contrib.diamond_square",
)
add(
    Spec(
        "contrib.diamond_square.normalized",
        [
            _RANDOM,
            TensorSpec(
                "roughness",
                ("B",),
                range=(0.4, 0.8),
                description="factor of the displacement from step to step",
            ),
        ],
        [TensorSpec("texture", layout="NCHW", range=(0.0, 1.0))],
        config={"random_scale": 0.7, "normalize_range": (0.0, 1.0)},
        symbols=STENCIL,
        gradients=(),
        reference="the recursion in Python",
        picture="terrain",
    ),
    fn="contrib.diamond_square",
)
