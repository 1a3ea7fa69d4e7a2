// Making zlib streams for tests of what reads them.
#pragma once

#include <zlib.h>

#include <string>

namespace sheaf::test {

/// `bytes` as one zlib stream.
inline std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string stream(size, '\0');
  compress2(reinterpret_cast<Bytef*>(stream.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
            static_cast<uLong>(bytes.size()), 9);
  stream.resize(size);
  return stream;
}

}  // namespace sheaf::test
