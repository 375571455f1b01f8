"""Images of NumPy and of files as tensors, and as objects, against NumPy, OpenCV and Pillow."""

import os
import resource
import struct
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from PIL import Image as Pillow
from torch import Tensor

from chiasm import io
from chiasm.image import (
    ChannelsOrder,
    ColorSpace,
    Image,
    ImageLayout,
    ImageSize,
    ImageToTensor,
    PixelFormat,
    image_list_to_tensor,
    image_to_string,
    image_to_tensor,
    print_image,
    tensor_to_image,
)

RNG = np.random.default_rng(0)
RGB = RNG.integers(0, 256, (5, 7, 3), np.uint8)
RGBA = RNG.integers(0, 256, (5, 7, 4), np.uint8)
FIRST, LAST = ChannelsOrder.CHANNELS_FIRST, ChannelsOrder.CHANNELS_LAST


# --- arrays -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.int64, np.float16, np.float64, np.bool_])
@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 1), (5, 7, 3), (1, 5, 7, 3), (2, 5, 7, 4)])
def test_an_array_is_viewed_with_channels_first(shape: tuple[int, ...], dtype: type) -> None:
    array = (RNG.random(shape) * 200).astype(dtype)
    channels = array[..., None] if array.ndim == 2 else array
    expected = np.moveaxis(channels, -1, -3)
    kept, batch = image_to_tensor(array), image_to_tensor(array, keepdim=False)
    np.testing.assert_array_equal(kept.numpy(), expected)
    np.testing.assert_array_equal(batch.numpy(), expected if array.ndim == 4 else expected[None])
    assert kept.numpy().dtype == dtype and kept.data_ptr() == array.ctypes.data
    assert ImageToTensor()(array).equal(batch) and ImageToTensor(True)(array).equal(kept)


@pytest.mark.parametrize(
    ("shape", "expected", "kept"),
    [
        ((5, 7), (5, 7), (5, 7)),
        ((1, 5, 7), (5, 7), (5, 7)),
        ((3, 5, 7), (5, 7, 3), (5, 7, 3)),
        ((1, 1, 5, 7), (5, 7), (1, 5, 7)),
        ((1, 3, 5, 7), (5, 7, 3), (1, 5, 7, 3)),
        ((2, 1, 5, 7), (2, 5, 7), (2, 5, 7)),
        ((2, 4, 5, 7), (2, 5, 7, 4), (2, 5, 7, 4)),
        ((3, 1, 1), (1, 1, 3), (1, 1, 3)),
    ],
)
def test_a_tensor_is_viewed_with_channels_last(
    shape: tuple[int, ...], expected: tuple[int, ...], kept: tuple[int, ...]
) -> None:
    tensor = torch.rand(shape, requires_grad=True)
    array = tensor_to_image(tensor)
    assert array.shape == expected and tensor_to_image(tensor, keepdim=True).shape == kept
    assert array.ctypes.data == tensor.data_ptr()
    moved = np.moveaxis(tensor.detach().numpy(), -3, -1) if len(shape) > 2 else tensor.detach().numpy()
    np.testing.assert_array_equal(array, moved.reshape(expected))
    copied = tensor_to_image(tensor, force_contiguous=True)
    assert copied.flags.c_contiguous and np.array_equal(copied, array)
    assert tensor_to_image(tensor.bfloat16()).dtype == np.float32


def test_a_list_becomes_a_batch() -> None:
    images = [RNG.random((5, 7, 3)) for _ in range(3)]
    expected = np.moveaxis(np.stack(images), -1, 1)
    np.testing.assert_array_equal(image_list_to_tensor(images), expected)
    np.testing.assert_array_equal(image_list_to_tensor([torch.from_numpy(i) for i in images]), expected)


