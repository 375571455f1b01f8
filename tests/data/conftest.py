"""Fixtures of the tests of chiasm.data. They run in .deps/data (tools/data.sh), which has no torch."""

import io
import os
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from PIL import Image

import chiasm.runtime

ROOT = Path(__file__).resolve().parents[2]
BUNDLES = ROOT / "build" / "bundles"
PREPROCESS = BUNDLES / "pipelines.preprocess.chiasm"
EDGES = BUNDLES / "pipelines.edges.chiasm"
SOBEL = BUNDLES / "filters.sobel.chiasm"
BLUR = BUNDLES / "filters.gaussian_blur2d.chiasm"
#: Among the images of `photos`
BAD = ("0003.jpg", "0017.jpg")
COUNT = 64


def encoded(
    rng: np.random.Generator, height: int, width: int, form: str = "JPEG", mode: str = "RGB"
) -> bytes:
    small = rng.integers(0, 256, (height // 8, width // 8, 3), np.uint8)
    file = io.BytesIO()
    Image.fromarray(small).resize((width, height), Image.Resampling.BICUBIC).convert(mode).save(file, form)
    return file.getvalue()


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bundle cache of every test and of its workers."""
    folder = tmp_path_factory.mktemp("cache")
    os.environ["CHIASM_CACHE"] = str(folder)
    os.environ["PYTHONPATH"] = str(ROOT / "python")
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    return folder


@pytest.fixture(scope="session")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of images of several sizes, two of which cannot be read."""
    folder, rng = tmp_path_factory.mktemp("photos"), np.random.default_rng(0)
    for i in range(COUNT):
        name, size = f"{i:04}.jpg", (96 + 8 * (i % 5), 128 + 8 * (i % 7))
        (folder / name).write_bytes(encoded(rng, *size))
    (folder / BAD[0]).write_text("no image")
    whole = (folder / BAD[1]).read_bytes()
    (folder / BAD[1]).write_bytes(whole[: len(whole) // 2])
    return folder


@pytest.fixture(scope="session")
def expected(photos: Path) -> dict[str, np.ndarray | None]:
    """The op's expected result for each image, by another decoder and by chiasm.runtime."""
    import cv2

    method = chiasm.runtime.open(PREPROCESS).method("forward", num_threads=1)
    results: dict[str, np.ndarray | None] = {}
    for path in sorted(photos.iterdir()):
        frame = None if path.name in BAD else cv2.imread(str(path))
        results[path.name] = None if frame is None else method(frame)[0]
    return results


def same_rows(rows: pa.Table, expected: dict[str, np.ndarray | None], id: str = "id") -> None:
    """Assert that a table has every id once, with the expected result bit for bit, or with an error if none
    is expected."""
    ids = [Path(name).name for name in rows[id].to_pylist()]
    assert sorted(ids) == sorted(expected)
    # Engines keep tensors or lists
    outputs = rows["output"].combine_chunks()
    values = outputs.storage if isinstance(outputs.type, pa.BaseExtensionType) else outputs
    errors = rows["error"].to_pylist()
    for i, name in enumerate(ids):
        want = expected[name]
        if want is None:
            assert "not an image" in errors[i], errors[i]
        else:
            assert errors[i] is None
            got = values[i].values.to_numpy()
            np.testing.assert_array_equal(got.view(np.uint32), want.reshape(-1).view(np.uint32), err_msg=name)
