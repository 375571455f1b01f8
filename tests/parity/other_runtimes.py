"""Runs bundles in engines that chiasm does not ship: an old ONNX Runtime and OpenVINO, with both forms of
each ONNX artifact.

    tools/other_runtimes.sh                              # makes the environments
    python tests/parity/other_runtimes.py [FOLDER]       # the folder of bundles; build/bundles by default

Every ONNX artifact of the ops listed below is run on the bundle's golden vectors and compared within the
manifest's tolerances; in the old ONNX Runtime the fused form also runs with chiasm's plug-in. Known failures
of an engine are listed below with the reason; an entry that no longer fails is a failure, so that the list
stays correct. The last line printed is `other runtimes: N checks, M failed`, and the exit status is 1 if
something failed.
"""

from __future__ import annotations

import json
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from other_runtimes_worker import forms
from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from chiasm.onnx import library

ROOT = Path(__file__).resolve().parents[2]
WORKER = Path(__file__).with_name("other_runtimes_worker.py")

#: By engine: its environment in .deps, and the module to import.
ENGINES = {
    "ONNX Runtime 1.17": ("ort-1.17", "onnxruntime"),
    "OpenVINO": ("openvino", "openvino"),
}

_OLD_FLOAT64 = "ONNX Runtime 1.17 has no float64 kernel of Cos and others"
_OLD_FUSION = (
    "ONNX Runtime 1.17 fuses a float64 product with a transpose into an operator that it has for float32 only"
)
_FLOAT32_INSIDE = "OpenVINO's CPU plug-in computes float64 in float32"
_EDGES = "the edges of bins are rounded from quotients, whose last bits are OpenVINO's own"

#: The ops that were examined with these engines; each family of image ops is represented.
OPS = (
    "ops.*",
    "color.*12_to_rgb*",
    "color.rgb_to_grayscale",
    "color.rgb_to_hsv",
    "enhance.normalize",
    "feature.*",
    "filters.bilateral_blur",
    "filters.gaussian_blur2d",
    "filters.median_blur",
    "filters.sobel",
    "geometry.*",
    "losses.*",
    "morphology.dilation",
    "pipelines.*",
)


def _old(
    reason: str, methods: list[str], ops: str, family: str = "geometry", dtype: str = "float32"
) -> dict[tuple[str, str, str], str]:
    """Known failures of ONNX Runtime 1.17 for some ops of a family, in both forms."""
    files = [f"{method}.{dtype}{form}.onnx" for method in methods for form in ("", ".fused")]
    return {("ONNX Runtime 1.17", f"{family}.{op}", file): reason for op in ops.split() for file in files}


