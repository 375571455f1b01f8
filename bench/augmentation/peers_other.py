"""Albumentations and DALI, which have a separate environment (.deps/augmentation). Both take frames (B, H, W,
3), which are prepared outside the measured time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from .settings import SETTINGS as S
from .settings import Call, shares


def frames_of(images: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(images.transpose(0, 2, 3, 1))


def albumentations(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    """One image per call, in ``threads`` threads; OpenCV, which it calls, uses one thread in each."""
    import albumentations as A
    import cv2

    cv2.setNumThreads(1)
    limits = (1 - S.colours, 1 + S.colours)
    made: dict[str, Callable[[], Any]] = {
        "flip": lambda: A.HorizontalFlip(p=S.flip),
        "crop": lambda: A.RandomResizedCrop((S.side, S.side), S.area, S.ratio),
        "affine": lambda: A.Affine(
            rotate=(-S.degrees, S.degrees),
            translate_percent={"x": (-S.shift, S.shift), "y": (-S.shift, S.shift)},
            scale=S.scale,
            keep_ratio=True,
            p=1.0,
        ),
        "jitter": lambda: A.ColorJitter(limits, limits, limits, (-S.hue, S.hue), p=1.0),
        "blur": lambda: A.GaussianBlur((S.taps, S.taps), S.sigma, p=1.0),
        "normalise": lambda: A.Normalize(S.mean, S.std),
    }
    frames = frames_of(images)
    pool = ThreadPoolExecutor(threads)
    pipelines = [A.Compose([made[step]() for step in steps]) for _ in range(threads)]
    dtype = np.float32 if "normalise" in steps else np.uint8

    def call() -> np.ndarray:
        out = np.empty(images.shape, dtype)

        def part(pipeline: Any, some: range) -> None:
            for i in some:
                out[i] = pipeline(image=frames[i])["image"].transpose(2, 0, 1)

        list(pool.map(part, pipelines, shares(len(frames), threads)))
        return out

    return call


def dali(images: np.ndarray, steps: Sequence[str], threads: int) -> Call:
    """The operators for CPUs. A call waits for its own batch: no batch is prepared ahead.

    The operator that normalises also flips, as is usual with DALI; the distribution is the same. The colour
    changes are in DALI's order, which is fixed.
    """
    from nvidia.dali import fn, pipeline_def, types

    middle = [S.side / 2, S.side / 2]

    def uniform(low: float, high: float, shape: Sequence[int] = ()) -> Any:
        return fn.random.uniform(range=[low, high], shape=list(shape))

    def matrix() -> Any:
        factor, offset = uniform(*S.scale), S.shift * S.side
        scaled = fn.transforms.scale(scale=fn.stack(factor, factor), center=middle)
        turned = fn.transforms.rotation(scaled, angle=uniform(-S.degrees, S.degrees), center=middle)
        return fn.transforms.translation(turned, offset=uniform(-offset, offset, [2]))

    @pipeline_def(
        batch_size=len(images),
        num_threads=threads,
        device_id=None,
        exec_async=False,
        exec_pipelined=False,
        prefetch_queue_depth=1,
    )
    def pipeline() -> Any:
        x = fn.external_source(name="frames", layout="HWC", no_copy=True)
        if "crop" in steps:
            x = fn.random_resized_crop(
                x, size=(S.side, S.side), random_area=list(S.area), random_aspect_ratio=list(S.ratio)
            )
        if "affine" in steps:
            x = fn.warp_affine(x, matrix=matrix(), fill_value=0, inverse_map=False)
        if "jitter" in steps:
            brightness, contrast, saturation = (uniform(1 - S.colours, 1 + S.colours) for _ in range(3))
            x = fn.color_twist(
                x,
                brightness=brightness,
                contrast=contrast,
                saturation=saturation,
                hue=uniform(-360 * S.hue, 360 * S.hue),
            )
        if "blur" in steps:
            x = fn.gaussian_blur(x, window_size=S.taps, sigma=uniform(*S.sigma))
        mirror = fn.random.coin_flip(probability=S.flip) if "flip" in steps else 0
        if "normalise" in steps:
            mean, std = ([255 * v for v in values] for values in (S.mean, S.std))
            x = fn.crop_mirror_normalize(
                x, dtype=types.FLOAT, output_layout="CHW", mirror=mirror, mean=mean, std=std
            )
        elif "flip" in steps:
            x = fn.flip(x, horizontal=mirror)
        return x

    frames, made = frames_of(images), pipeline()
    made.build()

    def call() -> np.ndarray:
        made.feed_input("frames", frames)
        [result] = made.run()
        return np.asarray(result.as_tensor())  # valid until the next run

    return call
