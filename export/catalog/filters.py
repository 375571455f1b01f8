"""Filters."""

from ..spec import Spec, TensorSpec, image
from . import STENCIL, add

add(Spec(
    "filters.gaussian_blur2d",
    [image(), TensorSpec("sigma", ("B", 2), range=(0.5, 3.0), description="standard deviations (y, x) of each image, in pixels")],
    [TensorSpec("output", layout="NCHW")],
    config={"kernel_size": (5, 5), "border_type": "reflect"},
    symbols=STENCIL,
    reference="OpenCV GaussianBlur(BORDER_REFLECT_101)",
))

add(Spec(
    "filters.sobel",
    [image()],
    [TensorSpec("output", layout="NCHW", description="gradient magnitude")],
    config={"normalized": True, "eps": 1e-6},
    symbols=STENCIL,
    dtypes=("float32", "float64"),
    reference="OpenCV Sobel(BORDER_REPLICATE)",
))

add(Spec(
    "filters.median_blur",
    [image()],
    [TensorSpec("output", layout="NCHW")],
    config={"kernel_size": (3, 3), "border_type": "reflect"},
    symbols=STENCIL,
    reference="SciPy median_filter(mode='mirror')",
))

add(Spec(
    "filters.bilateral_blur",
    [image()],
    [TensorSpec("output", layout="NCHW")],
    config={"kernel_size": (5, 5), "sigma_color": 0.1, "sigma_space": (1.5, 1.5), "border_type": "reflect"},
    symbols=STENCIL,
    reference="the definition in NumPy float64, and OpenCV bilateralFilter on one channel",
))

add(Spec(
    "filters.canny",
    [image(channels=3, color="RGB")],
    [TensorSpec("magnitude", layout="NCHW", description="gradient magnitude on the ridges, 0 elsewhere"),
     TensorSpec("edges", layout="NCHW", description="1 on edges, 0 elsewhere")],
    config={"low_threshold": 0.5, "high_threshold": 0.9, "kernel_size": (5, 5), "sigma": (1.0, 1.0), "hysteresis": True},
    symbols=STENCIL,
    reference="OpenCV Canny on the same gradients",
))

add(Spec(
    "filters.joint_bilateral_blur",
    [image(), image("guidance", channels=1, color="GRAY")],
    [TensorSpec("output", layout="NCHW")],
    config={"kernel_size": (3, 3), "sigma_color": 0.1, "sigma_space": (1.5, 1.5), "border_type": "reflect"},
    symbols=STENCIL,
    reference="the definition in NumPy float64",
))

add(Spec(
    "filters.guided_blur",
    [image("guidance", channels=3, color="RGB"), image()],
    [TensorSpec("output", layout="NCHW")],
    config={"kernel_size": (5, 5), "eps": 0.01, "border_type": "reflect"},
    symbols=STENCIL,
    reference="the definition in NumPy float64",
))

add(Spec(
    "filters.fast_guided_blur",
    [image("guidance", channels=1, color="GRAY"), image()],
    [TensorSpec("output", layout="NCHW")],
    config={"kernel_size": (5, 5), "eps": 0.01, "border_type": "reflect", "subsample": 2},
    # The small images must be stencils' images too.
    symbols={"H": (16, 32768), "W": (16, 32768)},
    reference="the definition in NumPy float64",
), fn="filters.guided_blur")

add(Spec(
    "filters.rank_filter",
    [image()],
    [TensorSpec("output", layout="NCHW")],
    config={"rank": 2, "kernel_size": (3, 3), "border_type": "reflect"},
    symbols=STENCIL,
    reference="SciPy rank_filter(mode='mirror')",
))

add(Spec(
    "filters.percentile_filter",
    [image()],
    [TensorSpec("output", layout="NCHW")],
    config={"percentile": 80.0, "kernel_size": (3, 3), "border_type": "reflect"},
    symbols=STENCIL,
    reference="SciPy percentile_filter(mode='mirror')",
))

add(Spec(
    "filters.non_local_means",
    [image()],
    [TensorSpec("output", layout="NCHW")],
    config={"patch_size": 5, "patch_distance": 5, "h": 0.2, "sigma": 0.05, "border_type": "reflect"},
    symbols=STENCIL,
    # A gradient would be 121 copies of the loop's body.
    gradients=(),
    reference="the definition in NumPy float64, OpenCV fastNlMeansDenoising",
))
