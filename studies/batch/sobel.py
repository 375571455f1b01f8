"""The paper's work: the magnitude of Sobel's gradient of every channel, float32, kernels divided by 8,
borders replicated."""

from __future__ import annotations

import numpy as np

from bench.images.ops import Agreement

from . import kornias, ours
from .ways import Images, Ready, Setup, Way, Work, from_matrices, into, over_images


def _eager(setup: Setup):
    from chiasm.filters import sobel

    return sobel


def _opencv(images: Images, setup: Setup) -> Ready:
    import cv2

    cv2.setNumThreads(1 if len(images) > 1 else setup.threads)
    matrices = images.matrices
    made = [np.empty_like(m) for m in matrices]
    flat = [m.reshape(m.shape[0], -1) for m in made]  # cv2.magnitude takes one channel

    def one(i: int, scratch: dict) -> None:
        dx = into(
            scratch,
            "dx",
            cv2.Sobel,
            matrices[i],
            cv2.CV_32F,
            1,
            0,
            ksize=3,
            scale=1 / 8,
            borderType=cv2.BORDER_REPLICATE,
        )
        dy = into(
            scratch,
            "dy",
            cv2.Sobel,
            matrices[i],
            cv2.CV_32F,
            0,
            1,
            ksize=3,
            scale=1 / 8,
            borderType=cv2.BORDER_REPLICATE,
        )
        cv2.magnitude(dx.reshape(flat[i].shape), dy.reshape(flat[i].shape), flat[i])

    return Ready(over_images(one, len(matrices), setup.threads), lambda _: from_matrices(made))


def _pillow(images: Images, setup: Setup) -> Ready:
    from PIL import Image, ImageFilter, ImageMath

    pictures = [Image.fromarray(i) for i in images.rgb]
    # Its results are bytes: a derivative of 0 becomes 128.
    across = ImageFilter.Kernel((3, 3), (-1, 0, 1, -2, 0, 2, -1, 0, 1), 8, 128)
    down = ImageFilter.Kernel((3, 3), (-1, -2, -1, 0, 0, 0, 1, 2, 1), 8, 128)

    def magnitude(of: dict) -> Image.Image:
        dx, dy = of["float"](of["dx"]) - 128, of["float"](of["dy"]) - 128
        return (dx * dx + dy * dy) ** 0.5

    def one(i: int, scratch: dict) -> list[Image.Image]:
        dx, dy = pictures[i].filter(across).split(), pictures[i].filter(down).split()
        return [ImageMath.lambda_eval(magnitude, dx=x, dy=y) for x, y in zip(dx, dy, strict=True)]

    call = over_images(one, len(pictures), setup.threads)
    return Ready(
        call,
        lambda made: (
            np.stack([np.stack([np.asarray(band) for band in picture]) for picture in made]) / np.float32(255)
        ),
    )


def _scikit_image(images: Images, setup: Setup) -> Ready:
    from skimage import filters

    planes, shape = images.planes, images.floats.shape
    call = over_images(lambda i, scratch: filters.sobel(planes[i]), len(planes), setup.threads)
    return Ready(call, lambda made: np.stack(made).reshape(shape) * np.float32(0.5**0.5))


def _scipy(images: Images, setup: Setup) -> Ready:
    from scipy import ndimage

    planes, made = images.planes, np.empty_like(images.floats)
    outputs = list(made.reshape(-1, *made.shape[2:]))

    def one(i: int, scratch: dict) -> None:
        dx = scratch.setdefault("dx", np.empty_like(outputs[i]))
        ndimage.sobel(planes[i], 1, dx, "nearest")
        ndimage.sobel(planes[i], 0, outputs[i], "nearest")
        np.hypot(dx, outputs[i], out=outputs[i])
        np.multiply(outputs[i], np.float32(1 / 8), out=outputs[i])

    return Ready(over_images(one, len(planes), setup.threads), lambda _: made)


def _kornia_rs(images: Images, setup: Setup) -> Ready:
    sobel, matrices = kornias.module("kornia_rs").imgproc.sobel, images.matrices
    return Ready(lambda: [sobel(m, 3) for m in matrices], lambda made: from_matrices(made) / 8)


_EPSILON = "chiasm adds 1e-6 to the squared magnitude"
WORK = Work(
    "Sobel",
    "Magnitude of the gradient of each channel by Sobel's 3 x 3 kernels divided by 8, float32, the border"
    " replicated: `chiasm.filters.sobel`.",
    "filters.sobel",
    ours.ways("filters.sobel", _eager, frames=False, agrees=Agreement(1e-6))
    | {
        "OpenCV": Way(_opencv, Agreement(1.1e-3, note=_EPSILON)),
        "Pillow": Way(_pillow, Agreement(4e-3, edge=1, note="rounds to bytes inside, and keeps the border")),
        "scikit-image": Way(_scikit_image, Agreement(1.1e-3, note=_EPSILON + "; sqrt(2) times as large")),
        "SciPy": Way(_scipy, Agreement(1.1e-3, note=_EPSILON)),
    }
    | kornias.ways(
        lambda kornia, setup, x: kornia.filters.sobel(x),
        lambda images: images.floats,
        lambda made: made,
        Agreement(1e-5),
    )
    | {
        "kornia-rs": Way(
            _kornia_rs, Agreement(1.1e-3, edge=1, note="kernels not divided, zeros around the image")
        )
    },
)
