"""Local maxima against SciPy; heat maps and windows against NumPy; refined maxima against closed forms and a
loop in NumPy."""

import numpy as np
import pytest
import scipy.ndimage as ndi
import scipy.special
import scipy.stats
import torch
from photos import photo
from torch import Tensor

from chiasm.geometry.subpix import (
    conv_quad_interp3d,
    conv_soft_argmax2d,
    conv_soft_argmax3d,
    iterative_quad_interp3d,
    nms2d,
    nms3d,
    nms3d_minmax,
    render_gaussian2d,
    spatial_expectation2d,
    spatial_soft_argmax2d,
    spatial_softmax2d,
)

D = torch.float64


def noise(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed), dtype=D)


def blobs(*shape: int, seed: int = 0) -> Tensor:
    """Smooth volumes (B, C, D, H, W)."""
    smooth = ndi.gaussian_filter(noise(*shape, seed=seed).numpy(), (0, 0, 0.8, 1.0, 1.1), mode="nearest")
    return torch.from_numpy(10.0 * smooth)


# --- local maxima -------------------------------------------------------------------------------------------


def strict_maxima(x: np.ndarray, size: tuple[int, ...]) -> np.ndarray:
    """Values that exceed all others in a window over the last axes; values beyond the border are infinite."""
    others = np.ones(size, bool)
    others[tuple((k - 1) // 2 for k in size)] = False
    lead = x.ndim - len(size)
    origin = [0] * lead + [(k - 1) // 2 - k // 2 for k in size]
    return x > ndi.maximum_filter(
        x, footprint=others[(None,) * lead], mode="constant", cval=np.inf, origin=origin
    )


@pytest.mark.parametrize("size", [(3, 3), (5, 5), (3, 7), (2, 2), (4, 3), (1, 5)])
@pytest.mark.parametrize("channels", [1, 3])
def test_nms2d_equals_scipy(size: tuple[int, int], channels: int) -> None:
    x = photo(2, channels, 33, 40) - 0.5
    expected = strict_maxima(x.numpy(), size)
    assert expected.sum() > 10
    np.testing.assert_array_equal(nms2d(x, size, True), expected)
    np.testing.assert_array_equal(nms2d(x, size), np.where(expected, x.numpy(), 0))


@pytest.mark.parametrize("size", [(3, 3, 3), (1, 3, 5), (2, 4, 3), (3, 1, 1), (5, 2, 3)])
def test_nms3d_equals_scipy(size: tuple[int, int, int]) -> None:
    x = noise(2, 3, 9, 17, 20)
    expected = strict_maxima(x.numpy(), size)
    assert expected.sum() > 10
    np.testing.assert_array_equal(nms3d(x, size, True), expected)
    np.testing.assert_array_equal(nms3d(x, size), np.where(expected, x.numpy(), 0))


def test_one_size_stands_for_all_axes() -> None:
    x = noise(1, 2, 7, 12, 13)
    assert torch.equal(nms3d(x, 3), nms3d(x, (3, 3, 3)))
    assert torch.equal(nms2d(x[0], 3), nms2d(x[0], (3, 3)))


def test_maxima_and_minima() -> None:
    x = noise(2, 2, 6, 15, 16)
    maxima, minima = nms3d_minmax(x)
    np.testing.assert_array_equal(maxima, strict_maxima(x.numpy(), (3, 3, 3)))
    np.testing.assert_array_equal(minima, strict_maxima(-x.numpy(), (3, 3, 3)))


def test_a_plateau_has_no_maximum() -> None:
    x = torch.zeros(1, 1, 5, 7, 7)
    x[0, 0, 2, 3, 2:4] = 1.0
    assert not nms3d(x, 3, True).any()
    assert not nms2d(x[:, :, 2], 3, True).any()


def test_suppression_hands_on_the_gradient_of_maxima() -> None:
    x = noise(1, 1, 5, 9, 9).requires_grad_(True)
    (gradient,) = torch.autograd.grad(nms3d(x, 3).sum(), x)
    assert torch.equal(gradient.bool(), nms3d(x, 3, True))


# --- heat maps ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("temperature", [None, 0.3, torch.tensor(0.3), torch.tensor([2.0])])
def test_softmax_equals_scipy(temperature: object) -> None:
    x = noise(2, 3, 9, 11)
    expected = scipy.special.softmax(
        x.numpy() / (1.0 if temperature is None else float(temperature)), axis=(2, 3)
    )
    np.testing.assert_allclose(spatial_softmax2d(x, temperature), expected, atol=1e-8)
    rows, columns = np.mgrid[:9, :11]
    position = np.stack([(expected * columns).sum((2, 3)), (expected * rows).sum((2, 3))], -1)
    np.testing.assert_allclose(spatial_soft_argmax2d(x, temperature, False), position, atol=1e-6)
    np.testing.assert_allclose(spatial_soft_argmax2d(x, temperature), position / [5, 4] - 1, atol=1e-6)


def test_large_values_do_not_overflow() -> None:
    x = torch.full((1, 1, 4, 5), 1e30)
    assert torch.equal(spatial_softmax2d(x), torch.full((1, 1, 4, 5), 0.05))


def test_expectation_is_linear() -> None:
    """A heat map with sum 3 gives three times the mean."""
    p = noise(2, 3, 9, 11).abs()
    p = p / p.sum((2, 3), keepdim=True)
    torch.testing.assert_close(spatial_expectation2d(3.0 * p), 3.0 * spatial_expectation2d(p))
    rows, columns = np.mgrid[:9, :11]
    mean = [
        [[np.average(axis, weights=p[b, c]) for axis in (columns, rows)] for c in range(3)] for b in range(2)
    ]
    np.testing.assert_allclose(spatial_expectation2d(p, False), mean, atol=1e-12)


def test_an_axis_of_one_pixel_is_0() -> None:
    assert torch.equal(spatial_expectation2d(torch.ones(1, 1, 1, 1)), torch.zeros(1, 1, 2))
    assert torch.equal(render_gaussian2d(torch.zeros(2), torch.ones(2), (1, 1)), torch.ones(1, 1))


@pytest.mark.parametrize("normalized", [True, False])
def test_gaussian_equals_scipy(normalized: bool) -> None:
    half, offset = (np.array([10, 7]), -1.0) if normalized else (np.array([1, 1]), 0.0)
    mean, std = 0.3 * noise(2, 5, 2), 0.1 + noise(5, 2, seed=1).abs()
    if not normalized:
        mean, std = 10.0 + 5.0 * mean, 4.0 * std
    x, y = np.arange(21) / half[0] + offset, np.arange(15) / half[1] + offset
    actual = render_gaussian2d(mean, std, (15, 21), normalized)
    for b in range(2):
        for n in range(5):
            density = np.outer(
                *(scipy.stats.norm.pdf(axis, mean[b, n, i], std[n, i]) for axis, i in ((y, 1), (x, 0)))
            )
            np.testing.assert_allclose(actual[b, n], density / density.sum(), atol=1e-14)


def test_a_gaussian_far_outside_is_on_the_nearest_border() -> None:
    out = render_gaussian2d(torch.tensor([500.0, 3.0]), torch.tensor([1.0, 0.1]), (7, 9), False)
    assert out[3, 8] == 1.0 and out.sum() == 1.0


def test_a_rendered_mean_is_found_again() -> None:
    mean = torch.tensor([[0.1, -0.2], [0.3, 0.25]], dtype=D)
    found = spatial_expectation2d(render_gaussian2d(mean, torch.tensor([0.1, 0.12], dtype=D), (64, 80))[None])
    torch.testing.assert_close(found[0], mean, rtol=0, atol=1e-6)


# --- windows ------------------------------------------------------------------------------------------------


def by_windows(x: np.ndarray, size, stride, padding, temperature: float) -> tuple[np.ndarray, np.ndarray]:
    """Means of position (slice, row, column) and of value of one volume, window by window."""
    counts = [(n + 2 * p - k) // s + 1 for n, p, k, s in zip(x.shape, padding, size, stride)]
    position, value = np.empty([3, *counts]), np.empty(counts)
    for at in np.ndindex(*counts):
        first = [i * s - p for i, s, p in zip(at, stride, padding)]
        inside = tuple(slice(max(f, 0), min(f + k, n)) for f, k, n in zip(first, size, x.shape))
        weight = scipy.special.softmax(x[inside] / temperature)
        position[(slice(None), *at)] = [(weight * axis).sum() for axis in np.mgrid[inside]]
        value[at] = (weight * x[inside]).sum()
    return position, value


@pytest.mark.parametrize(
    ("size", "stride", "padding"),
    [
        ((3, 3, 3), (1, 1, 1), (1, 1, 1)),
        ((3, 5, 3), (1, 2, 1), (0, 2, 1)),
        ((1, 2, 4), (2, 1, 3), (0, 1, 2)),
        ((2, 1, 3), (1, 1, 1), (1, 0, 0)),
    ],
)
def test_windows_equal_numpy(size, stride, padding) -> None:
    x = noise(2, 2, 5, 9, 12)
    position, value = conv_soft_argmax3d(x, size, stride, padding, 0.4)
    scaled, _ = conv_soft_argmax3d(
        x, size, stride, padding, torch.tensor([0.4], dtype=D), normalized_coordinates=True
    )
    flat, flat_value = conv_soft_argmax2d(
        x[:, 0], size[1:], stride[1:], padding[1:], 0.4, False, output_value=True
    )
    for b in range(2):
        for c in range(2):
            expected, expected_value = by_windows(x[b, c].numpy(), size, stride, padding, 0.4)
            np.testing.assert_allclose(position[b, c], expected[[0, 2, 1]], atol=1e-12)
            np.testing.assert_allclose(value[b, c], expected_value, atol=1e-12)
            half = np.array([2.0, 5.5, 4.0])[:, None, None, None]
            np.testing.assert_allclose(scaled[b, c], expected[[0, 2, 1]] / half - 1.0, atol=1e-12)
        for n in range(5):
            expected, expected_value = by_windows(
                x[b, 0, n][None].numpy(), (1, *size[1:]), (1, *stride[1:]), (0, *padding[1:]), 0.4
            )
            np.testing.assert_allclose(flat[b, n], expected[[2, 1], 0], atol=1e-12)
            np.testing.assert_allclose(flat_value[b, n], expected_value[0], atol=1e-12)
    assert torch.equal(conv_soft_argmax2d(x[:, 0]), conv_soft_argmax2d(x[:, 0], output_value=True)[0])
    assert torch.equal(conv_soft_argmax3d(x, output_value=False), conv_soft_argmax3d(x)[0])


def test_windows_do_not_see_the_rest() -> None:
    """A peak elsewhere, for which exp overflows, does not change a window."""
    x = noise(1, 1, 8, 9).float()
    other = x.clone()
    other[..., 7, 8] = 1e6
    torch.testing.assert_close(conv_soft_argmax2d(other)[..., :6, :7], conv_soft_argmax2d(x)[..., :6, :7])


def test_what_is_masked_has_no_weight() -> None:
    x = noise(1, 1, 6, 8)
    x[..., 3:] = -float("inf")
    position, value = conv_soft_argmax2d(x, normalized_coordinates=False, output_value=True)
    alone, alone_value = conv_soft_argmax2d(x[..., :3], normalized_coordinates=False, output_value=True)
    torch.testing.assert_close((position[..., :3], value[..., :3]), (alone, alone_value))
    assert (value[..., 4:] == -float("inf")).all()
    assert torch.equal(position[0, 0, 0, 0, 4:], torch.arange(4.0, 8.0, dtype=D))


def test_gradients_are_finite_at_borders_and_masks() -> None:
    x = noise(1, 1, 6, 8)
    x[..., 3:] = -float("inf")
    temperature = torch.tensor(0.5, dtype=D, requires_grad=True)
    position, _ = conv_soft_argmax2d(x.requires_grad_(True), temperature=temperature, output_value=True)
    for gradient in torch.autograd.grad(position.sum(), [x, temperature]):
        assert torch.isfinite(gradient).all()


# --- quadratics ---------------------------------------------------------------------------------------------


def quadratic(peak: list[float], shape: tuple[int, ...], matrix: np.ndarray) -> Tensor:
    """9 - d^T matrix d for the distance d = (scale, x, y) from the peak."""
    z, y, x = np.mgrid[tuple(slice(n) for n in shape)]
    d = np.stack([z, x, y], -1) - peak
    return torch.from_numpy(9.0 - np.einsum("...i,ij,...j", d, matrix, d))[None, None]


TILTED = np.array([[1.0, 0.3, -0.2], [0.3, 0.8, 0.1], [-0.2, 0.1, 1.2]])
REFINERS = pytest.mark.parametrize("refine", [conv_quad_interp3d, iterative_quad_interp3d])


def only(x: Tensor, *at: int) -> Tensor:
    mask = torch.zeros_like(x, dtype=torch.bool)
    mask[(0, 0, *at)] = True
    return mask


@REFINERS
def test_a_quadratic_is_refined_exactly(refine) -> None:
    peak = [2.2, 4.3, 3.8]
    x = quadratic(peak, (6, 8, 9), TILTED)
    position, value = refine(x)
    assert nms3d(x, 3, True).sum() == 1 and nms3d(x, 3, True)[0, 0, 2, 4, 4]
    np.testing.assert_allclose(position[0, 0, :, 2, 4, 4], peak, atol=1e-12)
    np.testing.assert_allclose(value[0, 0, 2, 4, 4], 9.0, atol=1e-12)
    # all others are unchanged
    grid = torch.from_numpy(np.mgrid[:6, :8, :9][[0, 2, 1]]).double()
    others = torch.ones(6, 8, 9, dtype=torch.bool)
    others[2, 4, 4] = False
    assert torch.equal(position[0, 0][:, others], grid[:, others])
    assert torch.equal(value[0, 0][others], x[0, 0][others])


def test_steps_lead_to_the_peak() -> None:
    x = quadratic([4.1, 6.2, 2.9], (8, 8, 9), np.eye(3))
    start = only(x, 2, 4, 3)  # two, three and one voxel away
    for tries, found in ((1, False), (3, False), (4, True), (9, True)):
        position, value = iterative_quad_interp3d(x, tries, precomputed_nms_mask=start)
        np.testing.assert_allclose(
            position[0, 0, :, 2, 4, 3], [4.1, 6.2, 2.9] if found else [2, 3, 4], atol=1e-12
        )
        np.testing.assert_allclose(value[0, 0, 2, 4, 3], 9.0 if found else x[0, 0, 2, 4, 3], atol=1e-12)
    for radius, found in ((0, False), (2, False), (3, True)):
        position, _ = conv_quad_interp3d(x, precomputed_nms_mask=start, dilation_radius=radius)
        np.testing.assert_allclose(
            position[0, 0, :, 2, 4, 3], [4.1, 6.2, 2.9] if found else [2, 3, 4], atol=1e-12
        )
    # the neighbourhood of another maximum works too
    both = start | only(x, 4, 3, 5)
    position, _ = conv_quad_interp3d(x, precomputed_nms_mask=both, dilation_radius=1)
    np.testing.assert_allclose(position[0, 0, :, 2, 4, 3], [4.1, 6.2, 2.9], atol=1e-12)


@REFINERS
@pytest.mark.parametrize(("scale", "found"), [(2.9, True), (3.4, True), (3.6, False)])
def test_without_scale_steps(refine, scale: float, found: bool) -> None:
    """The extremum may still be up to 1.5 scales away."""
    x = quadratic([scale, 5.2, 3.9], (7, 8, 9), np.eye(3))
    position, _ = refine(x, precomputed_nms_mask=only(x, 2, 4, 4), allow_scale_steps=False)
    np.testing.assert_allclose(
        position[0, 0, :, 2, 4, 4], [scale, 5.2, 3.9] if found else [2, 4, 4], atol=1e-12
    )


@REFINERS
def test_what_cannot_be_refined_stays(refine) -> None:
    cases = [
        (quadratic([2.0, 0.2, 4.0], (6, 8, 10), np.eye(3)), (2, 4, 1), {}),  # moves to the border
        (quadratic([2.0, 0.2, 4.0], (6, 8, 10), np.eye(3)), (2, 4, 0), {}),  # starts at the border
        (
            quadratic([2.0, 5.7, 4.0], (6, 8, 10), np.eye(3)),
            (2, 4, 4),
            {"max_subpixel_shift": 3.0},
        ),  # finally too far
        (quadratic([2.2, 4.3, 3.8], (6, 8, 9), np.diag([1.0, 1.0, 1e-8])), (2, 4, 4), {}),  # flat along y
        (torch.ones(1, 1, 5, 6, 7, dtype=D), (2, 3, 3), {}),
    ]
    for x, at, settings in cases:
        position, value = refine(x, precomputed_nms_mask=only(x, *at), **settings)
        assert position[(0, 0, slice(None), *at)].tolist() == [at[0], at[2], at[1]]
        assert torch.equal(value, x)


@REFINERS
def test_a_minimum_is_refined_where_the_mask_says_so(refine) -> None:
    x = -quadratic([2.2, 4.3, 3.8], (6, 8, 9), TILTED)
    _, minima = nms3d_minmax(x)
    position, value = refine(x, precomputed_nms_mask=minima)
    np.testing.assert_allclose(position[0, 0, :, 2, 4, 4], [2.2, 4.3, 3.8], atol=1e-12)
    np.testing.assert_allclose(value[0, 0, 2, 4, 4], -9.0, atol=1e-12)


def by_loop(v: np.ndarray, at: tuple[int, ...], tries: int, limit: float) -> tuple[np.ndarray, float] | None:
    """The refined (slice, row, column) and value, or None."""
    at = np.array(at)
    eye = np.eye(3, dtype=int)
    for _ in range(tries):
        if (at < 1).any() or (at > np.array(v.shape) - 2).any():
            return None

        def f(offset, at=at):
            return v[tuple(at + offset)]

        g = np.array([(f(e) - f(-e)) / 2 for e in eye])
        hessian = np.diag([f(e) - 2 * f(0) + f(-e) for e in eye])
        for i, j in ((0, 1), (0, 2), (1, 2)):
            a, b = eye[i], eye[j]
            hessian[i, j] = hessian[j, i] = (f(a + b) - f(a - b) - f(b - a) + f(-a - b)) / 4
        if abs(np.linalg.det(hessian)) <= 1e-7 * abs(hessian).max() ** 3:
            return None
        shift = -np.linalg.solve(hessian, g)
        step = np.where(abs(shift) > limit, np.sign(shift), 0).astype(int)
        if not step.any():
            return (at + shift, f(0) + g @ shift / 2) if (abs(shift) <= 1.5).all() else None
        at = at + step
    return None


@pytest.mark.parametrize(("tries", "limit"), [(5, 0.6), (2, 0.3), (1, 0.6), (4, 2.0)])
def test_refinement_equals_a_loop(tries: int, limit: float) -> None:
    x = blobs(2, 2, 7, 20, 23)
    # also voxels next to maxima, from which the refinement moves
    start = torch.roll(nms3d(x, 3, True), 1, -1) | nms3d(x, 3, True)
    position, value = iterative_quad_interp3d(x, tries, max_subpixel_shift=limit, precomputed_nms_mask=start)
    refined = 0
    for b, c, *at in start.nonzero().tolist():
        expected = by_loop(x[b, c].numpy(), at, tries, limit)
        refined += expected is not None
        where, what = expected or (np.array(at), x[(b, c, *at)])
        np.testing.assert_allclose(position[(b, c, slice(None), *at)], where[[0, 2, 1]], atol=1e-9)
        np.testing.assert_allclose(value[(b, c, *at)], what, atol=1e-9)
    assert start.sum() > 60 and 10 < refined < start.sum()
    if limit == 0.6:
        near = conv_quad_interp3d(
            x, tries, max_subpixel_shift=limit, precomputed_nms_mask=start, dilation_radius=tries
        )
        assert torch.equal(near[0], position) and torch.equal(near[1], value)


@pytest.mark.parametrize("count", [0, 1, 4, 100_000])
def test_the_strongest_candidates(count: int) -> None:
    x = blobs(2, 2, 7, 20, 23)
    every, _ = iterative_quad_interp3d(x)
    some, value = iterative_quad_interp3d(x, max_candidates=count)
    grid, _ = iterative_quad_interp3d(x, precomputed_nms_mask=torch.zeros_like(x, dtype=torch.bool))
    maxima = nms3d(x, 3, True).numpy()
    for b in range(2):
        for c in range(2):
            at = np.argwhere(maxima[b, c])
            order = np.argsort(-x[b, c].numpy()[maxima[b, c]], kind="stable")
            expected = grid[b, c].clone()
            for z, r, q in at[order[:count]]:
                expected[:, z, r, q] = every[b, c, :, z, r, q]
            assert torch.equal(some[b, c], expected)
    assert count > 0 or torch.equal(value, x)


def test_flat_volumes_have_a_zero_gradient() -> None:
    x = torch.zeros(1, 1, 5, 6, 7, dtype=D, requires_grad=True)
    position, value = iterative_quad_interp3d(
        x, precomputed_nms_mask=torch.ones(1, 1, 5, 6, 7, dtype=torch.bool)
    )
    (gradient,) = torch.autograd.grad(position.sum() + value.sum(), x)
    assert torch.equal(gradient, torch.ones_like(x))


@REFINERS
def test_volumes_of_two_slices_stay(refine) -> None:
    x = noise(1, 2, 2, 6, 7)
    position, value = refine(x)
    assert torch.equal(value, x) and position.shape == (1, 2, 3, 2, 6, 7)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float16, torch.bfloat16])
def test_dtype_is_kept(dtype: torch.dtype) -> None:
    x = photo(1, 3, 9, 12, dtype)
    volume = torch.stack([x, 0.8 * x, 0.5 * x, 0.9 * x], 2)
    results = [
        spatial_softmax2d(x),
        spatial_expectation2d(x),
        spatial_soft_argmax2d(x),
        nms2d(x, 3),
        nms3d(volume, 3),
    ]
    results += [render_gaussian2d(torch.zeros(3, 2, dtype=dtype), torch.ones(2, dtype=dtype), (5, 6))]
    results += [*conv_soft_argmax3d(volume), *conv_quad_interp3d(volume), *iterative_quad_interp3d(volume)]
    assert all(r.dtype == dtype and torch.isfinite(r).all() for r in results)
