# Shared libraries that are loaded when they are first needed. Most commands, and most of the processes that a server starts,
# open no raster, film or exotic picture, and libgdal, libav and OpenCV's codecs bring two hundred libraries along, which cost
# every start a quarter of a second of processor time.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT SKYQUILT_SANITIZE AND NOT SKYQUILT_FUZZ)
  set(SKYQUILT_LATE ON)
  enable_language(ASM)
endif()

# skyquilt_load_late(library DEPS targets... FILES shared libraries...): `library` is compiled against the targets; whoever links
# it gets, in place of the shared libraries, a trampoline for each function that `library` calls (cmake/late). Where there are none
# for the processor, or a sanitizer looks on, the libraries are linked as any.
function(skyquilt_load_late library)
  cmake_parse_arguments(ARG "" "" "DEPS;FILES" ${ARGN})
  if(NOT SKYQUILT_LATE)
    target_link_libraries(${library} PRIVATE ${ARG_DEPS})
    return()
  endif()
  foreach(dependency ${ARG_DEPS})
    target_include_directories(${library} SYSTEM PRIVATE $<TARGET_PROPERTY:${dependency},INTERFACE_INCLUDE_DIRECTORIES>)
    target_compile_definitions(${library} PRIVATE $<TARGET_PROPERTY:${dependency},INTERFACE_COMPILE_DEFINITIONS>)
  endforeach()
  set(trampolines ${CMAKE_CURRENT_BINARY_DIR}/${library}_late.S)
  add_custom_command(OUTPUT ${trampolines}
    COMMAND ${CMAKE_SOURCE_DIR}/cmake/late/trampolines.sh ${trampolines} ${CMAKE_NM} ${CMAKE_READELF} $<TARGET_FILE:${library}> ${ARG_FILES}
    DEPENDS ${library} ${CMAKE_SOURCE_DIR}/cmake/late/trampolines.sh ${CMAKE_SOURCE_DIR}/cmake/late/x86_64.S VERBATIM)
  add_library(${library}_late STATIC ${trampolines})
  target_include_directories(${library}_late PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${library}_late PRIVATE skyquilt_base)
  # By its file: what is compiled against a target waits for all that the target makes by a command, here for `library` compiled.
  target_link_libraries(${library} INTERFACE $<TARGET_FILE:${library}_late> skyquilt_base)
endfunction()
