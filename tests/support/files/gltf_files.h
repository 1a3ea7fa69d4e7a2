// Small glTF files for tests.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace sheaf::test {

/// A glTF document with one buffer. Members of `json` may be set freely.
class GltfBuilder {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};

  /// Appends bytes, aligned to four, as a buffer view and returns its index.
  int add_view(const void* bytes, std::size_t size) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    const std::size_t offset = buffer_.size();
    buffer_.append(static_cast<const char*>(bytes), size);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }

  /// Adds an accessor with all of `values` and returns its index.
  template <class T> int add(const std::vector<T>& values, const char* type, bool normalized = false) {
    const std::size_t components = components_of(type);
    nlohmann::json accessor = {{"bufferView", add_view(values.data(), values.size() * sizeof(T))},
                               {"componentType", component_type<T>()},
                               {"count", values.size() / components},
                               {"type", type}};
    if (normalized) accessor["normalized"] = true;
    json["accessors"].push_back(accessor);
    return static_cast<int>(json["accessors"].size()) - 1;
  }

  /// Adds a mesh with one primitive and returns the primitive.
  nlohmann::json& add_mesh(const nlohmann::json& attributes) {
    json["meshes"].push_back({{"primitives", {{{"attributes", attributes}}}}});
    return json["meshes"].back()["primitives"][0];
  }

  /// A triangle (0, 0, 0), (1, 0, 0), (0, 1, 0) in a node without transform.
  nlohmann::json& add_triangle() {
    nlohmann::json& primitive = add_mesh({{"POSITION", add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}});
    json["nodes"].push_back({{"mesh", json["meshes"].size() - 1}});
    return primitive;
  }

  /// The document with its buffer as a data URI.
  std::string text() const {
    nlohmann::json document = json;
    document["buffers"] = {
        {{"byteLength", buffer_.size()}, {"uri", "data:application/octet-stream;base64," + base64()}}};
    if (buffer_.empty()) document.erase("buffers");
    return document.dump(1);
  }

  /// The document in a binary container.
  std::string binary() const {
    nlohmann::json document = json;
    document["buffers"] = {{{"byteLength", buffer_.size()}}};
    std::string head = document.dump(), body = buffer_;
    head.resize((head.size() + 3) / 4 * 4, ' ');
    body.resize((body.size() + 3) / 4 * 4);
    const std::size_t size = 12 + 8 + head.size() + 8 + body.size();
    return "glTF" + number(2) + number(size) + number(head.size()) + "JSON" + head + number(body.size()) +
           std::string("BIN\0", 4) + body;
  }

 private:
  static std::size_t components_of(const std::string& type) {
    if (type == "SCALAR") return 1;
    if (type == "MAT4") return 16;
    return static_cast<std::size_t>(type.back() - '0');
  }
  template <class T> static int component_type() {
    if (std::is_same_v<T, float>) return 5126;
    const int width = sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 2 : 4;
    return 5120 + width + (std::is_unsigned_v<T> ? 1 : 0);
  }
  static std::string number(std::size_t value) {
    std::string bytes;
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
  }
  std::string base64() const {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < buffer_.size(); i += 3) {
      std::uint32_t word = 0;
      for (std::size_t k = 0; k < 3; ++k)
        word = word << 8 | (i + k < buffer_.size() ? static_cast<unsigned char>(buffer_[i + k]) : 0u);
      for (std::size_t k = 0; k < 4; ++k) out += i + k > buffer_.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63];
    }
    return out;
  }

  std::string buffer_;
};

}  // namespace sheaf::test
