# What `cpack` makes in the build folder: three Debian packages with the dependencies their files have, and one archive.
set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_NAME diesink)
set(CPACK_PACKAGE_VENDOR "The diesink authors")
set(CPACK_PACKAGE_CONTACT "The diesink authors <diesink@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION "diesink turns a part program (a base surface with solids added and subtracted) into a die whose
element boundaries stay sharp, writes it for other CAD and CAM tools, plans tool paths over it that do
not gouge, and verifies them.")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGE_CHECKSUM SHA256)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
if(DIESINK_BUILD_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()

# The archive holds everything under one folder; it runs where the libraries it was linked with are.
set(CPACK_ARCHIVE_COMPONENT_INSTALL OFF)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME diesink)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "The command line tool, its manual page and completions.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libdiesink-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers, static libraries and find_package(diesink).")
# What find_package(diesink) looks for.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libeigen3-dev (>= 3.4), libhwy-dev, libdraco-dev, nlohmann-json3-dev, libmeshoptimizer-dev, libpng-dev")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-diesink)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python module diesink, with type stubs.")
if(DIESINK_BUILD_PYTHON)
  # An extension module is for one minor version of the interpreter.
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${next}), python3-numpy")
endif()
include(CPack)
