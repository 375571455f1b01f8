#!/usr/bin/env bash
# Install chiasm's requirements on a Debian machine: system packages, a Python environment in .venv, ONNX
# Runtime's headers, Triton's.
# usage: tools/setup.sh        Called by `make setup`; safe to run again, quick when nothing is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python3}

packages=(g++ make cmake ninja-build pkg-config ca-certificates python3-venv binutils
  libopencv-dev libgtest-dev libgmock-dev libeigen3-dev nlohmann-json3-dev libsodium-dev minisign libdlpack-dev
  libhwy-dev libbenchmark-dev lintian clang clang-format clang-tidy libclang-rt-dev g++-aarch64-linux-gnu qemu-user)

say() { printf '\033[1msetup:\033[0m %s\n' "$*"; }
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

installed() { dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q 'ok installed'; }

missing=()
for package in "${packages[@]}"; do installed "$package" || missing+=("$package"); done
debian_packages() {
  [ ${#missing[@]} -gt 0 ] || return 0
  say "installing Debian packages: ${missing[*]}"
  as_root apt-get -qq update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends "${missing[@]}" >/dev/null
}
# If Python can already make environments, both installs run in parallel: one waits for the disk, the other
# for the network.
if "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null; then
  debian_packages &
  debian=$!
  trap 'wait "$debian" || true' EXIT # not to leave dpkg locked when Python's part fails
else
  debian_packages
  debian=
fi

if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then # there is none, or only a part of one
  say "making .venv with $("$PYTHON" --version)"
  "$PYTHON" -m venv --clear .venv
fi
want=$(cat requirements.txt tools/uv.txt | sha256sum | cut -d' ' -f1)
if [ "$(cat .venv/.requirements 2>/dev/null)" != "$want" ]; then
  say "installing Python packages (PyTorch is 3 GB: a minute)"
  .venv/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r tools/uv.txt
  .venv/bin/uv pip install --quiet --compile-bytecode --python .venv/bin/python --require-hashes \
    -r requirements.txt
  echo "$want" > .venv/.requirements
fi
# `import chiasm` from the source tree, in every use of .venv
site=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
echo "$PWD/python" > "$site/chiasm-source.pth"

trap - EXIT
if [ -n "$debian" ] && ! wait "$debian"; then
  say "the Debian packages could not be installed"
  exit 1
fi
tools/onnxruntime.sh
tools/triton.sh headers
say "done"
