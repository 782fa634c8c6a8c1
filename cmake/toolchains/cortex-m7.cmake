# Cortex-M7 with the double-precision unit; QEMU's machine mps2-an500.
set(INBETWEEN_CPU_FLAGS "-mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard")
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")
