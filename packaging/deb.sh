#!/usr/bin/env bash
# Builds the Debian package of the present commit: packaging/deb.sh OUT [--check]
#   OUT      gets libplumbline-dev_VERSION-1_all.deb, and the source package
#   --check  lintian, and a user's project (tests/consumer) against the unpacked package
# Needs debhelper and what packaging/debian/control names; --check needs lintian.
set -euo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
(($# >= 1)) || { sed -n '2,5s/^# //p' "$0"; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
check=${2:-}

version=$(sed -nE 's/^project\(plumbline VERSION ([0-9.]+).*/\1/p' "$source/CMakeLists.txt")
tree="$out/plumbline-$version"
rm -rf "$tree"
# The built pages of the program are left out: they are no sources, and the package has no program.
git -C "$source" archive --prefix="plumbline-$version/" -o "$out/plumbline_$version.orig.tar.gz" HEAD . \
  ":(exclude)benchmarks/report/dist"
tar -C "$out" -xzf "$out/plumbline_$version.orig.tar.gz"
cp -r "$tree/packaging/debian" "$tree/debian"
date=$(git -C "$source" log -1 --format=%aD)
cat > "$tree/debian/changelog" << END
plumbline ($version-1) unstable; urgency=medium

  * Version $version, see CHANGELOG.md.

 -- The plumbline authors <plumbline@example.org>  $date
END
(cd "$tree" && dpkg-buildpackage --unsigned-source --unsigned-changes) > "$out/build.log" 2>&1 ||
  { tail -30 "$out/build.log" >&2; exit 1; }
package="$out/libplumbline-dev_$version-1_all.deb"
echo "built $package ($(stat -c %s "$package") bytes)"
[[ $check == --check ]] || exit 0

# A new package closes a bug by which it was asked for: there is none outside of Debian.
lintian --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs "$out/plumbline_$version-1_"*.changes
rm -rf "$out/root"
dpkg-deb --extract "$package" "$out/root"
components="core;thread;testing;opencv;io;bag"
cmake -S "$source/tests/consumer" -B "$out/consumer" -DCMAKE_PREFIX_PATH="$out/root/usr" \
  -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF "-DPLUMBLINE_COMPONENTS=$components" > "$out/consumer.log"
grep -q "plumbline_DIR:PATH=$out/root/" "$out/consumer/CMakeCache.txt"
cmake --build "$out/consumer" >> "$out/consumer.log"
"$out/consumer/consumer"
flags=$(PKG_CONFIG_PATH="$out/root/usr/share/pkgconfig" pkg-config --cflags plumbline)
# shellcheck disable=SC2086
g++ -std=c++20 $flags "$source/tests/consumer/main.cpp" -o "$out/by_pkg_config"
"$out/by_pkg_config"
