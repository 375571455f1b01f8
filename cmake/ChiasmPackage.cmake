# Debian packages: `cpack -G DEB` in a build tree makes libchiasm0 and libchiasm-dev. The torch backend is not
# among them, for it belongs to a PyTorch that Debian does not have, and the command `chiasm` is in the Python
# package.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME chiasm)
set(CPACK_PACKAGE_VENDOR chiasm)
set(CPACK_PACKAGE_CONTACT "chiasm maintainers <maintainers@chiasm.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(about
  "Computer-vision ops are exported to bundles, which are folders with compiled\ncode or ONNX graphs.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libchiasm0)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA
  "${PROJECT_BINARY_DIR}/debian/shlibs;${PROJECT_BINARY_DIR}/debian/triggers")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
  "runs bundles of computer-vision ops\n${about}\nThis package has the library that runs them, and its backends.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libchiasm-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libchiasm0 (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "runs bundles of computer-vision ops: headers\n${about}\nThis package has what C and C++ programs are built with.")

# What Debian asks of a package: whose it is, and what has changed, in its own form.
set(folder "${PROJECT_BINARY_DIR}/debian")
file(WRITE "${folder}/copyright" "Copyright (C) 2026 the authors of chiasm
License: Apache-2.0, whose text is in /usr/share/common-licenses/Apache-2.0
")
file(WRITE "${folder}/shlibs" "libchiasm ${PROJECT_VERSION_MAJOR} libchiasm0 (>= ${PROJECT_VERSION})\n")
file(WRITE "${folder}/triggers" "activate-noawait ldconfig\n")
file(WRITE "${folder}/changelog" "chiasm (${PROJECT_VERSION}) unstable; urgency=medium

  * CHANGELOG.md of the sources says what has changed.

 -- ${CPACK_PACKAGE_CONTACT}  Thu, 01 Jan 2026 00:00:00 +0000
")
execute_process(COMMAND gzip -9nf "${folder}/changelog" COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN ITEMS runtime development)
  string(TOUPPER ${component} name)
  install(FILES "${folder}/copyright" "${folder}/changelog.gz" COMPONENT ${component}
    DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${name}_PACKAGE_NAME}")
endforeach()

include(CPack)
