# Functions that build Sheaf for several instruction sets, for scripts that source this file in the repository's root.

# Microarchitecture levels of x86-64, the lowest first.
levels=(x86-64-v3 x86-64-v4)

# build_levels FOLDER [OPTION...] -- TARGET...: configures and builds in FOLDER/LEVEL, and sets `builds` to these folders.
build_levels() {
  local folder=$1 level options=()
  shift
  while [[ $1 != -- ]]; do
    options+=("$1")
    shift
  done
  shift
  builds=()
  for level in "${levels[@]}"; do
    echo "building for $level"
    cmake --preset release -B "$folder/$level" -DSHEAF_MARCH="$level" -DSHEAF_BUILD_TESTS=OFF -DSHEAF_BUILD_BENCH=OFF \
      -DSHEAF_PACKAGED_BUILDS= -DCMAKE_SKIP_INSTALL_ALL_DEPENDENCY=ON "${options[@]}" >/dev/null
    cmake --build "$folder/$level" --target "$@"
    builds+=("$folder/$level")
  done
}

# build_launcher: builds the launcher and the manual in the first of `builds`, which then installs all of them. Making
# the manual runs the program of the lowest level.
build_launcher() {
  cmake -B "${builds[0]}" -DSHEAF_PACKAGED_BUILDS="$(IFS=';'; echo "${builds[*]}")" >/dev/null
  cmake --build "${builds[0]}" --target sheaf_launcher sheaf_manual
}

# sheaf_version: prints the version of CMakeLists.txt.
sheaf_version() { sed -nE 's/^project\(sheaf VERSION ([0-9.]+).*/\1/p' CMakeLists.txt; }
