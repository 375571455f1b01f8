#!/usr/bin/env bash
# Fetch Debian's packages for aarch64 and unpack them to .deps/aarch64: libsodium, which the runtime is linked
# with, and dlpack's header. With `python` also a Python of .venv's version, NumPy and ONNX Runtime, to test
# the wheel for aarch64 under qemu. Nothing is installed, and this machine's own list of packages does not
# change. Called by `make build-aarch64` and `make test-aarch64`; quick if it exists already.
# usage: tools/aarch64.sh [python]
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$PWD/.deps/aarch64 python=$(.venv/bin/python -c 'import sys; print("python%d.%d" % sys.version_info[:2])')

# fetch MADE PACKAGE...: fetch the packages, of which one holds the file MADE, unless all of them are there
fetch() {
  local made=$folder/$1 all=$folder/.${1##*/}.complete
  shift
  [ -e "$all" ] && return
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  mkdir -p "$folder" "$work/lists/partial" "$work/cache/archives/partial"
  cp /var/lib/dpkg/status "$work/status"
  of_arm64() {
    apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User="$(id -un)" -o Dir::State="$work" \
      -o Dir::State::Lists="$work/lists" -o Dir::State::status="$work/status" -o Dir::Cache="$work/cache" "$@"
  }
  echo "fetching for aarch64 to .deps/aarch64: $*"
  of_arm64 update
  (cd "$work" && of_arm64 download "$@" && for package in *.deb; do dpkg -x "$package" "$folder"; done)
  rm -rf "$work"
  [ -e "$made" ] || { echo "aarch64.sh: $* have no ${made#"$folder"/}" >&2 && exit 1; }
  touch "$all"
}

fetch usr/lib/aarch64-linux-gnu/libsodium.a libsodium-dev
fetch usr/include/dlpack/dlpack.h libdlpack-dev
if [ "${1:-}" = python ]; then
  fetch "usr/bin/$python" "$python-minimal" "lib$python-minimal" "lib$python-stdlib" zlib1g libexpat1 libffi8 libssl3 libbz2-1.0 liblzma5
  site=$folder/site want=$(sha256sum tools/aarch64/python.txt | cut -d' ' -f1)
  [ "$(cat "$site/.requirements" 2>/dev/null)" = "$want" ] && exit 0
  rm -rf "$site"
  .venv/bin/uv pip install --quiet --no-deps --only-binary :all: --require-hashes --python .venv/bin/python \
    --python-platform aarch64-manylinux_2_28 --target "$site" -r tools/aarch64/python.txt
  echo "$want" >"$site/.requirements"
fi
