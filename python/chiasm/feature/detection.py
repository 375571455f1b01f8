"""Keypoints in scale space.

T. Lindeberg, Feature detection with automatic scale selection, IJCV 30(2), 1998; D. Lowe, Distinctive Image
Features from Scale-Invariant Keypoints, IJCV 60(2), 2004. The voxels of all octaves are numbered
consecutively, so that the same code finds and refines the strongest ones for any number of octaves.
"""

import math
from typing import List, Tuple

import torch
from torch import Tensor

from ..filters.gaussian import gaussian_blur2d
from ..geometry.subpix.quadratic import quadratic_extrema
from ..geometry.transform.resize import resize
from ..primitives.core.checks import check_choice, check_one_channel
from ..primitives.features.extrema import scale_space_nms
from ..primitives.numbers.ranking import stable_topk
from ..primitives.resampling.warping import position_dtype
from .harris import harris_response
from .responses import dog_response, gftt_response, hessian_response


def detect_keypoints(
    img: Tensor,
    max_keypoints: int,
    response: str = "hessian",
    num_octaves: int = 4,
    n_levels: int = 3,
    init_sigma: float = 1.6,
    mr_size: float = 6.0,
    threshold: float = 0.0,
    double_image: bool = False,
) -> Tuple[Tensor, Tensor, Tensor]:
    """Detect the strongest corners or blobs of all scales, in a fixed number of slots.

    A keypoint is a strict maximum of the response among its 3x3x3 neighbours in position and scale; for "dog"
    also a strict minimum, whose strength is its magnitude. So a maximum that two neighbours share, of a blob
    exactly half-way between two pixels, is not found, unless rounding makes them differ. A keypoint is
    refined by a quadratic through its neighbours, with at most two moves to a neighbouring voxel; if this
    does not converge, it keeps its position. Keypoints whose frame, before refinement, does not lie inside
    the image are dropped. The max_keypoints strongest before refinement are refined.

    Args:
        img: grey image (B, 1, H, W), floating point, assumed to have a blur of 0.5 pixels. Half precision is
            computed in float32.
        max_keypoints: number K of slots.
        response: "harris", "gftt" or "hessian", multiplied by the fourth power of the scale, or "dog".
        num_octaves: the number of octaves; each octave has every second pixel of the one before. Octaves of
            fewer than 8 pixels are left out.
        n_levels: scales in an octave; neighbouring ones differ by the factor 2^(1 / n_levels).
        init_sigma: the scale one level below the first scale of keypoints, in pixels of the first octave,
            more than 0.5 (1 with double_image).
        mr_size: the radius of a frame divided by its scale.
        threshold: a keypoint's score must exceed it; not negative.
        double_image: begin with the image enlarged to twice its size, as Lowe does. This finds keypoints of
            half the scales too, about four times as many.

    Returns:
        lafs (B, K, 2, 3), upright disks in pixels, float32 of half precision, zeros in slots without a
        keypoint; scores (B, K), descending, equal ones by octave, scale and position, 0 in slots without a
        keypoint; valid (B, K), bool. Positions, scales and scores are differentiable in img.

    Raises:
        TypeError: if img is not floating point.
        ValueError: if img is not (B, 1, H, W), response unknown or a number not as above.

    Example:
        >>> y, x = torch.arange(80.0)[:, None] - 41.5, torch.arange(80.0) - 37.3
        >>> lafs, scores, valid = detect_keypoints(torch.exp(-(x * x + y * y) / 50)[None, None], 3)
        >>> lafs[0, 0, :, 2].round(decimals=1), int(valid.sum())
        (tensor([37.3000, 41.5000]), 1)
    """
    _check(img, max_keypoints, response, num_octaves, n_levels, init_sigma, threshold, double_image)
    exact, blur = img.to(position_dtype(img.dtype)), 0.5
    if double_image:
        exact, blur = resize(exact, (2 * img.size(2), 2 * img.size(3)), "bilinear", False), 1.0
    volumes = _responses(exact, response, num_octaves, n_levels, init_sigma, blur)
    radii = [mr_size * init_sigma * 2.0 ** (k / n_levels) for k in range(n_levels + 2)]
    index, found = _strongest(volumes, response == "dog", radii, max_keypoints)
    place, octave, extent, pixel = _located(volumes, index)
    position, value = _refined(volumes, place, octave, extent)
    score = torch.where(found, value.abs().to(exact.dtype), torch.zeros_like(value).to(exact.dtype))
    score = torch.where(score > threshold, score, torch.zeros_like(score))
    scores, order = stable_topk(score, max_keypoints)
    valid = scores > 0
    sigma = pixel * torch.exp(position[..., 0] * (math.log(2.0) / n_levels)) * (init_sigma * mr_size)
    zero, x, y = torch.zeros_like(sigma), position[..., 1] * pixel, position[..., 2] * pixel
    if double_image:
        # Pixel i of the doubled image has its centre at (i + 0.5) / 2 - 0.5.
        sigma, x, y = 0.5 * sigma, 0.5 * x - 0.25, 0.5 * y - 0.25
    frames = torch.stack([sigma, zero, x, zero, sigma, y], -1).to(exact.dtype)
    frames = frames.gather(1, order[..., None].expand(-1, -1, 6)).unflatten(2, [2, 3])
    frames = torch.where(valid[..., None, None], frames, torch.zeros_like(frames))
    return frames, scores.to(img.dtype), valid


