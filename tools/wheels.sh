#!/usr/bin/env bash
# Build chiasm's wheels into dist/: chiasm for each Python in PYTHONS; chiasm-ops, chiasm-export and
# chiasm-torch once. auditwheel tags those with code by the oldest glibc on which it runs. The same sources
# give the same bytes.
# usage: [PYTHONS="python3.10 python3.12"] [DIST=FOLDER] tools/wheels.sh [WHAT...]
#   WHAT: runtime, aarch64, ops, export, torch. aarch64: chiasm for that CPU, by a cross-compiler
#   (tools/aarch64.sh first). By default the other four.
set -euo pipefail
cd "$(dirname "$0")/.."
PYTHONS=${PYTHONS:-.venv/bin/python}
DIST=$(realpath -m "${DIST:-dist}")
[ $# -gt 0 ] || set -- runtime ops export torch
# The timestamps in archives: the last commit's, or a fixed one without a repository.
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 1750000000)}
umask 022 # copies' modes are in archives
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
mkdir -p "$DIST"

# build PYTHON FOLDER [PIP_OPTION...]: a wheel for this machine, into $fresh
build() {
  local version environment
  version=$("$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  environment=wheels-$version
  PYTHON=$1 env -u _PYTHON_HOST_PLATFORM tools/environment.sh "$environment" tools/wheels.txt # the tools are for this machine
  rm -f "$fresh"/*.whl
  PATH="$PWD/.deps/$environment/bin:$PATH" ".deps/$environment/bin/python" -m pip wheel --quiet --disable-pip-version-check \
    --no-deps --no-build-isolation --wheel-dir "$fresh" "${@:2}"
  tool=$PWD/.deps/$environment/bin
}

# portable [AUDITWHEEL_OPTION...]: from $fresh to $DIST
portable() {
  PATH="$tool:$PATH" "$tool/python" -m auditwheel repair --wheel-dir "$DIST" "$@" "$fresh"/*.whl >"$fresh/log" 2>&1 || { cat "$fresh/log" && exit 1; }
}

for what in "$@"; do
  case $what in
    runtime)
      for python in $PYTHONS; do
        build "$python" .
        portable
      done
      ;;
    aarch64)
      for python in $PYTHONS; do
        suffix=$("$python" -c 'import sys; print(".cpython-%d%d-aarch64-linux-gnu.so" % sys.version_info[:2])')
        _PYTHON_HOST_PLATFORM=linux-aarch64 build "$python" . --config-settings=cmake.define.PYTHON_MODULE_EXTENSION="$suffix" \
          --config-settings=cmake.define.CMAKE_TOOLCHAIN_FILE="$PWD/cmake/aarch64.cmake" --config-settings=cmake.define.CHIASM_TRITON=OFF
        portable
      done
      ;;
    ops)
      staged=build/chiasm-ops
      rm -rf $staged
      mkdir -p $staged
      cp packaging/ops/pyproject.toml LICENSE $staged
      # What the wheel of chiasm leaves out: one list, so that each file is in one wheel
      mapfile -t left_out < <(.venv/bin/python -c '
import tomllib
for path in tomllib.load(open("pyproject.toml", "rb"))["tool"]["scikit-build"]["wheel"]["exclude"]:
    if path.startswith("chiasm/"):
        print(path)')
      (cd python && cp -r --parents "${left_out[@]}" ../$staged)
      build "${PYTHONS%% *}" ./$staged
      mv "$fresh"/*.whl "$DIST"
      ;;
    export) # static libraries, which auditwheel does not inspect: they are compiled for this machine's glibc
      [ -e python/chiasm/artifact/symbols.map ] || { echo "wheels.sh: chiasm-export needs what make build makes" >&2 && exit 1; }
      staged=build/chiasm-export
      rm -rf $staged
      mkdir -p $staged/chiasm
      cp packaging/export/pyproject.toml LICENSE $staged
      # Without the precompiled headers: 280 MB, usable only in this source tree
      (cd python/chiasm && find artifact \( -name '*.a' -o -path 'artifact/*include/*' -type f -o -name symbols.map \) -exec cp --parents -t "../../$staged/chiasm" {} +)
      build "${PYTHONS%% *}" ./$staged
      glibc=$(ldd --version | sed -nE '1s/.* ([0-9]+)\.([0-9]+)$/\1_\2/p')
      "$tool/python" -m wheel tags --remove --platform-tag "manylinux_${glibc}_$(uname -m)" "$fresh"/*.whl >/dev/null
      mv "$fresh"/*.whl "$DIST"
      ;;
    torch)
      torch=$(.venv/bin/python -c 'from importlib.util import find_spec; print(find_spec("torch").submodule_search_locations[0])')
      build "${PYTHONS%% *}" ./packaging/torch --config-settings=cmake.define.TorchWheel_DIR="$torch"
      portable --exclude 'libtorch*.so' --exclude 'libc10*.so'
      ;;
    *) echo "wheels.sh: expected runtime, aarch64, ops, export or torch, got '$what'" >&2 && exit 2 ;;
  esac
done
ls -sh "$DIST"/*.whl
