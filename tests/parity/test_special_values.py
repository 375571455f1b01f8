"""The program that tests ops with special values detects failures."""

import sys
import textwrap

import pytest
import special_cases
import special_values
import torch
from special_cases import Case, agreeing, apply, cases, determined

#: A worker with four ops: one dies, one never ends, one fails a comparison, one passes.
WORKER = """
import json, os, signal, sys
for line in sys.stdin:
    job = json.loads(line)
    for step in ["forward eager: x=nan, all", "forward native: x=nan, all"]:
        if step in job["skipped"]:
            continue
        print("begin", step, flush=True)
        if job["op"] == "dies" and "native" in step:
            os.kill(os.getpid(), signal.SIGSEGV)
        while job["op"] == "hangs" and "native" in step:
            pass
        if job["op"] == "differs" and "native" in step:
            failure = {"op": job["op"], "method": "forward", "backend": "native", "case": "x=nan, all"}
            print("fail", json.dumps(failure | {"message": "1, eager nan"}), flush=True)
        print("end", flush=True)
    print("done", flush=True)
"""


@pytest.fixture
def child(tmp_path, monkeypatch):
    worker = tmp_path / "worker.py"
    worker.write_text(textwrap.dedent(WORKER))
    monkeypatch.setattr(special_values, "WORKER", worker)
    monkeypatch.setattr(special_values, "PROCESSOR_SECONDS", 0.3)
    made = special_values.Child()
    yield made
    if made.process is not None:
        made.stop()


@pytest.mark.parametrize(
    "op, message",
    [("dies", "ended by SIGSEGV"), ("hangs", "did not end in 0.3 s"), ("differs", "1, eager nan")],
)
def test_a_call_that_dies_hangs_or_differs_is_reported_and_the_rest_goes_on(child, op, message):
    report = child.check({"op": op, "skipped": []})
    (failure,) = report.failures
    assert (failure["backend"], failure["case"], failure["message"]) == ("native", "x=nan, all", message)
    after = child.check({"op": "well", "skipped": []})
    assert after.calls == 2 and not after.failures


def test_an_op_that_always_dies_is_given_up(child, monkeypatch):
    monkeypatch.setattr(special_values, "WORKER", sys.executable)  # not Python source: ends at once
    report = child.check({"op": "dies", "skipped": []})
    assert (
        len(report.failures) == special_values.DEATHS + 1 and "is left out" in report.failures[-1]["message"]
    )


def test_cases_hold_what_they_say():
    inputs = {"x": torch.rand(2, 3, 4) + 1.0, "labels": torch.tensor([1, 2, 3]), "m": torch.rand(1, 3, 3)}
    seen = {str(c): apply(inputs, c) for c in cases(inputs)}
    assert seen["x=nan, all"]["x"].isnan().all() and torch.equal(
        seen["x=nan, all"]["labels"], inputs["labels"]
    )
    assert int(seen["x=inf, one"]["x"].isinf().sum()) == 1
    assert seen["x=negated, row"]["x"].lt(0).sum(-1).flatten().tolist() == [0, 0, 0, 4, 0, 0]
    assert 0 < float(seen["x=denormal, all"]["x"].max()) < torch.finfo(torch.float32).tiny
    assert seen["labels=1000000000, one"]["labels"].tolist() == [1, 10**9, 3]
    assert torch.linalg.matrix_rank(seen["m=rank one, all"]["m"]).tolist() == [1]
    assert all(
        not torch.equal(changed[c.partition("=")[0]], inputs[c.partition("=")[0]])
        for c, changed in seen.items()
    )


def test_what_hangs_on_rounding_is_not_compared_and_everything_else_is():
    values = torch.tensor([1.0, 2.0, torch.nan, torch.inf, 5.0])
    other = torch.tensor([1.0, 2.5, torch.nan, torch.inf, torch.nan])
    assert determined(values, [values, other], 1e-6, 1e-6).tolist() == [True, False, True, True, False]
    wrong = torch.tensor([1.1, 2.0, 0.0, torch.nan, -torch.inf])
    assert agreeing(wrong, values, 1e-6, 1e-6).tolist() == [False, True, False, False, False]


def test_huge_numbers_that_cancel_are_told_from_those_that_do_not():
    inputs = {"x": torch.full((1, 1, 4, 50), 1e10)}
    shaken = [special_cases.shaken(inputs, seed, 1e-4)["x"] for seed in (1, 2, 3)]
    for op, expected in [(lambda x: x * 0.5, True), (lambda x: x[..., 1:] - x[..., :-1], False)]:
        known = determined(op(inputs["x"]), [op(x) for x in shaken], 5e-6, 2.5e-5)
        assert bool(known.all()) == expected and bool(known.any()) == expected


def test_a_case_is_named_as_it_is_asked_for():
    assert str(Case("input", "nan", "row")) == "input=nan, row"