# --- objects ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [FIRST, LAST])
@pytest.mark.parametrize(
    ("method", "source", "code"),
    [
        ("to_gray", ColorSpace.RGB, cv2.COLOR_RGB2GRAY),
        ("to_gray", ColorSpace.BGR, cv2.COLOR_BGR2GRAY),
        ("to_rgb", ColorSpace.BGR, cv2.COLOR_BGR2RGB),
        ("to_bgr", ColorSpace.RGB, cv2.COLOR_RGB2BGR),
        ("to_rgb", ColorSpace.GRAY, cv2.COLOR_GRAY2RGB),
        ("to_bgr", ColorSpace.GRAY, cv2.COLOR_GRAY2BGR),
    ],
)
def test_colours_equal_opencv(method: str, source: ColorSpace, code: int, order: ChannelsOrder) -> None:
    frame = RGB[..., :1] if source == ColorSpace.GRAY else RGB
    expected = cv2.cvtColor(frame, code).reshape(5, 7, -1)
    given = frame if order == LAST else frame.transpose(2, 0, 1)
    image = Image.from_numpy(given, source, order)
    made = getattr(image, method)()
    found = made.to_numpy()
    np.testing.assert_array_equal(found if order == LAST else found.transpose(1, 2, 0), expected)
    assert made.channels == expected.shape[2] and made.channels_order == order
    assert made.pixel_format == PixelFormat(ColorSpace[method.partition("_")[2].upper()], 8)
    assert getattr(made, method)() is made and image.data.data_ptr() == given.ctypes.data


def test_an_image_knows_its_tensor() -> None:
    image = Image.from_numpy(RGBA)
    assert image.pixel_format == PixelFormat(ColorSpace.UNKNOWN, 8)
    assert image.layout == ImageLayout(ImageSize(5, 7), 4, LAST) and image.image_size == (5, 7)
    assert (image.height, image.width, image.shape) == (5, 7, (5, 7, 4))
    made = image.float()
    assert made.dtype == torch.float32 and made.pixel_format.bit_depth == 32 and image.dtype == torch.uint8
    assert made.data.equal(torch.from_numpy(RGBA).float()) and image.to(torch.float64).dtype == torch.float64
    copy = image.clone()
    copy.data.zero_()
    assert bool(image.data.any()) and image.device == torch.device("cpu")
    back = Image.from_dlpack(image.to_dlpack(), channels_order=LAST)
    assert back.data.data_ptr() == image.data.data_ptr() and back.layout == image.layout
    assert Image.from_dlpack(torch.rand(3, 4, 5)).pixel_format.color_space == ColorSpace.RGB
    grey = Image.from_numpy(RGB[..., 0])
    assert grey.shape == (5, 7, 1) and grey.pixel_format.color_space == ColorSpace.GRAY
    assert repr(grey).endswith(f"\nPixel Format: {grey.pixel_format}\n Layout: {grey.layout}")


@pytest.mark.parametrize("order", [FIRST, LAST])
def test_an_image_is_written_and_read(tmp_path: Path, order: ChannelsOrder) -> None:
    given = RGB if order == LAST else RGB.transpose(2, 0, 1)
    file = tmp_path / "a.png"
    Image.from_numpy(given, ColorSpace.BGR, order).write(file)
    np.testing.assert_array_equal(cv2.imread(str(file)), RGB)
    read = Image.from_file(file)
    np.testing.assert_array_equal(read.data, RGB[..., ::-1].transpose(2, 0, 1))
    assert read.channels_order == FIRST and read.pixel_format == PixelFormat(ColorSpace.RGB, 8)


# --- files --------------------------------------------------------------------------------------------------


def over_white(rgba: np.ndarray) -> np.ndarray:
    alpha = rgba[..., 3:] / 255.0
    return rgba[..., :3] * alpha + 255.0 * (1.0 - alpha)


def test_files_are_read_as_the_type_says(tmp_path: Path) -> None:
    file = tmp_path / "rgba.png"
    Pillow.fromarray(RGBA).save(file)
    load, kinds = io.load_image, io.ImageLoadType
    for kind in (kinds.UNCHANGED, kinds.RGBA8):
        np.testing.assert_array_equal(load(file, kind), RGBA.transpose(2, 0, 1))
    white = over_white(RGBA).transpose(2, 0, 1)
    assert np.abs(load(file, kinds.RGB8).numpy() - white).max() <= 1
    assert np.abs(load(file).numpy() - white / 255).max() <= 1.01 / 255
    luma = (white * np.array([0.299, 0.587, 0.114])[:, None, None]).sum(0)
    assert np.abs(load(file, kinds.GRAY32).numpy() - luma / 255).max() <= 1.01 / 255
    assert load(str(file), kinds.GRAY8).shape == (1, 5, 7)


