"""`chiasm doctor`, in processes with different environments."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import chiasm.runtime
from chiasm.doctor import report

#: A process for which PyTorch and related packages appear not to be installed.
WITHOUT = """
import sys
from importlib.machinery import PathFinder
hidden = sys.argv[1].split(",")
found = PathFinder.find_spec
PathFinder.find_spec = classmethod(lambda cls, name, *rest: None if name in hidden else found(name, *rest))
sys.argv = ["chiasm", *sys.argv[2:]]
from chiasm.__main__ import main
main()
"""


def doctor(hidden: str = "", **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, hidden, "doctor"],
        env=os.environ | environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def lines(text: str, word: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith(word)]


def test_everything_is_here() -> None:
    text = "\n".join(report())
    backends = lines(text, "backend")
    for backend in chiasm.runtime.backends():
        assert any(f"{backend.name}: {backend.engine_version}" in line for line in backends), text
    assert "torch 2." in text
    [links] = [line for line in lines(text, "export") if "links native artifacts for " in line]
    assert {"x86-64-v2", "x86-64-v3"} <= set(links.partition(" for ")[2].split(", "))
    assert len(lines(text, "threads")) == 1 and "policy any" in text


def test_instruction_sets_are_the_cpu_s() -> None:
    flags = Path("/proc/cpuinfo").read_text().partition("flags")[2].splitlines()[0].split()
    text = "\n".join(report())
    runs = lines(text, "CPU")[0]
    assert ("x86-64-v3" in runs) == ({"avx2", "fma", "bmi1", "bmi2"} <= set(flags))
    v4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= set(flags)
    assert ("artifacts for x86-64-v4" in runs) == v4
    assert v4 or "not x86-64-v4: it has not all of AVX-512" in text


def test_a_cpu_without_avx2_runs_some_artifacts(monkeypatch: pytest.MonkeyPatch) -> None:
    for found, rest in (
        (["x86-64-v2"], "native artifacts for x86-64-v2 alone run here; the onnx backend does"),
        ([], "no native artifacts run here; the onnx backend does"),
    ):
        monkeypatch.setattr(chiasm._runtime, "instruction_sets", lambda found=found: found)
        text = "\n".join(report())
        assert f"not x86-64-v3: it has not all of AVX2, FMA and BMI2: {rest}" in text


def test_without_packages() -> None:
    text = doctor("torch,onnxruntime,click")
    for extra, missing, present in (
        ("cli", "click", "rich"),
        ("onnx", "onnxruntime", "jsonschema"),
        ("export", "torch", "safetensors"),
    ):
        [line] = lines(text, f"extra      {extra}:")
        assert f'not {missing}: pip install "chiasm[{extra}]"' in line and f"{present} " in line


@pytest.mark.parametrize("arguments", [["list"], ["export", "filters.sobel"]])
def test_what_needs_torch_says_so(arguments: list[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, "torch", *arguments], capture_output=True, text=True
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert 'this needs torch, which is not installed: pip install "chiasm[export]"' in done.stderr


def test_surroundings(tmp_path: Path) -> None:
    text = doctor(CHIASM_BACKEND_PATH=str(tmp_path), CHIASM_TRUST_POLICY="data_only", CXX="no-such-compiler")
    assert f"{tmp_path} (CHIASM_BACKEND_PATH): none" in text
    assert "policy data_only" in text
    assert "no compiler 'no-such-compiler': apt-get install g++, or set CXX" in text
    broken = tmp_path / "broken"
    broken.write_bytes(b"no program")
    broken.chmod(0o755)
    for compiler, why in ((broken, "Exec format error"), ("false", "exit status 1")):
        found = lines(doctor(CXX=str(compiler)), "export")[-1]
        assert f"the compiler '{compiler}' does not run" in found and why in found
    (tmp_path / "libchiasm_mine.so").write_bytes(b"no library")
    text = doctor(CHIASM_BACKEND_PATH=str(tmp_path), CHIASM_TRUST_POLICY="some")
    assert "libchiasm_mine.so" in lines(text, "plug-ins")[0]
    assert "mine: the mine backend is not available" in text
    assert "expected any, signed or data_only" in lines(text, "trust")[0]
