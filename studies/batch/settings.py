"""All settings of the measurement."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """The paper's: RGB images of 256 x 256 in batches of 1 to 256, the median of 500 repeats."""

    #: height and width of the images
    size: tuple[int, int] = (256, 256)
    #: images in a batch, for Sobel
    batches: tuple[int, ...] = (1, 2, 4, 8, 16, 32, 64, 128, 256)
    #: images in a batch, for the pipelines
    pipeline_batches: tuple[int, ...] = (1, 4, 16, 64, 256)
    #: calls of each contender at each batch size, unless they take longer than `seconds`; at least 3
    repeats: int = 500
    #: the most seconds for the repeats of one contender at one batch size
    seconds: float = 0.6
    #: the number of turns over which the repeats are spread
    turns: int = 20
    #: images in the batch for which memory is measured
    memory_batch: int = 64
    #: focal lengths and principal point of the camera, in pixels
    camera: tuple[float, float, float, float] = (220.0, 220.0, 127.5, 127.5)
    #: distortion of its lens: k1, k2, p1, p2, k3
    lens: tuple[float, float, float, float, float] = (-0.25, 0.07, 0.001, -0.0005, 0.0)
    #: height and width to which the five ops resize
    resized: tuple[int, int] = (224, 224)
    #: factors of brightness, contrast and saturation, and the rotation of hues, in radians
    jitter: tuple[float, float, float, float] = (1.2, 0.8, 1.3, 0.1)
    #: taps and standard deviation of the blur, in pixels
    blur: tuple[int, float] = (5, 1.0)
    #: for the channels R, G, B
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    std: tuple[float, float, float] = (0.229, 0.224, 0.225)


#: for tests
SMALL = Settings(
    size=(64, 80),
    batches=(1, 3),
    pipeline_batches=(1, 3),
    repeats=4,
    seconds=0.02,
    turns=2,
    memory_batch=4,
    camera=(55.0, 55.0, 39.5, 31.5),
    resized=(56, 48),
)
