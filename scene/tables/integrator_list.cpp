#include "scene/tables/integrator_list.h"

#include <fmt/format.h>

#include <algorithm>

namespace sheaf {

namespace {

/// The element that equals `name`, or null.
const char* find_name(const IntegratorNames& names, std::string_view name) {
  for (const char* each : names)
    if (each != nullptr && name == each) return each;
  return nullptr;
}

}  // namespace

std::optional<IntegratorMatch> find_integrator(std::string_view name, bool in_pbrt) {
  if (in_pbrt)
    for (const IntegratorEntry& entry : kIntegrators)
      if (const char* found = find_name(entry.pbrt_names, name)) return IntegratorMatch{&entry, found};
  for (const IntegratorEntry& entry : kIntegrators) {
    if (const char* found = find_name(entry.names, name)) return IntegratorMatch{&entry, found};
    if (find_name(entry.substituted, name) != nullptr)
      return IntegratorMatch{&entry, entry.names[0], Substitution::kEquivalent};
    if (find_name(entry.unsupported, name) != nullptr)
      return IntegratorMatch{&entry, entry.names[0], Substitution::kNoisier};
  }
  return std::nullopt;
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  const auto add = [&](const IntegratorNames& more) {
    for (const char* name : more)
      if (name != nullptr) names.emplace_back(name);
  };
  for (const IntegratorEntry& entry : kIntegrators) {
    add(entry.names);
    add(entry.substituted);
    add(entry.unsupported);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> suggested_integrators() {
  std::vector<std::string> names;
  for (const IntegratorEntry& entry : kIntegrators)
    if (entry.help != nullptr) names.emplace_back(entry.names[0]);
  return names;
}

std::string integrator_descriptions() {
  std::string text;
  for (const IntegratorEntry& entry : kIntegrators)
    if (entry.help != nullptr) text += fmt::format("{}{}: {}", text.empty() ? "" : ";\n", entry.names[0], entry.help);
  return text;
}

}  // namespace sheaf