#: (engine, op, file) -> why the engine cannot do it.
KNOWN = {
    **_old(
        _OLD_FLOAT64,
        ["forward", "vjp"],
        """
        epipolar.motion_from_essential_choose_solution pnp.refine_pnp transform.get_affine_matrix2d
        transform.get_affine_matrix3d transform.get_projective_transform transform.get_rotation_matrix2d
        transform.get_shear_matrix2d transform.get_shear_matrix3d transform.rotate transform.rotate3d
        transform.scale
    """,
    ),
    **_old(
        _OLD_FLOAT64,
        ["forward"],
        "transform.rotate.frames transform.warp_polar.linear.frames transform.warp_polar.log.frames",
        dtype="uint8",
    ),
    **_old(_OLD_FLOAT64, ["forward"], "transform.rotate.frames", dtype="int16"),
    **_old(_OLD_FLOAT64, ["forward"], "transform.rotate.frames", dtype="uint16"),
    **_old(
        _OLD_FUSION,
        ["forward"],
        """
        calibration.solve_pnp_dlt epipolar.decompose_essential_matrix epipolar.find_essential
        epipolar.find_fundamental epipolar.find_fundamental_7point epipolar.motion_from_essential
        epipolar.project_to_essential epipolar.triangulate_points ransac.ransac_essential
        ransac.ransac_fundamental solvers.find_affine stereo.stereo_rectify transform.crop_and_resize
        transform.crop_by_boxes transform.get_perspective_transform
    """,
    ),
    **_old(
        _OLD_FUSION,
        ["forward"],
        "transform.crop_and_resize.frames transform.crop_by_boxes.frames",
        dtype="uint8",
    ),
    **_old(
        _OLD_FUSION,
        ["forward"],
        """
        match_fginn.mutual match_fginn.plain match_mnn.masked match_mnn.plain match_nn.masked match_nn.plain
        match_smnn match_smnn_batched match_snn match_adalam.masked match_adalam.plain
    """,
        "feature",
    ),
    **_old(_OLD_FUSION, ["forward"], "two_view_homography", "pipelines"),
    **_old(_OLD_FUSION, ["forward"], "byte_track kalman_predict kalman_update sort_track", "ops"),
    **_old(_OLD_FLOAT64, ["forward"], "rotated_nms_fixed", "ops"),
    **_old(
        "ONNX Runtime 1.17 computes an index in the loop that is out of range",
        ["forward"],
        "ctc_beam_decode",
        "ops",
    ),
    (
        "ONNX Runtime 1.17",
        "geometry.conversions.axis_angle_to_rotation_matrix",
        "forward.float64.onnx",
    ): _OLD_FLOAT64,
    (
        "ONNX Runtime 1.17",
        "geometry.conversions.axis_angle_to_rotation_matrix",
        "forward.float64.fused.onnx",
    ): _OLD_FLOAT64,
    ("OpenVINO", "color.rgb_to_grayscale", "forward.float64.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "filters.sobel", "forward.float64.onnx"): _FLOAT32_INSIDE,
    (
        "OpenVINO",
        "geometry.transform.resize.bilinear_antialias.frames",
        "forward.uint8.onnx",
    ): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.camera.project_points", "forward.float64.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.transform.elastic_transform2d", "forward.float32.onnx"): (
        "OpenVINO 2026.4 optimises the graph into a wrong one: with every step as an output it is right"
    ),
    ("OpenVINO", "geometry.epipolar.find_essential", "forward.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.epipolar.find_fundamental_7point", "forward.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.epipolar.find_fundamental_7point", "vjp.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.ransac.ransac_essential", "forward.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.ransac.ransac_fundamental", "forward.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.ransac.ransac_fundamental", "vjp.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.solvers.solve_quadratic", "forward.float64.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "geometry.solvers.solve_quartic", "forward.float64.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "ops.decode_db", "forward.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "ops.decode_heatmaps", "forward.float32.onnx"): (
        "OpenVINO 2026.4 answers otherwise from run to run"
    ),
    ("OpenVINO", "ops.ps_roi_pool", "forward.float32.onnx"): _EDGES,
    ("OpenVINO", "ops.ps_roi_pool", "vjp.float32.onnx"): _EDGES,
    ("OpenVINO", "ops.roi_pool", "forward.float32.onnx"): _EDGES,
    ("OpenVINO", "losses.mutual_information_loss_2d.masked", "vjp.float32.onnx"): _FLOAT32_INSIDE,
    ("OpenVINO", "losses.normalized_mutual_information_loss_2d.masked", "vjp.float32.onnx"): _FLOAT32_INSIDE,
    (
        "OpenVINO",
        "geometry.conversions.axis_angle_to_rotation_matrix",
        "forward.float64.onnx",
    ): _FLOAT32_INSIDE,
}
#: Known failures that occur only on some CPUs or in some runs.
ON_SOME_MACHINES = {
    ("OpenVINO", "geometry.transform.elastic_transform2d", "forward.float32.onnx"),
    ("OpenVINO", "ops.decode_heatmaps", "forward.float32.onnx"),
}
#: engine -> why it cannot do the fused form of any op.
KNOWN_FUSED = {
    "OpenVINO": "OpenVINO's ONNX reader does not expand a model's own functions: it takes the flat form"
}


