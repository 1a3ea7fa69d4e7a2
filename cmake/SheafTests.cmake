# Tests: one program per folder of tests/, and one ctest entry per file.

# Optimized builds compile tests with -O1, because most tests compile for longer than they run. -O0 would take longer in
# all: libraries call the tests' copies of inline functions. Results do not depend on it; see -ffp-contract in
# SheafFlags.cmake.
set(SHEAF_TEST_OPTIMIZATION $<$<CONFIG:Release,RelWithDebInfo,Check>:-O1>)
# This test looks for effects of stronger optimization.
set_source_files_properties("${PROJECT_SOURCE_DIR}/tests/core/simd/test_contraction.cpp" PROPERTIES
  COMPILE_OPTIONS -O3 SKIP_PRECOMPILE_HEADERS ON)

# Long tests, the longest first. ctest starts them in this order, so that no long test runs alone at the end.
set(SHEAF_LONG_TESTS
  smoke_generate preview preview_browser python cli_signals cli_files cli_outputs cli_merge cli_memory slurm smoke_scripts references
  photon_mapping photon_media
  light_tracing light_tracing_media light_tracing_cameras adaptive smoke_scenes docs_commands docs_snippets
  media_estimators smoke_benchmarks
  uplift nanovdb envmap_light light_emit bsdf_list bsdf_principled media_tracking furnaces light_estimators spectral_render
  instancing_render determinism cli_render cli)

# Tests that are skipped if a program is missing; they then print "skipped: ".
set(SHEAF_OPTIONAL_TESTS slurm preview_browser)

