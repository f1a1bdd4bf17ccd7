# The project's own CMake words. Sources are always listed, never globbed.

add_library(skyquilt_flags INTERFACE)
target_include_directories(skyquilt_flags INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(skyquilt_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
if(SKYQUILT_SANITIZE OR SKYQUILT_FUZZ)
  # Under ASan Eigen's headers allocate in another way than in the Ceres library, which is not instrumented and shares
  # templates with us: what one allocated the other would free. ASan's malloc aligns to 16 bytes as well.
  target_compile_definitions(skyquilt_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
if(SKYQUILT_SANITIZE)
  # What asks of each pointer whether it may be followed is left to ASan and to the fuzz targets, which are built with
  # all: through Eigen's templates it was four tenths of the compiler's time (poses 154 CPU-s, 86 without).
  target_compile_options(skyquilt_flags INTERFACE
    -fsanitize=${SKYQUILT_SANITIZE} -fno-sanitize=null,alignment,object-size,pointer-overflow,vptr
    -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(skyquilt_flags INTERFACE -fsanitize=${SKYQUILT_SANITIZE})
endif()
if(SKYQUILT_FUZZ)
  target_compile_options(skyquilt_flags INTERFACE -fsanitize=fuzzer-no-link,address,undefined)
  target_link_options(skyquilt_flags INTERFACE -fsanitize=address,undefined)
endif()
if(SKYQUILT_TIDY)
  set(CMAKE_CXX_CLANG_TIDY clang-tidy)
endif()

set_property(GLOBAL PROPERTY SKYQUILT_HEADERS "")

# skyquilt_unity(target is_large): where SKYQUILT_UNITY is on, the target's sources are compiled as one, those of a large
# target as one for each folder, so that what they include is read once. Sources with compile options of their own stay by
# themselves (CMake sees to that). Private names of what is compiled as one must differ, which
# tests/architecture/unity_names.py holds in every configuration.
function(skyquilt_unity target is_large)
  if(NOT SKYQUILT_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    if(NOT is_large)
      set(folder all)
    elseif(IS_ABSOLUTE ${source})
      set(folder embedded)
    endif()
    string(MAKE_C_IDENTIFIER "in_${folder}" group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)  # sources look like headers to it
  endif()
endfunction()

# skyquilt_read_once(target HEADERS names... DEPS targets... OPTIONS ...): the standard library and Eigen are nine tenths of
# the text that a unity source includes: they and HEADERS, which come with DEPS, are read once for all targets of the same
# OPTIONS. Sources include what they use all the same: where SKYQUILT_UNITY is off each is read by itself, and by clang,
# which refuses what was precompiled before a file's present time, as a compiler's cache gives it.
function(skyquilt_read_once target)
  cmake_parse_arguments(ARG "" "" "HEADERS;DEPS;OPTIONS" ${ARGN})
  if(NOT SKYQUILT_UNITY OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  string(MAKE_C_IDENTIFIER "skyquilt_read_once_${ARG_DEPS}${ARG_OPTIONS}" headers)
  if(NOT TARGET ${headers})
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/nothing.cc CONTENT "")
    add_library(${headers} OBJECT ${CMAKE_BINARY_DIR}/nothing.cc)
    target_link_libraries(${headers} PRIVATE skyquilt_flags Eigen3::Eigen ${ARG_DEPS})
    target_compile_options(${headers} PRIVATE ${ARG_OPTIONS})
    target_precompile_headers(${headers} PRIVATE <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <filesystem>
      <fstream> <functional> <map> <memory> <mutex> <optional> <set> <span> <string> <string_view> <thread> <utility>
      <vector> <Eigen/Core> ${ARG_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
endfunction()

# skyquilt_optimise(target options...): with these where users run it, and with headers read once.
function(skyquilt_optimise target)
  if(NOT CMAKE_BUILD_TYPE STREQUAL "Release")
    set(ARGN)
  endif()
  target_compile_options(${target} PRIVATE ${ARGN})
  skyquilt_read_once(${target} OPTIONS ${ARGN})
endfunction()

# skyquilt_library(name [LARGE] [COLD | PIXELS] SOURCES a.cc ... [HOT b.cc ... [HOT_OPTIONS ...]] HEADERS a.h ...
# DEPS public... PRIVATE_DEPS private...)
# A COLD library has no loop that a user waits for (texts, documents, options, statements): -Og compiles it in half the time.
# One of PIXELS is loops over pixels or cells: -O3 makes vector instructions of them. HOT: sources apart from the others,
# which every tile, point or pixel runs through.
function(skyquilt_library name)
  cmake_parse_arguments(ARG "LARGE;COLD;PIXELS" "" "SOURCES;HOT;HOT_OPTIONS;HEADERS;DEPS;PRIVATE_DEPS" ${ARGN})
  if(ARG_HOT)
    add_library(${name}_hot OBJECT ${ARG_HOT})
    target_link_libraries(${name}_hot PRIVATE skyquilt_flags ${ARG_DEPS} ${ARG_PRIVATE_DEPS})
    skyquilt_unity(${name}_hot FALSE)
    if(ARG_HOT_OPTIONS)
      target_compile_options(${name}_hot PRIVATE ${ARG_HOT_OPTIONS})
    else()
      skyquilt_optimise(${name}_hot)
    endif()
    list(APPEND ARG_SOURCES $<TARGET_OBJECTS:${name}_hot>)
  endif()
  if(ARG_SOURCES)
    add_library(${name} STATIC ${ARG_SOURCES} ${ARG_HEADERS})
    target_link_libraries(${name} PUBLIC skyquilt_flags ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
    skyquilt_unity(${name} ${ARG_LARGE})
    if(ARG_COLD)
      skyquilt_optimise(${name} -Og)
    elseif(ARG_PIXELS)
      target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O3>)
    else()
      skyquilt_optimise(${name})
    endif()
  else()
    add_library(${name} INTERFACE ${ARG_HEADERS})
    target_link_libraries(${name} INTERFACE skyquilt_flags ${ARG_DEPS})
  endif()
  foreach(header ${ARG_HEADERS})
    set_property(GLOBAL APPEND PROPERTY SKYQUILT_HEADERS "${name}|${CMAKE_CURRENT_SOURCE_DIR}/${header}")
  endforeach()
endfunction()

# skyquilt_test(name SOURCES ... DEPS ... LABELS ... [TIMEOUT seconds] [SHARDS n] [LONG "Suite.Case:Suite.*"])
# One program a folder, and one test of ctest for all its cases, SHARDS tests where that would keep one core busy for long.
# The cases of LONG are no part of the short suite: they are the test NAME.long, labelled long. Where SKYQUILT_UNITY is on, a
# few sources are compiled as one: most of the time of each goes into reading the same headers.
function(skyquilt_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT;SHARDS;LONG" "SOURCES;DEPS;LABELS" ${ARGN})
  if(NOT SKYQUILT_TESTS)
    return()
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 1800)
  endif()
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE skyquilt_flags ${ARG_DEPS} GTest::gmock GTest::gtest GTest::gtest_main)
  set(options)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    # Assertions expand to much that runs once. A test that fails is looked into in another build.
    set(options -Og)
  endif()
  target_compile_options(${name} PRIVATE ${options})
  skyquilt_read_once(${name} HEADERS <gmock/gmock.h> <gtest/gtest.h> DEPS GTest::gmock OPTIONS ${options})
  if(SKYQUILT_UNITY)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
  endif()
  if("concurrency" IN_LIST ARG_LABELS)
    if(NOT TARGET skyquilt_concurrency_tests)
      add_custom_target(skyquilt_concurrency_tests)  # what ThreadSanitizer is built for
    endif()
    add_dependencies(skyquilt_concurrency_tests ${name})
  endif()
  if(ARG_LONG)
    add_test(NAME ${name}.long COMMAND ${name} --gtest_filter=${ARG_LONG})
    set_tests_properties(${name}.long PROPERTIES TIMEOUT 3600 LABELS "${ARG_LABELS};long"
      FAIL_REGULAR_EXPRESSION "Running 0 tests")  # LONG names what is not there
  endif()
  set(only)
  if(ARG_LONG)
    set(only --gtest_filter=-${ARG_LONG})
  endif()
  foreach(shard RANGE 1 ${ARG_SHARDS})
    set(test ${name})
    set(environment)
    if(ARG_SHARDS GREATER 1)
      set(test ${name}.${shard})
      math(EXPR index "${shard} - 1")
      set(environment "GTEST_TOTAL_SHARDS=${ARG_SHARDS};GTEST_SHARD_INDEX=${index}")
    endif()
    add_test(NAME ${test} COMMAND ${name} ${only})
    set_tests_properties(${test} PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}" ENVIRONMENT "${environment}")
  endforeach()
endfunction()

# skyquilt_bench(name SOURCES ... DEPS ...)
function(skyquilt_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  if(NOT SKYQUILT_BENCH)
    return()
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE skyquilt_flags ${ARG_DEPS} benchmark::benchmark)
endfunction()

# skyquilt_fuzz(name SOURCE fuzz.cc DEPS ...): a libFuzzer program (preset fuzz) built with clang, one of skyquilt_fuzz_targets. The
# server itself is no part of those: its coroutines are more than clang 14 and Debian's Boost can do together.
function(skyquilt_fuzz name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  if(NOT SKYQUILT_FUZZ)
    return()
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE skyquilt_flags ${ARG_DEPS})
  target_link_options(${name} PRIVATE -fsanitize=fuzzer)
  if(NOT TARGET skyquilt_fuzz_targets)
    add_custom_target(skyquilt_fuzz_targets)
  endif()
  add_dependencies(skyquilt_fuzz_targets ${name})
endfunction()

# Compiles each header on its own, so that none leans on what another includes.
function(skyquilt_check_all_headers)
  get_property(entries GLOBAL PROPERTY SKYQUILT_HEADERS)
  set(i 0)
  foreach(entry ${entries})
    string(REPLACE "|" ";" pair "${entry}")
    list(GET pair 0 library)
    list(GET pair 1 header)
    set(file ${CMAKE_BINARY_DIR}/header_checks/check_${i}.cc)
    file(WRITE ${file} "#include \"${header}\"\n#include \"${header}\"\n")
    add_library(header_check_${i} OBJECT ${file})
    target_link_libraries(header_check_${i} PRIVATE ${library} skyquilt_flags)
    math(EXPR i "${i}+1")
  endforeach()
endfunction()
