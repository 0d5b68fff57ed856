#!/usr/bin/env bash
# Makes the Debian packages and the archive, installs them in a bare Debian bookworm (debootstrap, chroot) and uses them
# there: the program, the Python module, and the C++ pages' project built with find_package(diesink). Needs root.
# usage: scripts/check_package.sh [FOLDER]   keeps the bare system in FOLDER (default build/chroot) for the next time
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in -h | --help) sed -n '2,5s/^# //p' "$0"; exit 0 ;; esac
[ "$(id -u)" -eq 0 ] || { echo "check_package: needs root for the chroot" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "check_package: needs debootstrap (apt-get install debootstrap)" >&2; exit 1; }
command -v dpkg-shlibdeps >/dev/null || { echo "check_package: needs dpkg-dev (apt-get install dpkg-dev)" >&2; exit 1; }

folder=$(realpath -m "${1:-build/chroot}")
mkdir -p "$folder" build
base=$folder/base root=$folder/root log=$folder/log
echo "check_package: building"
{ cmake --preset release -DDIESINK_BUILD_TESTS=OFF -DDIESINK_BUILD_BENCH=OFF -DDIESINK_BUILD_PYTHON=ON -B build/package &&
  cmake --build build/package && rm -rf build/package/packages && (cd build/package && cpack); } >"$log" 2>&1 ||
  { tail -n 40 "$log" >&2; exit 1; }
for deb in build/package/packages/*.deb; do
  echo "  $(dpkg-deb -f "$deb" Package Version | tr '\n' ' ') $(du -h "$deb" | cut -f1)"
  echo "    $(dpkg-deb -f "$deb" Depends)"
done

if [ ! -d "$base/etc" ]; then
  mirror=$(apt-cache policy base-files | grep -oE 'https?://[^ ]+' | grep -v security | head -n 1)
  echo "check_package: a bare bookworm from ${mirror:=http://deb.debian.org/debian}"
  debootstrap --variant=minbase --include=ca-certificates bookworm "$base.part" "$mirror" >"$log" 2>&1 ||
    { tail -n 20 "$log" >&2; exit 1; }
  mv "$base.part" "$base"
fi
umount -q "$root/proc" "$root/dev" 2>/dev/null || true
rm -rf --one-file-system "$root"
cp -a "$base" "$root"
cp -a /etc/apt/. "$root/etc/apt/"
cp /etc/resolv.conf /etc/hosts "$root/etc/" 2>/dev/null || true
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
trap 'umount -q "$root/proc" "$root/dev"' EXIT
mkdir -p "$root/srv/consumer"
cp build/package/packages/*.deb build/package/packages/*.tar.gz fixtures/parts/fig6.part tests/python/*.py "$root/srv/"
scripts/quick_start.py docs/cpp.md "$root/srv/consumer"

inside() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb DEBIAN_FRONTEND=noninteractive \
    ${http_proxy:+http_proxy=$http_proxy} ${https_proxy:+https_proxy=$https_proxy} \
    chroot "$root" sh -ec "cd /srv; $1"
}
install() {
  inside "apt-get -q update && apt-get install -q -y --no-install-recommends $1" >"$log" 2>&1 ||
    { tail -n 30 "$log" >&2; exit 1; }
}

echo "check_package: the program alone"
install "./diesink_*.deb"
inside 'diesink --version; diesink export fig6.part -o fig6.stl fig6.glb; diesink cl fig6.part --cutter 6,3 --cusp 0.02 -o fig6.ngc
  diesink verify fig6.part fig6.ngc --cusp 0.02 --json >/dev/null; diesink preview fig6.part -o fig6.png; diesink view fig6.part fig6.ngc -o fig6.html; diesink info fig6.glb >/dev/null
  test -e /usr/share/man/man1/diesink.1 -o -e /usr/share/man/man1/diesink.1.gz'
echo "check_package: the archive"
inside 'tar xzf diesink-*.tar.gz && diesink-*/bin/diesink info fig6.part >/dev/null'
echo "check_package: the Python module"
install "./python3-diesink_*.deb"
inside 'python3 -c "
import diesink, numpy
part = diesink.load(\"fig6.part\")
assert numpy.isfinite(part.grid().z).all()
path = part.cl(cutter=(6, 3), cusp=0.02)
assert part.verify(path).kept
print(part, part.tessellate(), path)"'
echo "check_package: a project that uses the library"
install "./libdiesink-dev_*.deb g++ cmake ninja-build"
inside 'cmake -S consumer -B consumer/build -G Ninja >/dev/null && cmake --build consumer/build >/dev/null && consumer/build/quick_start fig6.part'
echo "check_package: done"
