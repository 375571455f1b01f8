"""The wheel's versions of bench/opencv_peers: OpenCV's calls for the same work as a bundle, with matrices
that are reused."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

#: `into(key, function, ...)` calls a function of OpenCV; `dst` is a matrix that is reused for the same key.
Into = Callable[..., np.ndarray]
REFLECT = cv2.BORDER_REFLECT_101
CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (5, 5))
LAPLACIAN = (np.ones((3, 3)) - 9 * np.pad([[1.0]], 1)).astype(np.float32) / 16


class Peer(NamedTuple):
    """A call on all images of a batch, and its result: (B, H, W, C), or planes (B * C, H, W, 1)."""

    call: Callable[[], object]
    results: Callable[[], np.ndarray]


def opencv(bundle: str, inputs: list[np.ndarray]) -> Peer:
    """OpenCV's matrices are prepared here, outside of the call."""
    return peer(*PEERS[bundle], inputs)


def peer(form: Callable, function: Callable, inputs: list[np.ndarray]) -> Peer:
    """The call of `function` on each of the matrices that `form` makes of the first input."""
    matrices = form(inputs[0])
    kept: list[dict[str, np.ndarray]] = [{} for _ in matrices]
    last: list[np.ndarray] = [matrices[0]] * len(matrices)

    def bound(mine: dict[str, np.ndarray]) -> Into:
        def into(key: str, call: Callable, *arguments, dst: str = "dst", **options) -> np.ndarray:
            made = call(*arguments, **{dst: mine.get(key)}, **options)
            mine[key] = made[1] if isinstance(made, tuple) else made
            return mine[key]

        return into

    intos = [bound(k) for k in kept]
    others = form(inputs[2]) if len(inputs) > 2 and inputs[2].shape == inputs[0].shape else matrices

    def call() -> None:
        for i, (matrix, other, into) in enumerate(zip(matrices, others, intos, strict=True)):
            last[i] = function(into, matrix, inputs, other)

    return Peer(call, lambda: np.stack([m if m.ndim == 3 else m[..., None] for m in last]))


# --- OpenCV's forms of (B, C, H, W) -------------------------------------------------------------------------


def images(x: np.ndarray) -> list[np.ndarray]:
    return [np.ascontiguousarray(i.transpose(1, 2, 0)) for i in x]


def byte_planes(x: np.ndarray) -> list[np.ndarray]:
    return list((x if x.dtype == np.uint8 else np.rint(x * 255).astype(np.uint8)).reshape(-1, *x.shape[2:]))


def float_planes(x: np.ndarray) -> list[np.ndarray]:
    return list(x.reshape(-1, *x.shape[2:]))


def frame(x: np.ndarray) -> list[np.ndarray]:
    return [x]


# --- work on one matrix -------------------------------------------------------------------------------------


def sobel(into: Into, m, x, other, border=cv2.BORDER_REPLICATE, scale=1 / 8):
    dx = into("dx", cv2.Sobel, m, cv2.CV_32F, 1, 0, ksize=3, scale=scale, borderType=border)
    dy = into("dy", cv2.Sobel, m, cv2.CV_32F, 0, 1, ksize=3, scale=scale, borderType=border)
    flat = dx.reshape(dx.shape[0], -1), dy.reshape(dy.shape[0], -1)
    return into("magnitude", cv2.magnitude, *flat, dst="magnitude").reshape(m.shape)


def edges(into: Into, m, x, other):
    grey = into("grey", cv2.cvtColor, m, cv2.COLOR_BGR2GRAY)
    magnitude = sobel(
        into, into("blur", cv2.GaussianBlur, grey, (5, 5), 1.0), x, other, cv2.BORDER_DEFAULT, 1.0
    )
    return into("out", cv2.convertScaleAbs, magnitude)


def preprocess(into: Into, m, x, other):
    small = into("small", cv2.resize, m, (224, 224), interpolation=cv2.INTER_LINEAR)
    return (
        cv2.dnn.blobFromImage(small, 1 / (255 * 0.226), None, (123.675, 116.28, 103.53), True)
        if hasattr(cv2, "dnn")
        else small
    )


def gaussian(into: Into, m, x, other):
    sigma = float(x[1].flat[0])
    return into("out", cv2.GaussianBlur, m, (5, 5), sigma, sigmaY=sigma, borderType=REFLECT)


def unsharp(into: Into, m, x, other):
    return into(
        "out",
        cv2.addWeighted,
        m,
        2,
        into("blur", cv2.GaussianBlur, m, (5, 5), 1.5, sigmaY=1.5, borderType=REFLECT),
        -1,
        0,
    )


def canny(into: Into, m):
    grey = into("grey", cv2.cvtColor, m, cv2.COLOR_RGB2GRAY)
    blurred = into("blur", cv2.GaussianBlur, grey, (5, 5), 1.0, sigmaY=1.0, borderType=REFLECT)
    return into(
        "edges", cv2.Canny, blurred, 0.5 * 255, 0.9 * 255, dst="edges", apertureSize=3, L2gradient=True
    )


