"""The command `chiasm`, as users call it."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from chiasm.export import workers
from chiasm.export.cli import main
from chiasm.export.text import first_sentence
from chiasm.runtime import open as open_bundle
from tests.export.commands import refused, run

BUNDLES = Path(__file__).resolve().parents[2] / "build" / "bundles"
PHOTO = "astronaut.png"


def chiasm(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, [str(a) for a in arguments])
    return result.exit_code, result.output


@pytest.fixture(scope="module")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import skimage

    path = tmp_path_factory.mktemp("photo") / "photo.png"
    Image.open(Path(skimage.__file__).parent / "data" / PHOTO).convert("RGB").resize((201, 149)).save(path)
    return path


def test_help_teaches() -> None:
    code, text = chiasm("--help")
    assert code == 0 and "A first round" in text
    for command in main.commands:  # errors point to the examples of each
        assert f"  {command} " in text
        code, own = chiasm(command, "--help")
        assert code == 0 and f"    chiasm {command}" in own.partition("Example")[2], command
    summaries = text.partition("Commands:")[2].strip().splitlines()
    assert len(summaries) == len(main.commands) and all(line.endswith(".") for line in summaries)
    assert "..." not in "".join(summaries)


def test_list() -> None:
    code, text = chiasm("list", "filters.*")
    assert code == 0 and "filters.sobel" in text and "color" not in text
    code, text = chiasm("list", "no.such.op")
    assert code == 2 and "no.such.op" in text


def test_what_is_shown_is_a_whole_sentence() -> None:
    for text, sentence in (
        ("Resize, and\n    fill the rest. More.\n\n    Args", "Resize, and fill the rest."),
        ("Of e.g. a level. :func:`f` is faster.", "Of e.g. a level."),
        ("No full stop\n\nAnother paragraph.", "No full stop"),
        ("By 1.5 levels. (Or more.)", "By 1.5 levels."),
        (None, ""),
    ):
        assert first_sentence(text) == sentence
    assert "the rest." in " ".join(chiasm("list", "pipelines.letterbox")[1].split())


def test_export_info_verify(tmp_path: Path) -> None:
    code, text = chiasm("export", "color.rgb_to_hsv", "-o", tmp_path, "-f", "onnx", "-f", "torchscript")
    assert code == 0, text
    bundle = tmp_path / "color.rgb_to_hsv.chiasm"
    code, text = chiasm("info", bundle)
    assert code == 0 and "forward.float32.onnx" in text and "(B, 3, H, W)" in text
    code, text = chiasm("info", "--json", bundle)
    assert json.loads(text)["name"] == "color.rgb_to_hsv"
    code, text = chiasm("verify", bundle)
    assert code == 0 and "0 failed" in text, text
    (bundle / "forward.pt").write_bytes(b"no program")
    code, text = chiasm("verify", bundle)
    assert code == 1 and "forward.pt" in text
    code, text = chiasm("info", tmp_path)
    assert code == 1 and "manifest.json" in text


def test_nothing_to_export() -> None:
    code, text = chiasm("export")
    assert code == 2 and "--all" in text
    code, text = chiasm("export", "filters.sobel", "--method", "vjp")
    assert code == 2 and "every bundle has its forward method" in text


@pytest.mark.parametrize("backend", ["native", "torch", "onnx"])
def test_run_maps_an_image_file_to_an_image_file(photo: Path, tmp_path: Path, backend: str) -> None:
    import cv2

    target = tmp_path / "grey.png"
    code, text = chiasm("run", BUNDLES / "color.rgb_to_grayscale.chiasm", photo, target, "-b", backend)
    assert code == 0 and backend in text, text
    expected = cv2.imread(str(photo), cv2.IMREAD_GRAYSCALE)
    assert np.abs(np.asarray(Image.open(target)).astype(int) - expected).max() <= 1
    code, text = chiasm(
        "run", BUNDLES / "pipelines.edges.chiasm", photo, tmp_path / "edges.png", "-b", backend
    )
    assert code == 0 and np.asarray(Image.open(tmp_path / "edges.png")).shape == (149, 201)


def test_run_refuses_a_backend_that_is_not_there(photo: Path, tmp_path: Path) -> None:
    bundle = BUNDLES / "color.rgb_to_grayscale.chiasm"
    code, text = chiasm("run", bundle, photo, tmp_path / "grey.png", "-b", "nonsense")
    assert code == 1 and "there is no libchiasm_nonsense.so in" in text and "install" in text, text


def test_run_takes_other_inputs_and_says_which_are_missing(photo: Path, tmp_path: Path) -> None:
    blur = BUNDLES / "filters.gaussian_blur2d.chiasm"
    code, text = chiasm("run", blur, photo, tmp_path / "out.png")
    assert code == 1 and "sigma" in text and "--set" in text
    assert chiasm("run", blur, photo, tmp_path / "out.png", "--set", "sigma=[[1.5, 1.5]]")[0] == 0
    code, text = chiasm(
        "run",
        BUNDLES / "geometry.transform.resize.bilinear.chiasm",
        photo,
        tmp_path / "small.png",
        "-s",
        "like=50x60",
    )
    assert code == 0 and Image.open(tmp_path / "small.png").size == (60, 50)
    code, text = chiasm("run", blur, photo, tmp_path / "out.png", "--set", "nonsense=1")
    assert code == 1 and "nonsense" in text
    code, text = chiasm("run", BUNDLES / "losses.ssim_loss.chiasm", photo, tmp_path / "out.png")
    assert code == 1 and "losses.ssim_loss" in text


def test_a_file_that_is_no_image_is_named(tmp_path: Path) -> None:
    bad = tmp_path / "bad.png"
    bad.write_text("no image")
    code, text = chiasm("run", BUNDLES / "filters.sobel.chiasm", bad, tmp_path / "out.png")
    assert code == 1 and "bad.png" in text


def test_an_output_inside_a_bundle_is_refused(sobel: Path, photo: Path, tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(sobel)
    for words in (
        ["run", sobel, photo, sobel / "out.png"],
        ["run", sobel, photo, link / "out.png"],
        ["map", sobel, photo, sobel / "deeper" / "out"],
        ["pack", "filters", sobel, "-o", sobel],
        ["export", "filters.sobel", "-o", sobel],
        ["triton", sobel / "models", sobel],
    ):
        refused(run(*words), "is inside the bundle", "choose a place beside it", status=2)
    assert open_bundle(sobel).name == "filters.sobel"


def test_a_damaged_bundle_does_not_hide_the_others(sobel: Path, light: Callable[[str], Path]) -> None:
    (sobel / "forward.pt").write_bytes(b"no program")
    done = run("verify", light("filters.sobel"), sobel, sobel.parent)
    assert done.returncode == 1 and "pass" in done.stdout, done.stdout
    assert re.search(r"^verify: \d+ checks, 2 failed$", done.stdout, re.MULTILINE)
    assert sum("FAIL" in line for line in done.stdout.splitlines()) == 2
    first, second = done.stderr.splitlines()
    assert first.startswith("Error: ") and "forward.pt" in first
    assert second.startswith("Error: ") and "manifest.json" in second


def test_an_output_folder_whose_name_is_no_text_is_shown(sobel: Path, tmp_path: Path) -> None:
    for words in (
        ["pack", "edges", sobel, "-o", tmp_path / "dist\udcff"],
        ["triton", tmp_path / "models\udcff", f"edges={sobel}"],
    ):
        done = run(*words)
        assert done.returncode == 0 and "wrote " in done.stdout, done.stderr
    assert len(list(tmp_path.glob("*/chiasm_bundles_edges-*.whl"))) == 1


def test_a_folder_that_cannot_be_written_is_said_before_anything_is_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "export_entry", lambda *_: pytest.fail("it is exported"))
    (tmp_path / "file").write_text("")
    for folder, why in ((tmp_path / "file" / "below", "Not a directory"), (Path("/proc"), "No such file")):
        refused(run("export", "filters.sobel", "-o", folder), f"{folder}: cannot be written: {why}")
