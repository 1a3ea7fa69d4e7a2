// The table of all names of materials in files, from the list of models.
#include "scene/materials/plugins.h"

#include "scene/xml/find_plugin.h"

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

}  // namespace

std::span<const BsdfPlugin> bsdf_plugins() {
  static const std::vector<BsdfPlugin> kTable = plugins_of(static_cast<const MaterialModel*>(nullptr));
  return kTable;
}

MaterialModel read_bsdf_plugin(Properties& p, const BsdfDialect& dialect, std::span<const BsdfPlugin> own) {
  return find_plugin<BsdfPlugin>(p, {own, bsdf_plugins()}).read(p, dialect);
}

}  // namespace sheaf