def main(folder: Path) -> int:
    console = Console(width=None if sys.stdout.isatty() else 160)
    bundles = sorted(b for b in folder.glob("*.chiasm") if any(fnmatch(b.stem, op) for op in OPS))
    rows = [row for engine in ENGINES for row in run(engine, bundles)]
    console.print(summary(rows))
    for engine, reason in KNOWN_FUSED.items():
        count = sum(r["known"] and r["engine"] == engine and r["form"] == "body" for r in rows)
        console.print(f"[yellow]known[/] {engine}: {count} fused artifacts: {reason}", highlight=False)
    for r in rows:
        if r["known"] and not (r["form"] == "body" and r["engine"] in KNOWN_FUSED):
            console.print(
                f"[yellow]known[/] {r['engine']}: {r['op']} {r['file']}:"
                f" {KNOWN[r['engine'], r['op'], r['file']]}",
                highlight=False,
            )
    failed = [r for r in rows if r["message"] and not r["known"]]
    for r in failed[:40]:
        console.print(
            f"[red]FAIL[/] {r['engine']}: {r['op']} {r['file']}: {escape(r['message'][:600])}",
            highlight=False,
        )
    print(f"other runtimes: {len(rows)} checks, {len(failed)} failed")
    return 1 if failed or not rows else 0


def run(engine: str, bundles: list[Path]) -> list[dict[str, Any]]:
    """The worker's rows, and a row for every artifact that it should have run but did not."""
    environment, module = ENGINES[engine]
    python = ROOT / ".deps" / environment / "bin" / "python"
    if not python.exists():
        raise SystemExit(f"{python} is missing: run tools/other_runtimes.sh")
    done = subprocess.run([python, WORKER, module, library(), *bundles], capture_output=True, text=True)
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    seen = {(r["op"], r["file"], r["form"]) for r in rows}
    for op, file, form in [key for bundle in bundles for key in expected(module, bundle)]:
        if (op, file, form) not in seen:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            message = f"was not run; the process ended with {done.returncode}: {last}"
            rows.append(
                {
                    "op": op,
                    "file": file,
                    "form": form,
                    "error": float("inf"),
                    "message": message,
                    "seconds": 0.0,
                }
            )
    return [judge(engine, row) for row in rows]


def expected(engine: str, bundle: Path) -> list[tuple[str, str, str]]:
    """(op, file, form) for every ONNX artifact."""
    manifest = json.loads((bundle / "manifest.json").read_text())
    artifacts = [
        (m, a) for m in manifest["methods"].values() for a in m["artifacts"] if a["format"] == "onnx"
    ]
    return [(manifest["name"], a["file"], form) for m, a in artifacts for form in forms(engine, a, m)]


def judge(engine: str, row: dict[str, Any]) -> dict[str, Any]:
    """Apply the list of known failures."""
    reason = KNOWN.get((engine, row["op"], row["file"])) or (
        KNOWN_FUSED.get(engine) if row["form"] == "body" else None
    )
    if row["form"] == "native":  # known failures are of graphs with standard operators
        reason = None
    row |= {"engine": engine, "known": bool(reason and row["message"])}
    if reason and not row["message"] and (engine, row["op"], row["file"]) not in ON_SOME_MACHINES:
        row["message"] = f"passes, though it is listed as known not to ({reason}): take it off the list"
    return row


def summary(rows: list[dict[str, Any]]) -> Table:
    """A table of the largest error per artifact, with a column for each engine and form."""
    columns = (
        "ONNX Runtime 1.17 flat",
        "ONNX Runtime 1.17 body",
        "ONNX Runtime 1.17 native",
        "OpenVINO flat",
    )
    table = Table(
        Column("op", no_wrap=True),
        "artifact",
        *columns,
        title="other runtimes: largest difference from eager Python",
        box=None,
    )
    cells: dict[tuple[str, str], dict[str, str]] = {}
    for r in rows:
        column = f"{r['engine']} {r['form']}"
        colour = "yellow" if r["known"] else "red" if r["message"] else "green"
        key = (r["op"], r["file"].replace(".fused.", "."))
        cells.setdefault(key, {})[column] = f"[{colour}]{r['error']:.1e}[/]"
    for key, found in cells.items():
        table.add_row(*key, *(found.get(column, "") for column in columns))
    return table


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "bundles"))
