"""Every artifact is run before it is delivered: at other sizes than the exported one, and compared with eager
Python.

A tracer or a compiler that misinterprets a part of an op reports nothing. The artifacts run in a separate
process, so wrong code that ends the process does not end the export.
"""

from __future__ import annotations

import atexit
import json
import os
import selectors
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .. import example_inputs
from ..bundle import Golden, Writer
from ..errors import ExportError, explain
from ..job import ExportJob, Method, run_eager

#: The sizes in addition to the golden vectors': taller than wide, in a batch; and square, with one channel.
SIZES = (
    example_inputs.TESTS[1],
    {"B": 2, "C": 1, "H": 25, "W": 25, "N": 1, "OD": 12, "OH": 12, "OW": 12},
)
#: An op that takes longer in eager Python is compared at one size.
_SLOW = 5.0
#: The most seconds for all artifacts of a backend at all sizes.
_MOST_SECONDS = 600
#: ONNX Runtime's words for an operator that it has for other dtypes only. Such an artifact runs nowhere.
_NO_KERNEL = "Could not find an implementation"
_PROCESS = Path(__file__).with_name("trial_process.py")


@dataclass(frozen=True)
class Case:
    """Inputs and eager outputs at some sizes; `text` says why these sizes are in doubt, if they are."""

    golden: Golden
    sizes: dict[str, int]
    text: str


def prepare() -> None:
    """Start the process that will run the artifacts: it takes half a second, in which others work."""
    _Process.of_this()


def try_artifacts(job: ExportJob, writer: Writer) -> list[Golden]:
    """Compare the artifacts in `writer` with eager Python; those that need a machine, an engine or a CPU that
    is not available are skipped.

    Returns:
        The golden vectors of each method and dtype.

    Raises:
        ExportError: names the artifact, the sizes and the difference.
    """
    methods = [list(_cases(method)) for method in job.work if method.name in job.methods]
    cases = [case for of_method in methods for case in of_method]
    trial = replace(writer, manifest=dict(writer.manifest), files=dict(writer.files))
    trial.golden([case.golden for case in cases])
    backends = {a["backend"] for m in trial.manifest["methods"].values() for a in m["artifacts"]}
    with tempfile.TemporaryDirectory() as folder:
        bundle = trial.write(Path(folder))
        for backend in sorted(backends):
            _compare(job, backend, bundle, cases)
    return [replace(of_method[0].golden, name="") for of_method in methods]


def _cases(method: Method) -> Iterator[Case]:
    """The golden vectors; then the sizes in doubt; then the others, whose errors would not give a reason."""
    spec, slow = method.job.spec, False
    tried: list[dict[str, int]] = []
    golden, *others = [(example_inputs.fit(spec, sizes), "") for sizes in (example_inputs.GOLDEN, *SIZES)]
    for sizes, text in [golden, *((doubt.sizes, doubt.text) for doubt in method.doubts), *others]:
        if sizes in tried or (slow and not text):
            continue
        tried.append(sizes)
        begun = time.monotonic()
        inputs = method.tensors(example_inputs.GOLDEN | sizes)
        try:
            results = run_eager(method.module, inputs)
        except Exception as error:
            if text:  # the op refuses these sizes, and the graph does not
                raise ExportError(f"{spec.name}: cannot be exported to a graph{text}") from error
            shapes = ", ".join(f"{name} {tuple(t.shape)}" for name, t in inputs.items())
            raise explain(spec.name, None, error, shapes=shapes) from error
        slow = slow or time.monotonic() - begun > _SLOW
        outputs = dict(zip([t.name for t in method.outputs], results, strict=True))
        yield Case(Golden(method.name, method.variant, inputs | outputs, str(len(tried))), sizes, text)


def _compare(job: ExportJob, backend: str, bundle: Path, cases: list[Case]) -> None:
    name = job.spec.name
    try:
        rows = _Process.of_this().rows(bundle, backend)
    except _Ended as end:
        raise ExportError(
            f"{name}: the artifacts for the backend {backend} {end}: by a fault of chiasm or of PyTorch they"
            " are not what the op is; please report it with the op"
        ) from end
    seen: Counter[tuple[str, str, str]] = Counter()
    for row in rows:
        key = row["method"], row["artifact"], row["dtype"]  # a file may serve two methods
        of_method = [
            c for c in cases if (c.golden.method, c.golden.variant or "") == (row["method"], row["dtype"])
        ]
        case = of_method[seen[key]]
        seen[key] += 1
        no_kernel = row["passed"] is None and _NO_KERNEL in row["message"]
        if row["passed"] is not False and not no_kernel:
            continue
        if case.text:
            raise ExportError(f"{name}: cannot be exported to a graph{case.text}")
        if no_kernel:
            raise ExportError(
                f"{name}: {row['artifact']} holds an operator that ONNX Runtime does not have for its dtype\n"
                f"  because: {row['message']}\n"
                f"  instead: compute this step in float32 (x.to(torch.float32)), or leave the format out"
                " (formats=...)"
            )
        sizes = ", ".join(f"{symbol}={size}" for symbol, size in case.sizes.items())
        raise ExportError(
            f"{name}: {row['artifact']} does not give what eager Python gives"
            f"{f', with {sizes}' if sizes else ''}\n"
            f"  because: {row['message']}\n"
            f"  instead: write the op in other functions, leave the format out (formats=...), or state a"
            " wider tolerance in the spec where the difference is one of rounding"
        )


class _Ended(RuntimeError):
    """The process that runs artifacts has ended, or has to be ended."""


class _Process:
    """A process that runs the self-tests of bundles. It is kept: it loads each engine once."""

    _kept: _Process | None = None

    @classmethod
    def of_this(cls) -> _Process:
        """The process that belongs to this one; a fork does not use its parent's."""
        kept = cls._kept
        if kept is None or kept._parent != os.getpid() or kept._process.poll() is not None:
            cls._kept = kept = cls()
            atexit.register(kept.end)
        return kept

    def __init__(self) -> None:
        self._parent = os.getpid()
        self._one_at_a_time = threading.Lock()
        environment = {k: v for k, v in os.environ.items() if not k.startswith("CHIASM_TRUST")}
        environment["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PROCESS.read_text(), str(self._parent)],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # an interrupt does not reach it: it ends with this process
        )

    def rows(self, bundle: Path, backend: str) -> list[dict[str, Any]]:
        """The rows of a bundle's self-test on a backend."""
        with self._one_at_a_time:
            try:
                answer = self._answer(bundle, backend)
            except BaseException:
                self.end()  # an answer that comes late is nobody's
                raise
        if "error" in answer:
            raise ExportError(f"{bundle.name}: {answer['error']}")
        return answer["rows"]

    def _answer(self, bundle: Path, backend: str) -> dict[str, Any]:
        assert self._process.stdin is not None and self._process.stdout is not None
        request = json.dumps({"bundle": str(bundle.resolve()), "backend": backend})
        try:
            self._process.stdin.write(request.encode() + b"\n")
            self._process.stdin.flush()
            with selectors.DefaultSelector() as selector:
                selector.register(self._process.stdout, selectors.EVENT_READ)
                if not selector.select(_MOST_SECONDS):
                    raise _Ended(f"did not end in {_MOST_SECONDS} s")
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = b""
        if not line:
            code = self._process.wait()
            raise _Ended(f"ended their process ({f'signal {-code}' if code < 0 else f'status {code}'})")
        return json.loads(line)

    def end(self) -> None:
        if self._parent == os.getpid():
            self._process.kill()
            self._process.wait()
