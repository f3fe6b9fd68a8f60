# One CMake target per module. Includes are written from the repository root ("service/base/vec.h"), so the
# path of an #include names its module; tests/architecture checks every one against the table in
# docs/architecture.md.

# omni_module(NAME [SEPARATE] [DEPS targets...] [PRIVATE targets...]): static library omni_NAME, joined (omni_join), from the
# *.cc of this folder and its sub-folders (main.cc excepted); header-only folders become interface libraries. PRIVATE:
# libraries that stay behind our headers. SEPARATE: not joined, for sources full of Eigen's expressions, which gain nothing.
function(omni_module name)
  cmake_parse_arguments(ARG "SEPARATE" "EXCLUDE" "DEPS;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  list(FILTER sources EXCLUDE REGEX "main\\.cc$")
  if(ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX "${ARG_EXCLUDE}")
  endif()
  if(sources)
    add_library(omni_${name} STATIC ${sources})
    target_include_directories(omni_${name} PUBLIC ${omni_SOURCE_DIR})
    target_link_libraries(omni_${name} PUBLIC ${ARG_DEPS} PRIVATE ${ARG_PRIVATE})
    if(NOT ARG_SEPARATE)
      omni_join(omni_${name})
    endif()
  else()
    add_library(omni_${name} INTERFACE)
    target_include_directories(omni_${name} INTERFACE ${omni_SOURCE_DIR})
    target_link_libraries(omni_${name} INTERFACE ${ARG_DEPS})
  endif()
endfunction()

# omni_join(TARGET): in fast builds its sources compile sixteen at a time, for most of their time goes to the same headers.
# Names in their unnamed namespaces must differ; tests have a namespace of their own each, test_ and the file's name.
function(omni_join target)
  if(OMNI_FAST_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
  endif()
endfunction()

# omni_precompile(TARGET headers...): in fast builds, headers of libraries, never ours; each file goes on including what
# it uses.
function(omni_precompile target)
  if(OMNI_FAST_BUILD)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# Tests with the same definitions share the precompiled headers of test_base, the first of them (benchmarks have none). Their own code
# is a small part of their run time, and at -O2 GCC 12 warns of its own <string> (bug 105651) where it is precompiled; of
# that and of its <regex> (bug 105562) also at -O1 when instrumented.
function(omni_precompile_test target)
  if(NOT OMNI_FAST_BUILD)
    return()
  endif()
  target_compile_options(${target} PRIVATE -O1)
  if(OMNI_SANITIZE)
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow
                           -Wno-maybe-uninitialized)
  endif()
  if(NOT TARGET test_base OR target STREQUAL test_base)
    omni_precompile(${target} <gtest/gtest.h> <Eigen/Dense> <cmath> <filesystem> <random> <string> <vector>)
  else()
    target_precompile_headers(${target} REUSE_FROM test_base)
  endif()
endfunction()

# omni_discover(TARGET PREFIX [VIRTUAL_TIME [EXCEPT suites...]] [WITHOUT suite] [PROPERTIES ...]): registers each test of
# a program with ctest. VIRTUAL_TIME is for tests that start processes and wait for them: they run in virtual time, which
# a busy machine does not stretch (tests/hil/time/virtual_time_main.cc). The suites of EXCEPT run in real time, alone;
# under a sanitizer, which has to be the first library of a program, all of them do. WITHOUT: only people start it.
function(omni_discover target prefix)
  cmake_parse_arguments(ARG "VIRTUAL_TIME" "WITHOUT" "EXCEPT;PROPERTIES" ${ARGN})
  set(real "*")
  if(ARG_VIRTUAL_TIME AND NOT OMNI_SANITIZE)
    list(TRANSFORM ARG_EXCEPT APPEND ".*" OUTPUT_VARIABLE real)
    list(JOIN real ":" real)
    set_target_properties(${target} PROPERTIES CROSSCOMPILING_EMULATOR ${CMAKE_BINARY_DIR}/tests/omni_virtual_time)
    add_dependencies(${target} omni_virtual_time)
    gtest_discover_tests(${target} TEST_PREFIX ${prefix}. DISCOVERY_TIMEOUT 60 TEST_FILTER "-${real}:${ARG_WITHOUT}.*"
                         TEST_LIST ${target}_virtual PROPERTIES ${ARG_PROPERTIES})
    set_target_properties(${target} PROPERTIES CROSSCOMPILING_EMULATOR "")
  endif()
  if(ARG_VIRTUAL_TIME)
    list(APPEND ARG_PROPERTIES RUN_SERIAL TRUE)
  endif()
  if(OMNI_SANITIZE MATCHES thread)  # else every program sleeps a second at its end, and how soon it ends is tested
    list(APPEND ARG_PROPERTIES ENVIRONMENT TSAN_OPTIONS=atexit_sleep_ms=0)
  endif()
  if(real)
    gtest_discover_tests(${target} TEST_PREFIX ${prefix}. DISCOVERY_TIMEOUT 60 TEST_FILTER "${real}-${ARG_WITHOUT}.*"
                         PROPERTIES ${ARG_PROPERTIES})
  endif()
endfunction()

set(OMNI_WITHOUT_TESTS "" CACHE STRING "Names of tests that are left out: scripts/check, of what cannot race")

# omni_test(NAME [FOLDER f] [DEPS targets...] [LABELS ...] [TIMEOUT s] [REAL_TIME] [VIRTUAL_TIME [EXCEPT suites...]]
# [WITHOUT suite]): test_NAME from tests/NAME/*.cc, or tests/f/*.cc. REAL_TIME: needs the time that it takes on a quiet
# machine without sanitizers (scripts/check leaves it out, as what starts real processes). VIRTUAL_TIME, WITHOUT: as
# above.
function(omni_test name)
  cmake_parse_arguments(ARG "REAL_TIME;VIRTUAL_TIME" "TIMEOUT;FOLDER;WITHOUT" "DEPS;LABELS;EXCEPT" ${ARGN})
  if(NOT ARG_FOLDER)
    set(ARG_FOLDER ${name})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${omni_SOURCE_DIR}/tests/${ARG_FOLDER}/*.cc)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  if(name IN_LIST OMNI_WITHOUT_TESTS)
    set_target_properties(test_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  target_link_libraries(test_${name} PRIVATE ${ARG_DEPS} GTest::gtest GTest::gtest_main)
  if(OMNI_SANITIZE MATCHES address)
    target_link_libraries(test_${name} PRIVATE omni_thread_census)
  endif()
  set_target_properties(test_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_compile_definitions(test_${name} PRIVATE OMNI_SOURCE_DIR="${omni_SOURCE_DIR}" OMNI_BINARY_DIR="${CMAKE_BINARY_DIR}")
  omni_precompile_test(test_${name})
  omni_join(test_${name})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)  # it only ends what hangs, also on a busy computer
  endif()
  if(OMNI_SANITIZE)  # it ends what hangs, and ten times slower is not that
    math(EXPR ARG_TIMEOUT "5 * ${ARG_TIMEOUT}")
  endif()
  set(properties TIMEOUT ${ARG_TIMEOUT})
  if(ARG_LABELS)
    list(APPEND properties LABELS "${ARG_LABELS}")
  endif()
  if(NOT ARG_REAL_TIME AND NOT ARG_VIRTUAL_TIME)
    set_property(GLOBAL APPEND PROPERTY OMNI_TIMELESS_TESTS ${name})
  endif()
  if(name IN_LIST OMNI_WITHOUT_TESTS)
    return()
  endif()
  set(time)
  if(ARG_VIRTUAL_TIME)
    set(time VIRTUAL_TIME EXCEPT ${ARG_EXCEPT})
  endif()
  if(ARG_WITHOUT)
    list(APPEND time WITHOUT ${ARG_WITHOUT})
  endif()
  omni_discover(test_${name} ${name} ${time} PROPERTIES ${properties})
endfunction()

# omni_npm(MODULES comment): installs the npm packages that package-lock.json of this folder names, into the build tree.
# MODULES is set to their folder; what needs them depends on ${MODULES}/.installed.
function(omni_npm modules comment)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/node_modules)
  add_custom_command(
    OUTPUT ${folder}/.installed
    COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_CURRENT_SOURCE_DIR}/package.json
            ${CMAKE_CURRENT_SOURCE_DIR}/package-lock.json ${CMAKE_CURRENT_BINARY_DIR}
    COMMAND ${NPM_PROGRAM} ci --ignore-scripts --no-audit --no-fund --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${folder}/.installed
    WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}
    DEPENDS package.json package-lock.json
    COMMENT ${comment})
  set(${modules} ${folder} PARENT_SCOPE)
endfunction()
