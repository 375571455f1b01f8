"""The inputs that show an op at work: photographs for all images."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from chiasm import color, enhance, filters
from chiasm.export import example_inputs
from chiasm.export.job import run_eager
from chiasm.export.spec import Spec, TensorSpec

from .geometric import WARPED, counts, geometric, lattice, scale_space, solid, volume_sizes
from .judged import judged
from .photographs import photograph
from .values import count, places, values

#: The ops that take camera formats.
CAMERAS = (
    *(f"color.{name}_to_rgb" for name in ("nv12", "nv21", "i420", "yuyv", "uyvy")),
    *(f"pipelines.letterbox_{name}" for name in ("nv12", "nv21", "i420", "yuyv")),
)
#: Colour spaces to which an eager op converts RGB.
SPACES = ("HLS", "HSL", "HSV", "LAB", "LUV", "XYZ", "YCbCr", "YUV")
FRAMES = 9


def inputs(
    spec: Spec, images: np.ndarray, target: tuple[int, int] | None = None, points: int = 1000
) -> dict[str, torch.Tensor]:
    """The op's inputs for photographs (B, H, W, 3); `target` is the height and width of results whose size is
    an input; `points` is the number of points or rotations for ops that take these."""
    batch, height, width, _ = images.shape
    wanted = target or (height * 3 // 4, width * 3 // 4)
    rgb = torch.from_numpy(images.transpose(0, 3, 1, 2).copy()).float() / 255.0
    chosen = values(spec)
    entries = batch if any(is_image(spec, t) for t in spec.inputs) else count(spec)
    sizes = {"B": entries, "C": 3, "H": height, "W": width, "N": points, "OH": wanted[0], "OW": wanted[1]}
    sizes = example_inputs.fit(spec, sizes | volume_sizes(spec, height, width) | counts(spec))
    known = features(spec, rgb) | places(spec, sizes) | geometric(spec, sizes, rgb) | judged(spec, sizes, rgb)
    made = {}
    for tensor in spec.inputs:
        if tensor.name in known:
            made[tensor.name] = known[tensor.name]
        elif tensor.name in chosen:
            made[tensor.name] = repeated(tensor, chosen[tensor.name], sizes)
        elif is_image(spec, tensor):
            made[tensor.name] = picture(spec, tensor, rgb)
        elif "a label for each" in tensor.description:
            made[tensor.name] = levels(tensor, rgb)
    if len(made) < len(spec.inputs):
        made = example_inputs.make(spec, sizes, spec.variants()[0]) | made
    return {t.name: made[t.name] for t in spec.inputs}


def telling(op: nn.Module, given: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """The inputs with those seeds of 16 choices that change every sample, by as much as possible: many seeds
    leave a sample as it is."""
    if "seed" not in given or given["seed"].is_floating_point():
        return given
    image, most = next(iter(given.values())), 0.0
    own = 1000 * torch.arange(len(image))
    for choice in range(16):
        tried = given | {"seed": own + choice}
        result = run_eager(op, tried)[0]
        if result.shape != image.shape:
            return given
        change = float((result.double() - image.double()).abs().flatten(1).mean(1).min())
        if change > most:
            given, most = tried, change
    return given


def is_image(spec: Spec, tensor: TensorSpec) -> bool:
    """Whether an input is an image of the batch's size, and neither a mask nor labels."""
    shaped = bool(tensor.layout) or ("H" in tensor.shape and not spec.name.startswith("geometry."))
    return shaped and tensor.dtype in ("T", "uint8", "uint16")


def repeated(tensor: TensorSpec, value: object, sizes: dict[str, int]) -> torch.Tensor:
    """A value, repeated over the batch and the channels; it must have all other named dimensions."""
    made = torch.as_tensor(value, dtype=example_inputs.dtype_of(tensor.dtype, "float32"))
    own = dict(zip(reversed(tensor.shape), reversed(made.shape), strict=False))
    return made.expand(
        [d if isinstance(d, int) else sizes[d] if d in ("B", "C") else own[d] for d in tensor.shape]
    ).contiguous()


