# What `cmake --install` puts into a prefix, and the package that find_package(diesink) finds there.
include(CMakePackageConfigHelpers)

install(TARGETS diesink RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(TARGETS core formats EXPORT diesink-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/diesink COMPONENT development)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
# Each Debian package carries its own.
foreach(package IN ITEMS "program diesink" "development libdiesink-dev" "python python3-diesink")
  separate_arguments(package)
  list(GET package 0 component)
  list(GET package 1 name)
  if(NOT component STREQUAL "python" OR DIESINK_BUILD_PYTHON)
    install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright COMPONENT ${component})
  endif()
endforeach()

if(NOT CMAKE_CROSSCOMPILING)
  set(pages ${PROJECT_BINARY_DIR}/pages)
  install(FILES ${pages}/diesink.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${pages}/diesink DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
  install(FILES ${pages}/_diesink DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)
  install(FILES ${pages}/diesink.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT program)
endif()

# Where Debian's python3 looks in its /usr; any other prefix needs PYTHONPATH.
if(DIESINK_BUILD_PYTHON)
  set(python_dir lib/python3/dist-packages/diesink)
  install(TARGETS python_module LIBRARY DESTINATION ${python_dir} COMPONENT python)
  install(FILES ${PROJECT_SOURCE_DIR}/python/diesink/__init__.py ${PROJECT_SOURCE_DIR}/python/diesink/__init__.pyi
    ${PROJECT_SOURCE_DIR}/python/diesink/py.typed DESTINATION ${python_dir} COMPONENT python)
endif()

# What the static libraries link besides; a project that links them has to find it.
set(DIESINK_PRIVATE_PACKAGES "hwy draco nlohmann_json meshoptimizer PNG")
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/diesink)
install(EXPORT diesink-targets NAMESPACE diesink:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/diesink-config.cmake.in
  ${PROJECT_BINARY_DIR}/diesink-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/diesink-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/diesink-config.cmake ${PROJECT_BINARY_DIR}/diesink-config-version.cmake
  DESTINATION ${package_dir} COMPONENT development)
