"""Pipelines: several ops in one bundle, from camera frame to result."""

import torch

from ..spec import Spec, TensorSpec, Tolerance, frame
from . import STENCIL, add
from .feature_detection import blobs

add(
    Spec(
        "pipelines.preprocess",
        [frame()],
        [
            TensorSpec(
                "output",
                layout="NCHW",
                color="RGB",
                description="224 x 224, normalised by ImageNet's mean and standard deviation",
            )
        ],
        symbols=STENCIL,
        reference="OpenCV resize and blobFromImage",
    )
)

add(
    Spec(
        "pipelines.edges",
        [frame()],
        [
            TensorSpec(
                "output",
                layout="HW",
                color="GRAY",
                range=(0, 255),
                description="Sobel magnitude of the blurred grey image",
            )
        ],
        symbols=STENCIL,
        tolerances={
            "uint8": Tolerance(1, 0)
        },  # a float result on the border between two integers may round either way
        reference="OpenCV cvtColor, GaussianBlur, Sobel, magnitude",
    )
)


def _sample_views(generator, sizes, dtype):
    first, second = blobs(
        generator, sizes["B"], [(sizes["H"], sizes["W"], 0), (sizes["OH"], sizes["OW"], 5)], dtype
    )
    return {
        "image1": first,
        "image2": second,
        "uniforms": torch.rand((sizes["B"], sizes["S"], 4), generator=generator).to(dtype),
    }


add(
    Spec(
        "pipelines.two_view_homography",
        [
            TensorSpec("image1", ("B", 1, "H", "W"), layout="NCHW", color="GRAY", range=(0.0, 1.0)),
            TensorSpec("image2", ("B", 1, "OH", "OW"), layout="NCHW", color="GRAY", range=(0.0, 1.0)),
            TensorSpec(
                "uniforms",
                ("B", "S", 4),
                range=(0.0, 1.0),
                description="random numbers, uniform in [0, 1), of which samples are made",
            ),
        ],
        [
            TensorSpec("homography", description="from image1 to image2"),
            TensorSpec("points1", description="key points of image1 that are matched, zeros for the others"),
            TensorSpec("points2", description="their matches in image2"),
            TensorSpec("matched", description="which of the slots hold a match"),
            TensorSpec("inliers", description="which matches obey the homography"),
        ],
        config={"max_keypoints": 500, "num_octaves": 2, "mr_size": 3.0, "double_image": True},
        symbols={"H": (54, 32768), "W": (58, 32768), "OH": (54, 32768), "OW": (58, 32768), "S": (1, 1 << 16)},
        gradients=(),
        # of points, in pixels; see the detector and the estimator
        tolerances={"float32": Tolerance(2e-2, 1e-3)},
        sample=_sample_views,
        reference="OpenCV SIFT, BFMatcher, findHomography",
        picture="registered views",
    )
)
