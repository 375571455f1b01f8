"""The kernels' declarations: an error is one sentence, docs/kernels.md matches the current declarations, and
each kernel has its tests. Intrinsics stand in files that are named for their instruction set."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import torch

from chiasm.primitives.kernels import operators
from chiasm.primitives.kernels.declarations import ENUMERATIONS, KERNELS
from chiasm.primitives.kernels.schema import DeclarationError, kernel

ROOT = Path(__file__).resolve().parents[2]
GENERATE = ROOT / "runtime" / "artifact" / "generate.py"


@pytest.mark.parametrize(
    ("schema", "where", "message"),
    [
        ("half(x) -> T[N]", [], "kernel half: expected 'type[shape] name' or 'type name', got 'x'"),
        (
            "half(T[N] x)",
            [],
            "kernel 'half(T[N] x)': expected name(type[shape] argument, type argument, ...) -> type[shape]",
        ),
        (
            "half(float16[N] x) -> float32[N]",
            [],
            "kernel half: argument x: unknown type float16, known are T, I, U, S, V, P, A",
        ),
        (
            "half(T[N] x, Corner corner) -> T[N]",
            [],
            "kernel half: argument corner: unknown type Corner, known are int, float, bool, Border",
        ),
        ("half(T[N] x) -> I[N]", [], "kernel half: result: unknown type I"),
        (
            "half(T[N] x, I[N] y) -> T[N]",
            [],
            "kernel half: one of the type variables T, I, U, S, V, P, A at most",
        ),
        ("half(T[N] x, int n) -> T[N]", [], "kernel half: two arguments or sizes named n"),
        ("half(T[N] N) -> T[N]", [], "kernel half: two arguments or sizes named N"),
        ("half(T[N] x, int kBool) -> T[N]", [], "kernel half: expected 'type[shape] name' or 'type name'"),
        (
            "half(T[N - 1] x) -> T[N]",
            [],
            "kernel half: argument x: a size is a name, a number, or '...' at the beginning, got 'N - 1'",
        ),
        ("half(T[N] x) -> T[...]", [], "kernel half: '...' stands in one argument's shape"),
        ("half(T[N] x) -> T[M]", [], "kernel half: 'M' names M, which is no size, int or bool"),
        ("half(T[N] x, float s) -> T[s]", [], "kernel half: 's' names s, which is no size, int or bool"),
        ("half(T[N] x, Border b) -> T[b]", [], "kernel half: 'b' names b, which is no size, int or bool"),
        ("half(int n) -> float32[n]", [], "kernel half: expected a tensor among the arguments, got none"),
        ("half(T[N_] x) -> T[N_]", [], "kernel half: argument x: a size is a name, a number, or '...'"),
        ("half(T[N] x) -> T[N]", ["M > 2"], "kernel half: 'M > 2' names M"),
        ("half(T[N] x) -> T[N]", ["x > 2"], "kernel half: 'x > 2' names x"),
        ("half(T[N] x) -> T[N]", ["N >"], "kernel half: 'N >' is no expression"),
        ("half(T[N] x) -> T[N]", ["N"], "kernel half: 'N' is no comparison of a size"),
        ("half(T[N] x) -> T[N]", ["1 < 2"], "kernel half: '1 < 2' is no comparison of a size"),
        (
            "half(T[N] x) -> T[N]",
            ["1 < INT32_MAX"],
            "kernel half: '1 < INT32_MAX' is no comparison of a size",
        ),
        ("half(T[N] x) -> T[N]", [3], "kernel half: expected a condition as one line"),
        (
            "half(T[N] x, Border b) -> T[N]",
            ['b == "reflect"'],
            "kernel half: expected a condition as one line, enumerators in single quotes",
        ),
        (
            "half(int64[N] a, int64[M] b) -> int64[N]",
            ["a < b"],
            "kernel half: 'a < b' compares int64 tensors of different shapes",
        ),
        (None, [], "kernel None: schema: expected a text, got None"),
    ],
)
def test_a_wrong_declaration_is_one_sentence(schema: Any, where: list[Any], message: str) -> None:
    with pytest.raises(DeclarationError, match="^" + re.escape(message)):
        kernel(schema, "half.cpp", "", where, enumerations=ENUMERATIONS)


@pytest.mark.parametrize(
    ("schema", "name"),
    [
        ("template(T[N] x) -> T[N]", "template"),
        ("half(T[N] new) -> T[N]", "new"),
        ("half(T[N] lambda) -> T[N]", "lambda"),
        ("half(T[NEW] x) -> T[NEW]", "NEW"),
        ("half(T[N] x, int T) -> T[N]", "T"),
        ("half(T[T] x) -> T[T]", "T"),
        ("half(T[INT32_MAX] x) -> T[N]", "INT32_MAX"),
        ("half(T[Border] x) -> T[N]", "Border"),
        ("half(T[N] x, int result) -> T[N]", "result"),
        ("half(T[N] x, int i) -> T[N]", "i"),
        ("half(T[..., N] x, int count) -> T[..., N]", "count"),
        ("half(T[..., H, W] x, int planes) -> T[..., H, W]", "planes"),
        ("half(T[..., N] x, T[COUNT] y) -> T[..., N]", "COUNT"),
        ("half(T[B, C, H, W] images) -> T[B, C, H, W]", "images"),
    ],
)
def test_a_name_has_one_meaning(schema: str, name: str) -> None:
    with pytest.raises(DeclarationError, match=rf"^kernel \w+: the name {name} has another meaning"):
        kernel(schema, "half.cpp", "", enumerations=ENUMERATIONS)


def test_a_source_is_one_of_the_folders_and_a_text_fits_a_comment() -> None:
    with pytest.raises(DeclarationError, match=r"^kernel half: source: .* got '\.\./kernels/half\.cpp'"):
        kernel("half(T[N] x) -> T[N]", "../kernels/half.cpp", "")
    with pytest.raises(DeclarationError, match=r"^kernel half: doc: .* got one with '\*/'"):
        kernel("half(T[N] x) -> T[N]", "half.cpp", "x */ 2.")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A copy of the declarations, their generator and the sources, for changes."""
    for folder in ("runtime/artifact", "python/chiasm/primitives/kernels"):
        shutil.copytree(
            ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__", "aoti")
        )
    return tmp_path


