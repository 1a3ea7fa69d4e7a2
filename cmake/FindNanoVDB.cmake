# Finds NanoVDB (headers only): target nanovdb::nanovdb. Links Blosc if it is installed, because some files are
# compressed with it.
find_path(NanoVDB_INCLUDE_DIR nanovdb/NanoVDB.h)
find_path(Blosc_INCLUDE_DIR blosc.h)
find_library(Blosc_LIBRARY blosc)
mark_as_advanced(NanoVDB_INCLUDE_DIR Blosc_INCLUDE_DIR Blosc_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(NanoVDB REQUIRED_VARS NanoVDB_INCLUDE_DIR)
if(NanoVDB_FOUND AND NOT TARGET nanovdb::nanovdb)
  add_library(nanovdb::nanovdb INTERFACE IMPORTED)
  set_target_properties(nanovdb::nanovdb PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${NanoVDB_INCLUDE_DIR}")
  if(Blosc_INCLUDE_DIR AND Blosc_LIBRARY)
    set_target_properties(nanovdb::nanovdb PROPERTIES
      INTERFACE_COMPILE_DEFINITIONS NANOVDB_USE_BLOSC
      INTERFACE_LINK_LIBRARIES "${Blosc_LIBRARY}")
    target_include_directories(nanovdb::nanovdb SYSTEM INTERFACE "${Blosc_INCLUDE_DIR}")
  endif()
endif()
