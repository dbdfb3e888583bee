# cmake --install, the package Kedge for find_package(), and a Debian package: cpack -G DEB in the build folder.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(data ${CMAKE_INSTALL_DATADIR}/kedge)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Kedge)

install(TARGETS kedge kedge-replay RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# The tools in Python find their modules, the scenes and mpirun beside their own files.
install(DIRECTORY python prm DESTINATION ${data} USE_SOURCE_PERMISSIONS
        PATTERN __pycache__ EXCLUDE PATTERN tests EXCLUDE)
install(PROGRAMS scripts/mpirun DESTINATION ${data}/scripts)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/links)
file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/kedge/python)
foreach(tool kedge-plot kedge-study kedge-draw)
  file(CREATE_LINK ${from_bin}/${tool} ${PROJECT_BINARY_DIR}/links/${tool} SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/links/${tool} DESTINATION ${CMAKE_INSTALL_BINDIR})
endforeach()
install(DIRECTORY doc/ DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES README.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

# The rooms as Kedge::simulation, Kedge::output ..., each with the rooms that it builds on.
install(DIRECTORY include/kedge DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
get_property(rooms GLOBAL PROPERTY KEDGE_ROOMS)
foreach(room ${rooms})
  set_target_properties(kedge_${room} PROPERTIES EXPORT_NAME ${room})
  install(TARGETS kedge_${room} EXPORT Kedge ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endforeach()
install(TARGETS kedge_options trilinos deal.II UMFPACK muparser_if_there EXPORT Kedge)
install(EXPORT Kedge NAMESPACE Kedge:: DESTINATION ${package} FILE KedgeTargets.cmake)
configure_package_config_file(cmake/KedgeConfig.cmake.in ${PROJECT_BINARY_DIR}/KedgeConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/KedgeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/KedgeConfig.cmake ${PROJECT_BINARY_DIR}/KedgeConfigVersion.cmake
        DESTINATION ${package})

set(CPACK_PACKAGE_VENDOR "the authors of Kedge")
set(CPACK_PACKAGE_CONTACT "the authors of Kedge <kedge@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Material point method for anchors, plates and cones in soil")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS
    "openmpi-bin, python3-numpy, python3-scipy, python3-matplotlib, python3-pil, python3-jsonschema")
# Programs that link Kedge need these.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "libdeal.ii-dev, libtrilinos-tpetra-dev, libtrilinos-belos-dev, libtrilinos-muelu-dev, libtrilinos-ifpack2-dev, \
libtrilinos-amesos2-dev, libtrilinos-kokkos-dev, libsuitesparse-dev, libopenmpi-dev, libeigen3-dev, \
nlohmann-json3-dev, libcli11-dev, libfmt-dev, libcgal-dev, zlib1g-dev")
set(CPACK_STRIP_FILES ON)
include(CPack)
