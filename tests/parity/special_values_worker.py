"""The child process of special_values.py: runs one op's cases on every backend, and announces each step
before it begins.

Each line on standard input is a job (JSON); each line on the answering pipe is `begin STEP`, `end`, `fail
JSON` or `done`. So the last `begin` shows which step killed or stopped this process.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import torch
from special_cases import Case, Inputs, agreeing, apply, cases, determined, doubled, shaken

import chiasm.runtime
from chiasm.export import example_inputs
from chiasm.export.catalog import catalog
from chiasm.export.job import run_eager, with_cotangents
from chiasm.export.manifest import read_manifest
from chiasm.export.spec import Spec, TensorSpec
from chiasm.export.tracing.gradient import vjp_module
from chiasm.export.tracing.module import bind_spec

#: A call may use TIMES the memory of a normal call, plus MORE.
TIMES, MORE = 4, 64 << 20
#: The memory limit of a process: larger requests fail, and the machine stays usable.
ADDRESS_SPACE = 12 << 30

Run = Callable[[Inputs], tuple[torch.Tensor, ...]]


class Worker:
    """Runs jobs, and announces every step on `answers`."""

    def __init__(self, answers) -> None:
        self.answers = answers

    def say(self, *words: str) -> None:
        self.answers.write(" ".join(words) + "\n")
        self.answers.flush()

    def fail(self, op: str, method: str, backend: str, case: str, message: str) -> None:
        self.say(
            "fail",
            json.dumps({"op": op, "method": method, "backend": backend, "case": case, "message": message}),
        )

    def job(self, job: dict) -> None:
        """All methods and dtypes of an op, except the steps that ended an earlier process."""
        name, folder = job["op"], Path(job["bundles"]) / f"{job['op']}.chiasm"
        spec = catalog()[name].spec
        op = bind_spec(catalog()[name].function(), spec)
        manifest = read_manifest(folder)
        for method, signature in manifest["methods"].items():
            for variant in spec.variants():
                label = f"{method}{'.' + variant if variant else ''}"
                outputs = [
                    TensorSpec(t["name"], tuple(t["shape"]), t["dtype"])
                    for t in manifest["methods"]["forward"]["outputs"]
                ]
                eager = op if method == "forward" else vjp_module(op, spec, outputs)
                tensors = [TensorSpec(t["name"], tuple(t["shape"]), t["dtype"]) for t in signature["inputs"]]
                inputs = with_cotangents(
                    op, spec, example_inputs.fit(spec, example_inputs.GOLDEN), variant, tensors
                )
                Method(self, name, label, spec, signature, inputs, job).check(
                    folder, method, variant, lambda x, e=eager: run_eager(e, x)
                )


class Method:
    """One method of one op at one dtype."""

    def __init__(
        self, worker: Worker, op: str, label: str, spec: Spec, signature: dict, inputs: Inputs, job: dict
    ) -> None:
        self.worker, self.op, self.label, self.spec, self.signature, self.inputs = (
            worker,
            op,
            label,
            spec,
            signature,
            inputs,
        )
        self.skipped, self.job = set(job["skipped"]), job
        self.parts = len(spec.variants())
        self.normal: dict[str, int] = {}

    def check(self, folder: Path, method: str, variant: str | None, eager: Run) -> None:
        backends: dict[str, Run] = {"eager": eager}
        artifacts = [a for a in self.signature["artifacts"] if not a["dtypes"] or variant in a["dtypes"]]
        for backend in dict.fromkeys(a["backend"] for a in artifacts):
            loaded = self.step(
                f"load {backend}",
                lambda b=backend: chiasm.runtime.open(folder).method(
                    method, backend=b, dtype=variant, fused=False
                ),
            )
            if loaded is not None:
                backends[backend] = lambda x, m=loaded: as_tuple(m(*x.values()))
        for backend, run in backends.items():
            for _ in range(3):  # TorchScript compiles in its first calls
                self.step(f"{backend}: normal", lambda r=run: r(self.inputs))
            before = peak(reset=True)
            self.step(f"{backend}: normal", lambda r=run: r(self.inputs))
            self.normal[backend] = peak() - before
        chosen = [c for c in cases(self.inputs) if not self.job["cases"] or str(c) in self.job["cases"]]
        if self.job["mixed"]:
            chosen.sort(key=lambda c: hashlib.sha256(f"{self.op} {self.label} {c}".encode()).digest())
        end = time.monotonic() + self.job["seconds"] / self.parts
        for case in chosen:
            if time.monotonic() > end:
                break
            self.one(case, backends)

    def step(self, what: str, run: Callable):
        """Run a step that may kill this process, unless it did so before. Returns None if it raised, which is
        a failure."""
        if f"{self.label} {what}" in self.skipped:
            return None
        self.worker.say("begin", f"{self.label} {what}")
        try:
            return run()
        except Exception as error:
            self.failed(what, f"{type(error).__name__}: {(str(error).splitlines() or [''])[0][:300]}")
            return None
        finally:
            self.worker.say("end")

    def failed(self, what: str, message: str) -> None:
        backend, _, case = what.partition(": ")
        self.worker.fail(self.op, self.label, backend, case, message)

    def one(self, case: Case, backends: dict[str, Run]) -> None:
        """A case on every backend."""
        inputs = apply(self.inputs, case)
        results = {}
        for backend, run in backends.items():
            before = peak(reset=True)
            results[backend] = self.step(f"{backend}: {case}", lambda r=run: r(inputs))
            used = peak() - before
            if used > TIMES * self.normal[backend] + MORE:
                self.failed(
                    f"{backend}: {case}",
                    f"took {used >> 20} MiB, a normal call {self.normal[backend] >> 20} MiB",
                )
        expected = results.pop("eager")
        if expected is None or not self.compared(case):
            return
        floating = [str(t.dtype).removeprefix("torch.") for t in inputs.values() if t.is_floating_point()]
        limit = self.spec.tolerance(self.label.partition(".")[0], floating[0]) if floating else None
        rtol = limit.rtol if limit else 0.0
        others = [self.step(f"eager in float64: {case}", lambda: quietly(backends["eager"], doubled(inputs)))]
        others += [
            self.step(f"eager, shaken: {case}", lambda s=seed: backends["eager"](shaken(inputs, s, rtol)))
            for seed in (1, 2, 3)
        ]
        for i, want in enumerate(expected):
            limit = self.spec.tolerance(self.label.partition(".")[0], str(want.dtype).removeprefix("torch."))
            atol, rtol = (limit.atol, limit.rtol) if limit else (0.0, 0.0)
            known = determined(want, [o[i] for o in others if o is not None], atol / 4, rtol / 4)
            for backend, result in results.items():
                if result is not None:
                    wrong = known & ~agreeing(result[i], want, atol, rtol)
                    if wrong.any():
                        at = tuple(wrong.nonzero()[0].tolist())
                        self.failed(
                            f"{backend}: {case}",
                            f"output {i} at {at}: {float(result[i][at]):.7g}, eager {float(want[at]):.7g}"
                            f" ({int(wrong.sum())} of {wrong.numel()})",
                        )

    def compared(self, case: Case) -> bool:
        if not self.job["compared"] or self.label.startswith("vjp"):
            return False
        if case.value == "nan":
            return not (self.spec.without_nan or self.spec.special_values)
        # Sums of the largest numbers may be infinite.
        return not (case.value in ("inf", "-inf", "largest") and self.spec.special_values)


def quietly(run: Run, inputs: Inputs) -> tuple[torch.Tensor, ...] | None:
    """The result; None if the op does not support this dtype."""
    try:
        return run(inputs)
    except Exception:
        return None


def as_tuple(result) -> tuple[torch.Tensor, ...]:
    return tuple(result) if isinstance(result, (tuple, list)) else (result,)


def peak(reset: bool = False) -> int:
    """The most memory that this process held since the last reset, in bytes."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5")
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) << 10


def main() -> None:
    warnings.simplefilter("ignore")
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # output of libraries must not mix with answers
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    torch.set_num_threads(1)
    worker = Worker(answers)
    for line in sys.stdin:
        worker.job(json.loads(line))
        worker.say("done")


if __name__ == "__main__":
    main()
