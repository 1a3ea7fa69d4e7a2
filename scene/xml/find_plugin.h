// Tables of plugins that derive from lists of models.
#pragma once

#include "scene/xml/properties.h"

#include <algorithm>
#include <span>

namespace sheaf {

/// The plugin of an object in the first table that has its name. A Plugin has the members `name` and `read`. For an
/// unknown plugin, throws SceneError with the names in the tables and `others`.
template <class Plugin>
const Plugin& find_plugin(const Properties& p, std::initializer_list<std::span<const Plugin>> tables,
                          std::vector<std::string> others = {}) {
  for (const std::span<const Plugin> table : tables)
    for (const Plugin& plugin : table) {
      if (p.type() == plugin.name) return plugin;
      others.emplace_back(plugin.name);
    }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  p.fail_plugin(std::move(others));
}

}  // namespace sheaf
