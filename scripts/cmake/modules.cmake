# One CMake target per module. Includes are written from the repository root ("service/base/vec.h"), so the
# path of an #include names its module; tests/architecture checks every one against the table in
# docs/architecture.md.

# omni_module(NAME [DEPS targets...] [PRIVATE targets...]): static library omni_NAME from the *.cc of this folder and
# its sub-folders (main.cc excepted); header-only folders become interface libraries. PRIVATE: libraries that stay
# behind our headers.
function(omni_module name)
  cmake_parse_arguments(ARG "" "EXCLUDE" "DEPS;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc ${CMAKE_CURRENT_SOURCE_DIR}/*/*.cc)
  list(FILTER sources EXCLUDE REGEX "main\\.cc$")
  if(ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX "${ARG_EXCLUDE}")
  endif()
  if(sources)
    add_library(omni_${name} STATIC ${sources})
    target_include_directories(omni_${name} PUBLIC ${CMAKE_SOURCE_DIR})
    target_link_libraries(omni_${name} PUBLIC ${ARG_DEPS} PRIVATE ${ARG_PRIVATE})
  else()
    add_library(omni_${name} INTERFACE)
    target_include_directories(omni_${name} INTERFACE ${CMAKE_SOURCE_DIR})
    target_link_libraries(omni_${name} INTERFACE ${ARG_DEPS})
  endif()
endfunction()

# omni_test(NAME [DEPS targets...] [LABELS ...] [TIMEOUT s] [SERIAL]): test_NAME from tests/*/NAME.cc and
# tests/*/NAME_*.cc, registered with ctest test by test. SERIAL: nothing else runs meanwhile.
function(omni_test name)
  cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "DEPS;LABELS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/unit/${name}.cc ${CMAKE_SOURCE_DIR}/tests/unit/${name}_*.cc
       ${CMAKE_SOURCE_DIR}/tests/property/${name}.cc ${CMAKE_SOURCE_DIR}/tests/property/${name}_*.cc
       ${CMAKE_SOURCE_DIR}/tests/scenario/${name}.cc ${CMAKE_SOURCE_DIR}/tests/scenario/${name}_*.cc
       ${CMAKE_SOURCE_DIR}/tests/golden/${name}.cc ${CMAKE_SOURCE_DIR}/tests/golden/${name}_*.cc)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE ${ARG_DEPS} GTest::gtest GTest::gtest_main)
  set_target_properties(test_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_compile_definitions(test_${name} PRIVATE OMNI_SOURCE_DIR="${CMAKE_SOURCE_DIR}" OMNI_BINARY_DIR="${CMAKE_BINARY_DIR}")
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  set(properties TIMEOUT ${ARG_TIMEOUT})
  if(ARG_LABELS)
    list(APPEND properties LABELS "${ARG_LABELS}")
  endif()
  if(ARG_SERIAL)
    list(APPEND properties RUN_SERIAL TRUE)
  endif()
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()
