# A base without hardware: plant, control core, emulated USB. Without umockdev or libusb there is no plug.
pkg_check_modules(UMOCKDEV IMPORTED_TARGET umockdev-1.0)
pkg_check_modules(LIBUSB IMPORTED_TARGET libusb-1.0)

add_library(omni_hil_chain STATIC chain.cc faulty_link.cc hil_board.cc)
target_link_libraries(omni_hil_chain PUBLIC omni_sim omni_hil_board)
omni_hil_test(faulty_link DEPS omni_hil_chain)
omni_hil_test(chain DEPS omni_hil_chain omni_config)

omni_hil_test(time/virtual_clock DEPS omni_hil_time)
add_dependencies(test_hil_virtual_clock hil_clock_probe omni_virtual_time)

# Not under a sanitizer, which must be the first library of a program, as umockdev must.
if(UMOCKDEV_FOUND AND LIBUSB_FOUND AND NOT OMNI_SANITIZE)
  add_library(omni_hil_usb STATIC usb/usb_descriptors.cc usb/usb_node.cc usb/usb_emulator.cc)
  target_link_libraries(omni_hil_usb PUBLIC omni_hil_chain omni_device omni_wire PRIVATE PkgConfig::UMOCKDEV)
  omni_hil_test(usb/usb_emulator DEPS omni_hil_usb PkgConfig::LIBUSB)

  # omni_hil [options] -- PROGRAM: any program of libusb on the base.
  add_executable(omni_hil hil_main.cc hil_run.cc scenario.cc)
  target_link_libraries(omni_hil PRIVATE omni_hil_usb omni_hil_time omni_config omni_console omni_ipc
                        nlohmann_json::nlohmann_json)
  add_executable(hil_app hil_app.cc)
  target_link_libraries(hil_app PRIVATE omni_client)
  omni_hil_test(scenarios DEPS omni_support omni_hil_board omni_wire nlohmann_json::nlohmann_json)
  add_dependencies(test_hil_scenarios omni_hil omnid hil_app)
  omni_hil_test(calibrate TIMEOUT 300 DEPS omni_support omni_tools nlohmann_json::nlohmann_json)
  add_dependencies(test_hil_calibrate omni_hil omni)

  add_executable(hil_person hil_person.cc)
  target_link_libraries(hil_person PRIVATE omni_support omni_tools)
  target_compile_definitions(hil_person PRIVATE OMNI_BINARY_DIR="${CMAKE_BINARY_DIR}")
  omni_hil_test(setup TIMEOUT 300 WITHOUT HilSetupLong.* DEPS omni_support omni_tools nlohmann_json::nlohmann_json)
  add_dependencies(test_hil_setup omni_hil omni omnid hil_person)
endif()

# omni_deep: a base on a USB port of an emulated computer (scripts/test --deep).
pkg_check_modules(USBREDIR IMPORTED_TARGET libusbredirparser-0.5)
if(USBREDIR_FOUND)
  add_executable(omni_deep deep/deep_main.cc deep/redir_port.cc time/host_process.cc)
  target_link_libraries(omni_deep PRIVATE omni_hil_chain omni_config omni_drivers omni_console PkgConfig::USBREDIR)
endif()
