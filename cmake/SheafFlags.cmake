# sheaf_flags: the include folder, definitions and compiler flags of all code of this project. Optimisation and
# sanitizers come with the build type, see CMakePresets.json.
add_library(sheaf_flags INTERFACE)
target_include_directories(sheaf_flags INTERFACE "${PROJECT_SOURCE_DIR}")
target_compile_definitions(sheaf_flags INTERFACE SHEAF_VERSION="${PROJECT_VERSION}")
target_compile_options(sheaf_flags INTERFACE
  -fno-math-errno -fno-trapping-math
  -Wall -Wextra -Wshadow
  $<$<BOOL:${SHEAF_WERROR}>:-Werror>
  $<$<BOOL:${SHEAF_MARCH}>:-march=${SHEAF_MARCH}>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False alarms of g++ 12 in its own headers once inlined: AVX-512 intrinsics leave registers undefined on purpose, and
  # "literal" + string is taken for an overlapping copy.
  target_compile_options(sheaf_flags INTERFACE -Wno-uninitialized -Wno-maybe-uninitialized -Wno-restrict)
endif()
