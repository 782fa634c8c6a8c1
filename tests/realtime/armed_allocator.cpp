#include "tests/realtime/armed_allocator.hpp"

#include <cerrno>
#include <cstdlib>
#include <stdexcept>

#if defined(__has_feature)
#define INBETWEEN_HAS_FEATURE(feature) __has_feature(feature)
#else
#define INBETWEEN_HAS_FEATURE(feature) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || INBETWEEN_HAS_FEATURE(address_sanitizer)
#define INBETWEEN_ALLOCATOR_HOOKS 1
// As in <sanitizer/allocator_interface.h>, which not every compiler brings along.
extern "C" int __sanitizer_install_malloc_and_free_hooks(  // NOLINT
    void (*malloc_hook)(const volatile void* memory, std::size_t size),
    void (*free_hook)(const volatile void* memory));
#else
#define INBETWEEN_ALLOCATOR_HOOKS 0
#endif

namespace {

// Constant-initialised and of the executable itself: to read them takes no memory.
thread_local bool armed = false;
thread_local std::size_t calls = 0;

void count() {
  if (armed) ++calls;
}

}  // namespace

#if INBETWEEN_ALLOCATOR_HOOKS

namespace {

const bool hooks_installed =
    __sanitizer_install_malloc_and_free_hooks([](const volatile void*, std::size_t) { count(); },
                                              [](const volatile void*) { count(); }) != 0;

}  // namespace

#else

// The names under which glibc keeps its own.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* memory, std::size_t size);            // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT
void __libc_free(void* memory);                                  // NOLINT

void* malloc(std::size_t size) noexcept {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) noexcept {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  count();
  return __libc_realloc(memory, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  count();
  if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) return EINVAL;
  void* const taken = __libc_memalign(alignment, size);
  if (taken == nullptr) return ENOMEM;
  *memory = taken;
  return 0;
}
void free(void* memory) noexcept {
  count();
  __libc_free(memory);
}
}

#endif

namespace inbetween {

ArmedAllocator::ArmedAllocator() {
#if INBETWEEN_ALLOCATOR_HOOKS
  if (!hooks_installed) throw std::logic_error("the address sanitizer takes no hooks");
#endif
  if (armed) throw std::logic_error("the allocator is armed already");
  calls = 0;
  armed = true;
}

ArmedAllocator::~ArmedAllocator() {
  armed = false;
}

std::size_t ArmedAllocator::hits() const {
  return calls;
}

}  // namespace inbetween
