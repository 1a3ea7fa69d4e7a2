#!/usr/bin/env bash
# Installs the package in a Debian system that debootstrap creates and later runs reuse, and tests it as a user would:
# dependencies, both builds of the program, manual pages, completion, examples.
#   tests/package/check_package.sh [PACKAGE [FOLDER]]     default: build/package/sheaf_*.deb, build/debian12
# Run tools/packaging/make_package.sh first. Needs root, debootstrap and a mirror (see tools/packaging/debian_root.sh), and is skipped with
# exit status 77 without them. SHEAF_DEBIAN_RELEASE selects the release (default: bookworm).
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
package=${1:-$(ls "$repository"/build/package/sheaf_*.deb 2>/dev/null | tail -n 1)}
root=$(realpath -m "${2:-$repository/build/debian12}")

skip() {
  echo "package: skipped: $1"
  exit 77
}
fail() {
  echo "package: FAILED: $1" >&2
  exit 1
}
passed() { echo "package: ok: $1"; }

[[ -n $package && -e $package ]] || skip "there is no package; run tools/packaging/make_package.sh"
((EUID == 0)) || skip "needs root"
command -v debootstrap >/dev/null || skip "needs the package debootstrap"

source "$repository/tools/packaging/debian_root.sh"
make_debian_root "$root" "${SHEAF_DEBIAN_RELEASE:-bookworm}"
open_debian_root "$root"
as_user() { in_root setpriv --reuid=65534 --regid=65534 --clear-groups env HOME=/tmp "$@"; }  # as nobody

apt() { in_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" >"$root.log" 2>&1; }
apt purge --autoremove --yes sheaf || true  # missing in a new folder
cp "$package" "$root/tmp/sheaf.deb"
apt update || fail "apt-get update: $(tail -n 5 "$root.log")"
apt install --yes --no-install-recommends /tmp/sheaf.deb man-db python3 python3-numpy || fail "cannot be installed: $(tail -n 5 "$root.log")"
passed "installed with its dependencies"

levels=()
for folder in "$root"/usr/lib/sheaf/*; do
  level=${folder##*/}
  for program in sheaf sheaf_import_model; do
    if in_root ldd "/usr/lib/sheaf/$level/$program" | grep "not found"; then fail "$level: libraries are missing"; fi
  done
  levels+=("$level")
done
[[ ${levels[*]} == "x86-64-v3 x86-64-v4" ]] || fail "builds: ${levels[*]}"

declare -A isa=([x86-64-v3]=avx2 [x86-64-v4]=avx512)
best=x86-64-v3
grep -q avx512vl /proc/cpuinfo && best=x86-64-v4
[[ $(as_user sheaf --version) == *" ${isa[$best]}" ]] || fail "--version: $(as_user sheaf --version)"
[[ $(as_user env SHEAF_ISA=x86-64-v3 sheaf --version) == *" avx2" ]] || fail "SHEAF_ISA does not select the build"
if message=$(as_user env SHEAF_ISA=sse sheaf --version 2>&1); then fail "SHEAF_ISA=sse is accepted"; fi
[[ $message == *"expected x86-64-v4, x86-64-v3"* ]] || fail "SHEAF_ISA=sse: $message"
passed "$(as_user sheaf --version) is selected on this machine"

work=/tmp/sheaf_check
rm -rf "${root:?}$work"
as_user cp -r /usr/share/sheaf "$work"
for level in x86-64-v3 "$best"; do
  as_user env SHEAF_ISA="$level" sheaf render "$work/scenes/cornell/cornell.xml" -o "$work/$level.exr" \
    -o "$work/$level.png" --spp 16 --scale 0.5 --no-timestamps --float --quiet || fail "$level does not render"
  as_user sheaf info "$work/$level.exr" | grep -q "sheaf/isa.*${isa[$level]}" || fail "$level: the header's isa"
done
limits=(--max-relmse 1e-4)
as_user sheaf compare "$work/$best.exr" "$work/x86-64-v3.exr" "${limits[@]}" || fail "the images of both builds differ"
same=differ
cmp -s "$root$work/x86-64-v3.png" "$root$work/$best.png" && same="are the same"
passed "example rendered by x86-64-v3 and $best; the bytes of their PNG files $same"
cp "$repository/tests/package/check_examples.py" "$root/tmp/check_examples.py"
as_user python3 /tmp/check_examples.py /usr/share/sheaf /usr/share/doc/sheaf || fail "commands of the documentation"
passed "every command of the gallery and the README"
if as_user sheaf render "$work/scenes/no.xml" -o "$work/no.exr" 2>/dev/null; then fail "exit status of a missing scene"; fi

for command in "" render info compare denoise; do
  page=$(in_root env MANWIDTH=1000 man "sheaf${command:+-$command}" 2>/dev/null | tr -s '\n ' ' ')
  while read -r option; do
    [[ $page == *"$option"* ]] || fail "the manual of sheaf $command lacks $option"
  done < <(as_user sheaf $command --help | grep -oE -e '^ +(-[a-zA-Z], )?--[a-z-]+' | grep -oE -e '--[a-z-]+')
done
passed "manual pages with all options"

complete_words() {
  in_root bash -c 'source /usr/share/bash-completion/completions/sheaf
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); _sheaf; echo "${COMPREPLY[*]}"' bash "$@"
}
[[ $(complete_words sheaf re) == render ]] || fail "completion of commands"
[[ $(complete_words sheaf render --den) == --denoise ]] || fail "completion of options"
[[ $(complete_words sheaf render --color s) == spectral ]] || fail "completion of values"
[[ $(complete_words sheaf render /usr/share/sheaf/scenes/corn) == /usr/share/sheaf/scenes/cornell ]] ||
  fail "completion of files"
[[ -z $(complete_words sheaf render --spp 1) ]] || fail "completion of numbers"
passed "completion"
echo "package: all passed"