def picture(spec: Spec, tensor: TensorSpec, rgb: torch.Tensor) -> torch.Tensor:
    """The photographs, converted for an image input: colour space, channels, layout, dtype, range."""
    if tensor.name in ("src2", "template"):
        other = torch.from_numpy(photograph("coffee.png").copy()).permute(2, 0, 1)[None].float() / 255.0
        rgb = resized(other, rgb.shape[-2:]).expand_as(rgb)
    rgb = fitted(tensor, rgb)
    if tensor.layout == "NCDHW" and spec.name.startswith("geometry.subpix."):
        return scale_space(rgb)
    if tensor.layout == "NCDHW":
        return solid(rgb) if spec.name.startswith("geometry.") else volume(rgb)
    if tensor.description in ("heat maps", "distributions"):
        maps = hills(rgb)
        return maps / maps.sum((2, 3), keepdim=True) if tensor.description == "distributions" else maps
    if spec.name.startswith(WARPED):
        rgb = lattice(rgb)
    made = in_color(spec, tensor, rgb)
    if "binary" in tensor.description:
        made = rarer(made)
    if tensor.range == (0, 255):
        made = made * 255.0
    if tensor.dtype == "uint16":
        made = (made * 65535.0).round().to(torch.uint16)
    if "uint8" in (tensor.dtype, spec.variants()[0] if tensor.dtype == "T" else ""):
        made = (made if tensor.range == (0, 255) else made * 255.0).round().to(torch.uint8)
    if tensor.layout == "HWC":
        made = made[0].permute(1, 2, 0)
    elif tensor.layout == "NHWC":
        made = made.permute(0, 2, 3, 1)
    return made.contiguous()


def fitted(tensor: TensorSpec, rgb: torch.Tensor) -> torch.Tensor:
    """The photographs in the input's size, if that is fixed."""
    size = tensor.shape[1:3] if tensor.layout == "NHWC" else tensor.shape[-2:]
    if not all(isinstance(n, int) for n in size):
        return rgb
    return resized(rgb, size)


def resized(rgb: torch.Tensor, size: Sequence[int]) -> torch.Tensor:
    return functional.interpolate(rgb, size, mode="bilinear", antialias=True).clamp(0, 1)


def in_color(spec: Spec, tensor: TensorSpec, rgb: torch.Tensor) -> torch.Tensor:
    """The photographs in the input's channels."""
    gray = color.rgb_to_grayscale(rgb)
    if spec.name.startswith(CAMERAS):
        return camera(spec.name.split(".")[1], tensor.name, rgb)
    if tensor.name == "alpha_val":
        return ramp(rgb)
    if tensor.name == "seed":  # the seed of h-domes
        return (rgb - 0.25).clamp(0, 1)
    if "normals" in spec.name:
        made = normals(gray)
        return made * 0.5 + 0.5 if tensor.dtype == "uint8" else made
    if spec.name == "color.linear_rgb_to_rgb":
        return color.rgb_to_linear_rgb(rgb)
    if spec.name == "enhance.denormalize":
        known = values(spec)
        return enhance.normalize(rgb, torch.tensor(known["mean"]), torch.tensor(known["std"]))
    if tensor.color in SPACES:
        return getattr(color, f"rgb_to_{tensor.color.lower()}")(rgb)
    if tensor.color == "UV":
        return color.rgb_to_yuv420(rgb)[1]
    if tensor.color == "BAYER":
        return color.rgb_to_raw(rgb, spec.config["cfa"])
    if tensor.color == "RGBA":
        return torch.cat([rgb, ramp(rgb)], 1)
    if tensor.color == "BGR":
        return rgb.flip(1)
    channels = tensor.shape[-1:] if tensor.layout == "NHWC" else tensor.shape[1:2]
    return gray if 1 in channels else rgb


