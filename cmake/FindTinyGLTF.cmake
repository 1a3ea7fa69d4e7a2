# Finds tinygltf: target tinygltf::tinygltf, of which only the header is used. Its shared library also decodes images.
find_path(TinyGLTF_INCLUDE_DIR tiny_gltf.h)
mark_as_advanced(TinyGLTF_INCLUDE_DIR)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(TinyGLTF REQUIRED_VARS TinyGLTF_INCLUDE_DIR)
if(TinyGLTF_FOUND AND NOT TARGET tinygltf::tinygltf)
  add_library(tinygltf::tinygltf INTERFACE IMPORTED)
  set_target_properties(tinygltf::tinygltf PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${TinyGLTF_INCLUDE_DIR}")
endif()