def test_files_of_grey_and_of_a_palette(tmp_path: Path) -> None:
    grey, palette, deep = tmp_path / "grey.png", tmp_path / "palette.png", tmp_path / "deep.png"
    Pillow.fromarray(RGB[..., 0]).save(grey)
    coloured = Pillow.fromarray(RGB).quantize(8)
    coloured.save(palette)
    io.write_image(deep, torch.arange(35, dtype=torch.int32).mul(1800).to(torch.uint16).view(1, 5, 7))
    kinds = io.ImageLoadType
    np.testing.assert_array_equal(io.load_image(grey, kinds.UNCHANGED), RGB[None, ..., 0])
    np.testing.assert_array_equal(io.load_image(grey, kinds.RGB8), np.stack([RGB[..., 0]] * 3))
    np.testing.assert_array_equal(
        io.load_image(palette, kinds.RGB8), np.asarray(coloured.convert("RGB")).transpose(2, 0, 1)
    )
    np.testing.assert_array_equal(
        io.load_image(deep, kinds.UNCHANGED).to(torch.int32)[0], cv2.imread(str(deep), cv2.IMREAD_UNCHANGED)
    )
    with pytest.raises(ValueError, match=r"desired_type: expected UNCHANGED for .*deep\.png, whose values"):
        io.load_image(deep)


def test_a_jpeg_has_its_quality(tmp_path: Path) -> None:
    frame = cv2.resize(RGB, (64, 48), interpolation=cv2.INTER_CUBIC)
    sizes = []
    for quality in (30, 95):
        file = tmp_path / f"{quality}.JPG"
        io.write_image(file, image_to_tensor(frame), quality)
        sizes.append(file.stat().st_size)
    assert sizes[0] < sizes[1]
    assert (
        np.abs(io.load_image(file, io.ImageLoadType.RGB8).numpy() * 1.0 - frame.transpose(2, 0, 1)).mean() < 6
    )


def test_a_full_disk_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    file, planes = tmp_path / "a.bmp", torch.zeros(3, 40, 60, dtype=torch.uint8)
    file.write_bytes(b"mine")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (500, before[1]))  # as on a full disk
    try:
        with pytest.raises(OSError, match=r"too large: '.*a\.bmp'"):
            io.write_image(file, planes)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [(f.name, f.read_bytes()) for f in tmp_path.iterdir()] == [("a.bmp", b"mine")]
    io.write_image(file, planes)
    assert [f.name for f in tmp_path.iterdir()] == ["a.bmp"] and io.load_image(file).shape == (3, 40, 60)
    with pytest.raises(FileNotFoundError, match=r"'.*none/a\.png'"):
        io.write_image(tmp_path / "none" / "a.png", planes)


def test_files_that_are_no_images(tmp_path: Path) -> None:
    whole, pipe = BytesIO(), tmp_path / "pipe.png"
    Pillow.fromarray(RGB).save(whole, "PNG")
    os.mkfifo(pipe)
    damaged = {
        "cut.png": whole.getvalue()[:60],
        "flipped.png": whole.getvalue().replace(b"IDAT", b"IDAX"),
        "vast.png": whole.getvalue().replace(struct.pack(">II", 7, 5), struct.pack(">II", 60000, 60000)),
        "text.png": b"text",
        "empty.png": b"",
        "program.png": b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\nshowpage\n",
    }
    for name, data in damaged.items():
        (tmp_path / name).write_bytes(data)
    for file in (*(tmp_path / name for name in damaged), pipe, tmp_path, tmp_path / "none.png", f"{pipe}\0"):
        with pytest.raises(OSError):
            io.load_image(file)
    with pytest.raises(OSError, match=r"path_file: .*program\.png is PostScript, which is a program"):
        io.load_image(tmp_path / "program.png")


# --- a terminal ---------------------------------------------------------------------------------------------


def xterm() -> np.ndarray:
    """The colours from code 16 on, by xterm's documentation (256colres.pl)."""
    steps = [0] + [55 + 40 * k for k in range(1, 6)]
    cube = [(r, g, b) for r in steps for g in steps for b in steps]
    return np.array(cube + [(8 + 10 * k,) * 3 for k in range(24)], float)


