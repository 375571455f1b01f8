"""Filters: kernels."""

import math
from typing import Any

import numpy as np

from ..peer import Peer, opencv
from ..spec import Spec, TensorSpec
from . import add, rejected

NOT_POSITIVE = (0.0, -1.0, math.nan)
NOT_SIGMA = rejected("sigma", "a positive number", *NOT_POSITIVE)
NOT_SIGMAS = rejected("sigma", "positive numbers", (0.0, 1.0), (1.0, -2.0), (math.nan, 1.0))
NOT_SIGMAS_3D = rejected("sigma", "positive numbers", (1.0, math.nan, 1.0))
SIGMA = TensorSpec("sigma", ("B",), range=(0.5, 3.0), description="standard deviations in pixels")
KERNELS = [TensorSpec("kernel", description="one kernel for each entry")]


def _of_sum_1(taps: np.ndarray) -> np.ndarray:
    return taps / taps.sum()


add(
    Spec(
        "filters.gaussian",
        [SIGMA, TensorSpec("mean", ("B",), range=(1.0, 4.0), description="positions of the maxima")],
        KERNELS,
        config={"window_size": 5},
        peer=Peer(
            "scipy.stats",
            lambda stats, sigma, mean: stats.norm.pdf(np.arange(5), mean, sigma),
            "samples",
            after=_of_sum_1,
        ),
        reference="SciPy stats.norm.pdf",
        picture="kernels",
        errors=NOT_SIGMA,
    )
)

_TAPS = opencv(lambda cv2, sigma: cv2.getGaussianKernel(5, sigma)[:, 0], "samples", timed=False)

_TAPS_2D = opencv(
    lambda cv2, sigma: np.outer(cv2.getGaussianKernel(5, sigma[0]), cv2.getGaussianKernel(3, sigma[1])),
    "samples",
    timed=False,
)


def _taps_3d(cv2: Any, sigma: np.ndarray) -> Any:
    z, y, x = (cv2.getGaussianKernel(n, s)[:, 0] for n, s in zip((3, 5, 3), sigma.tolist(), strict=True))
    return z[:, None, None] * np.outer(y, x)


_TAPS_3D = opencv(_taps_3d, "samples", timed=False)
_STEPS = Peer(
    "scipy.stats",
    lambda stats, sigma: np.diff(stats.norm.cdf(np.arange(-2.5, 3), scale=sigma)),
    "samples",
    after=_of_sum_1,
    timed=False,
)
_BESSEL = Peer(
    "scipy.special",
    lambda special, sigma: special.ive(np.arange(-2, 3), sigma**2),
    "samples",
    after=_of_sum_1,
    timed=False,
)

for _name, _size, _axes, _reference, _peer in (
    ("get_gaussian_kernel1d", 5, 1, "OpenCV getGaussianKernel", _TAPS),
    ("get_gaussian_erf_kernel1d", 5, 1, "SciPy stats.norm.cdf", _STEPS),
    ("get_gaussian_discrete_kernel1d", 5, 1, "SciPy special.ive", _BESSEL),
    ("get_gaussian_kernel2d", (5, 3), 2, "OpenCV getGaussianKernel", _TAPS_2D),
    ("get_gaussian_kernel3d", (3, 5, 3), 3, "OpenCV getGaussianKernel", _TAPS_3D),
):
    _sigma = (
        SIGMA
        if _axes == 1
        else TensorSpec(
            "sigma", ("B", _axes), range=(0.5, 3.0), description="standard deviations, the last is x's"
        )
    )
    add(
        Spec(
            f"filters.{_name}",
            [_sigma],
            KERNELS,
            config={"kernel_size": _size},
            peer=_peer,
            reference=_reference,
            errors=NOT_SIGMA if _axes == 1 else NOT_SIGMAS if _axes == 2 else NOT_SIGMAS_3D,
            picture="kernels",
        )
    )

ANGLE = TensorSpec("angle", ("B",), range=(-180.0, 180.0), description="degrees, counterclockwise")
TURN = TensorSpec("angle", ("B", 3), range=(-90.0, 90.0), description="rotation vectors (x, y, z) in degrees")

DIRECTION = TensorSpec(
    "direction", ("B",), range=(-0.9, 0.9), description="-1 to 1: where along the line the weight is"
)

add(
    Spec(
        "filters.get_motion_kernel2d",
        [ANGLE, DIRECTION],
        KERNELS,
        config={"kernel_size": 5, "mode": "bilinear"},
        reference="SciPy affine_transform(order=1)",
        picture="kernels",
    )
)

add(
    Spec(
        "filters.get_motion_kernel3d",
        [TURN, DIRECTION],
        KERNELS,
        config={"kernel_size": 5, "mode": "nearest"},
        gradients=("direction",),
        reference="SciPy affine_transform(order=0)",
        picture="kernels",
    )
)

WAVE = [
    SIGMA,
    TensorSpec("theta", ("B",), range=(-3.0, 3.0), description="directions in radians"),
    TensorSpec("lambd", ("B",), range=(3.0, 8.0), description="wavelengths in pixels"),
]

add(
    Spec(
        "filters.get_gabor_kernel2d",
        [
            *WAVE,
            TensorSpec("gamma", ("B",), range=(0.3, 1.5), description="aspect ratios"),
            TensorSpec("psi", ("B",), range=(-3.0, 3.0), description="phases"),
        ],
        KERNELS,
        config={"kernel_size": (5, 9)},
        peer=opencv(
            lambda cv2, sigma, theta, wave, gamma, psi: cv2.getGaborKernel(
                (9, 5), sigma, theta, wave, gamma, psi
            ),
            "samples",
            timed=False,
        ),
        reference="OpenCV getGaborKernel",
        picture="kernels",
    )
)
