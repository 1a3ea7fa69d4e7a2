// PLY files in memory, written number by number in every encoding.
#pragma once

#include "scene/formats/mesh_io.h"
#include "tests/support/files/mesh_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

namespace sheaf::ply_files {

/// Reads the bytes of a file; `flip` as of read_ply().
inline MeshFile read(const std::string& bytes, bool flip = false) {
  const test::TemporaryFile file("mesh.ply", bytes);
  return read_ply(file.path(), flip);
}

/// The error message of the bytes of a file; empty if reading succeeds.
inline std::string error_in(const std::string& bytes) {
  return test::error_of([&] { read(bytes); });
}

/// Writes numbers as text or as bytes in one of two byte orders.
class Body {
 public:
  enum class Encoding { kAscii, kLittle, kBig };
  explicit Body(Encoding encoding) : encoding_(encoding) {}

  template <class T> Body& put(T value) {
    if (encoding_ == Encoding::kAscii) {
      text_ += (text_.empty() ? "" : " ") + std::to_string(value);
      return *this;
    }
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    const bool in_roulette = std::endian::native == std::endian::little;
    if (in_roulette != (encoding_ == Encoding::kLittle)) std::reverse(raw.begin(), raw.end());
    text_.append(raw.data(), raw.size());
    return *this;
  }
  const std::string& text() const { return text_; }
  std::string format() const {
    return encoding_ == Encoding::kAscii    ? "format ascii 1.0\n"
           : encoding_ == Encoding::kLittle ? "format binary_little_endian 1.0\n"
                                            : "format binary_big_endian 1.0\n";
  }

 private:
  Encoding encoding_;
  std::string text_;
};

inline constexpr std::array<Body::Encoding, 3> kEncodings{Body::Encoding::kAscii, Body::Encoding::kLittle,
                                                          Body::Encoding::kBig};

/// The header of a file of the given elements.
inline std::string header(const std::string& elements, const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

/// The elements of a file of one triangle, and their rows.
inline const std::string kTriangle =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\n";
inline const std::string kTriangleBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

}  // namespace sheaf::ply_files
