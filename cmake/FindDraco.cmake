# Finds Draco: target draco::draco, with the definition SHEAF_HAS_DRACO. Draco's own CMake package may require libraries
# that Sheaf does not use.
find_path(Draco_INCLUDE_DIR draco/compression/decode.h)
find_library(Draco_LIBRARY draco)
mark_as_advanced(Draco_INCLUDE_DIR Draco_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Draco REQUIRED_VARS Draco_LIBRARY Draco_INCLUDE_DIR)
if(Draco_FOUND AND NOT TARGET draco::draco)
  add_library(draco::draco UNKNOWN IMPORTED)
  set_target_properties(draco::draco PROPERTIES
    IMPORTED_LOCATION "${Draco_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Draco_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS SHEAF_HAS_DRACO)
endif()
