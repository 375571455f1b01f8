"""Writes docs/coverage.md from the catalog and docs/coverage.json, the record of the parity matrix's results.

    python tests/parity/coverage.py    # after tests/parity/matrix.py, which leaves build/parity.json, or
                                       # tests/browser/replay.py, which leaves build/browser.json, or
                                       # tests/parity/aarch64.py, which leaves build/aarch64.json, or
                                       # tests/parity/peers.py, which leaves build/peers.json

New results of these are first added to the record. The whole catalog takes hours to compile, so the record is
filled in pieces: for example by `chiasm export 'color.*'` and `matrix.py 'color.*'`. An op is recorded if it
was run in every way, and its gradient, if it has one, by ONNX Runtime and natively.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import json
import sys
from collections import defaultdict
from itertools import groupby
from pathlib import Path
from typing import Any

import chiasm.geometry
from chiasm.export.catalog import NO_GRADIENT, NOT_DEPLOYED, Entry, catalog

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools.columns import wrapped  # noqa: E402

PAGE, RECORD = ROOT / "docs" / "coverage.md", ROOT / "docs" / "coverage.json"
FOUND, FOUND_IN_BROWSER = ROOT / "build" / "parity.json", ROOT / "build" / "browser.json"
FOUND_ON_AARCH64 = ROOT / "build" / "aarch64.json"
FOUND_BESIDE_PEERS = ROOT / "build" / "peers.json"
#: Complete families: each of their public functions is in the catalog, or is listed with the reason why it is
#: not.
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
    """An op's information from the catalog: the first cells of its row."""
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
    """The names of the complete families' functions, and whether the catalog has a spec for each."""
    deployed = {inspect.unwrap(e.function()) for e in catalog().values()}
    found = {}
    for family in COMPLETE:
        module = importlib.import_module(f"chiasm.{family}")
        for name in module.__all__:
            if inspect.isfunction(getattr(module, name)):
                found[f"{family}.{name}"] = getattr(module, name) in deployed
    return found


def digest(entry: Entry) -> str:
    """The digest of an op's source: if the record has another digest, the op has changed since."""
    source = Path(inspect.getsourcefile(inspect.unwrap(entry.function())) or "").read_bytes()
    return hashlib.sha256(source).hexdigest()[:16]


def found(checks: list[dict], method: str) -> dict[str, float | None]:
    """The largest error of each way to run a method, None where a comparison failed."""
    result: dict[str, float | None] = {}
    for way, is_mine in WAYS.items():
        mine = [c for c in checks if c["method"] == method and is_mine(c)]
        if mine:
            result[way] = None if any(c["message"] for c in mine) else max(c["error"] for c in mine)
    return result


def add(record: dict[str, Any], checks: list[dict], entries: dict[str, Entry]) -> int:
    """Add to the record each op that was run in every way; returns their number."""
    by_op: dict[str, list[dict]] = defaultdict(list)
    for check in checks:
        by_op[check["op"]].append(check)
    added = 0
    for name in sorted(set(by_op) & set(entries)):
        row = {
            "source": digest(entries[name]),
            "forward": found(by_op[name], "forward"),
            "vjp": found(by_op[name], "vjp"),
        }
        gradient = {"ONNX (C++)", "native (C++)"} if entries[name].spec.differentiated() else set()
        if WAYS.keys() <= row["forward"].keys() and gradient <= row["vjp"].keys():
            record[name] = record.get(name, {}) | row
            added += 1
    return added


def add_browser(record: dict[str, Any], checks: list[dict]) -> None:
    """Add a browser's results to the record: the largest error on the golden vectors, or None."""
    for name in {check["op"] for check in checks} & record.keys():
        mine = [c for c in checks if c["op"] == name]
        record[name]["browser"] = None if any(c["message"] for c in mine) else max(c["error"] for c in mine)


def add_aarch64(record: dict[str, Any], found: dict[str, dict]) -> None:
    """Add aarch64's results to the record: the largest error on the golden vectors, or None, and whether the
    results have the same bits as on x86-64."""
    for name in found.keys() & record.keys():
        record[name]["aarch64"] = None if found[name]["message"] else found[name]["error"]
        record[name]["aarch64_same_bits"] = found[name]["same_bits"]


def add_peers(record: dict[str, Any], found: dict[str, dict]) -> None:
    """Add to the record by how many levels ops' results differ from their peers', and the share of those
    values."""
    for name in found.keys() & record.keys():
        record[name]["peer"] = found[name]


def beside_peer(row: dict[str, Any]) -> str:
    """A cell of the page: "0", or "1 (0.3 %)" where 0.3 % of the values differ, by a level at most."""
    if "peer" not in row:
        return ""
    most, differing = row["peer"]["most"], row["peer"]["differing"]
    return f"{most:g} ({100 * differing:.2g} %)" if most else "0"


def shown(errors: dict[str, float | None], way: str) -> str:
    """A cell of the page."""
    if way not in errors:
        return ""
    error = errors[way]
    return "**failed**" if error is None else f"{error:.0e}".replace("0e+00", "0")


