# What the bare-metal toolchain files share, after they have named processor, flags and MPS2 board (platform/mps2).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_C_FLAGS_INIT "${RELNAV_MACHINE_FLAGS}")
set(CMAKE_CXX_FLAGS_INIT "${RELNAV_MACHINE_FLAGS}")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)  # nothing links without a linker script
set(CMAKE_CROSSCOMPILING_EMULATOR ${CMAKE_CURRENT_LIST_DIR}/qemu-mps2 mps2-${RELNAV_BOARD})
set(ENV{PKG_CONFIG_LIBDIR} ${CMAKE_CURRENT_LIST_DIR}/../build/sysroots/${CMAKE_SYSTEM_PROCESSOR}/lib/pkgconfig)
