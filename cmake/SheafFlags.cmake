# Flags for the processor. On ARM64, char is unsigned by default, and Clang 14 lacks -march=native.
set(march "")
if(SHEAF_MARCH)
  set(march -march=${SHEAF_MARCH})
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  string(REPLACE "-march=native" "-mcpu=native" march "${march}")
  list(APPEND march -fsigned-char)
endif()

# sheaf_flags: include folders and compiler flags of all code of this project. Optimization and sanitizers come with the
# build type; see CMakePresets.json.
add_library(sheaf_flags INTERFACE)
target_include_directories(sheaf_flags INTERFACE "${PROJECT_SOURCE_DIR}" "${PROJECT_BINARY_DIR}/generated")
# -ffp-contract=off rounds a * b + c twice everywhere. Therefore the same source gives the same bits in every function,
# lane, optimization level and compiler. Code that wants a fused multiply-add calls fma(). Tested by
# tests/core/simd/test_contraction.cpp.
target_compile_options(sheaf_flags INTERFACE
  -fno-math-errno -fno-trapping-math -ffp-contract=off
  -Wall -Wextra -Wshadow
  $<$<BOOL:${SHEAF_WERROR}>:-Werror>
  ${march})
include(CheckCXXCompilerFlag)
include(CheckCXXSymbolExists)
string(JOIN " " CMAKE_REQUIRED_FLAGS ${march})
check_cxx_symbol_exists(__AVX512F__ "" SHEAF_TARGET_AVX512)
check_cxx_compiler_flag("-mmove-max=256 -mstore-max=256" SHEAF_HAS_MOVE_MAX)
unset(CMAKE_REQUIRED_FLAGS)

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Run g++'s garbage collector later: kernels compile 7% faster and use 250 MB more memory.
  target_compile_options(sheaf_flags INTERFACE --param=ggc-min-heapsize=600000)
  # False positives of g++ 12 to 14 in its own inlined headers, about inactive members of std::variant.
  target_compile_options(sheaf_flags INTERFACE -Wno-maybe-uninitialized)
  if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False positives about "literal" + string: overlapping copies or copies of negative length. AVX-512 intrinsics
    # intentionally leave registers undefined.
    target_compile_options(sheaf_flags INTERFACE
      -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds)
    if(SHEAF_TARGET_AVX512)
      target_compile_options(sheaf_flags INTERFACE -Wno-uninitialized)
    endif()
  endif()
endif()

if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # Masks of one lane are bool. Code that is generic in the lane policy combines masks by & and |.
  target_compile_options(sheaf_flags INTERFACE -Wno-unknown-warning-option -Wno-bitwise-instead-of-logical)
  # The stable_sort() of libstdc++ 12 calls deprecated functions, about which Clang 15 and later warn.
  target_compile_options(sheaf_flags INTERFACE -Wno-error=deprecated-declarations)
endif()

# By default g++ copies registers that it keeps in memory in pieces of 16 bytes. A whole-register load after such a copy
# stalls (measured: light_candidates 44 instead of 22 ns per item).
if(SHEAF_HAS_MOVE_MAX)
  set(move_bits $<IF:$<BOOL:${SHEAF_TARGET_AVX512}>,512,256>)
  target_compile_options(sheaf_flags INTERFACE -mmove-max=${move_bits} -mstore-max=${move_bits})
endif()
