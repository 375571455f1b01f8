"""The example of several processes at a small size: together they give the result of a single process."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch

from gallery.cases import ROOT
from studies.distributed.__main__ import alone, by_processes
from studies.distributed.report import apart, check, edges, section
from studies.distributed.settings import SMALL
from studies.distributed.work import batch, corners_taken, corners_truly, moved, truth


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    return by_processes(SMALL, tmp_path_factory.mktemp("processes"))


@pytest.fixture(scope="module")
def single() -> dict[str, Any]:
    return alone(SMALL)


def test_the_pipeline_of_two_processes_is_one_processs(
    together: list[dict[str, Any]], single: dict[str, Any]
) -> None:
    assert [len(result["edges"]) for result in together] == [2, 1]
    assert torch.equal(edges(together), single["edges"])


def test_ddp_learns_what_one_process_learns_which_is_the_truth(
    together: list[dict[str, Any]], single: dict[str, Any]
) -> None:
    assert apart(SMALL, together, single) <= SMALL.tolerance
    assert np.abs(corners_taken(single["homography"], SMALL) - corners_truly(SMALL)).max() < 0.3
    identity = torch.eye(3)[None]
    assert np.abs(corners_taken(identity, SMALL) - corners_truly(SMALL)).max() > 3


def test_two_torchruns_that_find_each_other_as_machines_do(single: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "settings.json").write_text(json.dumps(asdict(SMALL)))
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port = probe.getsockname()[1]
    nodes = ["--nnodes=2", "--nproc-per-node=1", "--rdzv-backend=c10d", f"--rdzv-endpoint=localhost:{port}"]
    command = [
        sys.executable,
        "-m",
        "torch.distributed.run",
        *nodes,
        "-m",
        "studies.distributed.worker",
        str(tmp_path),
    ]
    machines = [subprocess.Popen(command, cwd=ROOT) for _ in range(2)]
    assert [machine.wait() for machine in machines] == [0, 0]
    check(SMALL, torch.load(tmp_path / "result.pt"), single)


def test_a_difference_is_found(together: list[dict[str, Any]], single: dict[str, Any]) -> None:
    check(SMALL, together, single)
    with pytest.raises(RuntimeError, match="the pipeline's results differ"):
        check(SMALL, together, single | {"edges": single["edges"] + 1e-6})
    with pytest.raises(RuntimeError, match="what was learned differs"):
        check(SMALL, together, single | {"homography": single["homography"] + 1e-4 * torch.eye(3)[:1]})
    text = "\n".join(section(replace(SMALL, steps=7), together, single))
    assert "bit for bit" in text and "2 and 1" in text and "2 x 7 steps" in text


def test_photographs_move_as_opencv_moves_them() -> None:
    photographs = batch(SMALL)
    theirs = cv2.warpPerspective(
        photographs[0].permute(1, 2, 0).numpy(), truth(SMALL), SMALL.size, flags=cv2.INTER_LINEAR
    )
    ours = moved(photographs, SMALL)[0].permute(1, 2, 0).numpy()
    assert np.abs(ours - theirs)[4:-4, 4:-4].mean() < 0.01
