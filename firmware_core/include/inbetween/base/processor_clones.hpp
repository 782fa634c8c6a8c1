#pragma once

/// INBETWEEN_PROCESSOR_CLONES before a function has it compiled three times: for any x86-64, for one with
/// AVX2 and fused multiply-adds, and for one with AVX-512. The loader of the program takes the best that the
/// processor has. All of them give the same bits: IEEE 754 defines a fused multiply-add, which otherwise is a
/// call of the C library; lanes compute what one number after the other would; and no compiler fuses on its
/// own account (-ffp-contract=off).
///
/// INBETWEEN_PART_OF_CLONES before a function that such a function calls has it compiled with it:
/// left as a call it is compiled for any x86-64.
///
/// Nothing where no loader can choose, as on a microcontroller, or has no choice, and under Clang, which
/// calls the function by another name in other files. Under a sanitizer neither: the choice comes before it
/// is ready.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__AVX512F__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define INBETWEEN_PROCESSOR_CLONES [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#define INBETWEEN_HAS_WIDE_REGISTERS __builtin_cpu_supports("avx2") != 0
#define INBETWEEN_PART_OF_CLONES [[gnu::always_inline]] inline
#else
#define INBETWEEN_PROCESSOR_CLONES
#define INBETWEEN_PART_OF_CLONES
#if defined(__AVX2__)
#define INBETWEEN_HAS_WIDE_REGISTERS true
#else
#define INBETWEEN_HAS_WIDE_REGISTERS false
#endif
#endif

namespace inbetween {

/// Whether several numbers cost less at once than one after the other: not on a microcontroller.
#if defined(__x86_64__) || defined(__aarch64__)
inline constexpr bool lanes_are_quick = true;
#else
inline constexpr bool lanes_are_quick = false;
#endif

/// Whether registers hold 32 bytes where a function with INBETWEEN_PROCESSOR_CLONES runs. Vectors of that
/// size would otherwise live in memory, and take twice as long as those of 16 bytes.
inline bool has_wide_registers() {
  return INBETWEEN_HAS_WIDE_REGISTERS;
}

}  // namespace inbetween
