// Table of named dielectrics.
#include "scene/data/named_ior.h"

namespace sheaf {

namespace {

struct NamedIor {
  const char* name;
  float ior;
};
/// Names and values as documented by Mitsuba.
constexpr NamedIor kNamedIors[] = {
    {"vacuum", 1.0f},      {"helium", 1.000036f},        {"hydrogen", 1.000132f},
    {"air", 1.000277f},    {"carbon dioxide", 1.00045f}, {"water", 1.333f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.47f},      {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.575f},       {"diamond", 2.419f}};

}  // namespace

std::optional<float> find_ior(std::string_view name) {
  for (const NamedIor& entry : kNamedIors)
    if (name == entry.name) return entry.ior;
  return std::nullopt;
}

std::vector<std::string> ior_names() {
  std::vector<std::string> names;
  for (const NamedIor& entry : kNamedIors) names.emplace_back(entry.name);
  return names;
}

}  // namespace sheaf
