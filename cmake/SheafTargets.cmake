# Functions that turn folders into targets. Sources are given as patterns; the next build picks up new files.

# sheaf_sources(<variable> <pattern>...): sets the variable to the matching files of this project.
function(sheaf_sources variable)
  list(TRANSFORM ARGN PREPEND "${PROJECT_SOURCE_DIR}/")
  file(GLOB files CONFIGURE_DEPENDS ${ARGN})
  set(${variable} ${files} PARENT_SCOPE)
endfunction()

# sheaf_precompile(<target>): precompiles the headers that nearly every file includes: one set for core, and one with
# the scene description that all later targets share.
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

# sheaf_unite(<target>): with SHEAF_UNITY, compiles several sources of the target at a time. This suits targets of many
# small files, for which parsing headers dominates. Sources of one unit must not give the same name to different
# entities.
function(sheaf_unite target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${SHEAF_UNITY} UNITY_BUILD_BATCH_SIZE 16)
  if(SHEAF_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # In a unity build g++ would emit this warning, meant for headers, for all sources but the first.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# sheaf_share(<target>): compiles a target such that the Python module can link it. Symbols are hidden; therefore
# position-independent code calls and reads them directly, as programs do.
function(sheaf_share target)
  if(SHEAF_HAS_PYTHON_MODULE)
    target_compile_options(${target} PRIVATE -fPIC -fvisibility=hidden)
  endif()
endfunction()

# sheaf_layer(<name> SOURCES <pattern>... DEPENDS <target>...): adds the static or header-only library sheaf_<name>.
function(sheaf_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  if(sources)
    add_library(sheaf_${name} STATIC ${sources})
    target_link_libraries(sheaf_${name} PUBLIC ${arg_DEPENDS} PRIVATE sheaf_flags)
    sheaf_share(sheaf_${name})
    sheaf_precompile(sheaf_${name})
  else()
    add_library(sheaf_${name} INTERFACE)
    target_link_libraries(sheaf_${name} INTERFACE ${arg_DEPENDS})
  endif()
endfunction()

# sheaf_module(<name> SOURCES <pattern>... DEPENDS <target>...): adds the plugin <name>.so in the build folder, which
# programs load at run time. It is never instrumented for fuzzing, because it does not link the runtime that counts
# branches.
function(sheaf_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  add_library(${name} MODULE ${sources})
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Fuzz>:-fno-sanitize=all>)
  target_link_options(${name} PRIVATE $<$<CONFIG:Fuzz>:-fno-sanitize=all>)
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS} sheaf_flags)
endfunction()

# sheaf_program(<name> SOURCES <pattern>... DEPENDS <target>...): adds the program <name>, at the top of the build
# folder, unless no file matches. The property SHEAF_PROGRAMS lists all programs.
function(sheaf_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  if(sources)
    add_executable(${name} ${sources})
    target_link_libraries(${name} PRIVATE ${arg_DEPENDS} sheaf_flags)
    sheaf_share(${name})
    sheaf_precompile(${name})
    set_property(GLOBAL APPEND PROPERTY SHEAF_PROGRAMS ${name})
  endif()
endfunction()

# sheaf_helper(<name> SOURCES <pattern>... DEPENDS <target>...): adds a program, at the top of the build folder, that
# other programs start. It links no layer.
function(sheaf_helper name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS")
  sheaf_sources(sources ${arg_SOURCES})
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS} sheaf_flags)
endfunction()

# sheaf_embed(<target> <file> <name>): embeds the text of a file as the constant sheaf::<name>. The target's sources
# include it as a header with the path of the file and the extension .h.
function(sheaf_embed target file name)
  file(READ "${PROJECT_SOURCE_DIR}/${file}" SHEAF_EMBEDDED_TEXT)
  set(SHEAF_EMBEDDED_NAME ${name})
  cmake_path(REPLACE_EXTENSION file LAST_ONLY .h OUTPUT_VARIABLE header)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/embedded.h.in" "${PROJECT_BINARY_DIR}/embedded/${header}" @ONLY)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/embedded")
endfunction()

# sheaf_embed_tables(<target> <file>): embeds tables of floats as the arrays sheaf::<name>. In the file, each table is a
# line with its name and lines of numbers, which are literals of C++ without the suffix f; lines that start with # are
# comments. The target's sources include it as sheaf_embed() describes.
function(sheaf_embed_tables target file)
  file(STRINGS "${PROJECT_SOURCE_DIR}/${file}" lines REGEX "^[^#]")
  set(tables "")
  set(end "")
  foreach(line IN LISTS lines)
    if(line MATCHES "^[A-Za-z]")
      string(APPEND tables "${end}inline constexpr float ${line}[] = {\n")
      set(end "};\n")
    else()
      string(REGEX REPLACE "[^ ]+" "\\0f," line "${line}")
      string(APPEND tables "${line}\n")
    endif()
  endforeach()
  cmake_path(REPLACE_EXTENSION file LAST_ONLY .h OUTPUT_VARIABLE header)
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/embedded/${header}"
    CONTENT "// Written by CMake from ${file}.\n#pragma once\n\nnamespace sheaf {\n${tables}${end}}  // namespace sheaf\n")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/embedded")
endfunction()

# sheaf_list_headers(<folder> <template>): writes <folder>/all_headers.h below the build folder. It includes every header
# of the folder that specializes the template. New headers are found automatically. A specialization must begin a line;
# the list of the folder (list.h) does not compile without it.
function(sheaf_list_headers folder template)
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}/${folder}/*.h")
  set(includes "")
  foreach(header IN LISTS headers)
    file(STRINGS "${PROJECT_SOURCE_DIR}/${header}" specialisations REGEX "^template <> struct ${template}<")
    if(specialisations)
      string(APPEND includes "#include \"${header}\"\n")
    endif()
  endforeach()
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/${folder}/all_headers.h"
    CONTENT "// Written by CMake: the headers of ${folder}/ that specialize ${template}.\n#pragma once\n\n${includes}")
endfunction()

# sheaf_python_module(): adds the Python module sheaf._sheaf. The folder `python` of the build folder then holds the
# package, with links to its files in Python, for PYTHONPATH.
function(sheaf_python_module)
  sheaf_sources(sources tools/python/bindings/module*.cpp)
  set(package "${PROJECT_BINARY_DIR}/python/sheaf")
  add_library(sheaf_python_module MODULE ${sources})
  target_link_libraries(sheaf_python_module PRIVATE sheaf_python pybind11::module sheaf_flags)
  target_compile_options(sheaf_python_module PRIVATE -fvisibility=hidden)
  set_target_properties(sheaf_python_module PROPERTIES PREFIX "" OUTPUT_NAME _sheaf SUFFIX ".so"
    LIBRARY_OUTPUT_DIRECTORY "${package}")
  file(MAKE_DIRECTORY "${package}")
  sheaf_sources(files tools/python/sheaf/*.py tools/python/sheaf/*.pyi tools/python/sheaf/py.typed)
  foreach(file IN LISTS files)
    cmake_path(GET file FILENAME name)
    file(CREATE_LINK "${file}" "${package}/${name}" SYMBOLIC)
  endforeach()
  foreach(target IN ITEMS sheaf_color_io sheaf_import_model)
    if(TARGET ${target})
      add_custom_command(TARGET sheaf_python_module POST_BUILD COMMAND "${CMAKE_COMMAND}" -E create_symlink
        "$<TARGET_FILE:${target}>" "${package}/$<TARGET_FILE_NAME:${target}>" VERBATIM)
    endif()
  endforeach()
endfunction()
