# SPDX-License-Identifier: Apache-2.0
# Language level, warnings and sanitizers for everything that is ours.
option(DERMAP_BUILD_TESTS "Build the tests" ON)
option(DERMAP_BUILD_BENCHMARKS "Build the Google Benchmark programs" OFF)
option(DERMAP_BUILD_FUZZERS "Build the libFuzzer programs of tests/fuzz (clang only)" OFF)
option(DERMAP_WERROR "Warnings are errors" ON)
set(DERMAP_SANITIZE "" CACHE STRING "address,undefined | thread | empty")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(dermap_options INTERFACE)
configure_file(${CMAKE_CURRENT_LIST_DIR}/version.h.in ${PROJECT_BINARY_DIR}/generated/common/core/version.h @ONLY)
target_include_directories(dermap_options INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_compile_options(dermap_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor)
if(DERMAP_WERROR)
  target_compile_options(dermap_options INTERFACE -Werror)
endif()
if(DERMAP_SANITIZE)
  target_compile_options(dermap_options INTERFACE -fsanitize=${DERMAP_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(dermap_options INTERFACE -fsanitize=${DERMAP_SANITIZE})
  target_compile_definitions(dermap_options INTERFACE DERMAP_SANITIZED=1)
  # The emulated devices need libumockdev's library to be loaded first: the sanitizer's own must be in the program.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND DERMAP_SANITIZE MATCHES "address")
    target_link_options(dermap_options INTERFACE -static-libasan)
    target_compile_definitions(dermap_options INTERFACE DERMAP_STATIC_ASAN=1)
  endif()
endif()

if(DERMAP_BUILD_FUZZERS)  # everything is instrumented, the programs alone have libFuzzer's main
  target_compile_options(dermap_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# dermap_library(NAME files...): one static library a folder, with our options.
function(dermap_library name)
  add_library(${name} STATIC ${ARGN})
  target_link_libraries(${name} PUBLIC dermap_options)
endfunction()

# dermap_test(NAME files... [SERIAL] LIBS libraries...): one GoogleTest program a folder, its cases registered with
# CTest; SERIAL where they depend on time, so that no other test runs beside them.
function(dermap_test name)
  cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "LIBS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} GTest::gmock GTest::gtest_main)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)  # tests' own code need not be fast
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${ARG_TIMEOUT}
                       RUN_SERIAL ${ARG_SERIAL}
                       WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endfunction()
