#include "tools/importer/glb.h"

#include <fmt/format.h>

#include <cmath>

namespace sheaf::importer {

namespace {

/// Chunks have lengths of 32 bits.
constexpr std::size_t kMaxBuffer = 0xfffffff0u;

std::string number(std::size_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

}  // namespace

int Glb::add_view(const void* bytes, std::size_t size) {
  const std::size_t offset = aligned(buffer_.size());
  if (size > kMaxBuffer || offset > kMaxBuffer - size) throw ImportError("is too large: it has more than 4 GB of data");
  buffer_.resize(offset);
  buffer_.append(static_cast<const char*>(bytes), size);
  return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
}

template <class T>
int Glb::add_values(const std::vector<T>& values, std::size_t count, const char* type, int component_type) {
  const int view = add_view(values.data(), values.size() * sizeof(T));
  return add("accessors", {{"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}});
}

int Glb::add_accessor(const std::vector<float>& values, std::size_t count, const char* type) {
  return add_values(values, count, type, 5126);
}
int Glb::add_accessor(const std::vector<std::uint16_t>& values, std::size_t count, const char* type) {
  return add_values(values, count, type, 5123);
}
int Glb::add_accessor(const std::vector<std::uint32_t>& values, std::size_t count, const char* type) {
  return add_values(values, count, type, 5125);
}

std::string Glb::bytes() {
  buffer_.resize(aligned(buffer_.size()));
  if (!buffer_.empty()) json["buffers"] = {{{"byteLength", buffer_.size()}}};
  std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  text.resize(aligned(text.size()), ' ');
  constexpr std::size_t kHeaders = 12 + 8 + 8;
  if (text.size() + buffer_.size() > kMaxBuffer - kHeaders)
    throw ImportError("is too large: it has more than 4 GB of data");
  std::string out = fmt::format("glTF{}{}", number(2), number(kHeaders + text.size() + buffer_.size()));
  out += fmt::format("{}JSON{}", number(text.size()), text);
  out += number(buffer_.size()) + std::string("BIN\0", 4) + buffer_;
  return out;
}

double finite(double value) {
  if (!std::isfinite(value)) throw ImportError("has a number that is not finite");
  return value;
}

}  // namespace sheaf::importer
