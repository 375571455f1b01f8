"""The Python API of the runtime in a process: many threads, the interpreter's lock, torch in the same
process, and the thread policy."""

import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scale_bundle import write_scale

import chiasm.runtime as runtime

# Threads


def test_one_method_in_many_threads(method: runtime.Method) -> None:
    def work(seed: int) -> bool:
        generator = np.random.default_rng(seed)
        for _ in range(30):
            x = generator.random((int(generator.integers(1, 60)), int(generator.integers(1, 60)))).astype(
                np.float32
            )
            keep = x > 0.5
            y, dropped = method(x, float(seed), keep)
            if not (
                np.array_equal(y, np.where(keep, x * np.float32(seed), 0)) and np.array_equal(dropped, ~keep)
            ):
                return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(16)))


def test_gradients_in_many_threads(bundle: runtime.Bundle) -> None:
    vjp = bundle.method("vjp")

    def work(seed: int) -> bool:
        x = np.random.default_rng(seed).random((9, 11)).astype(np.float32)
        keep = x > 0.5
        return all(
            np.array_equal(vjp(x, seed, keep, x)[0], np.where(keep, x * seed, 0).astype(np.float32))
            for _ in range(20)
        )

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(8)))


def test_the_gil_is_released(method: runtime.Method) -> None:
    x = np.ones((4096, 4096), np.float32)
    keep = np.ones(x.shape, bool)
    method(x, 2, keep)
    started = threading.Event()
    span: list[float] = []

    def run() -> None:
        started.set()
        span.append(time.perf_counter())
        for _ in range(3):
            method(x, 2, keep)
        span.append(time.perf_counter())

    thread = threading.Thread(target=run)
    ticks = []
    thread.start()
    started.wait()
    while thread.is_alive():
        ticks.append(time.perf_counter())
        time.sleep(0.001)
    begin, end = span
    during = [tick for tick in ticks if begin + 0.1 * (end - begin) < tick < end - 0.1 * (end - begin)]
    assert len(during) >= 3, f"this thread was held up for {end - begin:.3f} s"


# The process


def run_python(code: str) -> str:
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_import_is_light() -> None:
    modules = (
        "import sys, chiasm.runtime; print([m for m in ('torch', 'onnxruntime', 'numpy') if m in"
        " sys.modules])"
    )
    assert run_python(modules) == "[]"


def test_stubs_of_engines_are_none_of_them() -> None:
    """Empty modules of these names, which a test or a build of documentation may put into sys.modules."""
    code = (
        "import sys, types\n"
        "for name in ('onnxruntime', 'torch'): sys.modules[name] = types.ModuleType(name)\n"
        "import chiasm.runtime; print(chiasm.runtime._package_folder('torch'))"
    )
    assert run_python(code) == "None"


def test_a_subinterpreter_refuses_the_import() -> None:
    # mod_wsgi runs applications in subinterpreters.
    code = """
try: import _interpreters as interpreters
except ImportError: import _xxsubinterpreters as interpreters
text = "try: import chiasm.runtime" + chr(10) + "except ImportError as error: print(error, flush=True)"
interpreters.run_string(interpreters.create(), text)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert "main interpreter only, and this is subinterpreter 1; with mod_wsgi" in done.stdout, done.stderr


def test_torch_can_be_imported_after_its_backend(tmp_path: Path) -> None:
    path = str(write_scale(tmp_path))
    code = (
        "import sys, numpy as np, chiasm.runtime as r\n"
        f"m = r.open({path!r}).method(backend='torch')\n"
        "y = m(np.ones((2, 3), np.float32), 2, np.ones((2, 3), bool))[0]\n"
        "assert 'torch' not in sys.modules\n"
        "import torch\n"
        "t = m(torch.ones(2, 3), 2, torch.ones(2, 3, dtype=torch.bool))[0]\n"
        "x = torch.ones(3, requires_grad=True); x.square().sum().backward()\n"
        "print(float(y.sum()), float(t.sum()), float(x.grad.sum()))"
    )
    assert run_python(code) == "12.0 12.0 6.0"


def test_without_memory_for_libtorch_the_others_are_listed_and_it_is_tried_again(tmp_path: Path) -> None:
    code = """
import resource, sys
import chiasm.runtime
pages = int(open("/proc/self/statm").read().split()[0])
most = pages * resource.getpagesize() + (200 << 20)
before = resource.getrlimit(resource.RLIMIT_AS)
resource.setrlimit(resource.RLIMIT_AS, (most, before[1]))
print({backend.name: backend.available for backend in chiasm.runtime.backends()})
try:
    chiasm.runtime.open(sys.argv[1]).method(backend="torch")
except chiasm.runtime.ChiasmError as error:
    print(error.code.name)
resource.setrlimit(resource.RLIMIT_AS, before)
print(chiasm.runtime.open(sys.argv[1]).method(backend="torch").backend)
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(write_scale(tmp_path))], capture_output=True, text=True, check=True
    )
    assert "'native': True" in done.stdout and "'torch': False" in done.stdout, done.stdout
    assert done.stdout.splitlines()[1:] == ["OUT_OF_MEMORY", "torch"]


def test_thread_policy_comes_first(tmp_path: Path) -> None:
    path = str(write_scale(tmp_path))
    code = (
        "import chiasm.runtime as r\n"
        "r.set_num_threads(3); assert r.get_num_threads() == 3\n"
        f"r.open({path!r}).method(backend='onnx')\n"
        "try: r.set_num_threads(2)\n"
        "except r.ChiasmError as e: print(e.code.name)"
    )
    assert run_python(code) == "FAILED_PRECONDITION"
