"""docs/howto/backend.md, dtype.md and isa.md agree with the code."""

import re
from pathlib import Path

import pytest

from chiasm.export.isas import ISAS
from chiasm.export.manifest import GPUS

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("backend.md", "dtype.md", "isa.md")


def test_the_code_of_the_page_is_the_example_s():
    page = (ROOT / "docs" / "howto" / "backend.md").read_text()
    example = (ROOT / "runtime" / "backends" / "example" / "example.cpp").read_text()
    blocks = re.findall(r"```cpp\n(.*?)```", page, re.DOTALL)
    assert len(blocks) >= 5
    assert [block for block in blocks if block not in example] == []


@pytest.mark.parametrize("page", PAGES)
def test_the_files_that_a_page_names_are_there(page):
    text = (ROOT / "docs" / "howto" / page).read_text()
    named = {name for name in re.findall(r"`((?:runtime|include|tests|python|cmake)/[^`<*]+)`", text)}
    assert named
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_an_instruction_set_is_known_in_every_place_that_its_page_names():
    def names(file: str, pattern: str) -> list[str]:
        found = re.search(pattern, (ROOT / file).read_text(), re.DOTALL)
        assert found is not None, file
        return re.findall(r"x86-64-v\d|armv[\d.]+-a", found[0])

    wanted = [name for name, isa in ISAS.items() if not isa.sm]
    assert len(wanted) >= 2
    built = [
        name
        for family in ("arm", "x86")
        for name in names("runtime/artifact/CMakeLists.txt", rf"set\(CHIASM_ISAS {family}[^)]*\)")
    ]
    assert sorted(built) == sorted(wanted)
    assert names("python/chiasm/export/manifest.schema.json", r'"isa": \{.*?\}') == wanted
    assert names("runtime/core/manifest.h", r"kIsaNames\[\] = \{.*?\}") == wanted
    assert sorted(names("python/chiasm/doctor.py", r"_INSTRUCTION_SETS = \{.*?\n\}")) == sorted(wanted)

    compared = re.findall(
        r"chiasm_calls_test\(\w+ (x86\S+)\)", (ROOT / "tests/kernels/CMakeLists.txt").read_text()
    )
    assert {"x86-64-v3", *compared} == {name for name in wanted if name.startswith("x86")}
    declared = [re.sub(r"[-.]", "_", name) for name in wanted]
    enumerators = re.search(r"enum class Isa \{(.*?)\}", (ROOT / "runtime/core/manifest.h").read_text())
    assert enumerators is not None and enumerators[1].strip().split(", ") == ["none", *declared]
    checked = re.findall(r"case Isa::(\w+):", (ROOT / "runtime/core/cpu.cpp").read_text())
    assert sorted(checked) == sorted([*declared, "none"])


def test_a_gpu_is_known_in_both_places_that_its_page_names():
    limits = (ROOT / "python/chiasm/export/patches/cuda.py").read_text()
    found = re.search(r"_LIMITS = \{.*?\n\}", limits, re.DOTALL)
    assert found is not None
    assert [f"sm_{sm}" for sm in re.findall(r"^ +(\d+): ", found[0], re.MULTILINE)] == list(GPUS)
