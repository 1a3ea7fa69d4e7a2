# Finds Assimp: target assimp::assimp.
find_path(Assimp_INCLUDE_DIR assimp/Importer.hpp)
find_library(Assimp_LIBRARY assimp)
mark_as_advanced(Assimp_INCLUDE_DIR Assimp_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Assimp REQUIRED_VARS Assimp_LIBRARY Assimp_INCLUDE_DIR)
if(Assimp_FOUND AND NOT TARGET assimp::assimp)
  add_library(assimp::assimp UNKNOWN IMPORTED)
  set_target_properties(assimp::assimp PROPERTIES
    IMPORTED_LOCATION "${Assimp_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Assimp_INCLUDE_DIR}")
endif()