FILTERS = "python/chiasm/primitives/kernels/declarations/filters.py"
#: A line of that file.
FIRST = "from ..registry import ROWS, declare\n"


def error_of(what: str, tree: Path, old: str, new: str, path: str = FILTERS) -> str:
    """The error of the generator after a change of the declarations, with which it must write nothing."""
    file = tree / path
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new, 1))
    done = subprocess.run(
        [sys.executable, "-S", tree / "runtime/artifact/generate.py", what, tree / "made"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert not (tree / "made").exists()
    error, _, rest = done.stderr.removeprefix("error: ").partition("\n")
    assert not rest, done.stderr
    return error


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '"medians.cpp",\n    "The median',
            '"median.cpp",\n    "The median',
            "kernel median_filter: there is no source runtime/artifact/kernels/median.cpp",
        ),
        (
            '"medians.cpp",\n    "The median',
            '"integral.cpp",\n    "The median',
            "kernel median_filter: runtime/artifact/kernels/integral.cpp does not have"
            " 'CHIASM_INSTANTIATE(median_filter)'",
        ),
        (
            "median_filter(P[N, H, L] x",
            "median_filter(Image[N, H, L] x",
            "kernel median_filter: argument x: unknown type Image",
        ),
    ],
)
def test_a_wrong_declaration_stops_the_build(tree: Path, old: str, new: str, message: str) -> None:
    assert error_of("build", tree, old, new).startswith(message)


