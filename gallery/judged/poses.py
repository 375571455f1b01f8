"""Estimated rotations, directions and positions, and true ones."""

from __future__ import annotations

import torch

from gallery.geometric.setting import Inputs, Setting, motion

TRUE = ((10.0, 25.0, 15.0), (0.0, -30.0, 40.0), (-20.0, 20.0, -30.0))
FOUND = ((12.0, 29.0, 12.0), (15.0, -38.0, 58.0), (40.0, 60.0, -70.0))


def rotations(s: Setting) -> Inputs:
    """Three poses, the first of them nearly right."""
    shifts = (
        ((0.9, 0.3, 0.2), (1.0, 0.4, 0.2)),
        ((0.8, 0.4, -0.3), (0.6, 0.8, -0.1)),
        ((0.6, -0.7, 0.1), (0.8, 0.5, 0.3)),
    )
    true = torch.stack([motion(t, turn) for turn, (t, _) in zip(TRUE, shifts, strict=True)])
    found = torch.stack([motion(t, turn) for turn, (_, t) in zip(FOUND, shifts, strict=True)])
    return {name: value.contiguous() for name, value in (
        ("R1", found[:, :3, :3]), ("R2", true[:, :3, :3]), ("P", found[:, :3]), ("P_gt", true[:, :3]),
    )}  # fmt: skip


def vectors(s: Setting) -> Inputs:
    true = torch.tensor([[1.0, 0.5, 0.2], [0.3, 1.0, -0.4], [-0.8, 0.4, 0.6]])
    return {"v1": torch.tensor([[0.9, 0.7, 0.3], [0.9, 0.5, -0.2], [0.7, 0.9, 0.1]]), "v2": true}


def positions(s: Setting) -> Inputs:
    """A camera's path up a spiral, and an estimate that drifts; errors of poses in degrees."""
    turn = torch.linspace(0, 9, 24)
    true = torch.stack([turn.cos(), turn.sin(), 0.25 * turn], 1)
    random = torch.Generator().manual_seed(0)
    drift = (0.05 * torch.randn(true.shape, generator=random)).cumsum(0)
    errors = 8 * torch.rand(60, generator=random) ** 2 + 0.3
    errors[::6] *= 5
    return {"t": true + drift, "t_gt": true, "errors": errors}
