"""`Map` on NumPy and Arrow batches, without an engine. Results are compared with chiasm.runtime."""

import io
import os
import pickle
import shutil
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
from PIL import Image

import chiasm.runtime
from chiasm.data import DataError, Files, Map
from chiasm.data.columns import from_arrow

from .conftest import BAD, BLUR, BUNDLES, EDGES, PREPROCESS, SOBEL, encoded, same_rows

GREY_TO_RGB = BUNDLES / "color.grayscale_to_rgb.frames.chiasm"
RNG = np.random.default_rng(1)
IMAGES = RNG.random((6, 3, 24, 40), np.float32)


def direct(bundle: Path, *inputs: np.ndarray) -> np.ndarray:
    return chiasm.runtime.open(bundle).method("forward", num_threads=1)(*inputs)


def tensors(array: np.ndarray) -> pa.Array:
    return pa.FixedShapeTensorArray.from_numpy_ndarray(array)


def stacked(column: pa.Array) -> np.ndarray:
    return column.to_numpy_ndarray()


def structs(column: pa.Array) -> list[np.ndarray | None]:
    return [r if r is None else np.array(r["data"]).reshape(r["shape"]) for r in column.to_pylist()]


def test_import_needs_the_standard_library_alone() -> None:
    code = (
        "import sys, chiasm.data\n"
        "print(sorted({m.partition('.')[0] for m in sys.modules} - set(sys.stdlib_module_names)))"
    )
    plain = subprocess.check_output([sys.executable, "-S", "-c", "pass"], text=True)
    result = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True)
    assert plain == "" and result.stdout.strip() == "['__main__', 'chiasm']", result


def test_rows_go_as_one_batch_with_the_same_bits() -> None:
    want = direct(SOBEL, IMAGES)
    numpy = Map(SOBEL)({"id": np.arange(6), "input": IMAGES})
    np.testing.assert_array_equal(numpy["output"], want)
    assert list(numpy) == ["id", "output"]
    batch = pa.record_batch({"id": pa.array(range(6)), "input": tensors(IMAGES)})
    result = Map(SOBEL)(batch)
    assert isinstance(result, pa.RecordBatch) and result.schema.names == ["id", "output"]
    np.testing.assert_array_equal(stacked(result["output"]), want)
    table = Map(SOBEL)(pa.Table.from_batches([batch, batch.slice(1, 2), batch.slice(0, 0)]))
    assert isinstance(table, pa.Table) and table.num_rows == 8
    np.testing.assert_array_equal(stacked(table["output"].chunk(1)), want[1:3])


def test_numbers_are_read_and_written_where_they_are() -> None:
    column = tensors(IMAGES)
    assert np.shares_memory(from_arrow("input", column).stack, IMAGES)
    assert np.shares_memory(from_arrow("input", column.slice(2, 3)).stack, IMAGES[2:5])
    rows, errors = Map(SOBEL).run({"input": from_arrow("input", column)})
    made = rows["output"].to_arrow(np.ones(6, bool), False)
    assert errors == [None] * 6 and np.shares_memory(stacked(made), rows["output"].stack)


def test_a_batch_may_be_larger_than_the_op_takes() -> None:
    many = RNG.random((5000, 1, 8, 8), np.float32)
    np.testing.assert_array_equal(
        Map(SOBEL)({"input": many})["output"],
        np.concatenate([direct(SOBEL, many[:4096]), direct(SOBEL, many[4096:])]),
    )


