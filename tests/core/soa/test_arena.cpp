// The arena: alignment, order of allocations, zero initialization.
#include "core/soa/arena.h"

#include <doctest/doctest.h>

namespace sheaf::test_arena {

TEST_CASE("arena: blocks are aligned and ordered and do not overlap and start as zeros") {
  Arena arena(1000);
  CHECK(arena.size() == 1024);
  CHECK(arena.used() == 0);
  auto* bytes = arena.take<unsigned char>(1);
  CHECK(arena.used() == kSimdAlignment);
  auto* doubles = arena.take<double>(9);
  CHECK(arena.used() == 3 * kSimdAlignment);
  CHECK(reinterpret_cast<std::uintptr_t>(bytes) % kSimdAlignment == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(doubles) % kSimdAlignment == 0);
  CHECK(reinterpret_cast<unsigned char*>(doubles) == bytes + kSimdAlignment);
  for (int i = 0; i < 9; ++i) CHECK(doubles[i] == 0.0);
  auto* rest = arena.take<unsigned char>(arena.size() - arena.used());
  CHECK(arena.used() == arena.size());
  CHECK(rest + 1024 - 3 * kSimdAlignment == bytes + 1024);
}

TEST_CASE("arena: empty blocks take no memory and moving an arena keeps its block") {
  Arena arena(64);
  CHECK(arena.take<float>(0) != nullptr);
  CHECK(arena.used() == 0);
  auto* p = arena.take<int>(16);
  p[15] = 42;
  const Arena moved = std::move(arena);
  CHECK(moved.used() == 64);
  CHECK(p[15] == 42);
}

}  // namespace sheaf::test_arena
