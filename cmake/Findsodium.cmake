# Find libsodium, which supplies Ed25519 and BLAKE2b: sodium::sodium. The static library is taken, so that a
# product needs none of it. Debian compiles it for programs (-fPIE), which does for a library too as long as
# that keeps the names to itself: --exclude-libs.
find_path(sodium_INCLUDE_DIR sodium.h)
find_library(sodium_STATIC_LIBRARY libsodium.a)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(sodium REQUIRED_VARS sodium_STATIC_LIBRARY sodium_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "Debian: apt-get install libsodium-dev")
if(sodium_FOUND AND NOT TARGET sodium::sodium)
  add_library(sodium::sodium STATIC IMPORTED)
  set_target_properties(sodium::sodium PROPERTIES
    IMPORTED_LOCATION "${sodium_STATIC_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${sodium_INCLUDE_DIR}"
    INTERFACE_LINK_OPTIONS "LINKER:--exclude-libs,libsodium.a")
endif()
mark_as_advanced(sodium_INCLUDE_DIR sodium_STATIC_LIBRARY)