# sheaf_test_support(DEPENDS <target>...): adds the library sheaf_test_support, which all test programs link: main() and
# the precompiled headers. Also adds the target sheaf_tests, which builds all test programs.
function(sheaf_test_support)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "DEPENDS")
  sheaf_sources(sources tests/support/*.cpp)
  add_library(sheaf_test_support STATIC ${sources})
  target_link_libraries(sheaf_test_support PUBLIC ${arg_DEPENDS} PRIVATE sheaf_flags)
  target_compile_definitions(sheaf_test_support PUBLIC DOCTEST_CONFIG_SUPER_FAST_ASSERTS)
  target_compile_options(sheaf_test_support PRIVATE ${SHEAF_TEST_OPTIMIZATION})
  if(SHEAF_PRECOMPILE)
    target_precompile_headers(sheaf_test_support PRIVATE "${PROJECT_SOURCE_DIR}/cmake/precompiled_tests.h")
  endif()
  add_custom_target(sheaf_tests)
endfunction()

# Sets a variable to whether a file contains slow tests.
function(sheaf_has_slow_tests variable source)
  file(STRINGS "${source}" suites REGEX "^TEST_SUITE.*\"slow\"" LIMIT_COUNT 1)
  if(suites)
    set(${variable} ON PARENT_SCOPE)
  else()
    set(${variable} OFF PARENT_SCOPE)
  endif()
endfunction()

# Sets a variable to whether a file contains only slow tests: the suite "slow" begins before its first test.
function(sheaf_is_slow variable source)
  file(STRINGS "${source}" first REGEX "^TEST_(CASE|SUITE)" LIMIT_COUNT 1)
  if(first MATCHES "^TEST_SUITE.*\"slow\"")
    set(${variable} ON PARENT_SCOPE)
  else()
    set(${variable} OFF PARENT_SCOPE)
  endif()
endfunction()

# sheaf_tests(<folder> DEPENDS <target>... [RUNS <target>...]): adds the program sheaf_tests_<folder> from the files
# tests/<folder>/*.cpp and tests/<folder>/*/*.cpp, and one ctest entry per file test_<unit>.cpp. RUNS: programs that the tests start. With
# SHEAF_SKIP_SLOW_TESTS, files of slow tests are not compiled. For the folders in SHEAF_ONLY_SLOW_TESTS, only files with
# slow tests are.
function(sheaf_tests folder)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS;RUNS")
  sheaf_sources(sources tests/${folder}/*.cpp tests/${folder}/*/*.cpp)
  set(units)
  foreach(source IN LISTS sources)
    sheaf_is_slow(slow "${source}")
    if(slow AND SHEAF_SKIP_SLOW_TESTS)
      list(REMOVE_ITEM sources "${source}")
      continue()
    endif()
    cmake_path(GET source STEM unit)
    sheaf_has_slow_tests(has_slow "${source}")
    if(folder IN_LIST SHEAF_ONLY_SLOW_TESTS AND unit MATCHES "^test_" AND NOT has_slow)
      list(REMOVE_ITEM sources "${source}")
      continue()
    endif()
    if(unit MATCHES "^test_")
      string(REGEX REPLACE "^test_" "" unit "${unit}")
      list(APPEND units ${unit})
    endif()
  endforeach()

  if(NOT sources)
    return()
  endif()
  set(program sheaf_tests_${folder})
  add_executable(${program} ${sources})
  sheaf_unite(${program})
  target_link_libraries(${program} PRIVATE sheaf_test_support ${arg_DEPENDS} sheaf_flags)
  target_compile_options(${program} PRIVATE ${SHEAF_TEST_OPTIMIZATION})
  target_compile_definitions(${program} PRIVATE SHEAF_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(arg_RUNS)
    target_compile_definitions(${program} PRIVATE SHEAF_EXECUTABLE="$<TARGET_FILE:sheaf>")
    add_dependencies(${program} ${arg_RUNS})
  endif()
  if(SHEAF_PRECOMPILE)
    target_precompile_headers(${program} REUSE_FROM sheaf_test_support)
  endif()
  add_dependencies(sheaf_tests ${program})

  foreach(unit IN LISTS units)
    set(filter "--source-file=*/test_${unit}.cpp")
    if(SHEAF_SKIP_SLOW_TESTS)
      list(APPEND filter --test-suite-exclude=slow)
    endif()
    add_test(NAME ${unit} COMMAND ${program} ${filter} --no-intro --no-version WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    sheaf_test_cost(${unit})
    set_tests_properties(${unit} PROPERTIES LABELS ${folder})
    if(unit IN_LIST SHEAF_OPTIONAL_TESTS)
      set_tests_properties(${unit} PROPERTIES SKIP_REGULAR_EXPRESSION "skipped: ")
    endif()
  endforeach()
endfunction()

# sheaf_test_cost(<test>): sets the priority of a test in ctest's order, and its timeout.
function(sheaf_test_cost test)
  list(REVERSE SHEAF_LONG_TESTS)
  list(FIND SHEAF_LONG_TESTS ${test} place)
  math(EXPR cost "${place} + 1")
  set_tests_properties(${test} PROPERTIES COST ${cost} TIMEOUT 900)
endfunction()

# sheaf_find_python(<consequence>): sets SHEAF_PYTHON, the interpreter of the tests. If there is no Python, prints
# the consequence.
function(sheaf_find_python consequence)
  find_program(SHEAF_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH DOC "Python with Debian's packages")
  find_program(SHEAF_PYTHON NAMES python3)
  if(NOT SHEAF_PYTHON)
    message(STATUS "No python3: ${consequence}")
  endif()
endfunction()

# sheaf_smoke_tests(<kind>... [OPTIONS <option>...]): runs each of the benchmarks, scripts or scenes (the examples) once
# with the shortest settings; `generate`, which writes the files of scenes, must be among the kinds. It is left out if
# SHEAF_GENERATED_SCENES names a folder that it wrote in another build. OPTIONS: passed to tests/smoke/smoke.py. That
# script finds what to run, and fails for scripts and programs without a known command line.
function(sheaf_smoke_tests)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "OPTIONS")
  sheaf_find_python("benchmarks, scripts and example scenes are not tested")
  if(NOT SHEAF_PYTHON)
    return()
  endif()
  get_property(programs GLOBAL PROPERTY SHEAF_PROGRAMS)
  if(SHEAF_GENERATED_SCENES)
    list(REMOVE_ITEM arg_UNPARSED_ARGUMENTS generate)
    list(APPEND arg_OPTIONS --generated "${SHEAF_GENERATED_SCENES}")
  endif()
  foreach(kind IN LISTS arg_UNPARSED_ARGUMENTS)
    add_test(NAME smoke_${kind} COMMAND "${SHEAF_PYTHON}" tests/smoke/smoke.py ${kind} --build "${PROJECT_BINARY_DIR}"
      ${arg_OPTIONS} --programs ${programs} WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    sheaf_test_cost(smoke_${kind})
    set_tests_properties(smoke_${kind} PROPERTIES LABELS smoke)
  endforeach()
  if(SHEAF_GENERATED_SCENES)
    return()
  endif()
  # The copy of the tree with generated files
  set_tests_properties(smoke_generate PROPERTIES FIXTURES_SETUP generated_scenes)
  foreach(kind IN ITEMS scenes scripts)
    if(kind IN_LIST arg_UNPARSED_ARGUMENTS)
      set_tests_properties(smoke_${kind} PROPERTIES FIXTURES_REQUIRED generated_scenes)
    endif()
  endforeach()
endfunction()

# sheaf_docs_tests(<name>...): adds a ctest entry docs_<name> for each script tests/docs/check_<name>.py, which checks
# the documentation. Scripts that lack a program print "skipped: ".
function(sheaf_docs_tests)
  sheaf_find_python("the documentation is not tested")
  if(NOT SHEAF_PYTHON)
    return()
  endif()
  foreach(name IN LISTS ARGN)
    add_test(NAME docs_${name} COMMAND "${SHEAF_PYTHON}" tests/docs/check_${name}.py --sheaf "$<TARGET_FILE:sheaf>"
      WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    sheaf_test_cost(docs_${name})
    set_tests_properties(docs_${name} PROPERTIES LABELS docs SKIP_REGULAR_EXPRESSION "skipped: ")
  endforeach()
endfunction()

# sheaf_blender_test(): tests the Blender add-on with a fake of Blender's modules.
function(sheaf_blender_test)
  sheaf_find_python("the Blender add-on is not tested")
  if(NOT SHEAF_PYTHON)
    return()
  endif()
  add_test(NAME blender_addon COMMAND "${SHEAF_PYTHON}" tests/blender/test_sheaf_render.py --sheaf
    "$<TARGET_FILE:sheaf>" WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  set_tests_properties(blender_addon PROPERTIES SKIP_REGULAR_EXPRESSION "skipped: ")
endfunction()

# sheaf_python_tests(): runs the tests of the Python package. tests/python/run.py writes the coverage of its lines to
# python/coverage.txt.
function(sheaf_python_tests)
  add_test(NAME python COMMAND "${Python_EXECUTABLE}" -B tests/python/run.py --package "${PROJECT_BINARY_DIR}/python"
    --sheaf "$<TARGET_FILE:sheaf>" --report "${PROJECT_BINARY_DIR}/python/coverage.txt"
    WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  sheaf_test_cost(python)
  set_tests_properties(python PROPERTIES LABELS python)
endfunction()

# sheaf_format_test(): checks that clang-format leaves every C++ file unchanged.
function(sheaf_format_test)
  add_test(NAME format COMMAND tools/check_format.sh WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
  set_tests_properties(format PROPERTIES LABELS format SKIP_REGULAR_EXPRESSION "skipped: ")
endfunction()
