# Dependencies of Sheaf, as imported targets.
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(TBB CONFIG REQUIRED)
find_package(Imath CONFIG REQUIRED QUIET)
find_package(OpenEXR CONFIG REQUIRED QUIET)
find_package(OpenImageIO MODULE REQUIRED)
find_package(OpenColorIO MODULE QUIET)  # optional, for views of --ocio-config
find_package(Embree MODULE REQUIRED)
find_package(xsimd MODULE REQUIRED)
find_package(NanoVDB MODULE REQUIRED)
find_package(TinyGLTF MODULE REQUIRED)
find_package(Draco MODULE QUIET)  # optional, for compressed meshes in glTF files
find_package(Meshoptimizer MODULE QUIET)  # likewise
find_package(Assimp MODULE QUIET)  # optional, for .dae, .fbx and .3ds models
find_package(OpenVDB MODULE QUIET)  # optional, for the tool vdb_to_nanovdb
find_package(pugixml CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(Microhttpd MODULE REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
