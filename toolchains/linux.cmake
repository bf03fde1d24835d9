# What the toolchain files of Linux targets share, after they have named the target's tools. Programs come from the host,
# libraries and headers from build/sysroots/PRESET (toolchains/sysroot.sh) or, with -DRELNAV_SYSROOT=, from an SDK.
set(CMAKE_SYSTEM_NAME Linux)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES RELNAV_SYSROOT)  # CMake's own trials read this file too
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)  # runs under the emulator and on a board without the libraries of this machine

set(CMAKE_FIND_ROOT_PATH ${RELNAV_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_LIBDIR} ${RELNAV_SYSROOT}/lib/pkgconfig)
