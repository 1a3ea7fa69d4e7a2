// An arena: one block of memory that is handed out from front to back and freed as a whole.
#pragma once

#include "core/simd/simd.h"

#include <cassert>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>

namespace sheaf {

/// A bump allocator. Every allocation is aligned to kSimdAlignment and lives as long as the arena. The constructing
/// thread zeroes the block, so first touch places its pages in the memory of that thread.
class Arena {
 public:
  explicit Arena(std::size_t bytes) : size_(round_up(bytes)), block_(allocate(size_)) {}

  /// Allocates `count` values of a trivially destructible type. The arena must have room for them.
  template <class T> T* take(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>);
    const std::size_t bytes = round_up(count * sizeof(T));
    assert(used_ + bytes <= size_);
    void* p = block_.get() + used_;
    used_ += bytes;
    return static_cast<T*>(p);
  }

  std::size_t size() const { return size_; }
  /// The whole block, for copying its contents.
  std::span<unsigned char> memory() { return {block_.get(), size_}; }
  std::span<const unsigned char> memory() const { return {block_.get(), size_}; }
  std::size_t used() const { return used_; }

 private:
  struct Free {
    void operator()(unsigned char* p) const { ::operator delete (p, std::align_val_t{kSimdAlignment}); }
  };
  static std::size_t round_up(std::size_t bytes) {
    return (bytes + kSimdAlignment - 1) / kSimdAlignment * kSimdAlignment;
  }
  static unsigned char* allocate(std::size_t bytes) {
    auto* p = static_cast<unsigned char*>(::operator new (bytes, std::align_val_t{kSimdAlignment}));
    std::memset(p, 0, bytes);
    return p;
  }

  std::size_t size_ = 0, used_ = 0;
  std::unique_ptr<unsigned char[], Free> block_;
};

}  // namespace sheaf