def test_every_family_is_read(tree: Path) -> None:
    resampling = FILTERS.replace("filters", "resampling")
    assert error_of("build", tree, "border != 'circular'", "border != 'round'", resampling) == (
        "kernel resize_blurred: \"border != 'round'\": border has no enumerator round"
    )


@pytest.mark.parametrize("what", ["build", "tests"])
@pytest.mark.parametrize(
    ("schema", "where", "message"),
    [
        ("T[N]", "N ** 2 > 1", "kernel half: 'N ** 2 > 1': no C++ form of 'N ** 2' is known"),
        ("T[N]", "2 ** -1 < N", "kernel half: '2 ** -1 < N': no C++ form of '2 ** (-1)' is known"),
        ("T[N]", f"N < {2**63}", f"kernel half: 'N < {2**63}': no C++ form of '{2**63}' is known"),
        ("T[N]", "N in ()", "kernel half: 'N in ()': no C++ form of this comparison is known"),
        ("T[N]", "border > 1", "kernel half: 'border > 1': no C++ form of 'border' is known"),
        ("T[N]", "scale % 2 == 0", "kernel half: 'scale % 2 == 0': no C++ form of 'scale % 2' is known"),
        ("T[2 ** N]", "N > 1", "kernel half: '2 ** N': no C++ form of '2 ** N' is known"),
        ("T['a']", "N > 1", "kernel half: \"'a'\": no C++ form of \"'a'\" is known"),
    ],
)
def test_an_expression_without_a_form_in_cpp_stops_the_build(
    tree: Path, what: str, schema: str, where: str, message: str
) -> None:
    (tree / "runtime/artifact/kernels/half.cpp").write_text(
        '#include "declared/half.h"\nCHIASM_INSTANTIATE(half)\n'
    )
    arguments = "T[N] x, Border border, float scale"
    declared = f'declare("half({arguments}) -> {schema}", "half.cpp", "", ["{where}"])\n'
    assert error_of(what, tree, FIRST, FIRST + declared) == message


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        ('declare("sobel(T[N] x) -> T[N]", "edges.cpp", "")\n', "kernel sobel: it is declared twice"),
        (
            'declare("half(T[N] x) -> T[N]", "half.cpp")\n',
            "filters.py:LINE: declare() missing 1 required positional argument: 'doc'",
        ),
        (
            'declare("half(T[N] x) -> T[N]", "half.cpp", "", precise=True)\n',
            "filters.py:LINE: declare() got an unexpected keyword argument 'precise'",
        ),
        (
            'declare("half(T[N] x) -> T[N]", "half.cpp", _DOC)\n',
            "filters.py:LINE: name '_DOC' is not defined",
        ),
        ('declare("half(T[N] x) -> T[N]" "half.cpp"", "")\n', "filters.py:LINE: "),
    ],
)
def test_a_mistake_in_python_names_its_line(tree: Path, declared: str, message: str) -> None:
    line = (tree / FILTERS).read_text().split(FIRST)[0].count("\n") + 2
    error = error_of("build", tree, FIRST, FIRST + declared)
    assert error.startswith(message.replace("LINE", str(line)))


def test_a_source_without_its_header_stops_the_build(tree: Path) -> None:
    source = tree / "runtime/artifact/kernels/medians.cpp"
    source.write_text(source.read_text().replace("declared/medians.h", "kernels.h"))
    error = error_of("build", tree, "", "")
    assert error.endswith("kernels/medians.cpp does not have '#include \"declared/medians.h\"'")


def test_a_changed_kernel_changes_its_own_header_alone(tree: Path) -> None:
    """So that other sources are not compiled again."""
    file = tree / FILTERS
    made = []
    for text in (file.read_text(), file.read_text().replace('"The median', '"This median', 1)):
        file.write_text(text)
        generate = [sys.executable, "-S", tree / "runtime/artifact/generate.py", "build", tree / "made"]
        subprocess.run(generate, check=True, timeout=60)
        made.append({f.name: f.read_text() for f in (tree / "made").rglob("*.*") if f.is_file()})
    before, after = made
    assert {name for name in after if after[name] != before.get(name)} == {"medians.h"}


