# What the Cortex-M targets share; the files beside this one set INBETWEEN_CPU_FLAGS and include it.
# There is no operating system: the compiler is tested with libraries, because a program needs the start-up
# code and the memory map of a board (examples/firmware).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_CXX_FLAGS_INIT
  # Of std::span by value GCC notes that it is passed otherwise than before GCC 7.1 (psabi). Beside every object a
  # .ci file says who calls whom with how much stack; scripts/measure-budget adds it up.
  # The linker leaves out what is not called.
  "${INBETWEEN_CPU_FLAGS} -mthumb -ffunction-sections -fdata-sections -fno-exceptions -fno-rtti \
-fno-threadsafe-statics -fno-use-cxa-atexit -Wno-psabi -fcallgraph-info=su")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostartfiles -Wl,--gc-sections -Wl,--fatal-warnings")
