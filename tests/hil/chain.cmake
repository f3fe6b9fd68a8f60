# A base without hardware: plant, control core, emulated USB. Without umockdev or libusb there is no plug.
pkg_check_modules(UMOCKDEV IMPORTED_TARGET umockdev-1.0)
pkg_check_modules(LIBUSB IMPORTED_TARGET libusb-1.0)

add_library(omni_hil_chain STATIC chain.cc faulty_link.cc hil_board.cc)
target_link_libraries(omni_hil_chain PUBLIC omni_sim omni_hil_board)
omni_hil_test(faulty_link DEPS omni_hil_chain)
omni_hil_test(chain DEPS omni_hil_chain omni_config)

if(UMOCKDEV_FOUND AND LIBUSB_FOUND)
  add_library(omni_hil_usb STATIC usb_descriptors.cc usb_node.cc usb_emulator.cc)
  target_link_libraries(omni_hil_usb PUBLIC omni_hil_chain omni_device omni_wire PRIVATE PkgConfig::UMOCKDEV)
  omni_hil_test(usb_emulator DEPS omni_hil_usb PkgConfig::LIBUSB)

  # omni_hil [options] -- PROGRAM: any program of libusb on the base.
  add_executable(omni_hil hil_main.cc hil_run.cc host_process.cc scenario.cc)
  target_link_libraries(omni_hil PRIVATE omni_hil_usb omni_config CLI11::CLI11 nlohmann_json::nlohmann_json)
  omni_hil_test(scenarios LIVE DEPS omni_tools omni_hil_board omni_wire nlohmann_json::nlohmann_json)
  add_dependencies(test_hil_scenarios omni_hil omnid)
endif()

# omni_deep: a base on a USB port of an emulated computer (scripts/test --deep).
pkg_check_modules(USBREDIR IMPORTED_TARGET libusbredirparser-0.5)
if(USBREDIR_FOUND)
  add_executable(omni_deep deep/deep_main.cc deep/redir_port.cc host_process.cc)
  target_link_libraries(omni_deep PRIVATE omni_hil_chain omni_config omni_drivers CLI11::CLI11 PkgConfig::USBREDIR)
endif()