def camera(name: str, part: str, rgb: torch.Tensor) -> torch.Tensor:
    """The photographs in a camera's format: luma from 16 to 235 and chroma from 16 to 240, divided by 255."""
    luma, blue, red = color.rgb_to_ycbcr(rgb[..., : rgb.shape[-1] // 2 * 2]).split(1, 1)
    luma = (16 + 219 * luma) / 255
    u, v = ((128 + 224 * (chroma - 0.5)) / 255 for chroma in (blue, red))
    if part in ("image", "frame"):
        u, v = (functional.avg_pool2d(chroma, (1, 2)) for chroma in (u, v))
        pair = [luma[..., 0::2], u, luma[..., 1::2], v]
        return torch.cat(pair if "yuyv" in name else [u, pair[0], v, pair[2]], 1)
    if part == "y":
        return luma
    halves = {"u": functional.avg_pool2d(u, 2), "v": functional.avg_pool2d(v, 2)}
    return torch.cat([halves[letter] for letter in part], 1)


def hills(rgb: torch.Tensor) -> torch.Tensor:
    """A hill of height 5 for each colour."""
    y, x = torch.meshgrid(
        torch.linspace(0, 1, rgb.shape[2]), torch.linspace(0, 1, rgb.shape[3]), indexing="ij"
    )
    made = [
        5.0 * torch.exp(-(((x - a) / 0.12) ** 2 + ((y - b) / 0.2) ** 2))
        for a, b in ((0.25, 0.3), (0.5, 0.6), (0.75, 0.4))
    ]
    return torch.stack(made).expand(rgb.shape).contiguous()


def ramp(rgb: torch.Tensor) -> torch.Tensor:
    """Alpha that grows from left to right."""
    return torch.linspace(0, 1, rgb.shape[-1]).expand(rgb.shape[0], 1, *rgb.shape[-2:]).contiguous()


def levels(tensor: TensorSpec, rgb: torch.Tensor) -> torch.Tensor:
    """A label for each pixel or voxel, by its brightness, in the input's range."""
    gray = color.rgb_to_grayscale(volume(rgb).transpose(1, 2) if "D" in tensor.shape else rgb)
    low, high = tensor.range or (0, 1)
    return (low + gray * (high - low)).round().to(torch.int64).squeeze(-3)


def rarer(images: torch.Tensor) -> torch.Tensor:
    """1 where the grey image is on the rarer side of its Otsu threshold, in one channel."""
    gray = images.mean(1, keepdim=True)
    bright = (gray > filters.otsu_threshold(gray)[1].view(-1, 1, 1, 1)).float()
    return torch.where(bright.mean((1, 2, 3), keepdim=True) > 0.5, 1 - bright, bright)


def normals(gray: torch.Tensor) -> torch.Tensor:
    """Unit normals of the surface whose height is the grey value."""
    slopes = filters.spatial_gradient(filters.gaussian_blur2d(gray, (7, 7), (1.5, 1.5)))[:, 0]
    return functional.normalize(torch.cat([-12 * slopes, torch.ones_like(gray)], 1), dim=1)


def volume(rgb: torch.Tensor) -> torch.Tensor:
    """Frames of a camera that moves sideways, (B, C, D, H, W)."""
    width = rgb.shape[-1] - 2 * FRAMES
    return torch.stack([rgb[..., 2 * i : 2 * i + width] for i in range(FRAMES)], 2).contiguous()


def features(spec: Spec, rgb: torch.Tensor) -> dict[str, torch.Tensor]:
    """Pixels as samples: values for densities, (red, green, blue, x, y) for whitening."""
    names = {t.name for t in spec.inputs}
    flat = rgb.flatten(2)
    if "x1" in names and spec.name.startswith("enhance."):
        return {"x1": flat[:1, 0].contiguous(), "x2": flat[:1, 1].contiguous()}
    if "x" in names and "bins" in names:
        return {"x": flat[:1].mean(1)}
    if "inp" in names:
        y, x = torch.meshgrid(*(torch.linspace(0, 1, n) for n in rgb.shape[-2:]), indexing="ij")
        points = torch.stack([*rgb[0], x, y], -1).reshape(-1, 5)[::23].contiguous()
        transform, mean, _ = enhance.zca_mean(points)
        return {"inp": points, "transform_matrix": transform, "mean_vector": mean}
    return {}