def test_a_kernel_that_cannot_be_called_stops_the_build(tree: Path) -> None:
    old, new = '"KY % 2 == 1", "KX % 2 == 1"]', '"KY % 2 == 1", "KY % 4 == 2"]'
    assert error_of("tests", tree, old, new) == (
        "kernel separable: no small sizes and numbers meet its conditions together, so no test can call it"
    )


@pytest.mark.parametrize("tried", [("y", 0, 1), ("scale", 0, 1), ("size", 2, 1), ("size", 2), "size"])
def test_limits_are_those_of_arguments(tried: Any) -> None:
    with pytest.raises(DeclarationError, match=r"^kernel half: tried: expected .*, got '?(y|scale|size)"):
        kernel("half(T[N] x, int size, float scale) -> T[N]", "half.cpp", "", tried=[tried])


def test_the_page_of_kernels_is_todays() -> None:
    page = runpy.run_path(str(GENERATE))["page"]()
    assert (ROOT / "docs" / "kernels.md").read_text() == page, "docs/kernels.md: run `make docs`"


def test_operators_have_the_declared_shapes() -> None:
    meta = {"device": "meta", "dtype": torch.float64}
    x = torch.empty(2, 3, 7, 9, **meta)
    assert operators.median_filter(x[0], 3, 5, "circular").shape == x[0].shape
    assert operators.canny_hysteresis(x, 0.1, 0.2).dtype == torch.bool
    assert operators.two_smallest(x[0], True).shape == (3, 7, 2)
    assert operators.two_smallest(x[0], False).shape == (3, 9, 2)
    assert operators.real_roots(x[0, 0]).shape == (2, 6, 9)
    assert operators.quantize_u8(x).dtype == torch.uint8
    with pytest.raises(ValueError, match=r"two_smallest: x: expected shape \(B, N, M\), got \[2, 3, 7, 9\]"):
        operators.two_smallest(x, True)
    with pytest.raises(
        ValueError,
        match="median_filter: border: expected one of reflect, replicate, circular, constant, got 'wrap'",
    ):
        operators.median_filter(x[0], 1, 3, "wrap")
    with pytest.raises(AttributeError, match="there is no kernel 'blur'"):
        operators.blur  # noqa: B018


def test_every_kernel_is_a_lowering() -> None:
    """A primitive or the exporter of networks calls each kernel."""
    sources = "".join(file.read_text() for file in (ROOT / "python/chiasm/primitives").rglob("*.py"))
    called = {name for name in KERNELS if f"kernels.{name}" in sources}
    formats = ROOT / "python/chiasm/export/formats"
    networks = "".join((formats / file).read_text() for file in ("networks.py", "recurrent.py"))
    called |= set(re.findall(r"torch\.ops\.chiasm\.(\w+)", networks))
    assert called == set(KERNELS)


#: A function of a C++ source, as clang-format writes it.
FUNCTION = re.compile(
    r"^(?:template <[^\n]*>\n)?\w[^\n;=()]*[ &*](\w+)\([^;{}]*\) \{(?:[^\n]*\}|(?:\n(?:[ #].*)?)*\n\})$",
    re.MULTILINE,
)


def parts_of(source: str) -> tuple[str, set[str]]:
    """A C++ source without its comments, its benchmarks and the functions that only these call; and the names
    of the benchmarks."""
    source, names = re.sub(r"//.*", "", source), set()
    while found := re.search(r"^\w*BENCHMARK\((\w+),", source, re.MULTILINE):
        names.add(found[1])
        end, depth = source.index("(", found.start()) + 1, 1
        while depth:
            depth += {"(": 1, ")": -1}.get(source[end], 0)
            end += 1
        source = source[: found.start()] + source[end:]
    while unused := [f for f in FUNCTION.finditer(source) if len(re.findall(rf"\b{f[1]}\b", source)) == 1]:
        for function in reversed(unused):
            source = source[: function.start()] + source[function.end() :]
    return source, names


