# Bare-metal Cortex-M7 with the double-precision FPU: the machine's flags and nothing else.
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(RELNAV_MACHINE_FLAGS "-mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16")
set(RELNAV_BOARD an500)
include(${CMAKE_CURRENT_LIST_DIR}/bare-metal.cmake)
