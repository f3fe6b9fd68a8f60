# How everything is compiled and linked, with the programs' place in the build tree.
option(OMNI_WERROR "Warnings are errors" OFF)
option(OMNI_TIDY "Run clang-tidy on our code while compiling" OFF)
option(OMNI_FAST_BUILD "Join sources, precompile headers of libraries; a missing #include shows only without" OFF)
set(OMNI_SANITIZE "" CACHE STRING "Value for -fsanitize= (address,undefined or thread); empty for none")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/archive)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # What ccache asks for where headers are precompiled: https://ccache.dev/manual/4.7.html#_precompiled_headers
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
  if(OMNI_FAST_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-fpch-preprocess)
  endif()
endif()

# Baseline x86-64 (Debian's Ceres fixes Eigen's ABI); contraction off, so that results do not depend on the target.
add_compile_options(-ffp-contract=off -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wconversion -Wno-sign-conversion
                    -Wimplicit-fallthrough -Wold-style-cast -Wno-missing-field-initializers)
if(OMNI_WERROR)
  add_compile_options(-Werror)
endif()

# What makes a mistake in memory end a program instead of handing it over: tests/hardening reads it from the files. Images
# for boards are a project of their own. Sanitizers look for the same themselves, and fortified calls would hide it.
include(CheckPIESupported)
check_pie_supported(LANGUAGES CXX)
add_link_options(-Wl,-z,relro,-z,now,-z,noexecstack)
find_program(MOLD_PROGRAM mold)
if(OMNI_FAST_BUILD AND MOLD_PROGRAM)
  add_link_options(-fuse-ld=mold)
endif()
# Programs hold what they call, and not all of every source that they call something of.
add_compile_options(-ffunction-sections -fdata-sections)
add_link_options(-Wl,--gc-sections,--discard-all)
if(NOT OMNI_SANITIZE)
  add_compile_options(-fstack-protector-strong -fstack-clash-protection
                      "$<$<NOT:$<CONFIG:Debug>>:SHELL:-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2>")
endif()

if(OMNI_SANITIZE)
  # Instrumented code hides from GCC what std::regex has set (its bug 105562); other builds keep that warning.
  add_compile_options(-fsanitize=${OMNI_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all -Wno-maybe-uninitialized)
  add_link_options(-fsanitize=${OMNI_SANITIZE})
endif()
if(OMNI_TIDY)
  find_program(CLANG_TIDY_PROGRAM clang-tidy REQUIRED)
  set(CMAKE_CXX_CLANG_TIDY ${CLANG_TIDY_PROGRAM} --quiet)
endif()
