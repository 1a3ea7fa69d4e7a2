# Installation rules, and the Debian package made from them; see tools/packaging/make_package.sh.

set(SHEAF_PACKAGED_BUILDS "" CACHE STRING
  "Folders with a built program each, named after its -march: installed in place of this one, with a launcher that \
chooses")

# sheaf_install(): installs the program; its manual pages and shell completion, generated from its help; the
# documentation; the example scenes with the scripts that generate the larger ones; and make_cloud, which one of these
# scripts runs.
function(sheaf_install)
  if(SHEAF_HAS_PYTHON_MODULE AND SKBUILD)
    # `pip install .`, which adds the files in Python. The package contains the program and what both load in the folders
    # of an installation.
    install(TARGETS sheaf RUNTIME DESTINATION sheaf/bin COMPONENT python)
    install(PROGRAMS tools/packaging/sheaf_script.py DESTINATION "${SKBUILD_SCRIPTS_DIR}" RENAME sheaf COMPONENT python)
    install(TARGETS sheaf_python_module LIBRARY DESTINATION sheaf/lib/sheaf COMPONENT python)
    if(OpenColorIO_FOUND)
      install(TARGETS sheaf_color_io LIBRARY DESTINATION sheaf/lib/sheaf COMPONENT python)
    endif()
    if(Assimp_FOUND)
      install(TARGETS sheaf_import_model RUNTIME DESTINATION sheaf/lib/sheaf COMPONENT python)
    endif()
    return()
  endif()
  include(GNUInstallDirs)
  if(SHEAF_PACKAGED_BUILDS)
    add_executable(sheaf_launcher EXCLUDE_FROM_ALL tools/packaging/launch.cpp)
    target_link_libraries(sheaf_launcher PRIVATE fmt::fmt-header-only)
    target_compile_options(sheaf_launcher PRIVATE -Wall -Wextra -Wshadow -Werror)
    install(PROGRAMS "$<TARGET_FILE:sheaf_launcher>" DESTINATION bin RENAME sheaf)
    foreach(build IN LISTS SHEAF_PACKAGED_BUILDS)
      cmake_path(GET build FILENAME level)
      install(PROGRAMS "${build}/sheaf" DESTINATION lib/sheaf/${level})
      if(OpenColorIO_FOUND)
        install(FILES "${build}/sheaf_color_io.so" DESTINATION lib/sheaf/${level})
      endif()
      if(Assimp_FOUND)
        install(PROGRAMS "${build}/sheaf_import_model" DESTINATION lib/sheaf/${level})
      endif()
    endforeach()
    # The first build runs on every machine that the package supports.
    list(GET SHEAF_PACKAGED_BUILDS 0 build)
    install(PROGRAMS "${build}/make_cloud" DESTINATION bin)
  else()
    install(TARGETS sheaf make_cloud RUNTIME DESTINATION bin)
    if(OpenColorIO_FOUND)
      install(TARGETS sheaf_color_io LIBRARY DESTINATION lib/sheaf)
    endif()
    if(Assimp_FOUND)
      install(TARGETS sheaf_import_model RUNTIME DESTINATION lib/sheaf)
    endif()
  endif()

  find_program(SHEAF_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH DOC "Python with Debian's packages")
  find_program(SHEAF_PYTHON NAMES python3)
  if(SHEAF_PYTHON)
    set(manual "${PROJECT_BINARY_DIR}/manual")
    add_custom_command(OUTPUT "${manual}/sheaf.fish" DEPENDS sheaf "${PROJECT_SOURCE_DIR}/tools/documentation/make_manual.py"
      COMMAND "${SHEAF_PYTHON}" "${PROJECT_SOURCE_DIR}/tools/documentation/make_manual.py" --sheaf "$<TARGET_FILE:sheaf>"
        --output "${manual}" -- ${CMAKE_CROSSCOMPILING_EMULATOR}
      COMMENT "Writing manual pages and completion" VERBATIM)
    # Only release builds make the manual by default. In sanitizer builds the program would report leaks in libraries.
    set(always "")
    if(CMAKE_BUILD_TYPE MATCHES "^Rel")
      set(always ALL)
    endif()
    add_custom_target(sheaf_manual ${always} DEPENDS "${manual}/sheaf.fish")
    install(DIRECTORY "${manual}/" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" FILES_MATCHING PATTERN "*.1")
    install(FILES "${manual}/sheaf.bash" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions"
      RENAME sheaf OPTIONAL)
    # Debian's zsh reads completions of packages from another folder than locally installed ones.
    set(zsh_folder site-functions)
    if(SHEAF_PACKAGED_BUILDS)
      set(zsh_folder vendor-completions)
    endif()
    install(FILES "${manual}/sheaf.zsh" DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/${zsh_folder}" RENAME _sheaf OPTIONAL)
    install(FILES "${manual}/sheaf.fish" DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d" OPTIONAL)
  else()
    message(STATUS "No python3: neither manual pages nor completion are made")
  endif()

  set(documentation "${CMAKE_INSTALL_DATADIR}/doc/sheaf")
  install(FILES LICENSE DESTINATION "${documentation}" RENAME copyright)
  install(FILES README.md DESTINATION "${documentation}")
  install(DIRECTORY docs DESTINATION "${documentation}")
  set(examples "${CMAKE_INSTALL_DATADIR}/sheaf")
  install(DIRECTORY scenes DESTINATION "${examples}" USE_SOURCE_PERMISSIONS PATTERN generated EXCLUDE
    PATTERN validation EXCLUDE PATTERN make_validation_scenes.py EXCLUDE PATTERN make_cloud.cpp EXCLUDE)

  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_NAME sheaf)
  set(CPACK_PACKAGE_VENDOR "The authors of Sheaf")
  set(CPACK_PACKAGE_CONTACT "The authors of Sheaf <sheaf@localhost>")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "physically based renderer for scenes of Mitsuba, Nori and pbrt")
  set(CPACK_PACKAGE_DESCRIPTION "Sheaf is a data-oriented wavefront path tracer for the CPU. It renders scenes and \
models to OpenEXR and PNG images, on the command line.
The package holds the program for processors with AVX2 and once more for those with AVX-512; which one is used is \
chosen when it starts.")
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_SUGGESTS "bash-completion, python3, python3-numpy")
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
  include(CPack)
endfunction()
