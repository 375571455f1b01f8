"""chiasm's pipelines for one camera frame, uint8, BGR: edges, and a classifier's input."""

from __future__ import annotations

import numpy as np

from bench.images.ops import Agreement

from . import kornias, ours
from .ways import Images, Ready, Setup, Way, Work, into, over_images

#: the defaults of pipelines.preprocess, with which it is exported
MEAN, STD, SIZE = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225), (224, 224)


def _eager_edges(setup: Setup):
    from chiasm.pipelines import edges

    return edges


def _eager_preprocess(setup: Setup):
    from chiasm.pipelines import preprocess

    return preprocess


def _opencv_edges(images: Images, setup: Setup) -> Ready:
    import cv2

    cv2.setNumThreads(1 if len(images) > 1 else setup.threads)
    frames = images.frames
    made = [np.empty(f.shape[:2], np.uint8) for f in frames]

    def one(i: int, scratch: dict) -> None:
        grey = into(scratch, "grey", cv2.cvtColor, frames[i], cv2.COLOR_BGR2GRAY)
        blurred = into(scratch, "blurred", cv2.GaussianBlur, grey, (5, 5), 1.0)
        dx = into(scratch, "dx", cv2.Sobel, blurred, cv2.CV_32F, 1, 0)
        dy = into(scratch, "dy", cv2.Sobel, blurred, cv2.CV_32F, 0, 1)
        cv2.convertScaleAbs(into(scratch, "magnitude", cv2.magnitude, dx, dy, dst="magnitude"), made[i])

    return Ready(
        over_images(one, len(frames), setup.threads), lambda _: np.stack(made)[:, None].astype(np.float32)
    )


def _opencv_preprocess(images: Images, setup: Setup) -> Ready:
    import cv2

    cv2.setNumThreads(1 if len(images) > 1 else setup.threads)
    frames = images.frames
    parameters = cv2.dnn.Image2BlobParams()
    parameters.scalefactor = tuple(1 / (255 * s) for s in STD)
    parameters.mean = tuple(255 * m for m in MEAN)
    parameters.swapRB = True

    def one(i: int, scratch: dict) -> np.ndarray:
        return cv2.dnn.blobFromImageWithParams(
            into(scratch, "small", cv2.resize, frames[i], SIZE, interpolation=cv2.INTER_LINEAR), parameters
        )

    return Ready(over_images(one, len(frames), setup.threads), np.concatenate)


def _kornia_edges(kornia, setup: Setup, frames):
    rgb = kornia.color.bgr_to_rgb(frames.permute(0, 3, 1, 2).float())
    blurred = kornia.filters.gaussian_blur2d(kornia.color.rgb_to_grayscale(rgb), (5, 5), (1.0, 1.0))
    return kornia.filters.sobel(blurred, normalized=False).round().clamp(0.0, 255.0).byte()


def _kornia_preprocess(kornia, setup: Setup, frames):
    rgb = kornia.color.bgr_to_rgb(frames.permute(0, 3, 1, 2).float() / 255.0)
    return kornia.enhance.normalize(
        kornia.geometry.resize(rgb, SIZE),
        frames.new_tensor(MEAN, dtype=rgb.dtype),
        frames.new_tensor(STD, dtype=rgb.dtype),
    )


def _kornia_rs_preprocess(images: Images, setup: Setup) -> Ready:
    pipeline, rgb = kornias.module("kornia_rs").pipeline, images.rgb
    return Ready(lambda: pipeline.resize_normalize_to_tensor_batch(rgb, SIZE, MEAN, STD), np.stack)


EDGES = Work(
    "The pipeline *edges*",
    "From a frame (bytes, BGR): grey, Gaussian blur 5 x 5 of sigma 1, Sobel magnitude, bytes:"
    " `chiasm.pipelines.edges`, one frame per call.",
    "pipelines.edges",
    ours.ways("pipelines.edges", _eager_edges, frames=True, agrees=Agreement(1))
    | {
        "OpenCV": Way(
            _opencv_edges,
            Agreement(8, 0.999, edge=1, note="rounds the grey and the blurred image to bytes"),
        )
    }
    | kornias.ways(
        _kornia_edges,
        lambda images: images.stacked_frames,
        lambda made: made.astype(np.float32),
        Agreement(1),
    ),
)
PREPROCESS = Work(
    "The pipeline *preprocess*",
    "From a frame (bytes, BGR): RGB, 224 x 224 (bilinear), in [0, 1], normalised, as planes:"
    " `chiasm.pipelines.preprocess`, one frame per call.",
    "pipelines.preprocess",
    ours.ways("pipelines.preprocess", _eager_preprocess, frames=True, agrees=Agreement(1e-5))
    | {"OpenCV": Way(_opencv_preprocess, Agreement(0.02, note="rounds the resized image to bytes"))}
    | kornias.ways(
        _kornia_preprocess, lambda images: images.stacked_frames, lambda made: made, Agreement(1e-4)
    )
    | {
        "kornia-rs": Way(
            _kornia_rs_preprocess, Agreement(0.04, note="takes RGB; rounds the resized image to bytes")
        )
    },
)
