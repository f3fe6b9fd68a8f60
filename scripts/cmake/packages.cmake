# Debian packages: `cpack` in a build tree of the release preset. omni: programs, scenes, page, unit, rule, manual pages,
# completions, documents; openxr-layer-omni: the layer, which applications request by name; libomni-dev: headers.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME omni)
set(CPACK_PACKAGE_VENDOR Omni)
set(CPACK_PACKAGE_CONTACT "The Omni authors <omni@localhost.invalid>")
set(CPACK_PACKAGE_HOMEPAGE_URL "")
set(CPACK_STRIP_FILES ON)
# The unit names its folder, which is not the one that packages are made in.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL omni layer dev)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
    WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS OFF)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(debian ${omni_SOURCE_DIR}/manifests/debian)
set(CPACK_DEBIAN_OMNI_PACKAGE_NAME omni)
set(CPACK_DEBIAN_OMNI_PACKAGE_SECTION electronics)
set(CPACK_DEBIAN_OMNI_PACKAGE_RECOMMENDS openxr-layer-omni)
set(CPACK_COMPONENT_OMNI_DESCRIPTION "magnetic haptics for OpenXR: service and tools
Omni tracks a pen that contains nothing but a magnet, and pushes and pulls it,
by the field of one desktop base. This package has the service omnid, the
command line omni with a live page for the browser, a digital twin that
simulates a base, example scenes, and the rule that gives the person at the
computer access to a base on USB. Try it without hardware: omni try.")
set(CPACK_DEBIAN_OMNI_PACKAGE_CONTROL_EXTRA ${debian}/omni/postinst)
set(CPACK_DEBIAN_LAYER_PACKAGE_NAME openxr-layer-omni)
set(CPACK_DEBIAN_LAYER_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LAYER_PACKAGE_RECOMMENDS "omni (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_LAYER_DESCRIPTION "magnetic haptics for OpenXR: API layer
With this API layer an OpenXR application sees the pen of Omni as an ordinary
tracked controller with buttons, thumbstick and haptics. Applications get it
when they request XR_APILAYER_OMNI_stylus, or, for one user, after
'omni layer enable'; installing it enables it for nobody.")
set(CPACK_DEBIAN_LAYER_PACKAGE_CONTROL_EXTRA ${debian}/layer/prerm)
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libomni-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS libopenxr-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS openxr-layer-omni)
set(CPACK_COMPONENT_DEV_DESCRIPTION "magnetic haptics for OpenXR: headers of the extensions
C headers of the OpenXR extensions of Omni: forces and constraints, haptic
scenes from glTF documents, the pen's inputs; and the sources of examples.")

# What a package must have, and a build without npm or scdoc has not.
set(OMNI_PACKAGED_FILES
    "${CMAKE_BINARY_DIR}/share/omni/page/page.js|npm|the page of omni try and omni monitor"
    "${OMNI_PAGES}/man/omni.1.gz|scdoc|the manual pages")
configure_file(${CMAKE_CURRENT_LIST_DIR}/packaged_files.cmake.in ${CMAKE_BINARY_DIR}/packaged_files.cmake @ONLY)
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_BINARY_DIR}/packaged_files.cmake)

# Files that Debian expects of every package.
string(TIMESTAMP OMNI_PACKAGE_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(row omni:omni layer:openxr-layer-omni dev:libomni-dev)
  string(REPLACE ":" ";" row ${row})
  list(GET row 0 component)
  list(GET row 1 OMNI_PACKAGE)
  set(made ${CMAKE_BINARY_DIR}/debian/${OMNI_PACKAGE})
  configure_file(${debian}/changelog.in ${made}/changelog @ONLY)
  file(ARCHIVE_CREATE OUTPUT ${made}/changelog.gz PATHS ${made}/changelog FORMAT raw COMPRESSION GZip COMPRESSION_LEVEL 9)
  install(FILES ${made}/changelog.gz ${debian}/copyright DESTINATION share/doc/${OMNI_PACKAGE} COMPONENT ${component}
          EXCLUDE_FROM_ALL)
  if(component STREQUAL layer)
    install(FILES ${OMNI_NOTICES} DESTINATION share/doc/${OMNI_PACKAGE} COMPONENT ${component} EXCLUDE_FROM_ALL)
  endif()
  if(EXISTS ${debian}/${component}/lintian-overrides)
    install(FILES ${debian}/${component}/lintian-overrides DESTINATION share/lintian/overrides RENAME ${OMNI_PACKAGE}
            COMPONENT ${component} EXCLUDE_FROM_ALL)
  endif()
endforeach()

include(CPack)
