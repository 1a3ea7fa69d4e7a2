# How a folder becomes a target. Sources are given as patterns; a new file is picked up by the next build.

# sheaf_sources(<variable> <pattern>...): the files of this project that match.
function(sheaf_sources variable)
  list(TRANSFORM ARGN PREPEND "${PROJECT_SOURCE_DIR}/")
  file(GLOB files CONFIGURE_DEPENDS ${ARGN})
  set(${variable} ${files} PARENT_SCOPE)
endfunction()

# sheaf_precompile(<target>): the headers that nearly every file includes are parsed once for core, and once, with the
# description of scenes, for all targets after it.
function(sheaf_precompile target)
  if(NOT SHEAF_PRECOMPILE)
    return()
  elseif(target STREQUAL sheaf_core)
    target_precompile_headers(${target} PRIVATE "${PROJECT_SOURCE_DIR}/cmake/precompiled.h")
  elseif(target STREQUAL sheaf_scene)
    target_precompile_headers(${target} PRIVATE "${PROJECT_SOURCE_DIR}/cmake/precompiled_scene.h")
  else()
    target_precompile_headers(${target} REUSE_FROM sheaf_scene)
  endif()
endfunction()

# sheaf_unite(<target>): with SHEAF_UNITY, its sources several at a time, for targets of many small files: what those
# include is most of the work. Two of them that stand together can't give one name to different things.
function(sheaf_unite target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${SHEAF_UNITY} UNITY_BUILD_BATCH_SIZE 8)
  if(SHEAF_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # What is told of headers would be told of all sources but the first.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# sheaf_layer(<name> SOURCES <pattern>... DEPENDS <target>...): the static library sheaf_<name>, or headers alone.
function(sheaf_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  if(sources)
    add_library(sheaf_${name} STATIC ${sources})
    target_link_libraries(sheaf_${name} PUBLIC ${arg_DEPENDS} PRIVATE sheaf_flags)
    sheaf_precompile(sheaf_${name})
  else()
    add_library(sheaf_${name} INTERFACE)
    target_link_libraries(sheaf_${name} INTERFACE ${arg_DEPENDS})
  endif()
endfunction()

# sheaf_module(<name> SOURCES <pattern>... DEPENDS <target>...): <name>.so in the build folder, for programs there to load
# while they run. It is not fuzzed: what would count its branches is no part of it.
function(sheaf_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  add_library(${name} MODULE ${sources})
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Fuzz>:-fno-sanitize=all>)
  target_link_options(${name} PRIVATE $<$<CONFIG:Fuzz>:-fno-sanitize=all>)
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS} sheaf_flags)
endfunction()

# sheaf_program(<name> SOURCES <pattern>... DEPENDS <target>...): the program <name>, in the build folder itself.
# Nothing is added if no file matches. The property SHEAF_PROGRAMS lists what was added.
function(sheaf_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  if(sources)
    add_executable(${name} ${sources})
    target_link_libraries(${name} PRIVATE ${arg_DEPENDS} sheaf_flags)
    sheaf_precompile(${name})
    set_property(GLOBAL APPEND PROPERTY SHEAF_PROGRAMS ${name})
  endif()
endfunction()

# sheaf_embed(<target> <file> <name>): the text of a file as the constant sheaf::<name>, for the target's sources to
# include as the header of the file's path, with .h in place of its extension.
function(sheaf_embed target file name)
  file(READ "${PROJECT_SOURCE_DIR}/${file}" SHEAF_EMBEDDED_TEXT)
  set(SHEAF_EMBEDDED_NAME ${name})
  cmake_path(REPLACE_EXTENSION file LAST_ONLY .h OUTPUT_VARIABLE header)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/embedded.h.in" "${PROJECT_BINARY_DIR}/embedded/${header}" @ONLY)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/embedded")
endfunction()
