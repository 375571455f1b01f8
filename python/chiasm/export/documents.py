"""A bundle's documents: the list of its parts (SBOM, CycloneDX) and its provenance (in-toto statement, SLSA
provenance).

They do not contain the machine, the user or the time, so that the same export gives the same bytes anywhere.
"""

from __future__ import annotations

import inspect
import io
import json
import os
import re
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import nn

from .isas import ISAS, compiler_command, run_tool
from .manifest import sha256

#: The package whose version a shared library has, for libraries that compiled code is linked with.
_OWNERS = ((r"libtorch|libc10", "torch"), (r"lib(c|m|mvec|pthread|dl)\.so|ld-linux", "glibc"))
#: Libraries inside native code, in the compiler's version (`_LINK` in isas.py).
_STATIC = ("libstdc++", "libgcc")


def sbom(manifest: Mapping[str, Any], files: Mapping[str, bytes]) -> bytes:
    """The bundle's parts as CycloneDX 1.6: its files, the packages that made them, and the libraries that its
    code is linked with."""
    native = {name: data for name, data in files.items() if name.endswith(".pt2")}
    versions = dict(manifest["producer"])
    packages = [
        _component("library", name, version, f"pkg:pypi/{name}@{version}")
        for name, version in versions.items()
    ]
    linked: list[dict[str, Any]] = []
    if native:
        versions |= {
            "gcc": _compiler_version(manifest),
            "glibc": (os.confstr("CS_GNU_LIBC_VERSION") or "").removeprefix("glibc "),
        }
        packages.append(_component("application", "g++", versions["gcc"]))
        linked += [_component("library", library, versions["gcc"]) for library in _STATIC]
        libraries = {name: _linked(data) for name, data in native.items()}
        # Not this machine's, but the cross-compiler's, whose version is not known
        foreign = {
            library for file, isa in _isas(manifest) if ISAS[isa].is_foreign for library in libraries[file]
        }
        for library in sorted({library for each in libraries.values() for library in each}):
            owner = next((owner for pattern, owner in _OWNERS if re.match(pattern, library)), "")
            version = "" if library in foreign else versions.get(owner, "")
            linked.append(_component("library", library, version))
    parts = [
        _component("file", name) | {"hashes": [{"alg": "SHA-256", "content": sha256(data)}]}
        for name, data in sorted(files.items())
    ]
    bundle = _component("library", manifest["name"], manifest["version"])
    # Native code contains parts of chiasm and of torch's headers; the other packages only produced the
    # bundle.
    inside = [
        p | {"scope": "required" if native and p["name"] in ("chiasm", "torch") else "excluded"}
        for p in packages
    ]
    components = [*parts, *inside, *[p | {"scope": "required"} for p in linked]]
    identity = json.dumps([bundle, components], sort_keys=True)
    return _json(
        {
            "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
            "bomFormat": "CycloneDX",
            "specVersion": "1.6",
            "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, identity)}",
            "version": 1,
            "metadata": {"component": bundle},
            "components": components,
            "dependencies": [
                {"ref": bundle["bom-ref"], "dependsOn": [c["bom-ref"] for c in (*parts, *linked)]}
            ],
        }
    )


def _component(kind: str, name: str, version: str = "", purl: str = "") -> dict[str, Any]:
    known = {key: value for key, value in (("version", version), ("purl", purl)) if value}
    return {"type": kind, "bom-ref": purl or f"{kind}:{name}", "name": name} | known


def _linked(package: bytes) -> list[str]:
    with zipfile.ZipFile(io.BytesIO(package)) as archive:
        return [
            library
            for name in archive.namelist()
            if name.endswith(".so")
            for library in _needed(archive.read(name))
        ]


def _needed(code: bytes) -> list[str]:
    """The shared libraries that compiled code is linked with."""
    with tempfile.NamedTemporaryFile(suffix=".so") as file:
        file.write(code)
        file.flush()
        return re.findall(r"NEEDED +(\S+)", run_tool(["objdump", "-p", file.name]))


def _compiler_version(manifest: Mapping[str, Any]) -> str:
    """The version of g++, or all versions if there was more than one."""
    commands = sorted({compiler_command(isa) for _, isa in _isas(manifest)})
    return ", ".join(dict.fromkeys(run_tool([c, "-dumpfullversion"]).strip() for c in commands))


def _isas(manifest: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The files of native code, each with the instruction set that it was compiled for."""
    for method in manifest["methods"].values():
        for artifact in method["artifacts"]:
            if "isa" in artifact or "sm" in artifact:
                yield artifact["file"], artifact.get("isa") or f"sm_{artifact['sm']}"


def provenance(
    fn: Callable[..., Any] | nn.Module,
    manifest: Mapping[str, Any],
    files: Mapping[str, bytes],
    asked: Mapping[str, Sequence[str]],
) -> bytes:
    """A bundle's provenance: its files with their hashes, the op's source, the request, and the versions of
    the packages that produced it."""
    packages = [
        {"name": name, "uri": f"pkg:pypi/{name}@{version}"} for name, version in manifest["producer"].items()
    ]
    sources = [{"name": name, "digest": {"sha256": digest}} for name, digest in _sources(fn)]
    compiler = (
        {"compiler": f"g++ {_compiler_version(manifest)}"}
        if any(name.endswith(".pt2") for name in files)
        else {}
    )
    return _json(
        {
            "_type": "https://in-toto.io/Statement/v1",
            "subject": [
                {"name": name, "digest": {"sha256": sha256(data)}} for name, data in sorted(files.items())
            ],
            "predicateType": "https://slsa.dev/provenance/v1",
            "predicate": {
                "buildDefinition": {
                    "buildType": "urn:chiasm:export:1",
                    "externalParameters": {
                        "name": manifest["name"],
                        "version": manifest["version"],
                        "config": manifest["config"],
                        "symbols": manifest["symbols"],
                        "dtypes": manifest["dtypes"],
                        **{key: list(values) for key, values in asked.items()},
                    },
                    "internalParameters": {"python": ".".join(map(str, sys.version_info[:3])), **compiler},
                    "resolvedDependencies": [*sources, *packages],
                },
                "runDetails": {
                    "builder": {
                        "id": "urn:chiasm:exporter",
                        "version": {"chiasm": manifest["producer"]["chiasm"]},
                    }
                },
            },
        }
    )


def _sources(fn: Callable[..., Any] | nn.Module) -> list[tuple[str, str]]:
    """The Python modules that define the op's function, or its module's classes, with the hashes of their
    files."""
    written = (
        [type(m) for m in fn.modules()]
        if isinstance(fn, nn.Module)
        else [inspect.unwrap(getattr(fn, "func", fn))]
    )
    found: dict[str, str] = {}
    for item in written:
        try:
            file = Path(inspect.getsourcefile(item) or "")
            if not file.is_relative_to(Path(torch.__file__).parent):
                found[item.__module__] = sha256(file.read_bytes())
        except (OSError, TypeError):  # defined in an interactive session, or in C
            continue
    return sorted(found.items())


def _json(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, indent=1) + "\n").encode()