def _check(
    img: Tensor,
    max_keypoints: int,
    response: str,
    num_octaves: int,
    n_levels: int,
    init_sigma: float,
    threshold: float,
    double_image: bool,
) -> None:
    check_one_channel(img, "img")
    if img.size(2) < 8 or img.size(3) < 8:
        raise ValueError(f"img: expected at least 8 x 8 pixels, got {list(img.shape)}")
    check_choice(response, ["harris", "gftt", "hessian", "dog"], "response")
    if max_keypoints < 1 or num_octaves < 1 or n_levels < 1:
        raise ValueError(
            f"max_keypoints, num_octaves, n_levels: expected positive numbers, got {max_keypoints},"
            f" {num_octaves} and {n_levels}"
        )
    least = 1.0 if double_image else 0.5
    if not init_sigma > least:
        raise ValueError(f"init_sigma: expected more than {least}, got {init_sigma}")
    if not threshold >= 0.0:
        raise ValueError(f"threshold: expected a number >= 0, got {threshold}")


def _responses(
    img: Tensor, response: str, num_octaves: int, n_levels: int, init_sigma: float, blur: float
) -> List[Tensor]:
    """The responses (B, n_levels + 2, H, W) of each octave, of an image that already has the given blur."""
    count = n_levels + 3 if response == "dog" else n_levels + 2
    sigmas = [init_sigma * 2.0 ** (k / n_levels) for k in range(count)]
    levels = [_blurred(img, math.sqrt(init_sigma * init_sigma - blur * blur))]
    out: List[Tensor] = []
    for octave in range(num_octaves):
        if octave > 0:
            levels = [_every_second(_every_second(levels[n_levels], 2), 3)]
        if levels[0].size(2) < 8 or levels[0].size(3) < 8:
            break
        for k in range(1, count):
            levels.append(
                _blurred(levels[k - 1], math.sqrt(sigmas[k] * sigmas[k] - sigmas[k - 1] * sigmas[k - 1]))
            )
        out.append(_response(torch.cat(levels, 1), response, sigmas))
    return out


def _response(levels: Tensor, response: str, sigmas: List[float]) -> Tensor:
    if response == "dog":
        return dog_response(levels[:, None])[:, 0]
    if response == "harris":
        found = harris_response(levels)
    elif response == "gftt":
        found = gftt_response(levels)
    else:
        found = hessian_response(levels)
    return torch.stack(
        [found[:, k] * (sigmas[k] * sigmas[k] * sigmas[k] * sigmas[k]) for k in range(len(sigmas))], 1
    )


def _blurred(x: Tensor, sigma: float) -> Tensor:
    size = 2 * math.ceil(4.0 * sigma) + 1
    return gaussian_blur2d(x, size, (sigma, sigma), "replicate")


