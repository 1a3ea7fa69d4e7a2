// The table of all names of materials in files, from the list of models.
#include "scene/materials/plugins.h"

#include <algorithm>
#include <cstring>

namespace sheaf {

namespace {

/// Reads plugin I of a model.
template <class Model, std::size_t I> MaterialModel read_as(Properties& p, const BsdfDialect& dialect) {
  constexpr Plugin<Model> kPlugin = Model::kPlugins[I];
  if constexpr (kPlugin.has_reader)
    return kPlugin.read(p, dialect);
  else
    return read_model<Model>(p, SpectrumRole::kReflectance, dialect);
}

template <class Model> void add_plugins(std::vector<BsdfPlugin>& table) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (table.push_back({Plugin<Model>(Model::kPlugins[I]).name, read_as<Model, I>}), ...);
  }
  (std::make_index_sequence<std::size(Model::kPlugins)>{});
}

template <class... Models> std::vector<BsdfPlugin> plugins_of(const std::variant<Models...>*) {
  std::vector<BsdfPlugin> table;
  (add_plugins<Models>(table), ...);
  std::sort(table.begin(), table.end(),
            [](const BsdfPlugin& a, const BsdfPlugin& b) { return std::strcmp(a.name, b.name) < 0; });
  return table;
}

const BsdfPlugin* find_plugin(std::span<const BsdfPlugin> table, const std::string& name) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const BsdfPlugin& each) { return name == each.name; });
  return found != table.end() ? &*found : nullptr;
}

}  // namespace

std::span<const BsdfPlugin> bsdf_plugins() {
  static const std::vector<BsdfPlugin> kTable = plugins_of(static_cast<const MaterialModel*>(nullptr));
  return kTable;
}

MaterialModel read_bsdf_plugin(Properties& p, const BsdfDialect& dialect, std::span<const BsdfPlugin> own) {
  if (const BsdfPlugin* plugin = find_plugin(own, p.type())) return plugin->read(p, dialect);
  if (const BsdfPlugin* plugin = find_plugin(bsdf_plugins(), p.type())) return plugin->read(p, dialect);
  std::vector<std::string> known;
  for (const std::span<const BsdfPlugin> table : {bsdf_plugins(), own})
    for (const BsdfPlugin& plugin : table) known.emplace_back(plugin.name);
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  p.fail_plugin(known);
}

}  // namespace sheaf