def test_constants_and_names() -> None:
    sigma = [[1.5, 0.5]]
    blur = Map(BLUR, columns={"input": "image", "sigma": sigma}, outputs={"output": "soft"})
    want = direct(BLUR, IMAGES, np.repeat(np.array(sigma, np.float32), 6, 0))
    np.testing.assert_array_equal(blur({"image": IMAGES})["soft"], want)
    each = Map(BLUR)({"input": IMAGES, "sigma": np.repeat(np.array(sigma, np.float32), 6, 0)})
    np.testing.assert_array_equal(each["output"], want)
    resize = BUNDLES / "geometry.transform.resize.bilinear.chiasm"
    like = np.zeros((20, 30), np.uint8)
    small = Map(resize, columns={"input": "bytes", "like": like}, errors="column")
    files = [encoded(RNG, 48, 64), b"no image", encoded(RNG, 96, 80)]
    result = small(pa.record_batch({"bytes": pa.array(files)}))
    # a row's shape is known, although the images' sizes are not
    assert result["output"].type == pa.fixed_shape_tensor(pa.float32(), [3, 20, 30])
    frame = cv2.imdecode(np.frombuffer(files[2], np.uint8), 1)[..., ::-1].astype(np.float32) / np.float32(255)
    want = direct(resize, np.ascontiguousarray(frame.transpose(2, 0, 1)[None]), like)[0]
    np.testing.assert_array_equal(stacked(result["output"])[2], want)
    assert not stacked(result["output"])[1].any() and result["error"][1].is_valid


def test_images_are_decoded_as_opencv_does(tmp_path: Path) -> None:
    turned, exif = Image.open(io.BytesIO(encoded(RNG, 48, 64))), Image.Exif()
    exif[0x0112] = 6
    turned.save(tmp_path / "turned.jpg", exif=exif)
    Image.open(io.BytesIO(encoded(RNG, 48, 64))).save(tmp_path / "half.jpg", subsampling=2, progressive=True)
    (tmp_path / "grey.jpg").write_bytes(encoded(RNG, 40, 56, mode="L"))
    (tmp_path / "a.png").write_bytes(encoded(RNG, 40, 56, "PNG"))
    (tmp_path / "clear.png").write_bytes(encoded(RNG, 40, 56, "PNG", "RGBA"))
    (tmp_path / "b.bmp").write_bytes(encoded(RNG, 40, 56, "BMP"))
    deep = RNG.integers(0, 65536, (40, 56), np.uint16)
    assert cv2.imwrite(str(tmp_path / "deep.png"), deep)
    paths = sorted(tmp_path.iterdir())
    batch = {"path": [p.name for p in paths], "frame": [p.read_bytes() for p in paths]}
    result = Map(EDGES)(pa.record_batch(batch))
    for path, got in zip(paths, structs(result["output"])):
        np.testing.assert_array_equal(got, direct(EDGES, cv2.imread(str(path))), err_msg=path.name)
    objects = Map(EDGES)(batch)["output"]
    assert objects.dtype == object and [o.shape for o in objects] == [
        s.shape for s in structs(result["output"])
    ]
    views = Map(EDGES)({"frame": [memoryview(d) for d in batch["frame"]]})["output"]
    assert all(np.array_equal(a, b) for a, b in zip(views, objects))


