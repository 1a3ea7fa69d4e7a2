// Inflating zlib streams: in pieces, truncated, corrupt, and with the limit on the output size.
#include "core/io/error.h"
#include "core/io/inflate.h"
#include "tests/support/files/deflate.h"

#include <doctest/doctest.h>

#include <random>
#include <string>

namespace sheaf::test_inflate {

using namespace test;

namespace {

std::string random_text(std::size_t size, unsigned letters) {
  std::mt19937 random(5);
  std::string text(size, '\0');
  for (char& c : text) c = static_cast<char>('a' + random() % letters);
  return text;
}

std::string inflated(std::string_view stream, std::size_t most) {
  Inflater inflater(stream);
  std::string out(most, '\0');
  out.resize(inflater.read(out));
  return out;
}

}  // namespace

TEST_CASE("inflate: deflated data are restored in pieces of every size and later bytes are left alone") {
  const std::string text = random_text(20000, 7), stream = deflated(text) + "something else";
  CHECK(inflated(stream, text.size() + 100) == text);
  for (const std::size_t piece : {1u, 7u, 4096u, 19999u}) {
    Inflater inflater(stream);
    std::string out, buffer(piece, '\0');
    for (std::size_t found = piece; found == piece;) {
      CHECK(inflater.max_remaining() >= text.size() - out.size());
      found = inflater.read(buffer);
      out.append(buffer, 0, found);
    }
    CHECK(out == text);
    CHECK(inflater.max_remaining() == 0);
    CHECK(inflater.read(buffer) == 0);
  }
}

TEST_CASE("inflate: the bound holds for the most compressible input") {
  const std::string zeros(10'000'000, '\0'), stream = deflated(zeros);
  CHECK(stream.size() < zeros.size() / 1000);
  CHECK(Inflater(stream).max_remaining() >= zeros.size());
  CHECK(inflated(stream, zeros.size()) == zeros);
}

TEST_CASE("inflate: truncated streams end early and corrupt ones throw") {
  const std::string text = random_text(5000, 26), stream = deflated(text);
  for (std::size_t size = 0; size < stream.size() - 5; size += 97) {
    const std::string found = inflated(stream.substr(0, size), text.size());
    CHECK(found.size() < text.size());
    CHECK(text.starts_with(found));
  }
  CHECK_THROWS_AS(inflated("not a zlib stream", 10), Error);
  std::mt19937 random(3);
  int errors = 0;
  for (int round = 0; round < 200; ++round) {
    std::string broken = stream;
    broken[random() % broken.size()] = static_cast<char>(random());
    try {
      inflated(broken, text.size() + 1);
    } catch (const Error&) { ++errors; }
  }
  CHECK(errors > 100);
}

}  // namespace sheaf::test_inflate
