// A binary glTF file (.glb) that grows part by part.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace sheaf::importer {

/// Failure with a message for the user.
class ImportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The document and its single buffer.
class Glb {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};

  /// Appends an element to an array of the document and returns its index.
  int add(const char* list, nlohmann::json element) {
    nlohmann::json& to = json[list];
    to.push_back(std::move(element));
    return static_cast<int>(to.size()) - 1;
  }

  /// Appends bytes to the buffer, aligned to four, as a buffer view, and returns its index. Throws ImportError if the
  /// buffer gets larger than the format allows.
  int add_view(const void* bytes, std::size_t size);

  /// Adds an accessor of `count` vectors (VEC2, VEC3 ...) whose numbers are `values`, and returns its index.
  int add_accessor(const std::vector<float>& values, std::size_t count, const char* type);
  int add_accessor(const std::vector<std::uint16_t>& values, std::size_t count, const char* type);
  int add_accessor(const std::vector<std::uint32_t>& values, std::size_t count, const char* type);

  /// The file. Text that is not UTF-8 is replaced.
  std::string bytes();

 private:
  template <class T>
  int add_values(const std::vector<T>& values, std::size_t count, const char* type, int component_type);

  std::string buffer_;
};

/// The number itself; throws ImportError if it is not finite.
double finite(double value);

}  // namespace sheaf::importer
