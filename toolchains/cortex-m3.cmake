# Bare-metal Cortex-M3, no FPU: the machine's flags and nothing else.
set(CMAKE_SYSTEM_PROCESSOR cortex-m3)
set(RELNAV_MACHINE_FLAGS "-mcpu=cortex-m3 -mthumb")
set(RELNAV_BOARD an385)
include(${CMAKE_CURRENT_LIST_DIR}/bare-metal.cmake)
