#pragma once
// Counts what reaches the heap: all forms of operator new, and Eigen's own allocation (checked in release builds too).
// Include it first, before anything of Eigen, and in one file of a program alone: it replaces the allocation functions.
// All of them are replaced, so that new and delete fit together under a sanitizer that has its own; Clang's for threads
// defines them strongly, so its preset links with -z muldefs, where the first definition is the one: this.

#ifdef EIGEN_CORE_H
#error "allocation_counter.hpp comes before any header of Eigen, also a precompiled one: see tests/CMakeLists.txt"
#endif

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace plumbline::test {
inline std::atomic<bool> watching{false};
inline std::atomic<long> allocations{0};
inline void count_allocation() noexcept { allocations += watching ? 1 : 0; }
/// Of an assertion of Eigen that failed, which while f runs is the one about its heap.
inline void eigen_objects() noexcept { watching ? count_allocation() : std::abort(); }
}  // namespace plumbline::test

#define EIGEN_RUNTIME_NO_MALLOC
#define eigen_assert(condition) (static_cast<bool>(condition) ? void() : plumbline::test::eigen_objects())
#include <Eigen/Core>

namespace plumbline::test {

/// How often f allocates.
template <class F>
long allocations_of(F&& f) {
  allocations = 0;
  Eigen::internal::set_is_malloc_allowed(false);
  watching = true;
  f();
  watching = false;
  Eigen::internal::set_is_malloc_allowed(true);
  return allocations;
}

// Not inlined: to the compiler a delete that is free() does not fit its new.
[[gnu::noinline]] inline void* allocate(std::size_t size, std::size_t alignment) noexcept {
  count_allocation();
  return std::aligned_alloc(alignment, (size + alignment) / alignment * alignment);
}
[[gnu::noinline]] inline void* allocate_or_throw(std::size_t size, std::size_t alignment) {
  if (void* const memory = allocate(size, alignment)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] inline void release(void* memory) noexcept { std::free(memory); }
inline constexpr std::size_t plain = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

}  // namespace plumbline::test

void* operator new(std::size_t n) { return plumbline::test::allocate_or_throw(n, plumbline::test::plain); }
void* operator new[](std::size_t n) { return plumbline::test::allocate_or_throw(n, plumbline::test::plain); }
void* operator new(std::size_t n, std::align_val_t a) { return plumbline::test::allocate_or_throw(n, std::size_t(a)); }
void* operator new[](std::size_t n, std::align_val_t a) {
  return plumbline::test::allocate_or_throw(n, std::size_t(a));
}
void* operator new(std::size_t n, const std::nothrow_t&) noexcept {
  return plumbline::test::allocate(n, plumbline::test::plain);
}
void* operator new[](std::size_t n, const std::nothrow_t&) noexcept {
  return plumbline::test::allocate(n, plumbline::test::plain);
}
void* operator new(std::size_t n, std::align_val_t a, const std::nothrow_t&) noexcept {
  return plumbline::test::allocate(n, std::size_t(a));
}
void* operator new[](std::size_t n, std::align_val_t a, const std::nothrow_t&) noexcept {
  return plumbline::test::allocate(n, std::size_t(a));
}
void operator delete(void* p) noexcept { plumbline::test::release(p); }
void operator delete[](void* p) noexcept { plumbline::test::release(p); }
void operator delete(void* p, std::size_t) noexcept { plumbline::test::release(p); }
void operator delete[](void* p, std::size_t) noexcept { plumbline::test::release(p); }
void operator delete(void* p, std::align_val_t) noexcept { plumbline::test::release(p); }
void operator delete[](void* p, std::align_val_t) noexcept { plumbline::test::release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { plumbline::test::release(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { plumbline::test::release(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { plumbline::test::release(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { plumbline::test::release(p); }
void operator delete(void* p, std::align_val_t, const std::nothrow_t&) noexcept { plumbline::test::release(p); }
void operator delete[](void* p, std::align_val_t, const std::nothrow_t&) noexcept { plumbline::test::release(p); }
