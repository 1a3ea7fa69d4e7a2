# Fuzz targets; see tests/fuzz/README.md. The preset fuzz links libFuzzer, which requires Clang. The preset asan links
# tests/fuzz/mutate.cpp instead.

# The sources of kernels/ that read files; fuzz builds contain nothing else of that layer.
set(SHEAF_FUZZ_KERNELS kernels/film/*.cpp kernels/render/render_state.cpp)

# sheaf_find_fuzzer(): sets SHEAF_HAS_FUZZER. Without libFuzzer, adds a ctest entry that reports it.
function(sheaf_find_fuzzer)
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_FLAGS -fsanitize=fuzzer)
  check_cxx_source_compiles("#include <cstddef>
    extern \"C\" int LLVMFuzzerTestOneInput(const unsigned char*, std::size_t) { return 0; }" SHEAF_HAS_FUZZER)
  if(NOT SHEAF_HAS_FUZZER)
    add_test(NAME fuzz
      COMMAND "${CMAKE_COMMAND}" -E echo "skipped: no clang++ with libFuzzer (packages clang, libclang-rt-dev)")
    set_tests_properties(fuzz PROPERTIES LABELS fuzz SKIP_REGULAR_EXPRESSION "skipped: ")
  endif()
endfunction()

# sheaf_fuzz_targets(): adds a program for each tests/fuzz/fuzz_*.cpp, and a ctest entry that runs it briefly.
function(sheaf_fuzz_targets)
  if(SHEAF_FUZZ)
    set(driver)
    # Many messages suggest the most similar of many names. Comparisons of letters in that search give the fuzzer no
    # useful feedback.
    set_source_files_properties("${PROJECT_SOURCE_DIR}/core/io/error.cpp" PROPERTIES
      COMPILE_OPTIONS -fno-sanitize-coverage=trace-cmp)
  else()
    set(driver tests/fuzz/mutate.cpp)
    # Checks that the preset asan omits because they take long to compile in kernels.
    set(checks -fsanitize=alignment,float-cast-overflow -fsanitize-address-use-after-scope)
    target_compile_options(sheaf_core PRIVATE ${checks})
    target_compile_options(sheaf_scene PRIVATE ${checks})
    sheaf_sources(readers ${SHEAF_FUZZ_KERNELS})
    set_source_files_properties(${readers} PROPERTIES COMPILE_OPTIONS "${checks}" SKIP_PRECOMPILE_HEADERS ON)
  endif()
  sheaf_layer(fuzz SOURCES tests/fuzz/fuzz.cpp ${driver} tools/job/interrupted_image.cpp tools/job/parts.cpp
    DEPENDS sheaf_kernels)
  target_compile_definitions(sheaf_fuzz PUBLIC SHEAF_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  sheaf_program(sheaf_fuzz_seeds SOURCES tests/fuzz/seeds.cpp DEPENDS sheaf_fuzz)
  sheaf_sources(sources tests/fuzz/fuzz_*.cpp)
  foreach(source IN LISTS sources)
    cmake_path(GET source STEM target)
    sheaf_program(${target} SOURCES tests/fuzz/${target}.cpp DEPENDS sheaf_fuzz)
    if(SHEAF_FUZZ)
      target_link_options(${target} PRIVATE -fsanitize=fuzzer)
    endif()
    string(REPLACE fuzz_ "" name ${target})
    # A fixed seed: apart from the time limit, the result depends only on the code.
    add_test(NAME ${target} COMMAND tests/fuzz/run.sh "${PROJECT_BINARY_DIR}" ${name} -seed=1 -max_total_time=1
      WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    set_tests_properties(${target} PROPERTIES LABELS fuzz TIMEOUT 300)
  endforeach()
endfunction()
