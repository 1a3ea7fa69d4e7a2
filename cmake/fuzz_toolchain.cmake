# Clang where there is one, else what CMake finds.
find_program(SHEAF_CLANG NAMES clang++)
if(SHEAF_CLANG)
  set(CMAKE_CXX_COMPILER "${SHEAF_CLANG}")
endif()
