#!/usr/bin/env bash
# Fetch what the runtime is linked with on aarch64: Debian's libsodium for it, unpacked to .deps/aarch64. Nothing is installed, and this
# machine's own list of packages stays as it is.
# usage: tools/aarch64.sh        Called by `make test-aarch64`; quick when it is there.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$PWD/.deps/aarch64
[ -e "$folder/usr/lib/aarch64-linux-gnu/libsodium.a" ] && exit 0

rm -rf "$folder"
mkdir -p "$folder/lists/partial" "$folder/cache/archives/partial"
cp /var/lib/dpkg/status "$folder/status"
of_arm64() {
  apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User="$(id -un)" -o Dir::State="$folder" \
    -o Dir::State::Lists="$folder/lists" -o Dir::State::status="$folder/status" -o Dir::Cache="$folder/cache" "$@"
}
echo "fetching libsodium for aarch64 to .deps/aarch64"
of_arm64 update
(cd "$folder" && of_arm64 download libsodium-dev && dpkg -x libsodium-dev_*.deb .)
rm -rf "$folder"/lists "$folder"/cache "$folder/status" "$folder"/*.deb
