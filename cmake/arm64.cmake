# Toolchain for arm64 programs on Debian of another processor, with its multiarch packages (docs/install.md):
#   cmake --preset release -B build/arm64 --toolchain cmake/arm64.cmake -DSKYQUILT_TESTS=OFF -DCMAKE_CXX_COMPILER_LAUNCHER=
# Headers that are the same for all processors lie in /usr/include, libraries and the others below the triplet, where the
# compiler looks by itself. What the build itself runs of the program (manual pages, completions) goes through qemu.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
find_program(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)

# Libraries of this machine's own processor are none of the program's; tools are.
set(CMAKE_SYSTEM_LIBRARY_PATH /usr/lib/${triplet} /lib/${triplet})
set(CMAKE_IGNORE_PREFIX_PATH /usr/local)
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/${triplet}/pkgconfig:/usr/share/pkgconfig)

set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
