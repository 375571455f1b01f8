#!/usr/bin/env bash
# Tests chiasm on a fresh system: Debian or Ubuntu in a separate folder, by debootstrap. The wheel and a pack
# of bundles are installed there by pip and used from Python and C++, and so are the Debian packages if the
# system has their glibc; the time from an empty system to both results is printed. Needs root, a network, and
# debootstrap (apt-get install debootstrap).
# usage: tests/consumer/fresh_root.sh SUITE [MIRROR]   trixie, or jammy with the address of a mirror of Ubuntu
set -euo pipefail
suite=${1:?"usage: tests/consumer/fresh_root.sh SUITE [MIRROR]"} mirror=${2:-}
cd "$(dirname "$0")/../.."
work=$PWD/build/roots root=$PWD/build/roots/$suite dist=$PWD/build/roots/dist
say() { printf '\033[1m%s:\033[0m %s\n' "$suite" "$*"; }
[ "$(id -u)" = 0 ] || { echo "fresh_root.sh: must be run as root" >&2 && exit 2; }
command -v debootstrap >/dev/null || { echo "fresh_root.sh: debootstrap is not installed: apt-get install debootstrap" >&2 && exit 2; }

# Commands in the root see only its processes, and mounts disappear when they end.
inside() { unshare --mount --pid --fork --kill-child sh -c 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"' "$root" "$@"; }

mkdir -p "$work"
if [ ! -e "$root/made" ]; then
  say "debootstrap"
  rm -rf "$root"
  components=main
  [ "$(basename "$(readlink -f "/usr/share/debootstrap/scripts/$suite")")" != gutsy ] || components=main,universe # an Ubuntu
  debootstrap --variant=minbase --components=$components --include=ca-certificates "$suite" "$root" ${mirror:+"$mirror"} \
    >"$work/$suite.log" 2>&1 || { tail -n 5 "$work/$suite.log" && exit 1; }
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  # The new system must also trust this machine's additional certificates, such as a proxy's.
  cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true
  inside update-ca-certificates >>"$work/$suite.log" 2>&1
  touch "$root/made"
fi
if [ ! -e "$root/ready" ]; then
  say "what builds a C++ program"
  inside sh -c 'apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends python3 python3-venv g++ make cmake pkg-config' \
    >>"$work/$suite.log" 2>&1 || { tail -n 5 "$work/$suite.log" && exit 1; }
  touch "$root/ready"
fi
version=$(inside python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')
say "$(inside sh -c '. /etc/os-release; echo "$PRETTY_NAME"'), glibc $(inside ldd --version | sed -nE '1s/.* //p'), Python $version, $(inside g++ --version | head -n 1)"

python=$(command -v "python$version" || true)
"${python:-false}" -c '' 2>/dev/null || python=$(compgen -G "$HOME/.pyenv/versions/$version.*/bin/python" | tail -n 1) ||
  { echo "fresh_root.sh: no Python $version is here to build the wheel with" >&2 && exit 2; }
# What an earlier run built is of other sources.
rm -rf "$dist" build/release/packages
say "the wheel for Python $version, the Debian packages"
DIST=$dist PYTHONS=$python tools/wheels.sh runtime >"$work/wheel.log" 2>&1 || { tail -n 20 "$work/wheel.log" && exit 1; }
(cd build/release && cpack -G DEB) >"$work/cpack.log" 2>&1 || { tail -n 20 "$work/cpack.log" && exit 1; }
[ -e build/bundles/filters.sobel.chiasm ] || PYTHONPATH=python .venv/bin/python -m chiasm export filters.sobel --method forward -o build/bundles
PYTHONPATH=python .venv/bin/python -m chiasm pack filters build/bundles/filters.sobel.chiasm -o "$dist" >/dev/null

rm -rf "$root/work" "$root/env"
mkdir "$root/work"
cp -r "$dist"/chiasm-*.whl "$dist"/chiasm_bundles_filters-*.whl tests/consumer/cpp "$root/work"
cat >"$root/work/sobel.py" <<'PY'
import numpy as np
import chiasm.runtime

ramp = np.broadcast_to(np.linspace(0, 1, 65, dtype=np.float32), (1, 3, 48, 65)).copy()
edges = chiasm.runtime.open("filters.sobel").method("forward")(ramp)
np.testing.assert_allclose(edges[..., 1:-1], np.hypot(1 / 64, 1e-3), rtol=1e-5)
print("sobel from Python:", edges.shape)
PY
cat >"$root/work/first.sh" <<'SH'
set -e
python3 -m venv /env
/env/bin/pip install --quiet --disable-pip-version-check --no-cache-dir /work/*.whl
/env/bin/python /work/sobel.py
cmake -S /work/cpp -B /work/build "-Dchiasm_DIR=$(/env/bin/python -m chiasm --cmakedir)" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build /work/build >/dev/null
/work/build/consumer "$(/env/bin/python -c 'from chiasm import packs; print(packs.find("filters.sobel"))')"
SH
started=$(date +%s.%N)
inside sh /work/first.sh
took=$(awk "BEGIN { printf \"%.1f\", $(date +%s.%N) - $started }")
say "from nothing to results in Python and C++: $took s"
awk "BEGIN { exit !($took < 60) }" || { say "expected less than 60 s" && exit 1; }

cp build/release/packages/libchiasm0_*.deb build/release/packages/libchiasm-dev_*.deb "$root/work"
if inside sh -c 'apt-get install -y --no-install-recommends /work/*.deb >/work/apt.log 2>&1'; then
  inside sh -ec 'rm -rf /work/deb; cmake -S /work/cpp -B /work/deb >/dev/null; cmake --build /work/deb >/dev/null
    /work/deb/consumer "$(/env/bin/python -c "from chiasm import packs; print(packs.find(\"filters.sobel\"))")"
    apt-get purge -y libchiasm0 libchiasm-dev >/dev/null 2>&1'
  say "the Debian packages: installed, used, removed"
else
  say "the Debian packages do not fit: $(grep -m 1 Depends "$root/work/apt.log" || tail -n 1 "$root/work/apt.log")"
fi
echo "$suite: passed"
