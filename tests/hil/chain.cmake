# A base without hardware: plant, control core, emulated USB. Without umockdev or libusb there is no such base.
pkg_check_modules(UMOCKDEV IMPORTED_TARGET umockdev-1.0)
pkg_check_modules(LIBUSB IMPORTED_TARGET libusb-1.0)

add_library(omni_hil_link STATIC faulty_link.cc)
target_link_libraries(omni_hil_link PUBLIC omni_base)
omni_hil_test(faulty_link DEPS omni_hil_link)

if(UMOCKDEV_FOUND AND LIBUSB_FOUND)
  add_library(omni_hil_usb STATIC usb_descriptors.cc usb_node.cc usb_emulator.cc)
  target_link_libraries(omni_hil_usb PUBLIC omni_hil_link omni_device omni_wire PRIVATE PkgConfig::UMOCKDEV)
  omni_hil_test(usb_emulator DEPS omni_hil_usb PkgConfig::LIBUSB)
endif()
