# Finds tinyobjloader: target tinyobjloader::tinyobjloader, of which only the header is used. scene/formats/obj.cpp compiles
# its implementation, so that functions of the C library can be inlined.
find_path(tinyobjloader_INCLUDE_DIR tiny_obj_loader.h)
mark_as_advanced(tinyobjloader_INCLUDE_DIR)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(tinyobjloader REQUIRED_VARS tinyobjloader_INCLUDE_DIR)
if(tinyobjloader_FOUND AND NOT TARGET tinyobjloader::tinyobjloader)
  add_library(tinyobjloader::tinyobjloader INTERFACE IMPORTED)
  set_target_properties(tinyobjloader::tinyobjloader PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${tinyobjloader_INCLUDE_DIR}")
endif()