def page(entries: dict[str, Entry], record: dict[str, Any]) -> str:
    public = public_functions()
    rows = {n: record.get(n, {"source": "", "forward": {}, "vjp": {}}) for n in entries}
    waiting = [f"`{n}`" for n in entries if n not in record]
    changed = [n for n in entries if n in record and rows[n]["source"] != digest(entries[n])]
    failed = [f"`{n}`" for n in entries if None in (*rows[n]["forward"].values(), *rows[n]["vjp"].values())]
    lines = [
        "# Coverage",
        "",
        "Written by `make coverage`; do not edit. Each number is the largest difference from eager",
        "Python over the parity matrix's shapes (none of them the exported ones; batches of 1 and more;",
        "1, 3 and 5 channels) and the op's dtypes; every one is within the op's tolerance",
        "`atol + rtol |expected|`, given for its first dtype. An empty cell: there is no such artifact. In a",
        "browser, by ONNX Runtime for the web, and on aarch64, natively under an emulator, only",
        "golden vectors are compared; `=`: the results on aarch64 equal those on x86-64 bit for bit.",
        "",
        "*Peer*, for ops whose results are bytes or 16 bits: by how many levels they differ at most from the",
        "reference's on photographs (8 of 256 x 256 and one of 1920 x 1080), and the share of values that",
        "differ. Hues are on a circle: 0 and 180 are the same. Warps of bytes round positions to 1/32 pixel,",
        "or to a pixel, and OpenCV in another way. To RGB from Lab and Luv, photographs are read as codes,",
        "many of which are no colour.",
        "",
        f"Of {len(public)} public functions {sum(public.values())} are deployed in every format,",
        f"{len(public) - sum(public.values())} are not, for the reasons at the end. The catalog has",
        f"{len(entries)} specs: some functions have several.",
        "",
        "The whole catalog takes hours to compile, so it is compared in pieces, each at its own time;",
        "every run of the tests compares a part of what a commit changes. The source files of",
        f"{len(changed)} ops, marked `*`, have changed since their comparison.",
        "",
        f"Compared on every backend: {len(entries) - len(waiting)} specs."
        + (f" Failed: {', '.join(failed)}." if failed else " None failed."),
        f"Not compared natively with its gradient yet: {', '.join(waiting)}."
        if waiting
        else "None is left out.",
        "",
        "| family | specs | " + " | ".join(WAYS) + " | browser | aarch64 | with vjp |",
        "|---|---|" + "---|" * (len(WAYS) + 3),
    ]
    for family, names in groupby(entries, key=lambda n: n.partition(".")[0]):
        group = list(names)
        counts = [sum(way in rows[n]["forward"] for n in group) for way in WAYS]
        counts += [sum(rows[n].get(way) is not None for n in group) for way in ("browser", "aarch64")]
        gradients = sum(bool(entries[n].spec.differentiated()) for n in group)
        lines.append(
            f"| {family} | {len(group)} | "
            + " | ".join(f"{100 * c // len(group)} %" for c in counts)
            + f" | {gradients} |"
        )
    for family, names in groupby(entries, key=lambda n: n.partition(".")[0]):
        columns = [
            "op",
            "dtypes",
            "vjp by",
            "tolerance",
            "reference",
            "peer",
            *WAYS,
            "browser",
            "aarch64",
            "vjp ONNX",
            "vjp native",
        ]
        lines += ["", f"## {family}", "", "| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
        for name in names:
            cells = declared(entries[name])
            cells[0] += "\\*" * (name in changed)
            cells.append(beside_peer(rows[name]))
            cells += [shown(rows[name]["forward"], way) for way in WAYS]
            cells.append(shown(rows[name], "browser"))
            cells.append(shown(rows[name], "aarch64") + " =" * rows[name].get("aarch64_same_bits", False))
            cells += [shown(rows[name]["vjp"], way) for way in ("ONNX (C++)", "native (C++)")]
            lines.append("| " + " | ".join(cells) + " |")
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


def main() -> None:
    entries = catalog()
    record = json.loads(RECORD.read_text())
    added = add(record, json.loads(FOUND.read_text()), entries) if FOUND.exists() else 0
    if FOUND_IN_BROWSER.exists():
        add_browser(record, json.loads(FOUND_IN_BROWSER.read_text()))
    if FOUND_ON_AARCH64.exists():
        add_aarch64(record, json.loads(FOUND_ON_AARCH64.read_text()))
    if FOUND_BESIDE_PEERS.exists():
        add_peers(record, json.loads(FOUND_BESIDE_PEERS.read_text()))
    rows = [f"{json.dumps(name)}: {json.dumps(record[name])}" for name in entries if name in record]
    RECORD.write_text("{\n" + ",\n".join(rows) + "\n}\n")
    PAGE.write_text(wrapped(page(entries, record)))
    print(f"{added} ops taken into {RECORD.relative_to(ROOT)}; wrote {PAGE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
