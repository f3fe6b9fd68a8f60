# What `cmake --install` puts beside the programs, which their own folders install. share/omni is found from the programs
# (service/config/paths.h) and the layer's library from its manifest, so that a prefix may be moved; only the unit names
# its place, since systemd wants it so.
include(GNUInstallDirs)

# The prefix is known when it is installed; "%" has a meaning in units.
set(OMNI_SYSTEMD_USER_DIR lib/systemd/user CACHE STRING "Folder for omnid.service, below the prefix unless absolute")
install(CODE "
  set(unit_folder \"${OMNI_SYSTEMD_USER_DIR}\")
  get_filename_component(prefix \"\${CMAKE_INSTALL_PREFIX}\" ABSOLUTE)
  cmake_path(ABSOLUTE_PATH unit_folder BASE_DIRECTORY \"\${prefix}\")
  string(REPLACE \"%\" \"%%\" OMNI_PROGRAMS \"\${prefix}/bin\")
  configure_file(\"${omni_SOURCE_DIR}/manifests/systemd/omnid.service.in\" \"${CMAKE_BINARY_DIR}/omnid.service\" @ONLY)
  file(INSTALL DESTINATION \"\${unit_folder}\" TYPE FILE FILES \"${CMAKE_BINARY_DIR}/omnid.service\"
       \"${omni_SOURCE_DIR}/manifests/systemd/omnid.socket\")
" COMPONENT omni)

install(FILES LICENSE README.md CHANGELOG.md SECURITY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN man EXCLUDE)
install(DIRECTORY manifests/limits DESTINATION ${CMAKE_INSTALL_DOCDIR}/manifests)
# What of others is compiled into the programs and the layer, in the words of Debian's packages: headers, and the C++
# library in the layer. Shared libraries bring their own.
set(OMNI_NOTICES ${CMAKE_BINARY_DIR}/notices.txt)
set(notices "Compiled into programs and libraries of Omni. What is bundled in the page: share/omni/page/licenses.txt.\n")
file(GLOB boost RELATIVE /usr/share/doc /usr/share/doc/libboost1.*-dev)
foreach(package libeigen3-dev libglm-dev nlohmann-json3-dev libcli11-dev ${boost} libopenxr-dev libspdlog-dev
                libtomlplusplus-dev libstdc++-12-dev)
  if(EXISTS /usr/share/doc/${package}/copyright)
    file(READ /usr/share/doc/${package}/copyright text)
    string(APPEND notices "\n==== ${package} ====\n\n${text}")
  endif()
endforeach()
file(WRITE ${OMNI_NOTICES} "${notices}")
install(FILES CITATION.cff ${OMNI_NOTICES} DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(CODE "
  cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_PREFIX NORMALIZE OUTPUT_VARIABLE prefix)
  set(OMNI_DOCUMENTS \"\$ENV{DESTDIR}\${prefix}/${CMAKE_INSTALL_DOCDIR}\")
  include(\"${omni_SOURCE_DIR}/scripts/cmake/installed_links.cmake\")
")
