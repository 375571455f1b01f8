"""`chiasm pack`, and the bundles in its wheels. tests/consumer/pip_install.sh installs one by pip."""

import base64
import hashlib
import json
import os
import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import chiasm.runtime
from chiasm import packs
from chiasm.data import Map
from chiasm.doctor import report
from chiasm.export.cli import main
from chiasm.export.errors import ExportError
from chiasm.export.manifest import BundleError
from chiasm.export.pack import pack
from tests.export.commands import refused, run

OPS = ("color.rgb_to_grayscale", "color.rgb_to_hsv")


@pytest.fixture
def bundles(light: Callable[[str], Path]) -> list[Path]:
    return [light(name) for name in OPS]


@pytest.fixture
def installed(bundles: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A wheel, unpacked in a folder of sys.path."""
    wheel, _ = pack("two-colors", bundles, tmp_path / "dist")
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    monkeypatch.syspath_prepend(site)
    return site


def test_a_wheel_is_whole(bundles: list[Path], tmp_path: Path) -> None:
    wheel, written = pack("two-colors", bundles, tmp_path)
    assert written and wheel.name == "chiasm_bundles_two_colors-0.1.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        lines = archive.read("chiasm_bundles_two_colors-0.1.0.dist-info/RECORD").decode().splitlines()
        for path, digest, size in (line.split(",") for line in lines[:-1]):
            data = archive.read(path)
            names.remove(path)
            assert len(data) == int(size)
            want = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            assert digest == f"sha256={want}"
    assert names == {lines[-1].removesuffix(",,")}


def test_the_same_bundles_give_the_same_bytes(
    bundles: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, _ = pack("colors", bundles, tmp_path / "a")
    second, _ = pack("colors", bundles[::-1], tmp_path / "b")
    assert first.read_bytes() == second.read_bytes()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    third, _ = pack("colors", bundles, tmp_path / "c")
    with zipfile.ZipFile(third) as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(2023, 11, 14, 22, 13, 20)}
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "253402300799")  # later than a zip archive can store
    last, _ = pack("colors", bundles, tmp_path / "d")
    with zipfile.ZipFile(last) as archive:
        assert {entry.date_time[0] for entry in archive.infolist()} == {2107}
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "soon")
    with pytest.raises(ExportError, match="SOURCE_DATE_EPOCH: expected seconds since 1970"):
        pack("colors", bundles, tmp_path / "e")


def test_what_is_there_is_left_alone_and_what_is_half_is_not(bundles: list[Path], tmp_path: Path) -> None:
    wheel, _ = pack("colors", bundles, tmp_path)
    os.utime(wheel, ns=(1, 1))
    assert pack("colors", bundles, tmp_path) == (wheel, False)
    assert wheel.stat().st_mtime_ns == 1
    assert pack("colors", bundles[:1], tmp_path) == (wheel, True)
    whole = wheel.read_bytes()
    wheel.write_bytes(whole[: len(whole) // 2])
    assert pack("colors", bundles[:1], tmp_path) == (wheel, True)
    assert wheel.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [wheel]


def test_a_wheel_that_cannot_be_read_is_written_again(bundles: list[Path], tmp_path: Path) -> None:
    wheel, _ = pack("colors", bundles[:1], tmp_path)
    whole = wheel.read_bytes()
    with zipfile.ZipFile(wheel) as archive:
        record = archive.getinfo("chiasm_bundles_colors-0.1.0.dist-info/RECORD")
    start = record.header_offset + 30 + len(record.filename)
    directory = whole.rindex(b"PK\x01\x02")
    for place, value in ((start, 0xFF), (directory + 6, 0xFF)):  # its content, and the version it needs
        damaged = bytearray(whole)
        damaged[place] = value
        wheel.write_bytes(damaged)
        pack("colors", bundles[:1], tmp_path)
        assert wheel.read_bytes() == whole
    wheel.unlink()
    os.mkfifo(wheel)
    assert pack("colors", bundles[:1], tmp_path) == (wheel, True)
    assert wheel.read_bytes() == whole


def test_native_code_names_the_glibc(bundles: list[Path], tmp_path: Path) -> None:
    bundle = shutil.copytree(bundles[0], tmp_path / "bundle")
    manifest = json.loads((bundle / "manifest.json").read_text())
    artifact = dict(manifest["methods"]["forward"]["artifacts"][0])
    for glibc in ("2.9", "2.34"):  # compared as numbers, not as text
        native = artifact | {"format": "native", "backend": "native", "isa": "x86-64-v3", "glibc": glibc}
        manifest["methods"]["forward"]["artifacts"].append(native)
    (bundle / "manifest.json").write_text(json.dumps(manifest))
    wheel, _ = pack("colors", [bundle], tmp_path)
    assert wheel.name.startswith("chiasm_bundles_colors-0.1.0-py3-none-manylinux_2_34_")


def test_native_code_names_its_machines(bundles: list[Path], tmp_path: Path) -> None:
    bundle = shutil.copytree(bundles[0], tmp_path / "bundle")
    manifest = json.loads((bundle / "manifest.json").read_text())
    artifacts = manifest["methods"]["forward"]["artifacts"]
    native = dict(artifacts[0]) | {"format": "native", "backend": "native"}
    artifacts.append(native | {"isa": "armv8.2-a", "glibc": "2.36"})
    artifacts.append(native | {"isa": "x86-64-v3", "glibc": "2.34"})
    (bundle / "manifest.json").write_text(json.dumps(manifest))
    wheel, _ = pack("colors", [bundle], tmp_path)
    assert wheel.name.endswith("-py3-none-manylinux_2_36_aarch64.manylinux_2_34_x86_64.whl")
    with zipfile.ZipFile(wheel) as archive:
        tags = archive.read("chiasm_bundles_colors-0.1.0.dist-info/WHEEL").decode().splitlines()[-2:]
    assert tags == ["Tag: py3-none-manylinux_2_36_aarch64", "Tag: py3-none-manylinux_2_34_x86_64"]


def test_refusals(bundles: list[Path], tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="'Colors'"):
        pack("Colors", bundles, tmp_path)
    with pytest.raises(ExportError, match="'1-2'"):
        pack("colors", bundles, tmp_path, "1-2")
    with pytest.raises(ExportError, match=r"another bundle of color\.rgb_to_hsv"):
        pack("colors", [bundles[1], bundles[1]], tmp_path)
    damaged = shutil.copytree(bundles[0], tmp_path / "damaged")
    next(damaged.glob("*.onnx")).write_bytes(b"no model")
    with pytest.raises(BundleError, match="bytes, the manifest says"):
        pack("colors", [damaged], tmp_path)
    for name, match in (("golden.safetensors", "sha256 differs"), ("more.txt", "does not name")):
        before = (damaged / name).read_bytes() if (damaged / name).exists() else b" "
        (damaged / name).write_bytes(before[:-1] + b"?")
        for file in bundles[0].glob("*.onnx"):
            (damaged / file.name).write_bytes(file.read_bytes())
        with pytest.raises(BundleError, match=match):
            pack("colors", [damaged], tmp_path)
        (damaged / name).write_bytes(before)
    assert not list(tmp_path.glob("*.whl"))


def test_open_by_name(installed: Path) -> None:
    assert [found.distribution for found in packs.packs()] == ["chiasm-bundles-two-colors"]
    hsv = chiasm.runtime.open("color.rgb_to_hsv")
    assert Map("color.rgb_to_hsv").parcel.name == "color.rgb_to_hsv.chiasm"
    assert hsv.name == "color.rgb_to_hsv"
    grey = hsv.method(backend="onnx")(np.full((1, 3, 8, 8), 0.25, np.float32))
    np.testing.assert_array_equal(grey[0, :, 0, 0], [0, 0, 0.25])
    with pytest.raises(chiasm.runtime.ChiasmError, match="chiasm list --installed"):
        chiasm.runtime.open("color.no_such_op")
    with pytest.raises(chiasm.runtime.ChiasmError) as raised:
        chiasm.runtime.open("no/such/path.chiasm")
    assert "--installed" not in str(raised.value)


def test_a_folder_of_that_name_comes_first(
    installed: Path, bundles: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / OPS[0]).symlink_to(bundles[1])
    monkeypatch.chdir(tmp_path)
    assert chiasm.runtime.open(OPS[0]).name == OPS[1]


@pytest.mark.parametrize(
    "package",
    ["..up", ".here", "../../etc", "absent.sub", "loud.sub", "module", "module.sub", "sys", "__main__", ""],
)
def test_a_pack_that_names_no_package_does_not_hide_the_others(installed: Path, package: str) -> None:
    info = installed / "another-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Name: another\nVersion: 1\n")
    (info / "entry_points.txt").write_text(f"[{packs.GROUP}]\nx = {package}\n")
    (installed / "loud").mkdir()
    (installed / "loud" / "__init__.py").write_text("raise RuntimeError('code of a pack ran')")
    (installed / "module.py").write_text("")
    (installed / "of.others.chiasm").mkdir()
    assert [found.distribution for found in packs.packs()] == ["chiasm-bundles-two-colors"]
    assert chiasm.runtime.open("color.rgb_to_hsv").name == "color.rgb_to_hsv"


def test_a_pack_may_be_a_package_in_another_that_is_not_run(installed: Path, bundles: list[Path]) -> None:
    info = installed / "another-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Name: an\x1b[31mother\n")
    (info / "entry_points.txt").write_text(f"[{packs.GROUP}]\nx = loud.sub\n")
    (installed / "loud" / "sub").mkdir(parents=True)
    (installed / "loud" / "__init__.py").write_text("raise RuntimeError('code of a pack ran')")
    (installed / "loud" / "sub" / "my.op.chiasm").symlink_to(bundles[0])
    (installed / "loud" / "sub" / "\x1b[31m\udcff.chiasm").mkdir()
    (installed / "loud" / "sub" / "no.folder.chiasm").write_text("")
    assert chiasm.runtime.open("my.op").name == OPS[0]
    lines = packs.listing()
    assert "my.op  another None" in lines and all(line.isprintable() for line in lines)
    assert not any("no.folder" in line for line in lines)


def test_entry_points_that_cannot_be_read_are_one_sentence(installed: Path) -> None:
    info = installed / "another-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Name: another\nVersion: 1\n")
    (info / "entry_points.txt").write_bytes(b"\xff")
    assert any(line.startswith("bundles    ") and "entry_points.txt" in line for line in report())
    with pytest.raises(OSError, match=r"entry_points\.txt.*UnicodeDecodeError"):
        chiasm.runtime.open("color.rgb_to_hsv")


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


def test_the_command(installed: Path, bundles: list[Path], elsewhere: Path) -> None:
    def chiasm(*arguments: str) -> str:
        result = CliRunner().invoke(main, [*arguments])
        assert result.exit_code == 0, result.output
        return result.output

    listed = chiasm("list", "--installed").splitlines()
    assert listed == [f"{name}  chiasm-bundles-two-colors 0.1.0" for name in OPS]
    assert chiasm("list", "--installed", "*hsv").splitlines() == listed[1:]
    nothing = CliRunner().invoke(main, ["list", "--installed", "filters.*"])
    assert nothing.exit_code == 2 and "no installed bundle matches 'filters.*'" in nothing.output
    assert "wrote dist/chiasm_bundles_one" in chiasm("pack", "one", str(bundles[0]))
    assert "unchanged" in chiasm("pack", "one", str(bundles[0]))


def test_the_commands_take_the_name_of_an_installed_bundle(
    installed: Path, photo: Path, elsewhere: Path
) -> None:
    out = elsewhere / "out.png"
    for words in (
        ["info", OPS[0]],
        ["verify", OPS[0]],
        ["run", OPS[0], photo, out],
        ["triton", elsewhere / "models", OPS[0]],
    ):
        done = run(*words)
        assert done.returncode == 0 and OPS[0] in done.stdout, done.stderr
    assert out.exists() and (elsewhere / "models" / OPS[0] / "1" / f"{OPS[0]}.chiasm").is_dir()
    for words in (["info", "color.nothing"], ["map", "color.nothing", photo, elsewhere / "mapped"]):
        refused(run(*words), "color.nothing is neither a folder here nor the name of an inst", status=2)
    (elsewhere / OPS[0]).mkdir()  # a folder of that name comes first
    refused(run("info", OPS[0]), "not a bundle")
