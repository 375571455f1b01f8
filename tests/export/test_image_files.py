"""Images that the command reads and writes: as OpenCV reads them, and with one line for what is no image."""

import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import EpsImagePlugin, Image

from chiasm.export.images import read_image, to_array
from chiasm.export.manifest import BundleError
from chiasm.writing import write_whole
from tests.export.commands import refused, run

Folder = Callable[[str], Path]


def _bomb(path: Path) -> None:
    """A PNG whose header declares 60000 x 60000 pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(bytes(1000)))
        + chunk(b"IEND", b"")
    )


def test_images_that_cannot_be_read_or_written(light: Folder, photo: Path, tmp_path: Path) -> None:
    bundle, out = light("filters.sobel"), tmp_path / "out.png"
    _bomb(tmp_path / "bomb.png")
    (tmp_path / "cut.png").write_bytes(photo.read_bytes()[:400])
    (tmp_path / "text.png").write_text("no image")
    (tmp_path / "empty.png").write_bytes(b"")
    Image.fromarray(np.zeros((9, 9), np.float32)).save(tmp_path / "float.tif")
    for name, part in (
        ("bomb.png", "too many pixels"),
        ("cut.png", "not an image"),
        ("text.png", "not an image"),
        ("empty.png", "not an image"),
        ("float.tif", "32 bits"),
    ):
        refused(run("run", bundle, tmp_path / name, out), name, part)
    refused(run("run", bundle, tmp_path / "none.png", out), "none.png", "does not exist", status=2)
    for name, part in (
        ("out", "no extension"),
        ("out.xyz", "'.xyz'"),
        ("none/out.png", "none does not exist"),
    ):
        refused(run("run", bundle, photo, tmp_path / name), part)
    assert not list(tmp_path.glob("out*")) and not list(tmp_path.glob(".writing*"))


def test_writing_a_file_leaves_the_umask_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is the process's: a file that another thread makes meanwhile would be everyone's to write."""
    set_umask = os.umask
    before = set_umask(0o027)
    try:
        monkeypatch.setattr(os, "umask", lambda mask: pytest.fail("it sets the umask"))
        for _ in range(2):
            write_whole(tmp_path / "file", b"text")
    finally:
        set_umask(before)
    assert (tmp_path / "file").stat().st_mode & 0o777 == 0o640
    assert [(f.name, f.read_bytes()) for f in tmp_path.iterdir()] == [("file", b"text")]


