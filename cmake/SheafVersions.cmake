# The version of Sheaf, and those of the libraries of the build for `sheaf --version -v`.

# sheaf_version_header(<path> <lines>): writes a header below the build folder, with lines in the namespace sheaf.
function(sheaf_version_header path lines)
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/${path}"
    CONTENT "// Written by CMake.\n#pragma once\n\nnamespace sheaf {\n${lines}\n}\n")
endfunction()

# Only files that include this header are compiled again for another version.
sheaf_version_header(core/io/version.h
  "/// The version of Sheaf, such as \"1.2.3\".\ninline constexpr char kSheafVersion[] = \"${PROJECT_VERSION}\";")

# sheaf_header_version(<variable> <header> <name>...): sets the variable to the numbers behind names in a header, joined
# by dots.
function(sheaf_header_version variable header)
  set(numbers "")
  foreach(name IN LISTS ARGN)
    if(EXISTS "${header}")
      file(STRINGS "${header}" line REGEX "${name}[^A-Z_]" LIMIT_COUNT 1)
      if(line MATCHES "${name}[^0-9]*([0-9.]+)")
        list(APPEND numbers ${CMAKE_MATCH_1})
      endif()
    endif()
  endforeach()
  list(JOIN numbers . version)
  set(${variable} "${version}" PARENT_SCOPE)
endfunction()

# sheaf_list_libraries(): writes tools/cli/libraries.h below the build folder, with the constant kLibraries. The
# libraries of image formats name their versions themselves.
function(sheaf_list_libraries)
  sheaf_header_version(xsimd_VERSION "${xsimd_INCLUDE_DIR}/xsimd/config/xsimd_config.hpp"
    XSIMD_VERSION_MAJOR XSIMD_VERSION_MINOR XSIMD_VERSION_PATCH)
  sheaf_header_version(NanoVDB_VERSION "${NanoVDB_INCLUDE_DIR}/nanovdb/NanoVDB.h"
    NANOVDB_MAJOR_VERSION_NUMBER NANOVDB_MINOR_VERSION_NUMBER NANOVDB_PATCH_VERSION_NUMBER)
  sheaf_header_version(OpenColorIO_VERSION "${OpenColorIO_INCLUDE_DIR}/OpenColorIO/OpenColorABI.h" OCIO_VERSION_STR)
  sheaf_header_version(Draco_VERSION "${Draco_INCLUDE_DIR}/draco/core/draco_version.h" kDracoVersion)
  set(libraries "Embree ${Embree_VERSION}" "oneTBB ${TBB_VERSION}" "xsimd ${xsimd_VERSION}" "OpenEXR ${OpenEXR_VERSION}"
    "Imath ${Imath_VERSION}" "zlib ${ZLIB_VERSION_STRING}"
    "pugixml ${pugixml_VERSION}" "fmt ${fmt_VERSION}" "CLI11 ${CLI11_VERSION}"
    "nlohmann-json ${nlohmann_json_VERSION}" "NanoVDB ${NanoVDB_VERSION}" "tinygltf" "tinyobjloader" "libmicrohttpd")
  foreach(optional IN ITEMS OpenColorIO Draco Meshoptimizer Assimp)
    if(${optional}_FOUND)
      list(APPEND libraries "${optional} ${${optional}_VERSION}")
    endif()
  endforeach()
  list(TRANSFORM libraries STRIP)
  list(JOIN libraries ", " text)
  sheaf_version_header(tools/cli/libraries.h "inline constexpr char kLibraries[] = \"${text}\";")
endfunction()
