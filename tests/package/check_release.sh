#!/usr/bin/env bash
# Tests the files of a release as a user would, in bare systems of Debian 12 and 13 that debootstrap creates and later
# runs reuse: the archive without any package, and the wheels with python3-venv alone.
#   tests/package/check_release.sh [FOLDER [ROOTS]]     default: build/release_files, build/release_roots
# Run tools/packaging/make_release.sh first. Needs root, debootstrap, python3, and a mirror (see
# tools/packaging/debian_root.sh), and is skipped with exit status 77 without them. A wheel is tested in the system that
# has its version of Python. numpy comes from PyPI.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=$(realpath -m "${1:-$repository/build/release_files}")
roots=$(realpath -m "${2:-$repository/build/release_roots}")
work=/tmp/sheaf_check

skip() {
  echo "release: skipped: $1"
  exit 77
}
fail() {
  echo "release: FAILED: $release: $1" >&2
  exit 1
}
passed() { echo "release: ok: $release: $1"; }

archives=("$folder"/sheaf-*-linux-x86_64.tar.xz)
[[ -e ${archives[0]} ]] || skip "there is no archive; run tools/packaging/make_release.sh"
((EUID == 0)) || skip "needs root"
command -v debootstrap >/dev/null || skip "needs the package debootstrap"
name=$(basename "${archives[0]}" .tar.xz)

source "$repository/tools/packaging/debian_root.sh"
as_user() { in_root setpriv --reuid=65534 --regid=65534 --clear-groups env HOME=/tmp "$@"; }  # as nobody
in_work() { as_user bash -c 'cd "$1" && shift && exec "$@"' bash "$work" "$@"; }

# check_libraries FOLDER [NAME...]: all libraries are in the folder, or belong to glibc, or have one of the names.
check_libraries() {
  local top=$1 file allowed="/ld-linux[^/]*$|/lib(c|m|dl|pthread|rt|resolv|mvec)[.]so" outside count=0
  shift
  for library in "$@"; do allowed+="|/$library"; done
  while read -r file; do
    outside=$(in_root ldd "$file" 2>&1 | grep -vE '^\s*linux-vdso|statically linked|not a dynamic' | sed 's/ (0x.*//; s/.* => //' |
      grep -vE "^\s*$top/|$allowed" || true)
    [[ -z $outside ]] || fail "$file uses $outside"
    count=$((count + 1))
  done < <(in_root find "$top" -type f \( -name '*.so*' -o -perm -100 \) -exec sh -c 'head -c 4 "$1" | grep -q ELF && echo "$1"' sh {} \;)
  ((count > 10)) || fail "only $count files to load in $top"
  passed "$count programs and libraries in $top use nothing else"
}

# check_scenes SHEAF: images of all kinds, by a program.
check_scenes() {
  local sheaf=$1 scenes=$work/scenes model image
  in_work "$sheaf" render "$scenes/cornell/cornell.xml" --spp 16 --scale 0.5 --denoise nlm --quiet -o cornell.png
  in_work "$sheaf" render picture.xml --quiet -o t.jpg
  in_work "$sheaf" render textures.xml --spp 16 --quiet -o textures.png -o textures.tif -o textures.exr
  for model in draco.glb square.fbx; do
    in_work "$sheaf" render "$model" --integrator depth --spp 16 --size 320x240 --quiet -o "${model%.*}.exr"
  done
  in_work "$sheaf" render textures.xml --spp 16 --quiet --ocio-config config.ocio -o view.png
  in_work "$sheaf" render "$scenes/spectral/prism.xml" --color spectral --spp 1 --scale 0.2 --quiet -o prism.exr
  # Both models are the same square.
  in_work "$sheaf" compare draco.exr square.exr --max-relmse 1e-6 >/dev/null || fail "the models differ"
  for image in cornell.png textures.png textures.tif view.png; do
    [[ -s $debian_root$work/$image ]] || fail "no $image"
  done
  passed "$(as_user "$sheaf" --version): images, models, textures of 5 formats, denoising, OpenColorIO"
}

