"""Writes a model repository: complete models, and never over existing ones."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ..export.manifest import SUFFIX
from .ensembles import Ensemble, joined
from .parts import Part, RepositoryError, Tensor

_NETWORK = Path(__file__).with_name("network.py")
_SCRATCH = ".chiasm-triton-"


def write(repository: Path, parts: Sequence[Part], ensemble: str | None = None) -> list[Path]:
    """Write a model for each part, and optionally one that runs them in sequence.

    Parameters
    ----------
    repository
        The folder that ``tritonserver --model-repository`` names; created if it does not exist.
    parts
        Bundles are copied; networks are run by ONNX Runtime in Triton's Python backend.
    ensemble
        The name of a model that runs all parts in their order: the outputs of each become the inputs of the
        next part with the same names; a single output becomes a single input whatever their names.

    Returns
    -------
    The models' folders, the ensemble's at the end.

    Raises
    ------
    RepositoryError
        If a model of that name exists, or parts do not fit. Nothing is written then.
    BundleError
        If a bundle is damaged.
    """
    chain = [] if ensemble is None else [joined(Part.check_name(ensemble), parts)]
    names = [part.name for part in parts] + [each.name for each in chain]
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise RepositoryError(f"two models would be called '{twice[0]}': give other names, NAME=PATH")
    for name in names:
        if os.path.lexists(repository / name):
            raise RepositoryError(
                f"{repository / name} is there already: remove it, or give another name, NAME=PATH"
            )
    within = Path(os.path.realpath(repository))
    for part in parts:
        if not part.is_network and within.is_relative_to(os.path.realpath(part.path)):
            raise RepositoryError(
                f"{repository}: it is inside the bundle {part.path}, which a new file would make invalid:"
                " choose a folder beside it"
            )
        _ = part.tensors  # reads the bundle: nothing is written before all bundles are known to be valid
    repository.mkdir(parents=True, exist_ok=True)
    moved: list[Path] = []
    try:
        # Write elsewhere and then move: a running server must see only complete models
        with tempfile.TemporaryDirectory(prefix=_SCRATCH, dir=_movable_from(repository)) as scratch:
            for part in parts:
                _write_part(Path(scratch) / part.name, part)
            for each in chain:
                _write_ensemble(Path(scratch) / each.name, each)
            for name in names:
                os.rename(Path(scratch) / name, repository / name)
                moved.append(repository / name)
    except BaseException as error:
        for folder in moved:
            shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OSError):
            file = str(error.filename2 or error.filename or repository)
            where = repository if _SCRATCH in file else file
            raise RepositoryError(f"{where}: {error.strerror or error}") from error
        raise
    return moved


def _movable_from(repository: Path) -> Path:
    """A folder from which models can be moved into the repository: the one that holds it. If the repository
    is a mount, as in a container, or that folder cannot be written, the repository itself, where a server
    that polls reports the unfinished folder in its log."""
    beside = repository.resolve().parent
    try:
        with tempfile.TemporaryDirectory(prefix=_SCRATCH, dir=beside) as scratch:
            file, moved = Path(scratch) / "probe", repository / Path(scratch).name
            file.touch()  # a file, because a server takes each folder for a model
            os.rename(file, moved)
            moved.unlink()
    except OSError:
        return repository
    return beside


def _write_part(folder: Path, part: Part) -> None:
    version = folder / "1"
    version.mkdir(parents=True)
    if part.is_network:
        shutil.copyfile(part.path, version / "model.onnx")
        shutil.copyfile(_NETWORK, version / "model.py")
        inputs, outputs = part.tensors
        config = 'backend: "python"\n' + _described("input", inputs) + _described("output", outputs)
    else:
        _copy(part.path, version / f"{part.path.resolve().name.removesuffix(SUFFIX)}{SUFFIX}")
        config = 'backend: "chiasm"\n'  # the backend reads the rest from the manifest
    (folder / "config.pbtxt").write_text(config, "utf-8")


def _copy(bundle: Path, target: Path) -> None:
    try:
        shutil.copytree(bundle, target)
    except shutil.Error as error:  # of each file
        file, _, why = error.args[0][0]
        raise RepositoryError(f"{file}: cannot be copied: {why}") from error


def _write_ensemble(folder: Path, ensemble: Ensemble) -> None:
    (folder / "1").mkdir(parents=True)  # Triton requires a version folder; an ensemble's is empty
    config = 'platform: "ensemble"\n'
    config += _described("input", ensemble.inputs) + _described("output", ensemble.outputs)
    config += "ensemble_scheduling {\n"
    for step in ensemble.steps:
        config += f"  step {{\n    model_name: {_quoted(step.model)}\n    model_version: -1\n"
        for kind, mapping in (("input_map", step.inputs), ("output_map", step.outputs)):
            for key, value in mapping.items():
                config += f"    {kind} {{ key: {_quoted(key)} value: {_quoted(value)} }}\n"
        config += "  }\n"
    (folder / "config.pbtxt").write_text(config + "}\n", "utf-8")


def _described(kind: str, tensors: Sequence[Tensor]) -> str:
    return "".join(
        f"{kind} {{ name: {_quoted(t.name)} data_type: TYPE_{t.type} dims: {list(t.dims)} }}\n"
        for t in tensors
    )


def _quoted(text: str) -> str:
    """A string of protobuf's text format, which has no \\u."""
    parts = (f"\\{ord(c):03o}" if ord(c) < 32 or c in '"\\\x7f' else c for c in text)
    return f'"{"".join(parts)}"'
