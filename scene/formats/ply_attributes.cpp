// Grouping of a PLY element's properties into attributes by name.
#include "scene/formats/ply_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

namespace sheaf {

namespace {

/// Suffixes of the channels of one attribute.
constexpr std::array<std::string_view, 4> kEndings{"xyzw", "rgba", "0123", "1234"};
constexpr std::string_view kColorEndings = kEndings[1];

/// Returns the scalar property of this name, or nullopt.
std::optional<std::size_t> find_number(const PlyElement& element, std::string_view name) {
  const auto& all = element.properties;
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const PlyProperty& p) { return p.name == name && !p.count_type; });
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

/// "foo_x" split into "foo" and 'x'.
struct SplitName {
  std::string_view prefix;
  char ending;
};
std::optional<SplitName> split_name(const PlyProperty& property) {
  const std::string_view name = property.name;
  if (property.count_type || name.size() < 3 || name[name.size() - 2] != '_') return std::nullopt;
  return SplitName{name.substr(0, name.size() - 2), name.back()};
}

class AttributeFinder {
 public:
  AttributeFinder(const PlyElement& element, std::vector<std::string>& warnings, std::vector<std::size_t>& left_out)
      : element_(element), warnings_(warnings), left_out_(left_out) {}

  std::vector<PlyAttribute> find() {
    find_color();
    for (std::size_t i = 0; i < element_.properties.size();) i = find_group(i);
    return std::move(attributes_);
  }

 private:
  void find_color() {
    using Names = std::array<std::string_view, 3>;
    for (const Names& names : {Names{"r", "g", "b"}, Names{"red", "green", "blue"}}) {
      const auto r = find_number(element_, names[0]), g = find_number(element_, names[1]),
                 b = find_number(element_, names[2]);
      if (!r || !g || !b) continue;
      add({element_.name + "_color", {*r, *g, *b}});
      return;
    }
  }

  /// Adds the attribute that starts at property `begin`, if any; returns the index of the next property to examine.
  std::size_t find_group(std::size_t begin) {
    const auto first = split_name(element_.properties[begin]);
    if (!first) return begin + 1;
    const auto endings =
        std::find_if(kEndings.begin(), kEndings.end(), [&](std::string_view e) { return e.front() == first->ending; });
    if (endings == kEndings.end()) return begin + 1;
    PlyAttribute attribute{fmt::format("{}_{}", element_.name, first->prefix), {}};
    if (*endings == kColorEndings) attribute.name += "_color";
    std::size_t i = begin;
    for (const char ending : *endings) {
      const auto next = i < element_.properties.size() ? split_name(element_.properties[i]) : std::nullopt;
      if (!next || next->prefix != first->prefix || next->ending != ending) break;
      attribute.properties.push_back(i++);
    }
    add(std::move(attribute));
    return i;
  }

  void add(PlyAttribute attribute) {
    const std::size_t channels = attribute.properties.size();
    if (channels != 1 && channels != 3) {
      omit(attribute, fmt::format("has {} channels, expected 1 or 3", channels));
    } else if (std::any_of(attributes_.begin(), attributes_.end(),
                           [&](const PlyAttribute& other) { return other.name == attribute.name; })) {
      omit(attribute, "appears twice");
    } else {
      attributes_.push_back(std::move(attribute));
    }
  }

  /// Warns that the attribute is not read.
  void omit(const PlyAttribute& attribute, const std::string& reason) {
    warnings_.push_back(fmt::format("attribute '{}' {}: left out", attribute.name, reason));
    left_out_.insert(left_out_.end(), attribute.properties.begin(), attribute.properties.end());
  }

  const PlyElement& element_;
  std::vector<std::string>& warnings_;
  std::vector<std::size_t>& left_out_;
  std::vector<PlyAttribute> attributes_;
};

/// Returns the maximum of an integer type, or 0 for other types.
double largest_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
      return 127;
    case PlyType::kUint8:
      return 255;
    case PlyType::kInt16:
      return 32767;
    case PlyType::kUint16:
      return 65535;
    case PlyType::kInt32:
      return 2147483647;
    case PlyType::kUint32:
      return 4294967295;
    default:
      return 0;
  }
}

}  // namespace

std::optional<PlySlot> ply_slot(const PlyProperty& property) {
  struct Meaning {
    std::string_view name;
    PlySlot slot;
  };
  constexpr std::array<Meaning, 14> kMeanings{{{"x", kPlyX},
                                               {"y", kPlyY},
                                               {"z", kPlyZ},
                                               {"nx", kPlyNormalX},
                                               {"ny", kPlyNormalY},
                                               {"nz", kPlyNormalZ},
                                               {"u", kPlyU},
                                               {"v", kPlyV},
                                               {"s", kPlyU},
                                               {"t", kPlyV},
                                               {"texture_u", kPlyU},
                                               {"texture_v", kPlyV},
                                               {"texture_s", kPlyU},
                                               {"texture_t", kPlyV}}};
  if (property.count_type) return {};
  const auto found =
      std::find_if(kMeanings.begin(), kMeanings.end(), [&](const Meaning& m) { return m.name == property.name; });
  if (found == kMeanings.end()) return {};
  return found->slot;
}

std::vector<PlyAttribute> find_ply_attributes(const PlyElement& element, std::vector<std::string>& warnings,
                                              std::vector<std::size_t>& left_out) {
  return AttributeFinder(element, warnings, left_out).find();
}

std::string unknown_properties_warning(const PlyElement& element, const std::vector<std::size_t>& properties) {
  constexpr std::size_t kMaxNamed = 12, kMaxLength = 40;
  if (properties.empty()) return {};
  std::string names;
  for (std::size_t i = 0; i < std::min(properties.size(), kMaxNamed); ++i)
    names += (i == 0 ? "'" : ", '") + element.properties[properties[i]].name.substr(0, kMaxLength) + "'";
  if (properties.size() > kMaxNamed) names += fmt::format(" and {} more", properties.size() - kMaxNamed);
  return fmt::format("element '{}': {}{} not understood: left out", element.name,
                     properties.size() == 1 ? "property " : "properties ", names);
}

float ply_attribute_value(PlyType type, double value) {
  const double largest = largest_of(type);
  if (largest > 0) {
    const double encoded = value / largest;  // sRGB, IEC 61966-2-1
    value = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
  }
  const auto rounded = static_cast<float>(value);
  return std::isfinite(rounded) ? rounded : 0.0f;
}

}  // namespace sheaf
