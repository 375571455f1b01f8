"""Rows as other libraries have them: NumPy's bytes, images of Pillow, paths, structs of Hugging Face."""

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pyarrow as pa
import pytest
from PIL import Image

import chiasm.runtime
from chiasm.data import DataError, Files, Map
from chiasm.data.decoding import decode

from .conftest import BUNDLES, EDGES, PREPROCESS, encoded

MEDIAN = BUNDLES / "filters.median_blur.frames.chiasm"
NMS = BUNDLES / "geometry.bbox.nms_fixed.chiasm"
RNG = np.random.default_rng(6)


def edges(frame: np.ndarray) -> np.ndarray:
    return chiasm.runtime.open(EDGES).method("forward", num_threads=1)(frame)


def test_paths_may_be_objects_and_an_empty_one_is_shown(photos: Path) -> None:
    read = Map(PREPROCESS, columns={"frame": Files("path")}, errors="column")
    result = read({"path": [photos / "0000.jpg", ""]})
    assert list(result["error"]) == [None, "'': No such file or directory"]


def test_fixed_bytes_of_numpy_keep_their_zeros() -> None:
    """A bitmap's last bytes are its first row, here black. NumPy pads the shorter file."""
    frames = [RNG.integers(1, 256, (16, width, 3), np.uint8) for width in (24, 40)]
    for frame in frames:
        frame[:8] = 0
    files = np.array([cv2.imencode(".bmp", frame)[1].tobytes() for frame in frames])
    assert files.dtype.kind == "S" and files[0].endswith(b"\0") is False
    for got, frame in zip(Map(EDGES)({"frame": files})["output"], frames):
        np.testing.assert_array_equal(got, edges(frame))


@pytest.mark.parametrize("form", [".jpg", ".png", ".tif", ".webp"])
def test_files_of_other_formats_may_be_padded(form: str) -> None:
    files = [cv2.imencode(form, RNG.integers(0, 256, (16, w, 3), np.uint8))[1].tobytes() for w in (24, 64)]
    for got, file in zip(Map(EDGES)({"frame": np.array(files)})["output"], files):
        assert got.shape == cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_GRAYSCALE).shape


def test_images_of_pillow_have_the_colour_order_of_the_op() -> None:
    frame = RNG.integers(0, 256, (16, 24, 3), np.uint8)
    picture = Image.fromarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB))
    [got] = Map(EDGES)({"frame": [picture]})["output"]  # takes BGR
    np.testing.assert_array_equal(got, edges(frame))
    with pytest.raises(DataError, match="expected an array, got an image: it takes no image"):
        Map(NMS)({"boxes": [picture], "scores": np.zeros((1, 2), np.float32)})


@pytest.mark.parametrize("color", ["", "YUV", "L"])
def test_a_colour_of_another_name_is_read_as_rgb(color: str) -> None:
    frame = RNG.integers(0, 256, (16, 24, 3), np.uint8)
    tensor = SimpleNamespace(name="frame", dtypes=["uint8"], layout="HWC", shape=["H", "W", "3"], color=color)
    for data in (cv2.imencode(".png", frame[..., ::-1])[1].tobytes(), Image.fromarray(frame)):
        np.testing.assert_array_equal(decode(tensor, data), frame)


def test_numbers_of_16_bits_are_read_from_files() -> None:
    frame = RNG.integers(0, 65536, (24, 32), np.uint16)
    file = cv2.imencode(".png", frame)[1].tobytes()
    got = Map(MEDIAN, columns={"input": "file"}, dtype="uint16")({"file": [file]})["output"][0]
    inner = np.s_[1:-1, 1:-1]  # OpenCV has another border
    np.testing.assert_array_equal(got[..., 0][inner], cv2.medianBlur(frame, 3)[inner])


def test_images_of_hugging_face_are_read() -> None:
    """Their library stores an image as a struct of its bytes and its path."""
    frames = [RNG.integers(0, 256, (16, 24, 3), np.uint8) for _ in range(3)]
    images = [{"bytes": cv2.imencode(".png", frame)[1].tobytes(), "path": "x.png"} for frame in frames]
    kind = pa.struct({"bytes": pa.binary(), "path": pa.string()})
    table = pa.table({"image": pa.array([None, *images, None], kind)}).slice(1)
    got = Map(EDGES, columns={"frame": "image"}, errors="column")(table)
    assert got["error"].to_pylist() == [None] * 3 + ["input 'frame': it is missing in this row"]
    for row, frame in zip(got["output"].to_pylist(), frames):
        np.testing.assert_array_equal(np.reshape(row["data"], row["shape"]), edges(frame))


def test_a_batch_of_missing_rows_alone_has_the_columns_of_the_others() -> None:
    for bundle in (PREPROCESS, EDGES):
        mapping = Map(bundle, errors="column")
        missing = mapping(pa.record_batch({"frame": [None, None]}))
        assert missing["error"].to_pylist() == ["input 'frame': it is missing in this row"] * 2
        assert missing.schema == mapping(pa.record_batch({"frame": [encoded(RNG, 48, 64)]})).schema


def test_an_iterator_of_something_else_is_one_error() -> None:
    with pytest.raises(DataError, match="expected an iterator of Arrow record batches, got one of builtins"):
        next(Map(EDGES)(iter([5])))
    with pytest.raises(DataError, match=r"got one of pyarrow\.lib\.Table"):
        next(Map(EDGES)(iter([pa.table({"frame": [b""]})])))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"columns": "image"}, r"columns: expected a dict \{INPUT: COLUMN\}, got 'image'"),
        ({"columns": ["image"]}, r"columns: expected a dict \{INPUT: COLUMN\}, got \['image'\]"),
        ({"outputs": ["output"]}, r"outputs: expected a dict \{OUTPUT: COLUMN\}, got \['output'\]"),
        ({"outputs": {"output": None}}, r"a column of its own for each output, got \[None\]"),
        ({"columns": {"frame": Path("image")}}, r"expected a column's name or Files\(NAME\) for one of them"),
    ],
)
def test_arguments_of_another_kind_are_one_error(arguments: dict, message: str) -> None:
    with pytest.raises(DataError, match=message):
        Map(EDGES, **arguments)


def test_a_type_that_numpy_lacks_is_one_error() -> None:
    grey = Map(BUNDLES / "color.rgb_to_grayscale.chiasm", dtype="bfloat16")
    with pytest.raises(
        DataError, match="'image' is bfloat16, which NumPy and Arrow do not have: take another"
    ):
        grey({"image": np.zeros((2, 3, 8, 8), np.float32)})


def test_columns_that_pass_through_have_as_many_rows() -> None:
    batch = {"frame": [b"", b""], "path": ["a"], "note": np.float32(1)}
    with pytest.raises(DataError, match=r"different numbers of rows: \{'frame': 2, 'path': 1\}"):
        Map(EDGES, id="path")(batch)


def test_a_column_of_names_that_is_not_there_is_named() -> None:
    with pytest.raises(DataError, match="no column 'path': it has 'frame'; name another by id=COLUMN"):
        Map(EDGES, id="path")({"frame": [encoded(RNG, 48, 64)]})


def test_a_column_of_errors_says_what_to_do() -> None:
    batch = {"frame": [encoded(RNG, 48, 64)], "error": [None]}
    with pytest.raises(
        DataError, match="'error' already: rename or drop it; or, in Python, take errors='null'"
    ):
        Map(EDGES, errors="column")(batch)
    assert list(Map(EDGES, errors="null")(batch)) == ["error", "output"]
