"""Conversions and grids against NumPy and OpenCV, drawing against OpenCV."""

from typing import Callable
from unittest.mock import patch

import cv2
import numpy as np
import pytest
import torch
from photos import frame, photo
from torch.utils._python_dispatch import TorchDispatchMode

from chiasm import image
from chiasm.primitives.core.lowering import PRIMITIVES

# --- conversions and grids ----------------------------------------------------------------------------------


@pytest.mark.parametrize("channels", [1, 3, 4, 7])
def test_bytes_in_and_out(channels: int) -> None:
    levels = torch.round(photo(3, channels, 19, 23) * 255).to(torch.uint8)
    channels_last = levels.permute(0, 2, 3, 1)
    x = image.frames_to_tensor(channels_last)
    np.testing.assert_array_equal(x, levels.numpy().astype(np.float32) / np.float32(255))
    assert x.is_contiguous()
    assert torch.equal(image.tensor_to_frames(x), channels_last)
    assert torch.equal(image.frames_to_tensor(channels_last[0]), x[:1])
    assert torch.equal(image.frames_to_tensor(channels_last[0], keepdim=True), x[0])
    assert torch.equal(image.frames_to_tensor(channels_last, keepdim=True), x)
    assert torch.equal(image.tensor_to_frames(x[0]), channels_last[0])


def test_bytes_round_and_saturate_as_opencv() -> None:
    x = photo(1, 3, 37, 53) * 4 - 2
    assert x.min() < 0 and x.max() > 1
    saturated = np.stack([cv2.addWeighted(p, 255.0, p, 0.0, 0.0, dtype=cv2.CV_8U) for p in x[0].numpy()], -1)
    np.testing.assert_array_equal(image.tensor_to_frames(x)[0], saturated)
    halves = torch.arange(256).reshape(1, 1, 256) / 255.0 + 0.5 / 255.0
    exact = halves.double()
    expected = np.clip(np.rint((exact * 255).numpy()), 0, 255)
    np.testing.assert_array_equal(image.tensor_to_frames(exact)[..., 0], expected[0])


def test_camera_frame() -> None:
    x = image.frames_to_tensor(frame(48, 64))
    assert x.shape == (1, 3, 48, 64) and x.dtype == torch.float32
    np.testing.assert_array_equal(image.tensor_to_frames(x)[0], frame(48, 64))


def test_kernels_of_frames_take_bytes_in_rows_of_two_pixels() -> None:
    with patch.object(torch.compiler, "is_exporting", lambda: True):
        for name in ("frame_to_grey", "resize_frame"):
            takes = PRIMITIVES[f"chiasm.primitives.images.frames.{name}"].lowerings[0].when
            assert takes(torch.zeros(4, 2, 3, dtype=torch.uint8))
            assert not takes(torch.zeros(4, 2, 3)) and not takes(torch.zeros(4, 1, 3, dtype=torch.uint8))


@pytest.mark.parametrize(
    ("count", "n_row", "padding", "rows", "columns"),
    [
        (1, None, 2, 1, 1),
        (2, None, 2, 1, 2),
        (4, None, 0, 2, 2),
        (5, None, 3, 2, 3),
        (9, None, 2, 3, 3),
        (10, None, 1, 3, 4),
        (7, 1, 2, 7, 1),
        (7, 3, 1, 3, 3),
        (3, 5, 2, 1, 5),
        (6, 3, 0, 2, 3),
    ],
)
def test_grid_equals_slices(count: int, n_row: int, padding: int, rows: int, columns: int) -> None:
    x = photo(count, 3, 5, 7) + 0.01
    expected = np.zeros((3, rows * (5 + padding) - padding, columns * (7 + padding) - padding), np.float32)
    for i in range(count):
        top, left = i // columns * (5 + padding), i % columns * (7 + padding)
        expected[:, top : top + 5, left : left + 7] = x[i]
    np.testing.assert_array_equal(image.make_grid(x, n_row, padding), expected)


