"""docs/coverage.md from the catalog and the last full parity matrix.

    python tests/parity/coverage.py            # after `make parity`, which leaves build/parity.json

A test compares the page with the catalog, so an op that is added without `make parity coverage` fails it.
"""

from __future__ import annotations

import importlib
import inspect
import json
from collections import defaultdict
from itertools import groupby
from pathlib import Path

import chiasm.geometry
from chiasm.export.catalog import NO_GRADIENT, NOT_DEPLOYED, Entry, catalog

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "coverage.md"
#: Families that are complete: each of their public functions is in the catalog, or is listed with the reason
#: why it cannot be.
COMPLETE = (
    "augmentation",
    "color",
    "enhance",
    "filters",
    "morphology",
    "image",
    "feature",
    "losses",
    "ops",
    "metrics",
    "contrib",
    "pipelines",
    *(f"geometry.{family}" for family in chiasm.geometry.__all__),
)
WAYS = {
    "TorchScript (C++)": lambda check: check["artifact"].endswith("forward.pt"),
    "ONNX (C++)": lambda check: check["backend"] == "C++ onnx",
    "ONNX (Python)": lambda check: check["backend"] == "Python onnx",
    "native (C++)": lambda check: check["backend"] == "C++ native",
    "fused in ONNX Runtime": lambda check: check["backend"] in ("C++ onnx fused", "Python onnx fused"),
}


def declared(entry: Entry) -> list[str]:
    """What the catalog alone says of an op: the page's first cells."""
    spec = entry.spec
    tolerances = {d: spec.tolerance("forward", d) for d in spec.dtypes if spec.generic}
    loosest = next(iter(tolerances.values()), None)
    gradient = ", ".join(f"`{n}`" for n in spec.differentiated()) or "no"
    return [
        f"`{spec.name}`",
        " ".join(spec.dtypes) if spec.generic else "as declared",
        gradient,
        f"{loosest.atol:g} + {loosest.rtol:g}" if loosest else "exact",
        spec.reference or "-",
    ]


def public_functions() -> dict[str, bool]:
    """Names of the complete families' functions, and whether the catalog has a spec of each."""
    deployed = {inspect.unwrap(e.function()) for e in catalog().values()}
    found = {}
    for family in COMPLETE:
        module = importlib.import_module(f"chiasm.{family}")
        for name in module.__all__:
            if inspect.isfunction(getattr(module, name)):
                found[f"{family}.{name}"] = getattr(module, name) in deployed
    return found


def cell(checks: list[dict], way: str, method: str) -> str:
    """The largest error of a way to run a method, or what went wrong."""
    mine = [c for c in checks if c["method"] == method and WAYS[way](c)]
    if not mine:
        return ""
    return (
        "**failed**"
        if any(c["message"] for c in mine)
        else f"{max(c['error'] for c in mine):.0e}".replace("0e+00", "0")
    )


def page(entries: dict[str, Entry], checks: list[dict]) -> str:
    by_op: dict[str, list[dict]] = defaultdict(list)
    for check in checks:
        by_op[check["op"]].append(check)
    missing = sorted(set(entries) - set(by_op))
    if missing:
        raise SystemExit(f"build/parity.json has nothing of {', '.join(missing)}: run `make parity` first")
    public = public_functions()
    without = [f"`{n}`" for n in entries if not cell(by_op[n], "native (C++)", "forward")]
    failed = sum(bool(c["message"]) for c in checks)
    lines = [
        "# Coverage",
        "",
        (
            "Written by `make parity coverage`; do not edit. Each number is the largest difference from eager"
            " Python over the parity matrix's"
        ),
        (
            "shapes (none of them the exported ones; batches of 1 and more; 1, 3 and 5 channels) and the op's"
            " dtypes; every one is within the op's tolerance"
        ),
        "`atol + rtol |expected|`, given for its first dtype. An empty cell: there is no such artifact.",
        "",
        (
            f"{len(public)} public functions in {', '.join(COMPLETE)}: {sum(public.values())} are deployed in"
            f" every format, {len(public) - sum(public.values())} are"
        ),
        (
            f"not, for the reasons at the end. {len(entries)} specs in all families (some functions have"
            f" several), {len(checks)} comparisons, {failed} failed."
        ),
        (
            f"Not compiled in this run: {', '.join(without)}."
            if without
            else "All of them were compiled natively."
        ),
        "",
        "| family | specs | " + " | ".join(WAYS) + " | with vjp |",
        "|---|---|" + "---|" * (len(WAYS) + 1),
    ]
    for family, names in groupby(entries, key=lambda n: n.partition(".")[0]):
        group = list(names)
        counts = [sum(bool(cell(by_op[n], way, "forward")) for n in group) for way in WAYS]
        gradients = sum(bool(entries[n].spec.differentiated()) for n in group)
        lines.append(
            f"| {family} | {len(group)} | "
            + " | ".join(f"{100 * c // len(group)} %" for c in counts)
            + f" | {gradients} |"
        )
    for family, names in groupby(entries, key=lambda n: n.partition(".")[0]):
        columns = ["op", "dtypes", "vjp by", "tolerance", "reference", *WAYS, "vjp ONNX", "vjp native"]
        lines += ["", f"## {family}", "", "| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
        for name in names:
            errors = [cell(by_op[name], way, "forward") for way in WAYS]
            errors += [cell(by_op[name], way, "vjp") for way in ("ONNX (C++)", "native (C++)")]
            lines.append("| " + " | ".join(declared(entries[name]) + errors) + " |")
    lines += ["", "## Not deployed", ""]
    lines += [f"* `{name}`: {reason}" for name, reason in sorted(NOT_DEPLOYED.items())]
    lines += [
        "",
        "## Differentiable, without an exported gradient",
        "",
        "Eager Python and TorchScript have it.",
        "",
    ]
    lines += [f"* `{name}`: {reason}" for name, reason in sorted(NO_GRADIENT.items())]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(catalog(), json.loads((ROOT / "build" / "parity.json").read_text())))
    print(f"wrote {PAGE.relative_to(ROOT)}")
