#!/usr/bin/env bash
# Makes the Debian packages of a build, reads what they say of themselves, and uses what they hold.
# scripts/check_package.sh installs them in a bare system; this needs neither root nor the net.
# usage: run.sh BUILD_FOLDER
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
for tool in dpkg-deb dpkg-shlibdeps; do
  command -v "$tool" >/dev/null || { echo "SKIPPED: no $tool (Debian: dpkg-dev)"; exit 77; }
done
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
(cd "$1" && cpack -G DEB -B "$scratch") >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
for deb in "$scratch"/*.deb; do
  dpkg-deb -f "$deb" Package Version Depends
  dpkg-deb -x "$deb" "$scratch/root"
done
depends() { dpkg-deb -f "$scratch"/"$1"_*.deb Depends; }
depends diesink | grep -q 'libdraco[0-9]* .*libpng16-16'
depends diesink | grep -q 'libc6 (>= 2'
depends libdiesink-dev | grep -q 'libeigen3-dev'
"$scratch/root/usr/bin/diesink" info "$top/fixtures/parts/fig6.part" --json >/dev/null
test -s "$scratch/root/usr/share/man/man1/diesink.1"
[ -n "$(find "$scratch/root/usr/lib" -path "*/cmake/diesink/diesink-config.cmake")" ]
for package in "$scratch"/*.deb; do
  name=$(dpkg-deb -f "$package" Package)
  test -s "$scratch/root/usr/share/doc/$name/copyright"
  # Shipped files belong to root and lie below /usr.
  dpkg-deb -c "$package" | awk '$2 != "root/root" || $6 !~ /^\.\/usr/ { print; bad = 1 } END { exit bad }'
done
if ls "$scratch"/python3-diesink_*.deb >/dev/null 2>&1; then
  depends python3-diesink | grep -q 'python3-numpy'
fi
