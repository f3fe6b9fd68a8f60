# Omni::extensions: the C headers of Omni's OpenXR extensions. The prefix is where this file lies: it may be moved.
get_filename_component(omni_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET Omni::extensions)
  add_library(Omni::extensions INTERFACE IMPORTED)
  set_target_properties(Omni::extensions PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${omni_prefix}/include")
endif()
