#!/usr/bin/env bash
# Tests the Debian packages of a build tree: lintian finds nothing, and a program is built and run with their
# unpacked content.
# usage: tests/consumer/deb.sh BUILD_TREE [BUNDLE]
set -euo pipefail
here=$(realpath "$(dirname "$0")") tree=$(realpath "$1") bundle=${2:+$(realpath "$2")}
work=$tree/tests/deb
rm -rf "$work" "$tree/packages" "$tree/_CPack_Packages"
mkdir -p "$work"
(cd "$tree" && cpack -G DEB >"$work/cpack.log" 2>&1) || { cat "$work/cpack.log" && exit 1; }
packages=("$tree"/packages/libchiasm0_*.deb "$tree"/packages/libchiasm-dev_*.deb)
for package in "${packages[@]}"; do
  dpkg-deb --field "$package" Package Version Architecture Depends
  dpkg-deb --extract "$package" "$work/root"
done
if command -v lintian >/dev/null; then
  # Suppressed: the tree is not configured for Debian's multiarch folder (it would be with
  # -DCMAKE_INSTALL_PREFIX=/usr); nothing is linked with libchiasm_ort.so, which is opened by its path; CMake
  # calls ldconfig in addition to the trigger that Debian requires.
  lintian --allow-root --fail-on error,warning --suppress-tags \
    pkg-config-unavailable-for-cross-compilation,sharedobject-in-library-directory-missing-soname,maintscript-calls-ldconfig \
    "${packages[@]}"
else
  echo "test-install: lintian left out, which is not installed" | tee -a "${CHIASM_LEFT_OUT:-/dev/null}"
fi
"$here/run_paths.sh" "$tree" "$work/root"

libraries=$(dirname "$(find "$work/root" -name libchiasm.so.0)")
cmake -S "$here/cpp" -B "$work/cpp" "-DCMAKE_PREFIX_PATH=$work/root/usr" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$work/cpp" >/dev/null
"$work/cpp/consumer" ${bundle:+"$bundle"}
export PKG_CONFIG_SYSROOT_DIR='' PKG_CONFIG_PATH="$libraries/pkgconfig"
# shellcheck disable=SC2046  # one flag per word
cc -std=c11 "$here/c/consumer.c" -o "$work/consumer_c" $(pkg-config --cflags --libs chiasm) "-Wl,-rpath,$libraries"
"$work/consumer_c" ${bundle:+"$bundle"}
echo "deb: passed"
