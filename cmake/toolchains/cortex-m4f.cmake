# Cortex-M4 with its single-precision unit; QEMU's machine mps2-an386.
set(INBETWEEN_CPU_FLAGS "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard")
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")
