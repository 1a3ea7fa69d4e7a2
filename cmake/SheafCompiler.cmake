# Which compiler, where nobody says (CMAKE_CXX_COMPILER, a toolchain file, the environment variable CXX): Clang if it is
# installed, else what CMake finds. Of the same sources g++ 12 makes kernels whose own work takes a sixth longer, as it
# keeps records of registers in memory (bench/README.md).
if(NOT CMAKE_CXX_COMPILER AND NOT CMAKE_TOOLCHAIN_FILE AND NOT DEFINED ENV{CXX})
  find_program(SHEAF_CLANG NAMES clang++)
  mark_as_advanced(SHEAF_CLANG)
  if(SHEAF_CLANG)
    set(CMAKE_CXX_COMPILER "${SHEAF_CLANG}")
  endif()
endif()