def _every_second(x: Tensor, dim: int) -> Tensor:
    return x.index_select(dim, 2 * torch.arange((x.size(dim) + 1) // 2, device=x.device))


def _strongest(volumes: List[Tensor], signed: bool, radii: List[float], count: int) -> Tuple[Tensor, Tensor]:
    """The indices (B, count) of the strongest extrema among the voxels of all octaves, and which of them
    exist."""
    strengths: List[Tensor] = []
    places: List[Tensor] = []
    offset = 0
    for volume in volumes:
        place = scale_space_nms(volume.detach(), radii, signed, count)
        value = volume.detach().flatten(1).gather(1, place.clamp(min=0)).abs()
        strengths.append(torch.where(place >= 0, value, torch.full_like(value, -1.0)))
        places.append(place + offset)
        offset = offset + volume.size(1) * volume.size(2) * volume.size(3)
    strength, order = stable_topk(torch.cat(strengths, 1), count)
    found = strength > 0
    index = torch.cat(places, 1).gather(1, order)
    return torch.where(found, index, torch.zeros_like(index)), found


def _located(volumes: List[Tensor], index: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """For indices among all voxels: scale, row and column (B, K, 3), at least 1; the octave (B, K), its sizes
    (B, K, 3) and its pixel size (B, K)."""
    zero = torch.zeros_like(index)
    depth = volumes[0].size(1)
    octave, start, height, width = zero, zero, zero + volumes[0].size(2), zero + volumes[0].size(3)
    pixel = torch.ones_like(index).to(torch.float64)
    offset, size = 0, 1.0
    for k in range(1, len(volumes)):
        offset = offset + depth * volumes[k - 1].size(2) * volumes[k - 1].size(3)
        size = 2.0 * size
        beyond = index >= offset
        octave, start = torch.where(beyond, zero + k, octave), torch.where(beyond, zero + offset, start)
        height, width = (
            torch.where(beyond, zero + volumes[k].size(2), height),
            torch.where(beyond, zero + volumes[k].size(3), width),
        )
        pixel = torch.where(beyond, torch.full_like(pixel, size), pixel)
    # By float64, which is exact: integer division in ONNX goes through float32.
    rest = index - start
    level = torch.floor(rest.to(torch.float64) / (height * width)).to(torch.int64)
    rest = rest - level * height * width
    row = torch.floor(rest.to(torch.float64) / width).to(torch.int64)
    place = torch.stack([level, row, rest - row * width], -1).clamp(min=1)
    return place, octave, torch.stack([zero + depth, height, width], -1), pixel


def _refined(volumes: List[Tensor], place: Tensor, octave: Tensor, extent: Tensor) -> Tuple[Tensor, Tensor]:
    """Scale, x and y (B, K, 3) and values (B, K) of the quadratics' extrema, in float64."""
    here = place
    shift, rise, regular, own = _quadratic(volumes, here, octave, extent)
    value = own
    for _ in range(2):
        step = (shift > 0.6).to(torch.int64) - (shift < -0.6).to(torch.int64)
        step = torch.where(regular[..., None], step, torch.zeros_like(step))
        here = torch.minimum((here + step).clamp(min=1), extent - 2)
        shift, rise, regular, value = _quadratic(volumes, here, octave, extent)
    near = (shift.detach().abs() <= 0.6).all(-1) & regular
    position = torch.where(near[..., None], here + shift, place.to(shift.dtype))
    return position.index_select(-1, torch.tensor([0, 2, 1], device=place.device)), torch.where(
        near, value + rise, own
    )


def _quadratic(
    volumes: List[Tensor], place: Tensor, octave: Tensor, extent: Tensor
) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
    """Shift (B, K, 3) along scale, row and column to the extremum at each place, its rise, whether there is
    one, and the voxel's value (B, K)."""
    cube = torch.arange(3, device=place.device) - 1
    level = place[..., 0][..., None, None, None] + cube[:, None, None]
    down = place[..., 1][..., None, None, None] + cube[:, None]
    across = place[..., 2][..., None, None, None] + cube
    height, width = extent[..., 1][..., None, None, None], extent[..., 2][..., None, None, None]
    index = ((level * height + down) * width + across).flatten(1)
    own = octave[..., None, None, None].expand(-1, -1, 3, 3, 3).flatten(1)
    near = volumes[0].flatten(1).gather(1, torch.where(own == 0, index, torch.zeros_like(index)))
    for k in range(1, len(volumes)):
        there = volumes[k].flatten(1).gather(1, torch.where(own == k, index, torch.zeros_like(index)))
        near = torch.where(own == k, there, near)
    near = near.reshape(-1, 3, 3, 3).to(torch.float64)
    shift, rise, regular = quadratic_extrema(near)
    shape = [place.size(0), place.size(1)]
    shift = (
        shift[:, :, 0, 0, 0].index_select(1, torch.tensor([0, 2, 1], device=place.device)).unflatten(0, shape)
    )
    return (
        shift,
        rise[:, 0, 0, 0].unflatten(0, shape),
        regular[:, 0, 0, 0].unflatten(0, shape),
        near[:, 1, 1, 1].unflatten(0, shape),
    )