def equalize(into: Into, m):
    return into("equal", cv2.equalizeHist, m)


def adaptive(into: Into, m):
    return into("binary", cv2.adaptiveThreshold, m, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY, 5, 2)


def otsu(into: Into, m, x, other):
    """The threshold is found on bytes and applied to float32."""
    limit, _ = cv2.threshold(
        into("bytes", cv2.convertScaleAbs, m, alpha=255), 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU
    )
    return into("out", cv2.threshold, m, (limit + 0.5) / 255, 0, cv2.THRESH_TOZERO)


def normalize(into: Into, m, x, other):
    mean, std = ((*map(float, v), 1.0) for v in x[1:])
    return into("out", cv2.divide, into("difference", cv2.subtract, m, mean), std)


def add_weighted(into: Into, m, x, other):
    alpha, beta, gamma = (float(x[i].flat[0]) for i in (1, 3, 4))
    return into("out", cv2.addWeighted, m, alpha, other, beta, gamma)


def threshold(into: Into, m, x, other):
    return into("out", cv2.threshold, m, float(x[1].flat[0]), float(x[2].flat[0]), cv2.THRESH_BINARY)


def resize(into: Into, m, x, other):
    return into("out", cv2.resize, m, x[-1].shape[::-1])


def warp(into: Into, m, x, other):
    return into("out", cv2.warpPerspective, m, x[1][0], x[-1].shape[::-1])


def on_bytes(function: Callable, scale: float) -> Callable:
    """A function that OpenCV has for bytes only, on float32 like chiasm's: the conversions from and to
    float32 are part of the call."""

    def call(into: Into, m, x, other):
        made = function(into, into("bytes", cv2.convertScaleAbs, m, alpha=scale))
        return into("out", cv2.multiply, made, 1 / scale, dtype=cv2.CV_32F)

    return call


def plain(function: Callable, *arguments, **options) -> Callable:
    """A call that depends only on the matrix."""
    return lambda into, m, x, other: into("out", function, m, *arguments, **options)


PEERS: dict[str, tuple[Callable[[np.ndarray], list[np.ndarray]], Callable[..., np.ndarray]]] = {
    "color.rgb_to_grayscale": (images, plain(cv2.cvtColor, cv2.COLOR_RGB2GRAY)),
    "color.rgb_to_hsv": (images, plain(cv2.cvtColor, cv2.COLOR_RGB2HSV)),
    "color.rgb_to_lab": (images, plain(cv2.cvtColor, cv2.COLOR_RGB2Lab)),
    "color.rgb_to_ycbcr": (images, plain(cv2.cvtColor, cv2.COLOR_RGB2YCrCb)),
    "color.rgb_to_yuv": (images, plain(cv2.cvtColor, cv2.COLOR_RGB2YUV)),
    "enhance.add_weighted": (images, add_weighted),
    "enhance.adjust_gamma": (images, lambda into, m, x, other: into("out", cv2.pow, m, float(x[1].flat[0]))),
    "enhance.clahe": (byte_planes, plain(cv2.createCLAHE(4.0, (4, 3)).apply)),
    "enhance.equalize": (float_planes, on_bytes(equalize, 255)),
    "enhance.integral_image": (images, plain(cv2.integral, dst="sum", sdepth=cv2.CV_32F)),
    "enhance.normalize": (images, normalize),
    "enhance.threshold.binary": (images, threshold),
    "filters.adaptive_threshold": (float_planes, on_bytes(adaptive, 1)),
    "filters.bilateral_blur": (images, plain(cv2.bilateralFilter, 5, 0.1, 1.5, borderType=REFLECT)),
    "filters.box_blur": (images, plain(cv2.blur, (5, 5), borderType=REFLECT)),
    "filters.canny": (images, on_bytes(canny, 255)),
    "filters.filter2d": (
        images,
        lambda into, m, x, other: into("out", cv2.filter2D, m, cv2.CV_32F, x[1], borderType=REFLECT),
    ),
    "filters.gaussian_blur2d": (images, gaussian),
    "filters.laplacian": (images, plain(cv2.filter2D, cv2.CV_32F, LAPLACIAN, borderType=REFLECT)),
    "filters.median_blur": (images, plain(cv2.medianBlur, 3)),
    "filters.otsu_threshold": (float_planes, otsu),
    "filters.sobel": (images, sobel),
    "filters.unsharp_mask": (images, unsharp),
    "geometry.transform.resize.bilinear": (images, resize),
    "geometry.transform.warp_perspective.bilinear_zeros": (images, warp),
    "morphology.dilation": (images, plain(cv2.dilate, CROSS)),
    "morphology.gradient": (images, plain(cv2.morphologyEx, cv2.MORPH_GRADIENT, CROSS)),
    "morphology.max_filter2d": (images, plain(cv2.dilate, SQUARE)),
    "pipelines.edges": (frame, edges),
    "pipelines.preprocess": (frame, preprocess),
}