def test_text_has_the_nearest_colour(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    codes = 16 + ((RGB[:, :, None].astype(float) - xterm()) ** 2).sum(-1).argmin(-1)
    expected = "".join("".join(f"\033[48;5;{c}m  " for c in row) + "\033[0m\n" for row in codes)
    planes = image_to_tensor(RGB)
    assert image_to_string(planes) == expected == image_to_string(planes.double() / 255)
    assert image_to_string(planes[:1]) == image_to_string(planes[:1].expand(3, -1, -1))
    file = tmp_path / "a.png"
    io.write_image(file, planes)
    print_image(file)
    print_image(planes)
    Image.from_numpy(RGB[..., ::-1].copy(), ColorSpace.BGR).print()
    assert capsys.readouterr().out == 3 * (expected + "\n")
    narrow = image_to_string(torch.full((1, 40, 60), 0.2), 6).splitlines()
    assert len(narrow) == 4 and narrow[0].count("  ") == 6


# --- errors -------------------------------------------------------------------------------------------------

LAYOUT = ImageLayout(ImageSize(5, 7), 3, LAST)
PLANES = torch.zeros(3, 5, 7, dtype=torch.uint8)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: image_to_tensor(PLANES),
            TypeError,
            "image: expected a NumPy array, got Tensor; frames_to_tensor",
        ),
        (lambda: image_to_tensor([1]), TypeError, "image: expected a NumPy array, got list$"),
        (lambda: image_to_tensor(RGB[0, 0]), ValueError, r"image: expected shape \(H, W\), .* got \[3\]"),
        (lambda: image_to_tensor(RGB[..., ::-1]), ValueError, "image: expected strides of at least 0"),
        (lambda: image_to_tensor(RGB.astype(object)), TypeError, "image: expected a dtype that PyTorch has"),
        (lambda: image_list_to_tensor([]), ValueError, "images: expected at least one, got none"),
        (lambda: image_list_to_tensor([RGB[0]]), ValueError, r"images\[0\]: expected shape \(H, W, C\)"),
        (lambda: image_list_to_tensor([RGB, RGB[1:]]), ValueError, r"images\[1\]: expected the first one's"),
        (lambda: tensor_to_image(RGB), TypeError, "tensor: expected a tensor, got ndarray"),
        (lambda: tensor_to_image(PLANES[0, 0]), ValueError, r"tensor: expected shape \(H, W\)"),
        (
            lambda: Image(PLANES, PixelFormat(ColorSpace.RGB, 8), LAYOUT),
            ValueError,
            "data: expected the layout",
        ),
        (
            lambda: Image(torch.from_numpy(RGB), PixelFormat(ColorSpace.RGB, 32), LAYOUT),
            ValueError,
            "pixel_format: expected a bit_depth of 8 for torch.uint8, got 32",
        ),
        (
            lambda: Image.from_numpy(RGB, ColorSpace.GRAY),
            ValueError,
            "layout: expected 1 channels for GRAY, got 3",
        ),
        (
            lambda: Image.from_numpy(RGB[None]),
            ValueError,
            r"data: expected shape \(H, W, C\), got \[1, 5, 7, 3\]",
        ),
        (lambda: Image.from_numpy(RGBA).to_rgb(), ValueError, "pixel_format: expected GRAY, RGB or BGR"),
        (lambda: Image.from_numpy(RGB, None, 1), ValueError, "channels_order: expected CHANNELS_FIRST or"),
        (lambda: io.load_image("a.png", "RGB8"), TypeError, "desired_type: expected an ImageLoadType"),
        (lambda: io.write_image("a.png", PLANES[:2]), ValueError, r"image: expected shape \(H, W\), or"),
        (
            lambda: io.write_image("a.png", PLANES.float()),
            TypeError,
            "image: expected uint8, or uint16 of one",
        ),
        (lambda: io.write_image("a.png", PLANES, 101), ValueError, "quality: expected 0 to 100, got 101"),
        (lambda: io.write_image("a.png", PLANES, "80"), TypeError, "quality: expected an int, got str"),
        (lambda: io.write_image("a.nope", PLANES), ValueError, "path_file: expected the extension.*'.nope'"),
        (lambda: io.write_image(3, PLANES), TypeError, "path_file: expected a path, got int"),
        (lambda: io.load_image(None), TypeError, "path_file: expected a path, got NoneType"),
        (lambda: image_to_string(PLANES[:2]), ValueError, r"image: expected shape \(C, H, W\) of 1 or 3"),
        (
            lambda: image_to_string(PLANES + 1.5),
            ValueError,
            r"image: expected values in \[0, 1\], got 1.5 to",
        ),
    ],
)
def test_errors_name_the_argument(call: Callable[[], Tensor], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=f"^{message}"):
        call()