def test_no_program_is_started_for_an_image(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pillow gives PostScript to Ghostscript, whatever the file is called."""
    started = tmp_path / "started"
    gs = tmp_path / "gs"
    gs.write_text(f"#!/bin/sh\ntouch {started}\n")
    gs.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(EpsImagePlugin, "gs_binary", None)  # found at its first use
    monkeypatch.setattr(EpsImagePlugin, "gs_windows_binary", None)
    image = tmp_path / "photo.png"
    image.write_text("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n%%EndComments\n")
    with pytest.raises(BundleError, match="PostScript"):
        read_image(image)
    assert not started.exists()


def test_files_are_read_as_opencv_reads_them(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    grey, colour = (
        random.integers(0, 65536, (13, 17), np.uint16),
        random.integers(0, 65536, (13, 17, 3), np.uint16),
    )
    cv2.imwrite(str(tmp_path / "grey16.png"), grey)
    cv2.imwrite(str(tmp_path / "colour16.png"), colour)
    cv2.imwrite(str(tmp_path / "grey16.tif"), grey)
    eight = random.integers(0, 256, (13, 17, 4), np.uint8)
    Image.fromarray(eight).save(tmp_path / "alpha.png")
    Image.fromarray(eight[..., 0]).convert("P").save(tmp_path / "palette.png")
    Image.fromarray(eight[..., 0] > 99).save(tmp_path / "bits.png")
    for orientation in range(1, 9):
        exif = Image.Exif()
        exif[0x0112] = orientation
        Image.fromarray(eight[..., :3]).save(tmp_path / f"turned{orientation}.jpg", exif=exif, quality=95)
    wanted = {"layout": "HWC", "shape": ["H", "W", 3], "dtype": "uint8", "color": "BGR", "name": "frame"}
    files = sorted(tmp_path.iterdir())
    assert len(files) == 14
    for file in files:
        expected = cv2.imread(str(file))
        got = to_array(wanted, read_image(file), [])
        assert got.shape == expected.shape, file.name
        # Two decoders of JPEG
        assert np.abs(got.astype(int) - expected).max() <= 2 * (file.suffix == ".jpg"), file.name


def test_numbers_have_all_sixteen_bits_and_the_colour_order_that_is_asked_for(tmp_path: Path) -> None:
    values = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    cv2.imwrite(str(tmp_path / "grey.png"), values)
    one = {"layout": "NCHW", "shape": ["B", 1, "H", "W"], "dtype": "T", "color": "GRAY", "name": "input"}
    got = to_array(one, read_image(tmp_path / "grey.png"), ["float32", "float64"])
    assert (
        got.dtype == np.float32
        and got.shape == (1, 1, 256, 256)
        and np.array_equal(np.rint(got[0, 0] * 65535), values)
    )
    colour = np.random.default_rng(2).integers(0, 256, (5, 7, 3), np.uint8)
    Image.fromarray(colour).save(tmp_path / "colour.png")
    bgr = to_array(
        one | {"shape": ["B", 3, "H", "W"], "color": "BGR"}, read_image(tmp_path / "colour.png"), ["float32"]
    )
    assert np.array_equal(np.rint(bgr[0] * 255), colour[..., ::-1].transpose(2, 0, 1))


def test_a_pgm_of_16_bits_is_read_as_by_opencv(tmp_path: Path) -> None:
    values = np.random.default_rng(0).integers(0, 65536, (9, 7), np.uint16)
    assert cv2.imwrite(str(tmp_path / "deep.pgm"), values)
    read = read_image(tmp_path / "deep.pgm")
    assert read.dtype == np.uint16
    np.testing.assert_array_equal(read[..., 0], cv2.imread(str(tmp_path / "deep.pgm"), cv2.IMREAD_UNCHANGED))


def test_a_photograph_on_its_side_is_processed_upright(light: Folder, tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(np.zeros((20, 40, 3), np.uint8)).save(tmp_path / "side.jpg", exif=exif)
    done = run("run", light("filters.sobel"), tmp_path / "side.jpg", tmp_path / "[red]out.png", "-b", "onnx")
    assert done.returncode == 0 and "[red]out.png" in done.stdout, done.stderr
    assert Image.open(tmp_path / "[red]out.png").size == (20, 40)


def test_numbers_of_16_bits_have_the_files_values_or_their_bytes_rescaled(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    deep, eight = random.integers(0, 65536, (5, 7), np.uint16), random.integers(0, 256, (5, 7, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "deep.png"), deep)
    cv2.imwrite(str(tmp_path / "eight.png"), eight)
    frames = {"layout": "NHWC", "shape": ["B", "H", "W", 3], "dtype": "uint16", "color": "BGR", "name": "f"}
    got = to_array(frames, read_image(tmp_path / "deep.png"), [])
    assert got.dtype == np.uint16 and np.array_equal(got, np.repeat(deep[None, :, :, None], 3, 3))
    # PNG's rule for depths (ISO/IEC 15948, 13.12)
    rescaled = np.floor(eight * (65535 / 255) + 0.5)
    assert np.array_equal(to_array(frames, read_image(tmp_path / "eight.png"), [])[0], rescaled)
    grey = to_array(frames | {"shape": ["B", "H", "W", 1]}, read_image(tmp_path / "eight.png"), [])
    assert np.abs(grey[0, ..., 0] / 257 - cv2.cvtColor(eight, cv2.COLOR_BGR2GRAY)).max() <= 1
    with pytest.raises(BundleError, match="'f' is int16, which image files do not have"):
        to_array(frames | {"dtype": "int16"}, read_image(tmp_path / "deep.png"), [])


def test_frames_are_images_too(light: Folder, tmp_path: Path) -> None:
    colour = np.random.default_rng(4).integers(0, 256, (20, 24, 3), np.uint8)
    Image.fromarray(colour).save(tmp_path / "in.png")
    done = run("run", light("filters.median_blur.frames"), tmp_path / "in.png", tmp_path / "out.png")
    assert done.returncode == 0, done.stderr
    inner = np.s_[1:-1, 1:-1]  # OpenCV has another border
    expected = cv2.medianBlur(colour, 3)[inner]
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "out.png"))[inner], expected)
