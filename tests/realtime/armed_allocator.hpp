// Counts the calls of the allocator that the present thread makes while it is armed: operator new and delete
// and the whole malloc family, of whatever library.
//
// The executable that links armed_allocator.cpp has these functions in place of the C library's, to which
// they pass on; in a build with the address sanitizer its own hooks count instead.
#pragma once

#include <cstddef>

namespace inbetween {

class ArmedAllocator {
 public:
  /// Counts from here on, until the object goes. One at a time in a thread.
  ArmedAllocator();
  ~ArmedAllocator();
  ArmedAllocator(const ArmedAllocator&) = delete;
  ArmedAllocator& operator=(const ArmedAllocator&) = delete;

  /// Calls so far: every one that takes memory, gives it back or changes its size.
  std::size_t hits() const;
};

}  // namespace inbetween
