# sheaf_flags: the include folder, definitions and compiler flags of all code of this project. Optimisation and
# sanitizers come with the build type, see CMakePresets.json.
add_library(sheaf_flags INTERFACE)
target_include_directories(sheaf_flags INTERFACE "${PROJECT_SOURCE_DIR}")
target_compile_definitions(sheaf_flags INTERFACE SHEAF_VERSION="${PROJECT_VERSION}")
# Without contraction a * b + c is rounded twice wherever it is inlined, so that the same source gives the same bits in any
# function, lane, level of optimisation and compiler; where a fused multiply-add is wanted, fma() says so. Tested by
# tests/core/test_contraction.cpp.
target_compile_options(sheaf_flags INTERFACE
  -fno-math-errno -fno-trapping-math -ffp-contract=off
  -Wall -Wextra -Wshadow
  $<$<BOOL:${SHEAF_WERROR}>:-Werror>
  $<$<BOOL:${SHEAF_MARCH}>:-march=${SHEAF_MARCH}>)
include(CheckCXXCompilerFlag)
include(CheckCXXSymbolExists)
if(SHEAF_MARCH)
  set(CMAKE_REQUIRED_FLAGS "-march=${SHEAF_MARCH}")
endif()
check_cxx_symbol_exists(__AVX512F__ "" SHEAF_TARGET_AVX512)
check_cxx_compiler_flag("-mmove-max=256 -mstore-max=256" SHEAF_HAS_MOVE_MAX)
unset(CMAKE_REQUIRED_FLAGS)

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # The compiler collects its garbage later: kernels compile 7 % faster for 250 MB more memory.
  target_compile_options(sheaf_flags INTERFACE --param=ggc-min-heapsize=600000)
  # False alarms of g++ (12 to 14) once its own headers are inlined: what a std::variant does not hold is taken for unset.
  target_compile_options(sheaf_flags INTERFACE -Wno-maybe-uninitialized)
  if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # "literal" + string is taken for an overlapping copy or one of negative length, and AVX-512 intrinsics leave registers undefined on purpose.
    target_compile_options(sheaf_flags INTERFACE
      -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds)
    if(SHEAF_TARGET_AVX512)
      target_compile_options(sheaf_flags INTERFACE -Wno-uninitialized)
    endif()
  endif()
endif()

if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # Masks of one lane are bool, and what is written once for one lane and for many combines masks by & and |.
  target_compile_options(sheaf_flags INTERFACE -Wno-unknown-warning-option -Wno-bitwise-instead-of-logical)
  # The stable_sort() of libstdc++ 12 calls what it deprecates, of which Clang 15 and later tell.
  target_compile_options(sheaf_flags INTERFACE -Wno-error=deprecated-declarations)
endif()

# Registers that g++ keeps in memory are copied by pieces of 16 bytes unless told otherwise; a whole-register load behind
# such a copy waits for the cache (measured: light_candidates 44 against 22 ns per item).
if(SHEAF_HAS_MOVE_MAX)
  set(move_bits $<IF:$<BOOL:${SHEAF_TARGET_AVX512}>,512,256>)
  target_compile_options(sheaf_flags INTERFACE -mmove-max=${move_bits} -mstore-max=${move_bits})
endif()
