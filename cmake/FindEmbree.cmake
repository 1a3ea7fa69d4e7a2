# Finds Embree 3 or 4: target embree::embree. The definition SHEAF_EMBREE_MAJOR holds the major version.
find_path(Embree_INCLUDE_DIR NAMES embree4/rtcore.h embree3/rtcore.h)
find_library(Embree_LIBRARY NAMES embree4 embree3)
mark_as_advanced(Embree_INCLUDE_DIR Embree_LIBRARY)
if(Embree_LIBRARY MATCHES "embree([34])")
  set(Embree_MAJOR ${CMAKE_MATCH_1})
  set(embree_config "${Embree_INCLUDE_DIR}/embree${Embree_MAJOR}/rtcore_config.h")
  if(EXISTS "${embree_config}")
    file(STRINGS "${embree_config}" embree_version REGEX "define RTC_VERSION_STRING")
    string(REGEX MATCH "[0-9.]+" Embree_VERSION "${embree_version}")
  endif()
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Embree
  REQUIRED_VARS Embree_LIBRARY Embree_INCLUDE_DIR Embree_VERSION VERSION_VAR Embree_VERSION)
if(Embree_FOUND AND NOT TARGET embree::embree)
  add_library(embree::embree UNKNOWN IMPORTED)
  set_target_properties(embree::embree PROPERTIES
    IMPORTED_LOCATION "${Embree_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Embree_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS "SHEAF_EMBREE_MAJOR=${Embree_MAJOR}")
endif()
