# 64-bit RISC-V under Linux.
set(INBETWEEN_PROCESSOR riscv64)
include("${CMAKE_CURRENT_LIST_DIR}/linux-gnu.cmake")
