// Parser of tensor files.
#include "scene/formats/tensor_file.h"

#include "scene/formats/little_endian.h"
#include "scene/formats/mesh_io.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <string_view>

namespace sheaf {

namespace {

constexpr std::string_view kTensorMagic("tensor_file\0", 12);
constexpr std::uint8_t kTypeSizes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};

std::string type_name(std::uint8_t type) {
  static constexpr const char* kNames[] = {"nothing", "uint8",  "int8",  "uint16",  "int16",   "uint32",
                                           "int32",   "uint64", "int64", "float16", "float32", "float64"};
  return kNames[type];
}

}  // namespace

std::string to_string(const TensorFile::Shape& shape) {
  std::string text;
  for (const std::uint64_t side : shape) text += (text.empty() ? "" : " x ") + std::to_string(side);
  return text.empty() ? "a single number" : text;
}

/// Parser of the file header.
class TensorFile::Reader {
 public:
  explicit Reader(TensorFile& file) : file_(file) {}

  void read() {
    if (!std::string_view(file_.content_).starts_with(kTensorMagic))
      file_.fail("expected a tensor file, which begins with the word tensor_file and a zero byte");
    at_ = kTensorMagic.size();
    const int major = number<std::uint8_t>(), minor = number<std::uint8_t>();
    if (major != 1 || minor != 0)
      file_.fail(fmt::format("expected version 1.0 of the format, found {}.{}", major, minor));
    const std::uint32_t fields = number<std::uint32_t>();
    if (fields > kMaxFields) file_.fail(fmt::format("expected at most {} fields, found {}", kMaxFields, fields));
    for (std::uint32_t i = 0; i < fields; ++i) read_field();
  }

 private:
  void read_field() {
    const std::string name = take(number<std::uint16_t>());
    Field field;
    const std::size_t dimensions = number<std::uint16_t>();
    field.type = number<std::uint8_t>();
    field.offset = number<std::uint64_t>();
    // Check type and dimensions
    if (field.type == 0 || field.type >= std::size(kTypeSizes))
      file_.fail(fmt::format("field '{}' has the type {}, expected one from 1 to 11", name, field.type));
    if (dimensions > kMaxDimensions)
      file_.fail(fmt::format("field '{}' has {} dimensions, expected at most {}", name, dimensions, kMaxDimensions));
    // Read the shape; the data must fit into the file
    field.count = 1;
    const std::uint64_t room =
        field.offset <= file_.content_.size() ? (file_.content_.size() - field.offset) / kTypeSizes[field.type] : 0;
    bool fits = true;
    for (std::size_t i = 0; i < dimensions; ++i) {
      field.shape.push_back(number<std::uint64_t>());
      if (field.shape.back() == 0) file_.fail(fmt::format("field '{}' is empty along one dimension", name));
      fits = fits && field.count <= room / field.shape.back();
      if (fits) field.count *= field.shape.back();
    }
    if (!fits || field.count > room)
      file_.fail(
          fmt::format("field '{}' of {} numbers of {} bytes begins at byte {} and does not fit into the file's {} "
                      "bytes: truncated?",
                      name, to_string(field.shape), kTypeSizes[field.type], field.offset, file_.content_.size()));
    if (!file_.fields_.emplace(name, std::move(field)).second)
      file_.fail(fmt::format("field '{}' appears twice", name));
  }

  std::string take(std::size_t size) {
    if (file_.content_.size() - at_ < size) file_.fail("the file is truncated");
    at_ += size;
    return file_.content_.substr(at_ - size, size);
  }
  template <class T> T number() { return little_endian<T>(take(sizeof(T)).data()); }

  TensorFile& file_;
  std::size_t at_ = 0;
};

TensorFile::TensorFile(const std::filesystem::path& file)
    : name_(file.string()), content_(read_mesh_bytes(file, "tensor file")) {
  Reader(*this).read();
}

const TensorFile::Field& TensorFile::field(const std::string& name) const {
  const auto found = fields_.find(name);
  if (found != fields_.end()) return found->second;
  std::string known;
  for (const auto& entry : fields_) known += (known.empty() ? "" : ", ") + entry.first;
  fail(fmt::format("has no field '{}' (it has: {})", name, known));
}

const TensorFile::Field& TensorFile::field(const std::string& name, Type type) const {
  const Field& found = field(name);
  if (found.type != static_cast<std::uint8_t>(type))
    fail(fmt::format("field '{}' holds {}, expected {}", name, type_name(found.type),
                     type_name(static_cast<std::uint8_t>(type))));
  return found;
}

const TensorFile::Shape& TensorFile::shape(const std::string& name, std::size_t dimensions) const {
  const Field& found = field(name);
  if (found.shape.size() != dimensions)
    fail(fmt::format("field '{}' has {} dimensions, expected {}", name, found.shape.size(), dimensions));
  return found.shape;
}

std::vector<float> TensorFile::floats(const std::string& name) const {
  const Field& found = field(name, Type::kFloat32);
  std::vector<float> result(found.count);
  const char* at = content_.data() + found.offset;
  for (std::size_t i = 0; i < result.size(); ++i, at += sizeof(float)) {
    result[i] = std::bit_cast<float>(little_endian<std::uint32_t>(at));
    if (!std::isfinite(result[i])) fail(fmt::format("field '{}': its number {} is not finite", name, i));
  }
  return result;
}

std::vector<float> TensorFile::every_nth_float(const std::string& name, std::size_t n) const {
  const Field& found = field(name, Type::kFloat32);
  std::vector<float> result((found.count + n - 1) / n);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] =
        std::bit_cast<float>(little_endian<std::uint32_t>(content_.data() + found.offset + i * n * sizeof(float)));
  return result;
}

std::vector<std::uint16_t> TensorFile::shorts(const std::string& name) const {
  const Field& found = field(name, Type::kUint16);
  std::vector<std::uint16_t> result(found.count);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = little_endian<std::uint16_t>(content_.data() + found.offset + i * sizeof(std::uint16_t));
  return result;
}

std::span<const char> TensorFile::bytes(const std::string& name) const {
  const Field& found = field(name, Type::kUint8);
  return {content_.data() + found.offset, found.count};
}

}  // namespace sheaf
