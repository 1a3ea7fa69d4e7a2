# Finds meshoptimizer: target meshoptimizer::meshoptimizer, with the definition SHEAF_HAS_MESHOPT.
find_path(Meshoptimizer_INCLUDE_DIR meshoptimizer.h)
find_library(Meshoptimizer_LIBRARY meshoptimizer)
mark_as_advanced(Meshoptimizer_INCLUDE_DIR Meshoptimizer_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Meshoptimizer REQUIRED_VARS Meshoptimizer_LIBRARY Meshoptimizer_INCLUDE_DIR)
if(Meshoptimizer_FOUND AND NOT TARGET meshoptimizer::meshoptimizer)
  add_library(meshoptimizer::meshoptimizer UNKNOWN IMPORTED)
  set_target_properties(meshoptimizer::meshoptimizer PROPERTIES
    IMPORTED_LOCATION "${Meshoptimizer_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Meshoptimizer_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS SHEAF_HAS_MESHOPT)
endif()
