# What every target of the project shares: the language, the warnings, the sanitizers and the
# floating-point rules.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug or RelWithDebInfo" FORCE)
endif()

find_program(INBETWEEN_CCACHE ccache)
if(INBETWEEN_CCACHE)
  # Without the paths of this checkout in a command another checkout finds what was compiled here. The compiler's list
  # of headers saves a run of the preprocessor for each file.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" CCACHE_DEPEND=1
    "${INBETWEEN_CCACHE}")
endif()

add_library(inbetween_settings INTERFACE)
# Every file in the project is included by its path from the root: "host_tools/plan/plan.hpp".
# The core is included by its public name: "inbetween/path/path.hpp".
target_include_directories(inbetween_settings INTERFACE "${PROJECT_SOURCE_DIR}")
# Under the sanitizers clang compiles the tests, and would warn of every double that an oracle counts on in long double.
set(double_promotion -Wdouble-promotion)
if(INBETWEEN_SANITIZE)
  set(double_promotion "")
endif()
target_compile_options(inbetween_settings INTERFACE
  -Wall -Wextra -Wpedantic -Werror -Wshadow -Wconversion -Wsign-conversion
  ${double_promotion}
  -Wnon-virtual-dtor -Wold-style-cast -Wcast-align -Woverloaded-virtual -Wnull-dereference
  -Wformat=2 -Wimplicit-fallthrough
  # GCC 12 takes any "literal" + std::string for an overlapping copy (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # In a batch (Batches.cmake) GCC takes the unnamed namespace of a source file for that of a header.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>
  # The same move gives the same bits on x86-64, arm64, RISC-V and Cortex-M only if no compiler fuses
  # a multiplication with an addition on its own account, as GCC would on all but the first.
  -ffp-contract=off)
# For x86-64 in general GCC copies a structure in halves of a wide register, and who reads the whole of it waits until
# both are in memory; and it clears and copies some hundred bytes with an instruction that is slow to begin (stop bounds
# took half as long again).
include(CheckCXXCompilerFlag)
set(quick_copies -mmove-max=256 -mstore-max=256 -mmemset-strategy=vector_loop:2048:noalign,libcall:-1:noalign
  -mmemcpy-strategy=vector_loop:2048:noalign,libcall:-1:noalign)
check_cxx_compiler_flag("${quick_copies}" INBETWEEN_QUICK_COPIES)
if(INBETWEEN_QUICK_COPIES)
  target_compile_options(inbetween_settings INTERFACE ${quick_copies})
endif()
if(INBETWEEN_SANITIZE)
  target_compile_options(inbetween_settings INTERFACE
    "-fsanitize=${INBETWEEN_SANITIZE}" -fno-sanitize-recover=all -fno-omit-frame-pointer
    # Sanitizer instrumentation confuses GCC's flow analysis.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-null-dereference$<SEMICOLON>-Wno-maybe-uninitialized>)
  # An index outside a span or a vector is a find, too.
  target_compile_definitions(inbetween_settings INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(inbetween_settings INTERFACE "-fsanitize=${INBETWEEN_SANITIZE}")
endif()
