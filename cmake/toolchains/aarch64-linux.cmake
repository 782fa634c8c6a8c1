# 64-bit Arm under Linux: a Raspberry Pi. scripts/bootstrap arm64 installs the libraries of the program.
set(INBETWEEN_PROCESSOR aarch64)
set(INBETWEEN_DEBIAN_ARCHITECTURE arm64)
include("${CMAKE_CURRENT_LIST_DIR}/linux-gnu.cmake")
