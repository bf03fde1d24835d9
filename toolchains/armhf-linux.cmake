set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_C_COMPILER arm-linux-gnueabihf-gcc)
set(CMAKE_CXX_COMPILER arm-linux-gnueabihf-g++)
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)  # GCC tells of a change in its version 7
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-arm-static)
set(RELNAV_SYSROOT ${CMAKE_CURRENT_LIST_DIR}/../build/sysroots/armhf-linux CACHE PATH "Libraries and headers of the target")
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