def test_jpegs_have_the_bits_that_pillow_decodes(monkeypatch: pytest.MonkeyPatch) -> None:
    from chiasm.data import decoding

    files = []
    for quality in (30, 75, 95, 100):
        for subsampling in (0, 1, 2):
            file = io.BytesIO()
            size = int(RNG.integers(17, 90)), int(RNG.integers(17, 90))
            noise = Image.fromarray(RNG.integers(0, 256, (*size, 3), np.uint8))
            noise.save(file, "JPEG", quality=quality, subsampling=subsampling, progressive=quality == 75)
            files.append(file.getvalue())
    # including damaged ones, which both decoders must accept or both reject
    damaged = []
    for data in files * 4:
        at = int(RNG.integers(200, len(data) - 2))
        damaged.append(data[:at] + bytes(RNG.integers(0, 256, 4, np.uint8)) + data[at + 4 :])
    kinds = [files[0], bytearray(files[0]), memoryview(files[0]), pa.array(files[:1])[0].as_buffer()]
    assert all(decoding._by_turbo(data, "BGR") is not None for data in kinds)
    for color in ("BGR", "RGB"):
        for i, data in enumerate([*files, *damaged]):
            fast = decoding._by_turbo(data, color)
            assert fast is not None or i >= len(files)
            if fast is not None:
                np.testing.assert_array_equal(fast, decoding.read_image("it", data, color), err_msg=str(i))
    for data in (files[0][: len(files[0]) // 2], b"\xff\xd8\xff\xff\xd9", b""):
        assert decoding._by_turbo(data, "BGR") is None
    fast = Map(EDGES)({"frame": files})["output"]
    monkeypatch.setattr(decoding, "_turbo", lambda: None)
    assert all(np.array_equal(a, b) for a, b in zip(fast, Map(EDGES)({"frame": files})["output"]))


def test_a_file_that_claims_too_many_pixels_is_refused() -> None:
    bomb = io.BytesIO()
    Image.new("RGB", (16, 16)).save(bomb, "JPEG")
    data = bytearray(bomb.getvalue())
    at = data.index(b"\xff\xc0") + 5
    data[at : at + 4] = b"\xff\xff\xff\xff"  # 65535 x 65535
    with pytest.raises(DataError, match="too many pixels"):
        Map(EDGES)({"frame": [bytes(data)]})


def test_rows_of_different_sizes_in_every_form() -> None:
    from ray.data._internal.tensor_extensions.arrow import ArrowTensorArray, ArrowVariableShapedTensorArray

    frames = [RNG.integers(0, 256, (16 + i, 24, 3), np.uint8) for i in range(4)]
    want = [direct(EDGES, frame) for frame in frames]
    objects = np.empty(4, object)
    objects[:] = frames
    ragged = pa.array([{"data": f.reshape(-1), "shape": list(f.shape)} for f in frames])
    for column in (frames, objects, ragged, ArrowVariableShapedTensorArray.from_numpy(objects)):
        batch = pa.record_batch({"frame": column}) if isinstance(column, pa.Array) else {"frame": column}
        got = Map(EDGES)(batch)["output"]
        got = structs(got) if isinstance(got, pa.Array) else got
        assert all(np.array_equal(a, b) for a, b in zip(got, want))
    same = np.stack([frames[0]] * 3)
    nested = pa.FixedSizeListArray.from_arrays(pa.array(same.reshape(-1)), 3)
    nested = pa.FixedSizeListArray.from_arrays(pa.FixedSizeListArray.from_arrays(nested, 24), 16)
    for column in (tensors(same), nested, ArrowTensorArray.from_numpy(same)):
        for part, count in ((column, 3), (column.slice(1, 1), 1), (column.slice(3), 0)):
            got = Map(EDGES)(pa.record_batch({"frame": part}))["output"]
            # all rows have one shape, so their edges are tensors too
            np.testing.assert_array_equal(stacked(got), np.stack([want[0]] * 3)[:count])
    # a Map's result is a valid input of another Map
    [name] = chiasm.runtime.open(GREY_TO_RGB).signature()[0]
    edges = Map(EDGES, outputs={"output": "edges"})(pa.record_batch({"frame": ragged}))
    colored = structs(Map(GREY_TO_RGB, columns={name.name: "edges"})(edges)["output"])
    for got, edge in zip(colored, want):
        np.testing.assert_array_equal(got, np.repeat(edge[..., None], 3, 2))


@pytest.mark.parametrize("kind", ["numpy", "arrow", "table", "iterator"])
def test_errors_name_the_row(kind: str) -> None:
    files = [encoded(RNG, 48, 64), encoded(RNG, 48, 64), b"no image", None]
    names = ["a", "b", "c", "d"]
    batch = pa.record_batch({"name": names, "frame": pa.array(files, pa.binary())})
    row = "row 2"
    if kind == "numpy":
        batch = {"name": np.array(names), "frame": files}
    elif kind == "table":
        batch = pa.Table.from_batches([batch.slice(0, 2), batch.slice(2)])
    elif kind == "iterator":
        batch = iter([batch])
    with pytest.raises(DataError, match=f"{row} \\(name 'c'\\): input 'frame': not an image"):
        result = Map(PREPROCESS, id="name")(batch)
        list(result)


def test_errors_as_a_column_or_as_null() -> None:
    files = [encoded(RNG, 48, 64), b"no image", None, encoded(RNG, 8, 8)[:40]]
    batch = pa.record_batch({"frame": pa.array(files, pa.binary())})
    for bundle in (PREPROCESS, EDGES):
        kept = Map(bundle, errors="column")(batch)
        assert [e is None for e in kept["error"].to_pylist()] == [True, False, False, False]
        assert "missing in this row" in kept["error"][2].as_py()
        null = Map(bundle, errors="null")(batch)
        assert null.schema.names == ["output"]
        assert [r is None for r in structs(null["output"])] == [False, True, True, True]
        want = direct(bundle, cv2.imdecode(np.frombuffer(files[0], np.uint8), 1))
        np.testing.assert_array_equal(
            structs(null["output"])[0], want.reshape(structs(null["output"])[0].shape)
        )
        for result in (kept, null):  # the result can be written and read
            file = io.BytesIO()
            parquet.write_table(pa.Table.from_batches([result]), file)
            assert parquet.read_table(file).to_batches()[0] == result
        numpy = Map(bundle, errors="column")({"frame": files})
        assert list(numpy["error"]) == kept["error"].to_pylist() and len(numpy["output"]) == 4
        assert [r is None for r in Map(bundle, errors="null")({"frame": files})["output"]] == [False] + [
            True
        ] * 3
    # a row that the op rejects, and the rows next to it
    images = [IMAGES[0], IMAGES[1, :, :4], IMAGES[2].astype(np.float64), IMAGES[3]]
    result = Map(SOBEL, errors="column")({"input": images})
    assert [e is None for e in result["error"]] == [True, False, False, True]
    assert "H must be from 8" in result["error"][1] and "float32" in result["error"][2]
    np.testing.assert_array_equal(result["output"][3], direct(SOBEL, IMAGES[3:4])[0])


@pytest.mark.parametrize("form", ["arrow", "numpy", "list"])
def test_files_are_read_by_the_worker(form: str, photos: Path, expected: dict, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    bad = {
        str(tmp_path / "none.jpg"): "none.jpg: No such file or directory",
        str(tmp_path): "Is a directory",
        str(tmp_path / "pipe"): "not a regular file",
        "a\0b": "ab: embedded null byte",
        None: "missing in this row",
        3: "expected the path of a file, got int",
    }
    if form == "arrow":  # whose columns have one type
        bad.pop(3)
    paths = [*(str(path) for path in sorted(photos.iterdir())), *bad]
    column = {"arrow": pa.array, "numpy": lambda rows: np.array(rows, object), "list": list}[form](paths)
    batch = {"path": column, "id": np.arange(len(paths))}
    mapping = pickle.loads(pickle.dumps(Map(PREPROCESS, columns={"frame": Files("path")}, errors="column")))
    result = mapping(pa.table(batch) if form == "arrow" else batch)
    assert list(result.column_names if form == "arrow" else result) == ["path", "id", "output", "error"]
    errors = result["error"].to_pylist() if form == "arrow" else list(result["error"])
    for message, error in zip(bad.values(), errors[-len(bad) :]):
        assert message in error, error
    good = len(paths) - len(bad)
    rows = (
        result
        if form == "arrow"
        else pa.table(
            {"path": paths[:good]}
            | {"output": tensors(result["output"][:good]), "error": pa.array(errors[:good], pa.string())}
        )
    )
    same_rows(rows.slice(0, good), expected, "path")


def test_paths_in_a_column_of_images_are_not_opened(photos: Path) -> None:
    """Else who sends a row to a service could read its files."""
    with pytest.raises(DataError, match="expected an array or the bytes of an image, got str"):
        Map(PREPROCESS)({"frame": [str(photos / "0000.jpg")]})


def test_null_tensors_and_numbers_are_errors_of_their_rows() -> None:
    flat = pa.FixedSizeListArray.from_arrays(
        pa.array(IMAGES.reshape(-1)), IMAGES[0].size, mask=pa.array([False, True] * 3)
    )
    nulls = pa.ExtensionArray.from_storage(pa.fixed_shape_tensor(pa.float32(), IMAGES[0].shape), flat)
    result = Map(SOBEL, errors="column")(pa.record_batch({"input": nulls}))
    assert [e is None for e in result["error"].to_pylist()] == [True, False] * 3
    np.testing.assert_array_equal(stacked(result["output"])[4], direct(SOBEL, IMAGES[4:5])[0])
    hole = pa.array([[1.0] * 64, [1.0] * 63 + [None]], pa.list_(pa.float32(), 64))
    result = Map(SOBEL, errors="column")(pa.record_batch({"input": hole}))
    assert "(64,)" in result["error"][0].as_py() and "missing" in result["error"][1].as_py()


@pytest.mark.parametrize("level", ["row", "plane", "line", "number"])
def test_a_null_at_any_level_of_nested_lists_is_an_error_of_its_row(level: str) -> None:
    images = IMAGES[:4].tolist()
    if level == "row":
        images[2] = None
    elif level == "plane":
        images[2][1] = None
    elif level == "line":
        images[2][1][5] = None
    else:
        images[2][1][5][7] = None
    kind = pa.list_(pa.list_(pa.list_(pa.float32(), 40), 24), 3)
    column = pa.array(images, kind)
    for start, bad in ((0, 2), (1, 1), (2, 0)):
        result = Map(SOBEL, errors="column")(pa.record_batch({"input": column.slice(start)}))
        errors = result["error"].to_pylist()
        assert [i for i, e in enumerate(errors) if e is not None] == [bad] and "is missing" in errors[bad]
        want = direct(SOBEL, IMAGES[3:4])[0]
        np.testing.assert_array_equal(stacked(result["output"])[3 - start], want)
    whole = Map(SOBEL)(pa.record_batch({"input": column.slice(3)}))["output"]
    np.testing.assert_array_equal(stacked(whole), direct(SOBEL, IMAGES[3:4]))


def test_null_numbers_in_rows_of_several_shapes_are_errors_of_their_rows() -> None:
    rows = [{"data": image.reshape(-1).tolist(), "shape": list(image.shape)} for image in IMAGES[:3]]
    rows[1]["data"][5] = None
    kind = pa.struct({"data": pa.list_(pa.float32()), "shape": pa.list_(pa.int64())})
    got = Map(SOBEL, errors="column")(pa.record_batch({"input": pa.array(rows, kind)}))
    assert got["error"].to_pylist() == [None, "column 'input': a number inside the row is null", None]
    with pytest.raises(DataError, match="row 0: column 'input': a number inside the row is null"):
        Map(SOBEL)(pa.record_batch({"input": pa.array([[1.0, None]], pa.list_(pa.float32()))}))
    rows[0] = {"data": [1.0], "shape": [1] * 70}
    with pytest.raises(DataError, match="row 0: column 'input': expected at most 8 dimensions, its shape ha"):
        Map(SOBEL)(pa.record_batch({"input": pa.array(rows, kind)}))


def test_columns_of_one_name_are_kept() -> None:
    batch = pa.RecordBatch.from_arrays(
        [pa.array([1]), pa.array([2]), tensors(IMAGES[:1])], ["a", "a", "input"]
    )
    got = Map(SOBEL)(batch)
    assert got.schema.names == ["a", "a", "output"] and [got[0].to_pylist(), got[1].to_pylist()] == [[1], [2]]


def test_empty_batches_have_the_same_columns() -> None:
    for bundle in (PREPROCESS, EDGES):
        full = pa.record_batch({"frame": pa.array([encoded(RNG, 48, 64)])})
        mapping = Map(bundle, errors="column")
        assert mapping(full.slice(0, 0)).schema == mapping(full).schema
        assert mapping(pa.Table.from_batches([], full.schema)).schema == mapping(full).schema
    assert Map(SOBEL)({"input": IMAGES[:0]})["output"].shape == (0, 3, 24, 40)
    full = pa.record_batch({"input": tensors(IMAGES)})
    assert Map(SOBEL)(pa.Table.from_batches([], full.schema)).schema == Map(SOBEL)(full).schema


@pytest.mark.parametrize(
    "column",
    [
        pa.array(["text"] * 2),
        pa.array([1, None]),
        pa.array([1.5, 2.5], pa.float32()),
        pa.array([True, None]),
        pa.array([[1.0], [2.0, 3.0]]),
        pa.array([[1.0, None], None]),
        pa.array([[[1.0]], [[2.0]]]),
        pa.array([{"data": [1.0, 2.0], "shape": [3, 5]}] * 2),
        pa.array([{"data": [1.0], "shape": [-1]}, {"data": None, "shape": None}]),
        pa.array([{"data": [1.0], "shape": [2**31 - 1, 2**31 - 1, 4]}, None]),
        pa.array([{"x": 1}, None]),
        pa.array([b"", None]),
        pa.array([b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n"], pa.large_binary()),
        pa.array(["a", "b"]).dictionary_encode(),
        pa.nulls(2),
        pa.array([None, None], pa.list_(pa.uint8(), 0)),
        pa.ExtensionArray.from_storage(
            pa.fixed_shape_tensor(pa.uint8(), [3, 4], permutation=[1, 0]),
            pa.array([[0] * 12] * 2, pa.list_(pa.uint8(), 12)),
        ),
        pa.array([0, 1], pa.timestamp("s")),
        pa.array([{"data": "ab", "shape": [2]}, None]),
        pa.array([{"data": [["a"]], "shape": [1]}, None]),
        pa.array([{"data": [1, 2], "shape": "ab"}, None]),
    ],
    ids=lambda column: str(column.type)[:40],
)
@pytest.mark.parametrize("errors", ["raise", "null", "column"])
def test_wrong_columns_are_one_clear_error(column: pa.Array, errors: str) -> None:
    for bundle in (EDGES, SOBEL):
        name = "frame" if bundle == EDGES else "input"
        try:
            result = Map(bundle, errors=errors)(pa.record_batch({name: column}))
        except DataError as error:
            assert name in str(error) and "\n" not in str(error)
        else:
            assert errors != "raise" and len(result) == 2
            if errors == "column":
                assert result["error"].null_count == 0


@pytest.mark.parametrize(
    ("batch", "message"),
    [
        ({"x": IMAGES}, "no column 'input': it has 'x'"),
        ({"input": IMAGES, "output": np.zeros(6)}, "a column 'output' already"),
        ({"input": IMAGES[0, 0, 0, 0]}, "expected an array"),
        ({"input": ["text"]}, "expected an array or the bytes"),
        ({"input": np.array(["text"])}, "expected numbers"),
        ({"input": np.ma.masked_array(IMAGES)}, "MaskedArray"),
        ({"input": IMAGES.astype(">f4")}, ">f4"),
        ({"input": [[[1], [1, 2]]]}, "row 0: column 'input'"),
        ({"input": np.array([[None]])}, "one object a row"),
        ([IMAGES], "expected a dict of arrays"),
        (None, "expected a dict of arrays"),
    ],
)
def test_wrong_batches(batch: object, message: str) -> None:
    with pytest.raises(DataError, match=message):
        Map(SOBEL)(batch)


def test_columns_of_different_lengths() -> None:
    with pytest.raises(DataError, match="different numbers of rows"):
        Map(BLUR)({"input": IMAGES, "sigma": np.ones((5, 2), np.float32)})


def test_memory_that_is_not_dense_is_copied() -> None:
    for array in (IMAGES[:, ::-1], IMAGES.transpose(0, 1, 3, 2), np.asfortranarray(IMAGES)):
        np.testing.assert_array_equal(
            Map(SOBEL)({"input": array})["output"], direct(SOBEL, np.ascontiguousarray(array))
        )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"columns": {"nothing": "x"}}, "no input 'nothing'"),
        ({"outputs": {"nothing": "x"}}, "no output 'nothing'"),
        ({"outputs": {}}, "a column of its own"),
        ({"outputs": {"output": "error"}, "errors": "column"}, "a column of its own"),
        ({"errors": "ignore"}, "expected one of raise, null, column"),
        ({"method": "backward"}, "no method 'backward'"),
        ({"columns": {"input": 3.0}}, "every input is a constant"),
    ],
)
def test_wrong_descriptions(arguments: dict, message: str) -> None:
    with pytest.raises(DataError, match=message):
        Map(SOBEL, **arguments)


@pytest.mark.parametrize("errors", ["raise", "null", "column"])
@pytest.mark.parametrize(
    ("sigma", "got"), [(1.5, ""), ([1.5], "1, 1"), ([1.5] * 3, "1, 3"), ([[[1.5, 1.5]]], "1, 1, 2")]
)
def test_a_constant_of_another_shape_is_one_error(errors: str, sigma: object, got: str) -> None:
    blur = Map(BLUR, {"input": "image", "sigma": sigma}, errors=errors)
    message = rf"input 'sigma': expected a constant of shape \(B, 2\), got one of shape \({got}\)"
    with pytest.raises(DataError, match=message):
        blur({"image": IMAGES})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"bundle": 3}, "bundle: expected a folder or a name, got 3"),
        ({"bundle": None}, "bundle: expected a folder or a name, got None"),
        ({"method": 3}, "method: expected a name, got 3"),
        ({"id": 3}, "id: expected a column's name, got 3"),
        ({"backend": 3}, "backend: expected a name, got 3"),
        ({"backend": None}, "backend: expected a name, got None"),
        ({"dtype": 3}, "dtype: expected one of .*float32.*, got 3"),
        ({"dtype": np.dtype(">f4")}, "dtype: expected one of .*float32.*, got dtype.'>f4'"),
        ({"num_threads": "2"}, "num_threads: expected a number from 0 to 1024, got '2'"),
        ({"num_threads": -1}, "num_threads: expected a number from 0 to 1024, got -1"),
        ({"num_threads": 1025}, "num_threads: expected a number from 0 to 1024, got 1025"),
        ({"num_threads": int}, "num_threads: expected a number from 0 to 1024, got <class 'int'>"),
        ({"columns": {"input": Files(["a"])}}, r"columns: expected a column's name in Files\(NAME\), got"),
    ],
)
def test_arguments_of_another_type_or_range_are_refused_at_once(arguments: dict, message: str) -> None:
    with pytest.raises(DataError, match=message):
        Map(**{"bundle": SOBEL, **arguments})


