# Builds the images for micro-controllers as a part of the host's build, if there is a cross compiler. Sets
# OMNI_IMAGE_DIR to their folder; empty: none are built.
set(OMNI_FIRMWARE AUTO CACHE STRING "Build firmware images: AUTO (where the tools are), ON (or fail) or OFF")
set_property(CACHE OMNI_FIRMWARE PROPERTY STRINGS AUTO ON OFF)
set(OMNI_IMAGE_DIR "" CACHE INTERNAL "Where the firmware images come; empty: none are built")
if(OMNI_FIRMWARE STREQUAL OFF OR NOT OMNI_HAS_ALL)
  return()
endif()

# The compiler returns the path of a file that it has, and the bare name of one that it lacks.
function(omni_find_cross_tools problem)
  find_program(ARM_CXX arm-none-eabi-g++)
  if(NOT ARM_CXX)
    set(${problem} "there is no arm-none-eabi-g++" PARENT_SCOPE)
    return()
  endif()
  foreach(file nano.specs libstdc++_nano.a)
    execute_process(COMMAND ${ARM_CXX} -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard -print-file-name=${file}
                    OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(NOT IS_ABSOLUTE "${found}")
      set(${problem} "arm-none-eabi-g++ has no ${file}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
  set(${problem} "" PARENT_SCOPE)
endfunction()

omni_find_cross_tools(problem)
if(problem)
  if(OMNI_FIRMWARE STREQUAL ON)
    message(FATAL_ERROR "OMNI_FIRMWARE=ON, but ${problem}: run scripts/setup all")
  endif()
  message(STATUS "No firmware images: ${problem} (scripts/setup all installs what is needed)")
  return()
endif()

set(OMNI_IMAGE_DIR ${CMAKE_BINARY_DIR}/images CACHE INTERNAL "Where the firmware images come")
include(ExternalProject)
ExternalProject_Add(omni_images
  SOURCE_DIR ${omni_SOURCE_DIR}/firmware/board
  BINARY_DIR ${CMAKE_BINARY_DIR}/cross
  PREFIX ${CMAKE_BINARY_DIR}/cross-steps
  CMAKE_ARGS -DCMAKE_TOOLCHAIN_FILE=${omni_SOURCE_DIR}/firmware/board/toolchain-arm.cmake
             -DOMNI_IMAGE_DIR=${OMNI_IMAGE_DIR} -DOMNI_WERROR=${OMNI_WERROR}
  BUILD_ALWAYS ON  # the inner build tracks what is up to date
  INSTALL_COMMAND "")
