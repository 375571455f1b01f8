"""Statistics of images and features, and what is computed of them: histograms, equalization, whitening."""

import math
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import Frames, Spec, TensorSpec, Tolerance, image
from . import STENCIL, add, rejected
from .enhance import OUTPUT, SUMS, of_levels

# --- equalization -------------------------------------------------------------------------------------------

add(
    Spec(
        "enhance.equalize",
        [image()],
        OUTPUT,
        gradients=(),
        peer=of_levels(lambda ops, x: ops.equalize(x)),
        reference="Pillow ImageOps.equalize",
        frames=Frames(
            peer=Peer(
                "PIL.ImageOps",
                lambda ops, x: ops.equalize(x),
                "planes",
                before=lambda x: (Image.fromarray(x),),
            )
        ),
    )
)


def _folded(made: tuple[Any, list[Any]]) -> np.ndarray:
    return np.reshape([np.asarray(image) for image in made[1]], made[0]) / 255


def _unfolded(volumes: np.ndarray) -> tuple[Any, ...]:
    levels = np.floor(255 * volumes + 0.5).astype(np.uint8)
    return volumes.shape, [Image.fromarray(x.reshape(-1, x.shape[-1])) for x in levels]


add(
    Spec(
        "enhance.equalize3d",
        [TensorSpec("input", ("B", "C", "D", "H", "W"), layout="NCDHW", description="batch of volumes")],
        [TensorSpec("output", layout="NCDHW")],
        symbols={"D": (1, 4096)},
        gradients=(),
        peer=Peer(
            "PIL.ImageOps",
            lambda ops, shape, images: (shape, [ops.equalize(image) for image in images]),
            "samples",
            before=_unfolded,
            after=_folded,
        ),
        reference="Pillow ImageOps.equalize of the volume's values",
    )
)

add(
    Spec(
        "enhance.autocontrast",
        [image("image")],
        OUTPUT,
        config={"cutoff": (1.0, 2.5)},
        gradients=(),
        # where the exact result is a level, Pillow's may be the one below
        peer=of_levels(lambda ops, x: ops.autocontrast(x, (1.0, 2.5)), atol=1.001 / 255),
        reference="Pillow ImageOps.autocontrast",
        frames=Frames(
            peer=Peer(
                "PIL.ImageOps",
                lambda ops, x: ops.autocontrast(x, (1.0, 2.5)),
                "planes",
                atol=1,
                before=lambda x: (Image.fromarray(x),),
            )
        ),
        errors=rejected(
            "cutoff", "percentages that are not negative and sum to less than 100", (math.nan, 1.0)
        ),
    )
)


def _clahe(cv2: Any, x: np.ndarray) -> np.ndarray:
    return cv2.createCLAHE(4.0, (4, 3)).apply(x)


add(
    Spec(
        "enhance.clahe",
        [
            TensorSpec(
                "image",
                ("B", "C", "H", "W"),
                "uint8",
                layout="NCHW",
                range=(0, 255),
                description="image batch",
            )
        ],
        OUTPUT,
        config={"clip_limit": 4.0, "tile_grid_size": (4, 3)},
        symbols=STENCIL,
        peer=opencv(_clahe, "planes"),
        reference="OpenCV createCLAHE",
    )
)

add(
    Spec(
        "enhance.equalize_clahe",
        [image()],
        OUTPUT,
        config={"clip_limit": 4.0, "grid_size": (3, 4)},
        symbols=STENCIL,
        gradients=(),
        peer=opencv(
            _clahe,
            "planes",
            before=lambda x: (np.floor(255 * x + 0.5).astype(np.uint8),),
            after=lambda levels: levels / 255,
        ),
        reference="OpenCV createCLAHE",
        frames=Frames(peer=opencv(_clahe, "planes")),
    )
)

add(
    Spec(
        "enhance.equalize_clahe.differentiable",
        [image()],
        OUTPUT,
        config={"clip_limit": 4.0, "grid_size": (3, 4), "slow_and_differentiable": True},
        symbols=STENCIL,
        # the steepness of a tile's curve and the number of its pixels amplify rounding
        tolerances={"float32": Tolerance(1e-4, 1e-4)},
        gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},
        reference="enhance.equalize_clahe, from which it differs by the rounding that it leaves out",
    ),
    fn="enhance.equalize_clahe",
)

# --- moments, extremes, counts ------------------------------------------------------------------------------

_MEAN_STD = opencv(lambda cv2, x: cv2.meanStdDev(x), "planes", after=lambda m: (m[0][0, 0], m[1][0, 0]))

add(
    Spec(
        "enhance.mean_std_dev",
        [image("image")],
        [
            TensorSpec("mean", description="of each channel"),
            TensorSpec("std", description="standard deviation of each channel"),
        ],
        gradient_tolerances=SUMS,
        peer=_MEAN_STD,
        reference="OpenCV meanStdDev; NumPy mean and std in float64",
        frames=Frames(peer=_MEAN_STD),
    )
)


def _places(found: Any) -> tuple[Any, ...]:
    least, greatest, first, last = found
    return least, greatest, np.array(first), np.array(last)


_MIN_MAX = opencv(lambda cv2, x: cv2.minMaxLoc(x), "planes", after=_places)