# --- drawing ------------------------------------------------------------------------------------------------


def lines(ends: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """OpenCV's lines x0, y0, x1, y1 (N, 4) as a mask."""
    canvas = np.zeros(size, np.uint8)
    for x0, y0, x1, y1 in ends.tolist():
        cv2.line(canvas, (x0, y0), (x1, y1), 1, 1, cv2.LINE_8)
    return canvas > 0


SIZE = (41, 57)


@pytest.mark.parametrize("channels", [1, 3, 7])
def test_points(channels: int) -> None:
    x = photo(2, channels, *SIZE)
    color = np.linspace(2, 3, channels).astype(np.float32)
    places = np.random.default_rng(0).integers(-3, 60, (2, 40, 2))
    actual = image.draw_point2d(x, torch.from_numpy(places), torch.from_numpy(color))
    for b in range(2):
        expected = x[b].numpy().copy()
        for px, py in places[b]:
            if 0 <= px < SIZE[1] and 0 <= py < SIZE[0]:
                expected[:, py, px] = color
        np.testing.assert_array_equal(actual[b], expected)
    single = image.draw_point2d(x[0], torch.from_numpy(places[0]) + 0.4, torch.from_numpy(color))
    assert torch.equal(single, actual[0])


@pytest.mark.parametrize("channels", [1, 3, 7])
def test_lines_equal_opencv(channels: int) -> None:
    x = photo(2, channels, *SIZE)
    color = np.linspace(2, 3, channels).astype(np.float32)
    ends = np.random.default_rng(1).integers(0, 41, (2, 60, 4))
    # A point, flat, upright, ties
    ends[:, :4] = [
        [5, 9, 5, 9],
        [3, 7, 30, 7],
        [8, 30, 8, 2],
        [10, 10, 30, 20],
    ]
    for n in range(60):
        p = torch.from_numpy(ends[:, n : n + 1])
        actual = image.draw_line(x, p[..., :2], p[..., 2:], torch.from_numpy(color))
        for b in range(2):
            expected = np.where(lines(ends[b, n : n + 1], SIZE), color[:, None, None], x[b].numpy())
            np.testing.assert_array_equal(actual[b], expected)


def test_many_lines_at_once_equal_opencv() -> None:
    x = photo(1, 3, *SIZE)
    ends = np.random.default_rng(2).integers(0, 41, (6, 4))
    p = torch.from_numpy(ends).float()
    actual = image.draw_line(x[0], p[:, :2], p[:, 2:], torch.tensor([5.0]))
    np.testing.assert_array_equal(actual, np.where(lines(ends, SIZE), np.float32(5), x[0].numpy()))
    one = image.draw_line(x[0], p[0, :2], p[0, 2:], torch.tensor([5.0]))
    assert torch.equal(one, image.draw_line(x[0], p[:1, :2], p[:1, 2:], torch.tensor([5.0])))


def test_lines_that_leave_the_image_are_cut() -> None:
    """The result is that of a larger image, cropped."""
    ends = np.random.default_rng(3).integers(-60, 120, (30, 4))
    for x0, y0, x1, y1 in ends.tolist():
        larger = lines(np.array([[x0, y0, x1, y1]]) + 70, (200, 200))
        actual = image.draw_line(
            torch.zeros(1, *SIZE), torch.tensor([x0, y0]), torch.tensor([x1, y1]), torch.ones(1)
        )
        np.testing.assert_array_equal(actual[0], larger[70 : 70 + SIZE[0], 70 : 70 + SIZE[1]])


RECTANGLES = np.array(
    [[3, 4, 20, 30], [10, 2, 50, 12], [-5, -5, 8, 8], [40, 30, 90, 70], [7, 7, 7, 7], [30, 20, 31, 21]]
)


@pytest.mark.parametrize("channels", [1, 3, 5])
@pytest.mark.parametrize(("fill", "width"), [(True, 1), (False, 1), (None, 3), (False, 5)])
def test_rectangles_equal_opencv(channels: int, fill: bool, width: int) -> None:
    x = photo(2, channels, *SIZE)
    colors = np.random.default_rng(4).random((2, 6, channels)).astype(np.float32) + 2
    batch = np.stack([RECTANGLES, RECTANGLES[::-1]])
    actual = image.draw_rectangle(x, torch.from_numpy(batch), torch.from_numpy(colors), fill, width)
    for b in range(2):
        expected = x[b].numpy()
        for n, (x1, y1, x2, y2) in enumerate(batch[b].tolist()):
            canvas = np.zeros((141, 157), np.uint8)
            cv2.rectangle(canvas, (x1 + 50, y1 + 50), (x2 + 50, y2 + 50), 255, -1 if fill else 1)
            if width > 1:  # OpenCV rounds the corners of wide lines: so widen its thin lines
                canvas = cv2.dilate(canvas, np.ones((width, width), np.uint8))
            mask = canvas[50 : 50 + SIZE[0], 50 : 50 + SIZE[1]] > 0
            expected = np.where(mask, colors[b, n][:, None, None], expected)
        np.testing.assert_array_equal(actual[b], expected)


def test_rectangles_on_16_bits() -> None:
    x = np.random.default_rng(5).integers(0, 65536, (1, 2, *SIZE)).astype(np.uint16)
    colors = np.array([[[60000, 1], [3, 65535]]], dtype=np.uint16)
    corners = np.array([[[3, 4, 20, 30], [10, 2, 50, 12]]])
    actual = image.draw_rectangle(
        torch.from_numpy(x), torch.from_numpy(corners), torch.from_numpy(colors), fill=True
    )
    expected = x.copy()
    expected[0, :, 4:31, 3:21] = colors[0, 0][:, None, None]
    expected[0, :, 2:13, 10:51] = colors[0, 1][:, None, None]
    np.testing.assert_array_equal(actual, expected[..., : SIZE[0], : SIZE[1]])


def test_rectangles_of_even_width() -> None:
    drawn = image.draw_rectangle(
        torch.zeros(1, 1, 9, 9), torch.tensor([[[2, 2, 6, 6]]]), torch.ones(1), line_width=2
    )[0, 0]
    expected = np.zeros((9, 9), np.float32)
    expected[1:7, 1:7] = 1
    expected[3:5, 3:5] = 0
    np.testing.assert_array_equal(drawn, expected)


def test_rectangle_colours_of_every_shape() -> None:
    x, r = photo(2, 3, *SIZE), torch.from_numpy(RECTANGLES).expand(2, 6, 4)
    full = torch.tensor([2.0, 3.0, 4.0])
    expected = image.draw_rectangle(x, r, full.expand(2, 6, 3))
    assert torch.equal(image.draw_rectangle(x, r, full), expected)
    assert torch.equal(image.draw_rectangle(x, r, torch.zeros(1)), image.draw_rectangle(x, r))
    assert torch.equal(
        image.draw_rectangle(x, r, torch.full((2, 6, 1), 7.0)),
        image.draw_rectangle(x, r, torch.full((3,), 7.0)),
    )
    # Empty
    assert torch.equal(image.draw_rectangle(x, torch.tensor([[[9, 9, 3, 3]]]).expand(2, 1, 4), full), x)
    unchanged = image.draw_rectangle(x, torch.zeros(2, 0, 4))
    assert torch.equal(unchanged, x) and unchanged.data_ptr() != x.data_ptr()


def ellipse(count: int, seed: int) -> np.ndarray:
    """Vertices of a convex polygon, with fractions."""
    generator = np.random.default_rng(seed)
    turn = np.sort(generator.random(count)) * 2 * np.pi
    return np.stack([28 + 25 * np.cos(turn + 0.3), 20 + 23 * np.sin(turn)], -1).astype(np.float32)


@pytest.mark.parametrize("count", [3, 4, 7, 12])
@pytest.mark.parametrize("whole", [False, True])
def test_polygons_equal_opencv(count: int, whole: bool) -> None:
    x = photo(2, 3, *SIZE)
    polygons = np.stack([ellipse(count, 1), ellipse(count, 2)[::-1]])  # both orders
    if whole:
        hulls = [cv2.convexHull(np.rint(p).astype(np.int32))[:, 0] for p in polygons]
        polygons = np.stack([np.concatenate([h, h[-1:].repeat(count - len(h), 0)]) for h in hulls]).astype(
            np.float32
        )
    colors = np.random.default_rng(0).random((2, 3)).astype(np.float32) + 2
    actual = image.draw_convex_polygon(x, torch.from_numpy(polygons), torch.from_numpy(colors))
    for b in range(2):
        inside = np.array(
            [
                [cv2.pointPolygonTest(polygons[b], (px, py), False) >= 0 for px in range(SIZE[1])]
                for py in range(SIZE[0])
            ]
        )
        assert 20 < inside.sum() < inside.size
        np.testing.assert_array_equal(actual[b], np.where(inside, colors[b][:, None, None], x[b].numpy()))
        canvas = np.zeros(SIZE, np.uint8)
        cv2.fillConvexPoly(canvas, np.rint(polygons[b]).astype(np.int32), 1)
        if whole:
            assert (canvas[inside] == 1).all()


@pytest.mark.parametrize(
    ("points", "pixels"),
    [
        ([[3, 3], [3, 3], [3, 3]], 1),  # a point
        ([[1, 2], [5, 2], [3, 2]], 5),  # a line
        ([[0.2, 0.2], [0.8, 0.2], [0.5, 0.8]], 0),  # between pixels
        ([[-9, -9], [30, -9], [30, 30], [-9, 30]], 64),  # everything
    ],
)
def test_degenerate_polygons(points: list[list[float]], pixels: int) -> None:
    drawn = image.draw_convex_polygon(
        torch.zeros(1, 1, 8, 8), torch.tensor([points], dtype=torch.float32), torch.ones(1)
    )
    assert drawn.sum() == pixels


@pytest.mark.parametrize("seed", range(6))
def test_polygons_are_filled_by_the_side_of_every_edge(seed: int) -> None:
    """Against the definition, pixel by pixel: integer and fractional vertices, convex or not, in both
    orientations, also outside the image."""
    torch.manual_seed(seed)
    vertices = torch.rand(4, 3 + seed, 2, dtype=torch.float64) * 24.0 - 6.0
    if seed % 2 == 0:
        vertices = vertices.round()
    drawn = image.draw_convex_polygon(torch.zeros(4, 1, 11, 13), vertices, torch.ones(1))[:, 0]
    for b in range(4):
        p = vertices[b].numpy()
        q = np.roll(p, -1, 0)
        for y in range(11):
            for x in range(13):
                side = (x - p[:, 0]) * (q - p)[:, 1] - (y - p[:, 1]) * (q - p)[:, 0]
                boxed = (p.min(0) <= (x, y)).all() and (p.max(0) >= (x, y)).all()
                assert drawn[b, y, x] == float(boxed and ((side >= 0).all() or (side <= 0).all()))


def test_a_polygon_of_many_vertices_takes_no_memory_for_each_pixel() -> None:
    largest = 0

    class Watched(TorchDispatchMode):
        def __torch_dispatch__(self, func, types, args=(), kwargs=None):
            nonlocal largest
            result = func(*args, **(kwargs or {}))
            largest = max(
                [
                    largest,
                    *(
                        t.numel()
                        for t in (result if isinstance(result, tuple) else (result,))
                        if isinstance(t, torch.Tensor)
                    ),
                ]
            )
            return result

    turn = torch.arange(300) * (2 * torch.pi / 300)
    with Watched():
        drawn = image.draw_convex_polygon(
            torch.zeros(1, 1, 100, 100),
            torch.stack([torch.cos(turn), torch.sin(turn)], -1)[None] * 40 + 50,
            torch.ones(1),
        )
    assert abs(float(drawn.sum()) - torch.pi * 1600) < 50
    assert largest <= 300 * 100


def test_the_input_is_left_alone_and_bytes_can_be_drawn_on() -> None:
    x = torch.zeros(1, 3, 8, 8, dtype=torch.uint8)
    p, c = torch.tensor([[[2, 3]]]), torch.tensor([9.0, 8.0, 7.0])
    results = [
        image.draw_point2d(x, p, c),
        image.draw_line(x, p, p, c),
        image.draw_rectangle(x, torch.cat([p, p], -1), c),
        image.draw_convex_polygon(x, p, c),
    ]
    assert x.sum() == 0
    for result in results:
        assert result.dtype == torch.uint8 and result[0, :, 3, 2].tolist() == [9, 8, 7] and result.sum() == 24


X, P, C = torch.zeros(2, 3, 8, 8), torch.zeros(2, 5, 2), torch.zeros(3)
WRONG = [
    (lambda: image.frames_to_tensor(X), TypeError, "image: expected dtype torch.uint8, got torch.float32"),
    (
        lambda: image.frames_to_tensor(X[0, 0].byte()),
        ValueError,
        r"image: expected shape \(H, W, C\) or \(B, H, W, C\), got \[8, 8\]",
    ),
    (lambda: image.tensor_to_frames(X.int()), TypeError, "tensor: expected a floating-point"),
    (lambda: image.tensor_to_frames(X[0, 0]), ValueError, "tensor: expected shape"),
    (lambda: image.make_grid(X[0]), ValueError, r"tensor: expected shape \(B, C, H, W\)"),
    (lambda: image.make_grid(X, 0), ValueError, "n_row: expected a positive number, got 0"),
    (lambda: image.make_grid(X, 2, -1), ValueError, "padding: expected zero or more, got -1"),
    (lambda: image.draw_point2d(X[0, 0, 0], P, C), ValueError, "image: expected shape"),
    (
        lambda: image.draw_point2d(X, P[0], C),
        ValueError,
        r"points: expected shape \(B, N, 2\) .* got \[5, 2\]",
    ),
    (
        lambda: image.draw_point2d(X[0], P, C),
        ValueError,
        r"points: expected shape \(N, 2\) .* got \[2, 5, 2\]",
    ),
    (
        lambda: image.draw_point2d(X, P, C[:2]),
        ValueError,
        r"color: expected shape \(C,\) or \(1,\) for C = 3, got \[2\]",
    ),
    (
        lambda: image.draw_line(X, P, P[:, :4], C),
        ValueError,
        "p2: expected as many points as p1 has, 5, got 4",
    ),
    (lambda: image.draw_line(X, P[..., :1], P, C), ValueError, "p1: expected shape"),
    (lambda: image.draw_line(X, P, P[..., 0], C), ValueError, "p2: expected shape"),
    (lambda: image.draw_rectangle(X[0], P, C), ValueError, r"image: expected shape \(B, C, H, W\)"),
    (
        lambda: image.draw_rectangle(X, P, C),
        ValueError,
        r"rectangle: expected shape \(B, N, 4\) .* got \[2, 5, 2\]",
    ),
    (
        lambda: image.draw_rectangle(X, P.repeat(1, 1, 2), C[:2]),
        ValueError,
        r"color: expected shape .* got \[2\]",
    ),
    (
        lambda: image.draw_rectangle(X, P.repeat(1, 1, 2), C, line_width=0),
        ValueError,
        "line_width: expected a positive number, got 0",
    ),
    (lambda: image.draw_convex_polygon(X[0], P, C), ValueError, "images: expected shape"),
    (
        lambda: image.draw_convex_polygon(X, P[:1], C),
        ValueError,
        r"polygons: expected shape \(B, N, 2\) .* got \[1, 5, 2\]",
    ),
    (
        lambda: image.draw_convex_polygon(X, P, X[..., 0, 0][:1]),
        ValueError,
        r"colors: expected shape .* got \[1, 3\]",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=range(len(WRONG)))
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
