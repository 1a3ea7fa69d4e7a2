#!/usr/bin/env bash
# Checks Sheaf for ARM64 on another machine: compiles it by Clang against Debian 12's packages for arm64, runs unit tests
# and renders by QEMU, and compares the images with those of a build for this machine.
#   tools/packaging/check_arm64.sh [FOLDER]      default: build/arm64
# Needs the packages lld and qemu-user-static besides those of tools/install_packages.sh, but no root. The mirror is the
# one of apt on this machine; SHEAF_DEBIAN_MIRROR overrides it. SHEAF names the program to compare with (default:
# build/release/sheaf, which is built if it is missing). Later runs reuse the packages and the build in FOLDER.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$repository"
folder=$(realpath -m "${1:-build/arm64}")
root=$folder/root
build=$folder/release
sheaf=$(realpath -m "${SHEAF:-build/release/sheaf}")
source tools/packaging/arm64_root.sh

# The longest unit tests, which are left out: they take four fifths of the time of all.
long_tests=(
  light_emit bsdf_rough bsdf_list uplift bsdf_metallic_roughness bsdf_principled bsdf_dispersive media_tracking bsdf_hair
  sampler bsdf_plastic light_sample
)
# QEMU ignores limits of the address space.
impossible_tests=(memory_limits)

fail() { echo "arm64: $*" >&2; exit 1; }

run_tests() {
  local excluded
  excluded=$(IFS='|' && echo "${long_tests[*]}|${impossible_tests[*]}")
  ctest --test-dir "$build" --label-regex '^(core|kernels)$' --exclude-regex "^($excluded)$" --output-on-failure \
    --timeout 3600 --parallel "$(nproc)" | tee "$folder/tests.log"
}

# check_image NAME SCENE [OPTION]...: renders the scene in both builds at the same seed. The images differ only where
# rounding sends a path elsewhere, which must stay within the noise: a tenth of the difference to another seed.
check_image() {
  local name=$1 scene=$2 noise
  shift 2
  local options=(--scale 0.1 --spp 16 --aov variance --quiet)
  "$sheaf" render "$scene" "${options[@]}" "$@" --seed 1 -o "$folder/$name-here.exr"
  "$sheaf" render "$scene" "${options[@]}" "$@" --seed 2 -o "$folder/$name-noise.exr"
  run_arm64 "$root" "$build/sheaf" render "$scene" "${options[@]}" "$@" --seed 1 -o "$folder/$name-arm64.exr"
  noise=$("$sheaf" compare "$folder/$name-noise.exr" "$folder/$name-here.exr" | awk '/^relative MSE/ { print $3 / 10 }')
  "$sheaf" compare "$folder/$name-arm64.exr" "$folder/$name-here.exr" --max-relmse "$noise" --min-mean-p 0.01 \
    >"$folder/$name.txt" || { cat "$folder/$name.txt"; fail "the images of $name differ by more than noise"; }
  summary+=("$name: $(awk -v noise="$noise" '/^relative MSE/ { printf "relative MSE %s (limit: %s)", $3, noise }
    /^mean ratio/ { printf ", mean ratio %s", $3 } /^Z-test/ { printf ", %s %% of values pass the Z-test", $2 }' \
    "$folder/$name.txt")")
}

for command in clang++ ld.lld qemu-aarch64-static; do
  command -v "$command" >/dev/null || fail "'$command' is missing; install clang, lld and qemu-user-static"
done
mkdir -p "$folder"
make_arm64_root "$root"
build_arm64 "$root" "$build" "sheaf_manual sheaf_tests_core sheaf_tests_kernels" -DSHEAF_UNIT_TESTS_ONLY=ON \
  -DSHEAF_BUILD_BENCH=OFF -DSHEAF_BUILD_PYTHON=OFF
if [[ ! -x $sheaf ]]; then
  cmake --preset release
  cmake --build --preset release --target sheaf
fi
summary=("$(run_arm64 "$root" "$build/sheaf" --version)")
run_tests
summary+=("$(grep 'tests passed' "$folder/tests.log"); left out: ${long_tests[*]} ${impossible_tests[*]}")
scenes/make/make_gltf_scene.py >/dev/null
check_image cornell scenes/cornell/cornell.xml
check_image medium scenes/media/fog.xml
check_image gltf scenes/gltf/generated/swatches.glb
check_image spectral scenes/spectral/metamers.xml --color spectral
printf 'arm64: %s\n' "${summary[@]}"