add(
    Spec(
        "enhance.min_max_loc",
        [image("image")],
        [
            TensorSpec("least", description="of each channel"),
            TensorSpec("greatest", description="of each channel"),
            TensorSpec("least_at", description="the first place (x, y) of the least, in pixels"),
            TensorSpec("greatest_at", description="the first place (x, y) of the greatest, in pixels"),
        ],
        peer=_MIN_MAX,
        reference="OpenCV minMaxLoc",
        frames=Frames(peer=_MIN_MAX),
    )
)

add(
    Spec(
        "enhance.count_histogram",
        [image("image")],
        [TensorSpec("counts", description="pixels in each of 64 bins of [0, 1)")],
        config={"n_bins": 64, "min": 0.0, "max": 1.0},
        gradients=(),
        peer=opencv(lambda cv2, x: cv2.calcHist([x], [0], None, [64], [0, 1]), "planes"),
        reference="OpenCV calcHist",
        frames=Frames(
            config={"n_bins": 256, "max": 256.0},
            peer=opencv(lambda cv2, x: cv2.calcHist([x], [0], None, [256], [0, 256]), "planes"),
        ),
        picture="histogram",
        errors=rejected("max", "a number above min = 0.0", math.nan),
    )
)

# --- densities ----------------------------------------------------------------------------------------------

_BINS = TensorSpec("bins", ("K",), description="centres of the bins")
_BANDWIDTH = TensorSpec("bandwidth", (1,), range=(0.1, 0.2), description="standard deviation of the kernel")

#: The gradient of a parameter that all values share is a sum over them.
_DENSITY_SUMS = {"float32": Tolerance(1e-3, 1e-3)}

add(
    Spec(
        "enhance.histogram",
        [TensorSpec("x", ("B", "N"), description="values"), _BINS, _BANDWIDTH],
        [TensorSpec("density")],
        config={"epsilon": 1e-10},
        symbols={"K": (2, 4096)},
        gradient_tolerances=_DENSITY_SUMS,
        reference="the definition in NumPy float64; SciPy gaussian_kde",
        picture="histogram",
    )
)

add(
    Spec(
        "enhance.histogram2d",
        [
            TensorSpec("x1", ("B", "N"), description="values"),
            TensorSpec("x2", ("B", "N"), description="values paired with them"),
            _BINS,
            _BANDWIDTH,
        ],
        [TensorSpec("density")],
        config={"epsilon": 1e-10},
        symbols={"K": (2, 4096)},
        gradient_tolerances=_DENSITY_SUMS,
        reference="the definition in NumPy float64",
        picture="joint density",
    )
)

for _kernel in ("triangular", "gaussian", "uniform", "epanechnikov"):
    add(
        Spec(
            f"enhance.image_histogram2d.{_kernel}",
            [image("image")],
            [
                TensorSpec("histogram", description="pixels in each of 16 bins"),
                TensorSpec("density", description="the same, of sum 1"),
            ],
            config={"min": 0.0, "max": 1.0, "n_bins": 16, "return_pdf": True, "kernel": _kernel},
            # sums over all pixels
            tolerances={"float32": Tolerance(1e-3, 1e-4)},
            gradients=() if _kernel == "uniform" else None,
            reference="the definition in NumPy float64",
            picture="histogram",
            errors=rejected("bandwidth", "a positive number", math.nan),
        ),
        fn="enhance.image_histogram2d",
    )

# --- linear transforms of features --------------------------------------------------------------------------

add(
    Spec(
        "enhance.linear_transform",
        [
            TensorSpec("inp", ("N", 5), description="samples"),
            TensorSpec("transform_matrix", (5, 5)),
            TensorSpec("mean_vector", (1, 5)),
        ],
        [TensorSpec("output")],
        gradient_tolerances=SUMS,
        peer=Peer("numpy", lambda np, x, matrix, mean: (x - mean) @ matrix, "batch"),
        reference="NumPy matrix product",
        picture="whitening",
    )
)


def _make_features(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Correlated features, of the scale of pixels; more samples than features, so that their covariance has
    full rank."""
    import torch

    features = torch.rand((sizes["N"], 5), generator=generator, dtype=torch.float64)
    mixing = torch.tensor([[1.0, 0.5, 0.2, 0.0, 0.1]], dtype=torch.float64)
    return {"inp": (features + features[:, :1] * mixing).to(dtype)}


_FEATURES = [TensorSpec("inp", ("N", 5), description="samples")]

#: Dividing by the root of a small eigenvalue amplifies rounding.
_WHITENING = {"float32": Tolerance(1e-3, 1e-3)}

add(
    Spec(
        "enhance.zca_mean",
        _FEATURES,
        [
            TensorSpec("transform_matrix"),
            TensorSpec("mean_vector"),
            TensorSpec("inverse", description="inverse of transform_matrix"),
        ],
        config={"unbiased": True, "eps": 1e-4, "return_inverse": True},
        symbols={"N": (8, 1 << 20)},
        tolerances=_WHITENING,
        make_inputs=_make_features,
        reference="NumPy eigh",
        picture="matrices",
    )
)

add(
    Spec(
        "enhance.zca_whiten",
        _FEATURES,
        [TensorSpec("output")],
        config={"unbiased": True, "eps": 1e-4},
        symbols={"N": (8, 1 << 20)},
        tolerances=_WHITENING,
        make_inputs=_make_features,
        reference="NumPy eigh",
        picture="whitening",
    )
)
