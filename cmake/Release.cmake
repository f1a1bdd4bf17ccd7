# What users run: one configuration, for run.sh, test.sh, the Docker image and packages alike.
# Include before any target. Optimised, without assert(), and hardened: whatever foreign bytes make a library or us do
# wrong, ends the process instead of running on. Names of functions stay in the program; line tables, a twentieth of the
# build and nine tenths of its objects' bytes, come from building the same commit with -DCMAKE_CXX_FLAGS=-g1: the same code.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_C_FLAGS_RELEASE "-O2 -DNDEBUG")
# The same bytes from any folder, which a compiler's cache can then answer for every clone: unity sources include by
# absolute path, so __FILE__ needs it as much as line tables do.
add_compile_options(-ffile-prefix-map=${CMAKE_SOURCE_DIR}=.)
# A seventh of the compiler's time went into the search of its own memory for what it no longer needs, from 128 MiB on.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(--param=ggc-min-heapsize=1048576)
endif()

# Some eighty programs link the same large archives: gold, of the same binutils, does that in a fifth of the time of bfd.
include(CheckLinkerFlag)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  check_linker_flag(CXX -fuse-ld=gold HAS_GOLD)
  if(HAS_GOLD)
    add_link_options(-fuse-ld=gold)
  endif()
endif()

if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT SKYQUILT_SANITIZE AND NOT SKYQUILT_FUZZ)
  # -U first: some compilers come with a level of their own.
  add_compile_options(-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2 -D_GLIBCXX_ASSERTIONS -fstack-protector-strong -fPIE)
  include(CheckCXXCompilerFlag)
  foreach(flag -fstack-clash-protection -fcf-protection)  # not on every processor
    string(MAKE_C_IDENTIFIER "HAS${flag}" has)
    check_cxx_compiler_flag(${flag} ${has})
    if(${has})
      add_compile_options(${flag})
    endif()
  endforeach()
  add_link_options(-pie -Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack)
endif()
