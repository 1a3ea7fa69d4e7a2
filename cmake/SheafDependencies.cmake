# Dependencies of Sheaf, as imported targets.
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(TBB CONFIG REQUIRED)
find_package(Imath CONFIG REQUIRED QUIET)
find_package(OpenEXR CONFIG REQUIRED QUIET)
find_package(PNG 1.6 REQUIRED)
find_package(JPEG REQUIRED)
find_package(TIFF 4.5 REQUIRED)
find_package(WebP MODULE REQUIRED)
find_package(OpenColorIO MODULE QUIET)  # optional, for views of --ocio-config
find_package(Embree MODULE REQUIRED)
find_package(xsimd MODULE REQUIRED)
find_package(NanoVDB MODULE REQUIRED)
find_package(TinyGLTF MODULE REQUIRED)
find_package(tinyobjloader MODULE REQUIRED)
find_package(Draco MODULE QUIET)  # optional, for compressed meshes in glTF files
find_package(Meshoptimizer MODULE QUIET)  # likewise
find_package(Assimp MODULE QUIET)  # optional, for .dae, .fbx, .3ds and .off models
find_package(OpenVDB MODULE QUIET)  # optional, for the tool make_vdb_files, which writes files for tests
find_package(pugixml CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(Microhttpd MODULE REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)

# The Python module is optional. It is built for the interpreter that also runs the tests.
set(SHEAF_HAS_PYTHON_MODULE OFF)
if(SHEAF_BUILD_PYTHON AND NOT SHEAF_FUZZ)
  if(NOT Python_EXECUTABLE AND NOT SKBUILD)
    find_program(SHEAF_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH DOC "Python with Debian's packages")
    set(Python_EXECUTABLE "${SHEAF_PYTHON}")
  endif()
  find_package(Python 3.9 COMPONENTS Interpreter Development.Module QUIET)
  find_package(pybind11 2.10 CONFIG QUIET)
  if(Python_Development.Module_FOUND AND pybind11_FOUND)
    set(SHEAF_HAS_PYTHON_MODULE ON)
  elseif(SKBUILD)
    message(FATAL_ERROR "The Python package needs pybind11 and the headers of Python")
  else()
    message(STATUS "No pybind11 or no headers of Python: the Python module is not built")
  endif()
endif()
