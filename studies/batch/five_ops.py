"""The five ops of pipeline.py: undistort, resize, jitter colours, blur, normalise; all in float32."""

from __future__ import annotations

from functools import partial

import numpy as np

from bench.images.ops import Agreement

from . import kornias, ours
from .settings import Settings
from .ways import Images, Ready, Setup, Way, Work, from_matrices, into, over_images

GREY = (0.299, 0.587, 0.114)


def config(settings: Settings) -> dict:
    """The arguments of `prepare` other than the image."""
    return {name: getattr(settings, name) for name in ("camera", "lens", "jitter", "blur", "mean", "std")} | {
        "size": settings.resized
    }


def _eager(setup: Setup):
    from .pipeline import prepare

    return partial(prepare, **config(setup.settings))


def camera_matrix(settings: Settings) -> np.ndarray:
    fx, fy, cx, cy = settings.camera
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def saturation_matrix(factor: float) -> np.ndarray:
    """The change of saturation by a factor, as one matrix on the colours R, G, B."""
    return (factor * np.eye(3) + (1 - factor) * np.outer(np.ones(3), GREY)).astype(np.float32)


def _opencv(images: Images, setup: Setup) -> Ready:
    """The maps are made once, as for many images of one camera. Each image goes through all steps while it is
    in the cache."""
    import cv2

    cv2.setNumThreads(1 if len(images) > 1 else setup.threads)
    s = setup.settings
    matrix, matrices = camera_matrix(s), images.matrices
    maps = cv2.initUndistortRectifyMap(matrix, np.array(s.lens), None, matrix, s.size[::-1], cv2.CV_32FC1)
    brightness, contrast, saturation, turn = s.jitter
    colours = saturation_matrix(saturation)
    made = [np.empty((*s.resized, 3), np.float32) for _ in matrices]
    zeros, ones = (0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0)

    def one(i: int, scratch: dict) -> None:
        step = partial(into, scratch)
        straight = step("straight", cv2.remap, matrices[i], *maps, cv2.INTER_LINEAR)
        x = step("small", cv2.resize, straight, s.resized[::-1], interpolation=cv2.INTER_LINEAR)
        x = step("small", cv2.min, step("small", cv2.multiply, x, (brightness,) * 4), ones)
        mean = cv2.mean(step("grey", cv2.cvtColor, x, cv2.COLOR_RGB2GRAY))[0]
        x = step(
            "small", cv2.add, step("small", cv2.multiply, x, (contrast,) * 4), (mean * (1 - contrast),) * 4
        )
        x = step("small", cv2.min, step("small", cv2.max, x, zeros), ones)
        x = step("other", cv2.transform, x, colours)
        x = step("other", cv2.min, step("other", cv2.max, x, zeros), ones)
        hsv = step("hsv", cv2.cvtColor, x, cv2.COLOR_RGB2HSV)
        hue = step("hue", cv2.add, step("hue", cv2.extractChannel, hsv, 0), (np.degrees(turn),))
        beyond = step("beyond", cv2.threshold, hue, 360.0, 360.0, cv2.THRESH_BINARY)
        cv2.insertChannel(step("hue", cv2.subtract, hue, beyond), hsv, 0)
        x = step("small", cv2.cvtColor, hsv, cv2.COLOR_HSV2RGB)
        x = step("other", cv2.GaussianBlur, x, (s.blur[0],) * 2, s.blur[1], sigmaY=s.blur[1])
        cv2.divide(step("small", cv2.subtract, x, (*s.mean, 0.0)), (*s.std, 1.0), made[i])

    return Ready(over_images(one, len(matrices), setup.threads), lambda _: from_matrices(made))


