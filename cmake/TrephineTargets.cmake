# Options and functions for the compilation of this project.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(TREPHINE_CCACHE ccache)
if(TREPHINE_CCACHE)
  set(CMAKE_C_COMPILER_LAUNCHER ${TREPHINE_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TREPHINE_CCACHE})
endif()

add_library(trephine_flags INTERFACE)
# Same bits on every compiler: no fused multiply-add, no reordering.
target_compile_options(trephine_flags INTERFACE -Wall -Wextra -Wpedantic -Wconversion -ffp-contract=off
                       $<$<BOOL:${TREPHINE_WARNINGS_AS_ERRORS}>:-Werror>)
target_compile_definitions(trephine_flags INTERFACE $<$<BOOL:${TREPHINE_ASSERTS}>:TREPHINE_ASSERTS>)
if(TREPHINE_SANITIZE)
  # g++ 12 with sanitizers reports uninitialized values that do not exist.
  target_compile_options(trephine_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_compile_options(-fsanitize=${TREPHINE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TREPHINE_SANITIZE})
endif()

# Calls within a library are direct, so that a shared library costs the servo nothing.
add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fno-semantic-interposition>)

# An installed program finds its libraries by a path relative to itself, at any prefix.
set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR};$ORIGIN")

# trephine_library(NAME SOURCES ... [FRONT ...] [HEADERS ...] [SHARED ...] [USES public targets] [LINKS private targets] [PACKAGE library|command])
# With PACKAGE it is installed: shared (unless BUILD_SHARED_LIBS is off), with its public headers in the package dev:
#   FRONT    for programs, included as <trephine/HEADER>, here and installed
#   HEADERS  for modules and devices, and all that FRONT needs
#   SHARED   not installed, for the other libraries of this tree
# Other headers are private to the library. A test enforces these lists.
function(trephine_library name)
  cmake_parse_arguments(arg "" "PACKAGE" "SOURCES;FRONT;HEADERS;SHARED;USES;LINKS" ${ARGN})
  if(arg_PACKAGE)
    add_library(trephine_${name} ${arg_SOURCES})
  else()
    add_library(trephine_${name} STATIC ${arg_SOURCES})
  endif()
  add_library(trephine::${name} ALIAS trephine_${name})
  set_target_properties(trephine_${name} PROPERTIES
    POSITION_INDEPENDENT_CODE ON
    OUTPUT_NAME trephine-${name}
    EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}) # before 1.0 every minor version may break
  target_compile_features(trephine_${name} PUBLIC cxx_std_20)
  target_include_directories(trephine_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/trephine>)
  target_link_libraries(trephine_${name} PUBLIC ${arg_USES} PRIVATE $<BUILD_INTERFACE:trephine_flags> ${arg_LINKS})
  if(arg_FRONT)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    foreach(header ${arg_FRONT})
      file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/include/trephine/${header} CONTENT "#include \"${folder}/${header}\"\n")
    endforeach()
    target_include_directories(trephine_${name} PUBLIC
      $<BUILD_INTERFACE:${CMAKE_CURRENT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  endif()
  if(arg_PACKAGE)
    install(TARGETS trephine_${name} EXPORT trephine-${name}
      LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${arg_PACKAGE} NAMELINK_COMPONENT dev
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
    install(EXPORT trephine-${name} NAMESPACE trephine:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/trephine COMPONENT dev)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    foreach(header ${arg_HEADERS})
      cmake_path(GET header PARENT_PATH within)
      install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/trephine/${folder}/${within} COMPONENT dev)
    endforeach()
    foreach(header ${arg_FRONT})
      install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/trephine COMPONENT dev)
    endforeach()
  endif()
endfunction()

# trephine_compile_fast(TARGET): less optimization, for code whose compilation takes longer than its execution.
function(trephine_compile_fast target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# trephine_compile_in_batches(TARGET): compiles several source files in one step. Most of the time of these files is
# spent on headers and templates, which a batch compiles once. Names at namespace scope must be unique in a target.
function(trephine_compile_in_batches target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${TREPHINE_BATCHES} UNITY_BUILD_BATCH_SIZE 8)
endfunction()

# Timeout of a test, s. A test that passes takes less even on a loaded machine.
set(trephine_test_patience 1500)

# trephine_test(NAME SOURCES ... [LINKS targets] [REALTIME filter]): one GoogleTest program; each case is a test
# of ctest. Cases that match REALTIME depend on the clock and run one at a time.
function(trephine_test name)
  cmake_parse_arguments(arg "" "REALTIME" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_LINKS} trephine_flags GTest::gtest_main)
  trephine_compile_fast(${name})
  trephine_compile_in_batches(${name})
  if(arg_REALTIME)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_FILTER "${arg_REALTIME}" TEST_LIST ${name}_realtime
      PROPERTIES TIMEOUT ${trephine_test_patience} RESOURCE_LOCK clock)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_FILTER "-${arg_REALTIME}" PROPERTIES TIMEOUT ${trephine_test_patience})
  else()
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${trephine_test_patience})
  endif()
endfunction()