def files_of_tests(sources: dict[str, str]) -> tuple[dict[str, set[str]], dict[str, set[str]]]:
    """The files that compare each kernel with a reference, and those with a benchmark of it: its name begins
    with the kernel's, and with no longer one."""
    compare: dict[str, set[str]] = {name: set() for name in KERNELS}
    measure: dict[str, set[str]] = {name: set() for name in KERNELS}
    for file, source in sources.items():
        rest, benchmarks = parts_of(source)
        for name in KERNELS:
            if re.search(rf"\b{name}\(", rest):
                compare[name].add(file)
        for benchmark in benchmarks:
            owners = [name for name in KERNELS if f"{benchmark}_".startswith(f"{name}_")]
            if owners:
                measure[max(owners, key=len)].add(file)
    return compare, measure


def test_every_kernel_has_its_tests_and_its_benchmark() -> None:
    """The test: against a reference, with a benchmark in the same file. Calls in guarded memory and refused
    calls are generated from the declarations."""
    folder = ROOT / "tests" / "kernels"
    sources = {file.name: file.read_text() for file in folder.glob("*_test.cpp")}
    del sources["refused_calls_test.cpp"], sources["guarded_test.cpp"]
    compare, measure = files_of_tests(sources)
    for name in KERNELS:
        assert compare[name], f"{name}: no test against a reference"
        assert compare[name] & measure[name], f"{name}: no benchmark beside its test"


def test_a_benchmark_is_no_test() -> None:
    helper = "template <int kSize>\nvoid box(Frame& frame) {\n  box_bytes(frame.x.data(), kSize);\n}\n"
    benchmark = "KERNEL_CALL_BENCHMARK(box_bytes_5x5, [] { return [frame = Frame()] { box<5>(frame); }; });\n"
    test = "TEST_F(Bytes, MeansOfWindows) {\n  box_bytes(image.data, 5);\n}\n"
    for source, files in ((helper + benchmark, set()), (test + helper + benchmark, {"bytes_test.cpp"})):
        compare, measure = files_of_tests({"bytes_test.cpp": source})
        assert compare["box_bytes"] == files
        assert measure["box_bytes"] == {"bytes_test.cpp"}


def test_intrinsics_stand_in_files_of_their_instruction_set() -> None:
    named = re.compile(r"_(avx2|avx512|x86|aarch64|neon|sse4)\.\w+$")
    intrinsics = re.compile(
        r"\b_mm\d*_|\b__m\d+|__builtin_ia32|mmintrin|arm_neon|_ZGV|\basm\b[^;]*\b(?:\w*mxcsr|fpcr)\b"
    )
    tracked = subprocess.run(
        ["git", "ls-files", "*.h", "*.hpp", "*.c", "*.cpp"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    files = [ROOT / file for file in tracked if not named.search(file)]
    assert files
    found = [str(file) for file in files if file.exists() and intrinsics.search(file.read_text())]
    assert not found, f"intrinsics in files without the name of an instruction set: {', '.join(found)}"


def test_no_kernel_stores_by_a_mask() -> None:
    """For AVX-512, Highway's BlendedStore of a vector of one value also writes what stands behind it."""
    sources = [*(ROOT / "runtime/artifact/kernels").iterdir()]
    assert sources and not [s.name for s in sources if "BlendedStore" in s.read_text()]


def test_no_kernel_has_the_name_of_an_operator_of_pytorchs() -> None:
    """The calls of both are C functions in one namespace."""
    folder = Path(torch.__file__).parent / "include/torch/csrc/inductor/aoti_torch"
    declared = set(
        re.findall(r"\baoti_torch_cpu_(\w+)", "".join(file.read_text() for file in folder.rglob("*.h")))
    )
    assert declared and not declared & set(KERNELS)