def test_a_dtype_may_be_numpys() -> None:
    double = IMAGES.astype(np.float64)
    for dtype in (np.float64, np.dtype("float64"), "float64"):
        mapping = Map(SOBEL, dtype=dtype, num_threads=np.int64(2))
        assert mapping.dtype == "float64" and mapping({"input": double})["output"].dtype == np.float64


def test_what_is_known_in_the_worker_only() -> None:
    for arguments, message in (
        ({"dtype": "int8"}, "int8"),
        ({"backend": "cuda"}, "cuda"),
    ):
        with pytest.raises(DataError, match=message):
            Map(SOBEL, **arguments)({"input": IMAGES})
    with pytest.raises(DataError, match=r"sigma.*no constant"):
        Map(BLUR, columns={"sigma": [["a"]]})({"input": IMAGES})
    with pytest.raises(DataError, match=r"seed.*no constant of int64: 1\.5 is no value of int64"):
        Map(BUNDLES / "augmentation.random_crop.chiasm", columns={"seed": [1.5]})({"input": IMAGES})
    with pytest.raises(DataError, match="nowhere"):
        Map("nowhere.chiasm")


def run_pickled(data: bytes) -> tuple[np.ndarray, str]:
    mapping = pickle.loads(data)
    return mapping({"input": IMAGES})["output"], str(mapping.parcel.folder())


