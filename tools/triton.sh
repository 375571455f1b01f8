#!/usr/bin/env bash
# Fetch the software with which the Triton backend is built and tested.
# usage: tools/triton.sh headers    Triton's C API in .deps/triton-headers, from the crate triton-sys (BSD-3),
#                                   by cargo; called by setup
#        tools/triton.sh server     a tritonserver, its client, perf_analyzer in .deps/triton; called by
#                                   `make test-serving`
# Safe to run again, quick when nothing has changed. Without cargo the backend is not built, and a message
# says so.
set -euo pipefail
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-.venv/bin/python}
version=0.2.0
sha256=10f5acb5060e1e726182d9f268ffee22c5444a38343a9466f4cc12d64b037e53

without() { echo "no Triton backend: $* (or give a folder with triton/core/tritonbackend.h: cmake -Dtriton_INCLUDE_DIR=)"; exit 0; }

headers() {
  local folder=.deps/triton-headers crate
  [ "$(cat "$folder/.crate" 2>/dev/null)" = "$sha256" ] && return
  command -v cargo >/dev/null || without "its headers come with a crate, and cargo 1.68 or later is not installed"
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT # expanded after the function has returned
  # A package that needs the crate and is never compiled: cargo fetches it from its configured registry
  printf '[package]\nname = "headers"\nversion = "0.0.0"\n[lib]\npath = "none.rs"\n[dependencies]\ntriton-sys = "=%s"\n' \
    "$version" > "$work/Cargo.toml"
  : > "$work/none.rs"
  timeout 300 cargo fetch --quiet --target "$(uname -m)-unknown-linux-gnu" --manifest-path "$work/Cargo.toml" ||
    without "cargo could not fetch the crate triton-sys $version"
  # Each of cargo's registries has a folder
  for crate in "${CARGO_HOME:-$HOME/.cargo}"/registry/cache/*/"triton-sys-$version.crate"; do
    echo "$sha256  $crate" | sha256sum --check --status && break
    echo "tools/triton.sh: $crate is not the crate that was looked at: expected SHA-256 $sha256"
    crate=
  done
  [ -n "$crate" ] || exit 1
  tar -xzf "$crate" -C "$work" "triton-sys-$version/deps/core/include" "triton-sys-$version/deps/core/LICENSE"
  rm -rf "$folder"
  mkdir -p .deps
  mv "$work/triton-sys-$version/deps/core" "$folder"
  echo "$sha256" > "$folder/.crate"
}

server() {
  local folder=.deps/triton want site
  if [ "$(uname -m)" != x86_64 ] || ! "$PYTHON" -c 'import os; assert tuple(map(int, os.confstr("CS_GNU_LIBC_VERSION").split()[1].split("."))) >= (2, 35)' 2>/dev/null; then
    echo "no Triton server: its wheel nvidia-pytriton is for x86-64 with glibc 2.35 or later"
    return
  fi
  tools/environment.sh triton tools/triton/environment.txt
  want=$(sha256sum tools/triton/server.txt | cut -d' ' -f1)
  [ "$(cat "$folder/.server" 2>/dev/null)" = "$want" ] && return
  .venv/bin/uv pip install --quiet --python "$folder/bin/python" --require-hashes --no-deps -r tools/triton/server.txt
  # perf_analyzer needs these under other names
  site=$("$folder/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
  mkdir -p "$folder/lib/perf_analyzer"
  ln -sf "$site"/nvidia_pytriton.libs/libb64-*.so.0d "$folder/lib/perf_analyzer/libb64.so.0d"
  ln -sf "$site"/nvidia_pytriton.libs/libcudart-*.so.12* "$folder/lib/perf_analyzer/libcudart.so.12"
  echo "$want" > "$folder/.server"
}

case "${1-}" in
  headers | server) "$1" ;;
  *) echo "usage: tools/triton.sh headers|server" && exit 2 ;;
esac
