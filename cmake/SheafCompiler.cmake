# Default compiler, unless the user chooses one (CMAKE_CXX_COMPILER, a toolchain file, the environment variable CXX):
# Clang if it is installed, otherwise CMake's choice. With g++ 12 the kernels' own work takes a sixth longer, because it
# keeps records of registers in memory (bench/README.md). scikit-build-core sets CXX to the compiler of Python, which is
# not the user's choice.
if(NOT CMAKE_CXX_COMPILER AND NOT CMAKE_TOOLCHAIN_FILE AND (SKBUILD OR NOT DEFINED ENV{CXX}))
  find_program(SHEAF_CLANG NAMES clang++)
  mark_as_advanced(SHEAF_CLANG)
  if(SHEAF_CLANG)
    set(CMAKE_CXX_COMPILER "${SHEAF_CLANG}")
  endif()
endif()

# Links with LLVM's linker if it is installed, which is three times as fast on programs with sanitizers.
find_program(SHEAF_LLD NAMES ld.lld)
mark_as_advanced(SHEAF_LLD)
if(SHEAF_LLD)
  add_link_options(-fuse-ld=lld)
endif()