def test_a_bundle_travels_in_the_pickle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bundle = tmp_path / "renamed.chiasm"
    shutil.copytree(SOBEL, bundle)
    data = pickle.dumps(Map(bundle))
    shutil.rmtree(bundle)
    want, cache = direct(SOBEL, IMAGES), tmp_path / "node"
    monkeypatch.setenv("CHIASM_CACHE", str(cache))
    with ProcessPoolExecutor(4) as pool:  # like a node's processes, which all begin at once
        results = list(pool.map(run_pickled, [data] * 4))
    copies = {folder for _, folder in results}
    assert len(copies) == 1 and all(np.array_equal(r, want) for r, _ in results)
    [copy] = copies
    assert sorted(p.name for p in Path(copy).parent.iterdir()) == ["renamed.chiasm"]
    # whatever happens to the cached copy, the sent bundle runs
    for damage in ("change", "extra", "missing", "pipe", "file", "link"):
        folder = Path(copy)
        if damage == "change":
            file = folder / "forward.float32.x86-64-v3.pt2"
            file.write_bytes(file.read_bytes()[:-1] + b"x")
        elif damage == "extra":
            (folder / "more").write_text("")
        elif damage == "missing":
            (folder / "manifest.json").unlink()
        elif damage == "pipe":
            (folder / "manifest.json").unlink()
            os.mkfifo(folder / "manifest.json")
        else:
            shutil.rmtree(folder)
            folder.write_text("") if damage == "file" else folder.symlink_to("/nowhere")
        result, again = run_pickled(data)
        assert again == copy and np.array_equal(result, want), damage
        assert sorted(p.name for p in folder.parent.iterdir()) == ["renamed.chiasm"]
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("CHIASM_CACHE", str(tmp_path / "file"))
    with pytest.raises(DataError, match="CHIASM_CACHE"):
        pickle.loads(data).parcel.folder()


