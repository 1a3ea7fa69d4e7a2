// Tables on large pages. Kernels read tables in random order, and with small pages nearly every read of a table of many
// megabytes would also wait for address translation.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace sheaf {

/// An allocator for std::vector. Blocks of at least two large pages (4 MB) are aligned to large pages, and large pages
/// are requested for them. This affects nothing but speed.
template <class T> struct LargePageAllocator {
  using value_type = T;

  LargePageAllocator() = default;
  template <class Other> LargePageAllocator(const LargePageAllocator<Other>&) {}

  T* allocate(std::size_t count) {
    if (count > (std::numeric_limits<std::size_t>::max() / 2 - kPageBytes) / sizeof(T))
      throw std::bad_array_new_length();
    const std::size_t bytes = size_of(count);
    void* const memory = ::operator new(bytes, alignment_of(bytes));
#if defined(__linux__)
    if (is_large(bytes)) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) { ::operator delete(memory, alignment_of(size_of(count))); }
  template <class Other> bool operator==(const LargePageAllocator<Other>&) const { return true; }

 private:
  static constexpr std::size_t kPageBytes = std::size_t{2} << 20;

  static constexpr bool is_large(std::size_t bytes) { return bytes >= 2 * kPageBytes; }
  /// Rounds large blocks up to whole pages.
  static constexpr std::size_t size_of(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    return is_large(bytes) ? (bytes + kPageBytes - 1) / kPageBytes * kPageBytes : bytes;
  }
  static constexpr std::align_val_t alignment_of(std::size_t bytes) {
    return std::align_val_t(is_large(bytes) ? kPageBytes : std::max<std::size_t>(alignof(T), 64));
  }
};

/// A table that may be large and that kernels read in random order. It begins at a cache line.
template <class T> using LargeTable = std::vector<T, LargePageAllocator<T>>;

/// LargePageAllocator for elements that the threads write first: resize() leaves them uninitialized.
template <class T> struct UninitializedLargePageAllocator : LargePageAllocator<T> {
  using LargePageAllocator<T>::LargePageAllocator;
  template <class U> void construct(U* address) { ::new (static_cast<void*>(address)) U; }
  template <class U, class... Arguments> void construct(U* address, Arguments&&... arguments) {
    ::new (static_cast<void*>(address)) U(std::forward<Arguments>(arguments)...);
  }
};
template <class T> using UninitializedLargeTable = std::vector<T, UninitializedLargePageAllocator<T>>;

}  // namespace sheaf