# check_preview SHEAF: the page of `sheaf watch` and its image.
check_preview() {
  local port log=$debian_root$work/watch.log failed=
  port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
  in_work bash -c 'echo $$ >watch.pid && exec "$@"' bash \
    "$1" watch "$work/scenes/cornell/cornell.xml" --scale 0.2 --spp 16 --serve "$port" >"$log" 2>&1 &
  /usr/bin/python3 - "$port" <<'END_PYTHON' || failed=true
import sys, time, urllib.request
address = f"http://127.0.0.1:{sys.argv[1]}"
for attempt in range(100):
    try:
        page = urllib.request.urlopen(address + "/", timeout=5).read()
        image = urllib.request.urlopen(address + "/image.png", timeout=5).read()
        if b"<html" in page and image.startswith(b"\x89PNG"):
            sys.exit(0)
    except OSError:
        pass
    time.sleep(0.1)
sys.exit("no page with an image")
END_PYTHON
  kill "$(cat "$debian_root$work/watch.pid")"
  wait
  if [[ -n $failed ]]; then fail "watch --serve: $(cat "$log")"; fi
  passed "sheaf watch --serve"
}

check_archive() {
  local sheaf=$work/$name/bin/sheaf
  tar --extract --file="${archives[0]}" --directory="$debian_root$work" --no-same-owner
  chown -R 65534:65534 "$debian_root$work"
  check_libraries "$work/$name"
  as_user cp -r "$work/$name/share/sheaf/scenes" "$work/scenes"
  check_scenes "$sheaf"
  check_preview "$sheaf"
  [[ -s $debian_root$work/$name/share/doc/sheaf/site/index.html ]] || fail "no documentation"
  # The folder can be moved, and its program started through a link.
  mv "$debian_root$work/$name" "$debian_root$work/moved"
  ln -sfn "$work/moved/bin/sheaf" "$debian_root$work/link"
  [[ $(as_user "$work/link" --version -v) != *missing* ]] || fail "the moved program lacks files"
  [[ $(as_user env SHEAF_ISA=x86-64-v3 "$work/link" --version) == *" avx2" ]] || fail "SHEAF_ISA does not select the build"
  passed "moved to another folder"
}

check_wheel() {
  local wheel=$1 start packages sheaf=$work/venv/bin/sheaf
  in_root rm -rf "$work/venv"
  as_user python3 -m venv "$work/venv"
  cp "$wheel" "$debian_root$work"
  start=$(date +%s.%N)
  as_user env "${pip_environment[@]}" "$work/venv/bin/pip" install --quiet "$work/$(basename "$wheel")" || fail "pip install"
  passed "pip install $(basename "$wheel") in $(awk -v a="$start" -v b="$(date +%s.%N)" 'BEGIN { printf "%.1f", b - a }') s"
  packages=$(as_user "$work/venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
  # Other modules of the same process share the library of C++.
  check_libraries "$packages/sheaf" 'libstdc[+][+][.]so' 'libgcc_s[.]so'
  in_work "$work/venv/bin/python" script.py || fail "the script in Python"
  check_scenes "$sheaf"
  passed "the package in Python, and the command of its environment"
}

# The configuration of pip on this machine, with the files that it names.
pip_environment=()
while IFS='=' read -r key value; do
  [[ -n $key ]] && pip_environment+=("$key=$value")
done < <(env | grep -E '^(PIP_|https?_proxy=|SSL_CERT_FILE=)' | grep -v '^PIP_FIND_LINKS=')

for release in bookworm trixie; do
  make_debian_root "$roots/$release" "$release"
  open_debian_root "$roots/$release"
  if [[ ! -e $debian_root/usr/bin/python3 ]]; then
    in_root env DEBIAN_FRONTEND=noninteractive bash -c 'apt-get -qq update && apt-get -qq install --yes --no-install-recommends python3-venv' \
      >"$roots/$release.log" 2>&1 || fail "python3-venv: $(tail -n 5 "$roots/$release.log")"
  fi
  if [[ -n ${PIP_CERT:-} ]]; then install -D "$PIP_CERT" "$debian_root$PIP_CERT"; fi
  if [[ -e /etc/pip.conf ]]; then cp /etc/pip.conf "$debian_root/etc/pip.conf"; fi
  rm -rf "${debian_root:?}$work"
  as_user mkdir "$work"
  "$repository/tests/package/release_inputs.py" "$debian_root$work"
  check_archive
  tag=$(in_root python3 -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
  wheels=("$folder"/sheaf-*-"$tag"-*.whl)
  [[ -e ${wheels[0]} ]] || fail "there is no wheel for $tag"
  check_wheel "${wheels[0]}"
  close_debian_root
done
echo "release: all passed"
