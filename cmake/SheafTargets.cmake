# How a folder becomes a target. Sources are given as patterns; a new file is picked up by the next build.

# sheaf_sources(<variable> <pattern>...): the files of this project that match.
function(sheaf_sources variable)
  list(TRANSFORM ARGN PREPEND "${PROJECT_SOURCE_DIR}/")
  file(GLOB files CONFIGURE_DEPENDS ${ARGN})
  set(${variable} ${files} PARENT_SCOPE)
endfunction()

# sheaf_layer(<name> SOURCES <pattern>... DEPENDS <target>...): the static library sheaf_<name>, or headers alone.
function(sheaf_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  if(sources)
    add_library(sheaf_${name} STATIC ${sources})
    target_link_libraries(sheaf_${name} PUBLIC ${arg_DEPENDS} PRIVATE sheaf_flags)
  else()
    add_library(sheaf_${name} INTERFACE)
    target_link_libraries(sheaf_${name} INTERFACE ${arg_DEPENDS})
  endif()
endfunction()

# sheaf_program(<name> SOURCES <pattern>... DEPENDS <target>...): the program <name>, in the build folder itself.
# Nothing is added if no file matches.
function(sheaf_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  if(sources)
    add_executable(${name} ${sources})
    target_link_libraries(${name} PRIVATE ${arg_DEPENDS} sheaf_flags)
  endif()
endfunction()

# sheaf_tests(SOURCES <pattern>... DEPENDS <target>...): the program sheaf_tests, and one entry of ctest for each
# file tests/test_<unit>.cpp.
function(sheaf_tests)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "SOURCES;DEPENDS")
  sheaf_program(sheaf_tests SOURCES ${arg_SOURCES} DEPENDS ${arg_DEPENDS})
  target_compile_definitions(sheaf_tests PRIVATE SHEAF_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(TARGET sheaf)
    target_compile_definitions(sheaf_tests PRIVATE SHEAF_EXECUTABLE="$<TARGET_FILE:sheaf>")
    add_dependencies(sheaf_tests sheaf)
  endif()
  sheaf_sources(sources ${arg_SOURCES})
  foreach(source IN LISTS sources)
    cmake_path(GET source STEM unit)
    if(NOT unit MATCHES "^test_")
      continue()
    endif()
    string(REGEX REPLACE "^test_" "" unit "${unit}")
    set(filter "--source-file=*/test_${unit}.cpp")
    if(SHEAF_SKIP_SLOW_TESTS)
      list(APPEND filter --test-suite-exclude=slow)
    endif()
    add_test(NAME ${unit} COMMAND sheaf_tests ${filter} --no-intro --no-version WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    set_tests_properties(${unit} PROPERTIES TIMEOUT 900)
  endforeach()
endfunction()
