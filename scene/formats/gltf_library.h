// Common code of the readers of glTF: the document as tinygltf has parsed it. Only scene/formats/gltf*.cpp include
// this.
#pragma once

#include "scene/formats/gltf.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

#include <cmath>

namespace sheaf {

/// Reads numbers and references of the parsed document and checks them.
class GltfChecker {
 public:
  GltfChecker(const tinygltf::Model& from, GltfFile& to) : model(from), out(to) {}

  /// Throws SceneError unless `value` is kNoIndex or an index into `count` elements.
  int index(int value, std::size_t count, const std::string& part, const char* name) const {
    if (value == kNoIndex || (value >= 0 && static_cast<std::size_t>(value) < count)) return value;
    throw out.error(part, fmt::format("'{}' is {}, but there are {}", name, value, count));
  }
  /// index() of a reference that must exist.
  int required(int value, std::size_t count, const std::string& part, const char* name) const {
    if (value == kNoIndex) throw out.error(part, fmt::format("'{}' is missing", name));
    return index(value, count, part, name);
  }

  double precise_number(double value, const std::string& part, const char* name) const {
    if (!std::isfinite(value) || std::abs(value) > kLargest)
      throw out.error(part, fmt::format("'{}' is not a finite number", name));
    return value;
  }
  float number(double value, const std::string& part, const char* name) const {
    return static_cast<float>(precise_number(value, part, name));
  }

  /// The member of an object in an extension; null if it is absent.
  static const tinygltf::Value* find(const tinygltf::Value& object, const char* name) {
    return object.IsObject() && object.Has(name) ? &object.Get(name) : nullptr;
  }
  float number(const tinygltf::Value& object, const char* name, float otherwise, const std::string& part) const {
    const tinygltf::Value* value = find(object, name);
    if (value == nullptr) return otherwise;
    if (!value->IsNumber()) throw out.error(part, fmt::format("'{}' is not a number", name));
    return number(value->GetNumberAsDouble(), part, name);
  }
  int integer(const tinygltf::Value& object, const char* name, int otherwise, const std::string& part) const {
    const tinygltf::Value* value = find(object, name);
    if (value == nullptr) return otherwise;
    if (!value->IsInt()) throw out.error(part, fmt::format("'{}' is not an integer", name));
    return value->GetNumberAsInt();
  }
  std::string text(const tinygltf::Value& object, const char* name, const std::string& otherwise) const {
    const tinygltf::Value* value = find(object, name);
    return value != nullptr && value->IsString() ? value->Get<std::string>() : otherwise;
  }

  const tinygltf::Model& model;
  GltfFile& out;

 private:
  static constexpr double kLargest = 1e30;
};

/// Adds the materials, with their extensions.
void convert_materials(const GltfChecker& from);

}  // namespace sheaf