def test_a_child_forked_during_a_load_loads_too() -> None:
    code = f"""
import os, signal, threading
import chiasm.data.mapping as mapping

loading, forked, load = threading.Event(), threading.Event(), mapping._open

def wait(wanted):
    loading.set()
    forked.wait(20)
    return load(wanted)

mapping._open = wait
thread = threading.Thread(target=mapping.Map({str(SOBEL)!r}).open)
thread.start()
loading.wait(20)
pid = os.fork()
if pid == 0:
    mapping._open = load
    signal.alarm(10)
    mapping.Map({str(BLUR)!r}).open()
    os._exit(0)
status = os.waitpid(pid, 0)[1]
forked.set()
thread.join()
print(status)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout == "0\n", done.stdout + done.stderr


def test_a_damaged_bundle_is_not_sent(tmp_path: Path) -> None:
    bundle = tmp_path / "damaged.chiasm"
    shutil.copytree(SOBEL, bundle)
    (bundle / "forward.float32.onnx").write_bytes(b"other")
    with pytest.raises(DataError, match=r"forward\.float32\.onnx"):
        Map(bundle)
    (bundle / "forward.float32.onnx").unlink()
    os.mkfifo(bundle / "forward.float32.onnx")
    with pytest.raises(DataError, match=r"forward\.float32\.onnx: not a regular file"):
        Map(bundle)


def test_the_plain_loop(photos: Path, expected: dict[str, np.ndarray | None]) -> None:
    mapping = Map(PREPROCESS, columns={"frame": "bytes"}, errors="column")
    paths = sorted(photos.iterdir())
    parts = [
        mapping(pa.record_batch({"id": [p.name for p in part], "bytes": [p.read_bytes() for p in part]}))
        for part in (paths[:20], paths[20:])
    ]
    same_rows(pa.Table.from_batches(parts), expected)
    assert set(BAD) <= set(expected)
