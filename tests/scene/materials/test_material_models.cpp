// The list of material models: its names in files and in docs/scene-format/bsdfs.md, and what a model must declare.
#include "scene/materials/plugins.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string>

namespace sheaf::test_material_models {

namespace {

struct Complete {
  using Closures = ClosureList<>;
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto&) { return std::tie(); }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};
struct WithoutTransmits {
  using Closures = ClosureList<>;
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto&) { return std::tie(); }
  MaterialRow make_row(RowContext& context) const;
};
struct WithoutRow {
  using Closures = ClosureList<>;
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto&) { return std::tie(); }
  bool transmits() const { return false; }
};
struct WithoutFields {
  using Closures = ClosureList<>;
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};
struct WithoutPlugins {
  using Closures = ClosureList<>;
  static constexpr auto fields(auto&) { return std::tie(); }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};
static_assert(CompleteModel<Complete>);
static_assert(!CompleteModel<WithoutTransmits> && !CompleteModel<WithoutRow> && !CompleteModel<WithoutPlugins> &&
              !CompleteModel<WithoutFields>);

}  // namespace

TEST_CASE("docs/scene-format/bsdfs.md has a section for every bsdf plugin") {
  std::ifstream file(SHEAF_SOURCE_DIR "/docs/scene-format/bsdfs.md");
  REQUIRE(file);
  std::set<std::string> headings;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("## ")) headings.insert(line);
  for (const BsdfPlugin& plugin : bsdf_plugins()) {
    CAPTURE(std::string(plugin.name));
    const std::string name = "`" + std::string(plugin.name) + "`";
    CHECK(std::any_of(headings.begin(), headings.end(),
                      [&](const std::string& heading) { return heading.find(name) != std::string::npos; }));
  }
}

TEST_CASE("the names of bsdf plugins are sorted and unique") {
  const auto plugins = bsdf_plugins();
  for (std::size_t i = 1; i < plugins.size(); ++i)
    CHECK(std::string(plugins[i - 1].name) < std::string(plugins[i].name));
}

}  // namespace sheaf::test_material_models