def _opencv_bytes(images: Images, setup: Setup) -> Ready:
    """The same steps on camera bytes: tables for the curves, and rounding to bytes after every step."""
    import cv2

    cv2.setNumThreads(1 if len(images) > 1 else setup.threads)
    s = setup.settings
    matrix, pictures = camera_matrix(s), images.rgb
    maps = cv2.initUndistortRectifyMap(matrix, np.array(s.lens), None, matrix, s.size[::-1], cv2.CV_16SC2)
    brightness, contrast, saturation, turn = s.jitter
    colours, levels = saturation_matrix(saturation), np.arange(256)
    brighter = np.clip(np.rint(levels * brightness), 0, 255).astype(np.uint8)
    turned = np.roll(levels, -round(turn / (2 * np.pi) * 256)).astype(np.uint8)
    scale, shift = np.float32(1 / (255 * np.array(s.std))), np.float32(np.array(s.mean) / np.array(s.std))
    made = [np.empty((*s.resized, 3), np.float32) for _ in pictures]

    def one(i: int, scratch: dict) -> None:
        step = partial(into, scratch)
        straight = step("straight", cv2.remap, pictures[i], *maps, cv2.INTER_LINEAR)
        x = step("small", cv2.resize, straight, s.resized[::-1], interpolation=cv2.INTER_LINEAR)
        x = step("other", cv2.LUT, x, brighter)
        mean = cv2.mean(step("grey", cv2.cvtColor, x, cv2.COLOR_RGB2GRAY))[0]
        stretched = np.clip(np.rint(mean + (levels - mean) * contrast), 0, 255).astype(np.uint8)
        x = step("other", cv2.transform, step("small", cv2.LUT, x, stretched), colours)
        hsv = step("hsv", cv2.cvtColor, x, cv2.COLOR_RGB2HSV_FULL)
        hue = step("turned", cv2.LUT, step("hue", cv2.extractChannel, hsv, 0), turned)
        cv2.insertChannel(hue, hsv, 0)
        x = step("small", cv2.cvtColor, hsv, cv2.COLOR_HSV2RGB_FULL)
        x = step("other", cv2.GaussianBlur, x, (s.blur[0],) * 2, s.blur[1], sigmaY=s.blur[1])
        cv2.subtract(
            step("float", cv2.multiply, x, (*scale.tolist(), 1.0), dtype=cv2.CV_32F),
            (*shift.tolist(), 0.0),
            made[i],
        )

    return Ready(over_images(one, len(pictures), setup.threads), lambda _: from_matrices(made))


def _kornia(kornia, setup: Setup, x):
    s, batch = setup.settings, x.size(0)
    matrix, lens = x.new_tensor(camera_matrix(s)).expand(batch, 3, 3), x.new_tensor(s.lens).expand(batch, 5)
    x = kornia.geometry.resize(kornia.geometry.undistort_image(x, matrix, lens), s.resized)
    x = kornia.enhance.adjust_brightness_accumulative(x, s.jitter[0])
    x = kornia.enhance.adjust_contrast_with_mean_subtraction(x, s.jitter[1])
    x = kornia.enhance.adjust_saturation_with_gray_subtraction(x, s.jitter[2])
    x = kornia.enhance.adjust_hue(x, s.jitter[3])
    x = kornia.filters.gaussian_blur2d(x, (s.blur[0],) * 2, (s.blur[1],) * 2)
    return kornia.enhance.normalize(x, x.new_tensor(s.mean), x.new_tensor(s.std))


WORK = Work(
    "Five ops in one bundle",
    "One bundle of five ops ([pipeline.py](../studies/batch/pipeline.py)): undistort, resize to 224 x 224,"
    " jitter of brightness, contrast, saturation and hue, blur, normalise, float32. OpenCV reuses its maps;"
    " *OpenCV on bytes* processes bytes until the normalisation.",
    "studies.prepare",
    ours.ways("studies.prepare", _eager, frames=False, agrees=Agreement(1e-3, 0.9999))
    | {
        "OpenCV": Way(_opencv, Agreement(1e-3, 0.9999)),
        "OpenCV on bytes": Way(
            _opencv_bytes, Agreement(0.1, 0.9, note="takes bytes, rounds to bytes after every step")
        ),
    }
    | kornias.ways(_kornia, lambda images: images.floats, lambda made: made, Agreement(1e-3, 0.9999)),
    debian=Agreement(0.02, note="reads at positions rounded to 1/32 pixel"),
)
