# Some of torch's settings have hardly any types.
# pyright: reportUnknownMemberType=false
"""Settings of the exporter's process that an op may change, such as torch's default dtype.

They are the caller's, and no format has them: a bundle would be what the op is under the settings that it
found.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import torch

from ..errors import own_line

_LEAST = sys.float_info.min


class _Setting(NamedTuple):
    name: str
    read: Callable[[], Any]
    write: Callable[[Any], object]


def _set_default_device(device: torch.device) -> None:
    torch.set_default_device(None if device.type == "cpu" else device)


def _set_anomaly_detection(flags: tuple[bool, bool]) -> None:
    torch.autograd.set_detect_anomaly(*flags)


def _set_autocast(flag: bool) -> None:
    torch.set_autocast_enabled("cpu", flag)


def _set_numpy_errors(errors: dict[str, Any]) -> None:
    np.seterr(**errors)


_SETTINGS = (
    _Setting("torch's default dtype", torch.get_default_dtype, torch.set_default_dtype),
    _Setting("torch's default device", torch.get_default_device, _set_default_device),
    _Setting("the number of torch's threads", torch.get_num_threads, torch.set_num_threads),
    _Setting("whether torch records gradients", torch.is_grad_enabled, torch.set_grad_enabled),
    _Setting(
        "whether torch is deterministic",
        torch.get_deterministic_debug_mode,
        torch.set_deterministic_debug_mode,
    ),
    _Setting(
        "the precision of torch's matrix products",
        torch.get_float32_matmul_precision,
        torch.set_float32_matmul_precision,
    ),
    _Setting(
        "torch's detection of anomalies",
        lambda: (torch.is_anomaly_enabled(), torch.is_anomaly_check_nan_enabled()),
        _set_anomaly_detection,
    ),
    _Setting("how often torch warns", torch.is_warn_always_enabled, torch.set_warn_always),
    _Setting(
        "torch's autocast",
        lambda: torch.is_autocast_enabled("cpu"),
        _set_autocast,
    ),
    # torch does not say, but Python's arithmetic is affected too
    _Setting(
        "whether the smallest numbers are taken for zero", lambda: _LEAST / 2 == 0, torch.set_flush_denormal
    ),
    _Setting("what NumPy does about errors", np.geterr, _set_numpy_errors),
    _Setting("the working folder", os.getcwd, os.chdir),
)


def settings() -> dict[str, Any]:
    """What the settings are."""
    return {setting.name: setting.read() for setting in _SETTINGS}


def changed(saved: Mapping[str, Any]) -> list[str]:
    """The settings that are others than the saved ones."""
    return [setting.name for setting in _SETTINGS if setting.read() != saved[setting.name]]


def restore(saved: Mapping[str, Any]) -> None:
    """Make the settings what they were."""
    for setting in _SETTINGS:
        if setting.read() != saved[setting.name]:
            setting.write(saved[setting.name])


def line_of_change(run: Callable[[], object], name: str) -> str | None:
    """The op's line that changes a setting, if it does so again when it is run again."""
    read = next(setting.read for setting in _SETTINGS if setting.name == name)
    before, found = read(), list[str | None]()

    def after_each_return(frame: Any, event: str, _: Any) -> None:
        if event.endswith("return") and not found and read() != before:
            found.append(own_line(traceback.extract_stack(frame)))

    sys.setprofile(after_each_return)
    try:
        run()
    except Exception:  # what it changed may have made it fail
        pass
    finally:
        sys.setprofile(None)
    return found[0] if found else None
