// Reading of models by the names of parameters that they declare (scene/description/parameter_names.h).
#pragma once

#include "scene/description/parameter_names.h"
#include "scene/xml/properties.h"

#include <iterator>
#include <tuple>
#include <utility>

namespace sheaf {

// Read a parameter into `value`, if present. `role`: of spectra; `range`: of numbers.
void read_parameter(Properties& p, const char* name, SpectrumInput& value, SpectrumRole role, NumberRange range);
void read_parameter(Properties& p, const char* name, SpectrumDescription& value, SpectrumRole role, NumberRange range);
void read_parameter(Properties& p, const char* name, ScalarInput& value, SpectrumRole role, NumberRange range);
void read_parameter(Properties& p, const char* name, float& value, SpectrumRole role, NumberRange range);
void read_parameter(Properties& p, const char* name, bool& value, SpectrumRole role, NumberRange range);

/// Reads the parameters that a model declares by kParameters.
template <DeclaresParameters Model> void read_declared(Properties& p, Model& model, SpectrumRole role) {
  const auto read = [&](auto& field, const ParameterName& names) {
    if (names.name == nullptr) return;
    const char* name = names.also != nullptr && p.has(names.also) && !p.has(names.name) ? names.also : names.name;
    read_parameter(p, name, field, role, names.range);
  };
  const auto fields = Model::fields(model);
  [&]<std::size_t... I>(std::index_sequence<I...>) { (read(std::get<I>(fields), Model::kParameters[I]), ...); }
  (std::make_index_sequence<std::size(Model::kParameters)>{});
}

/// Reads a model: by its read(), or else what it declares.
template <class Model, class... Arguments>
Model read_model(Properties& p, SpectrumRole role, const Arguments&... arguments) {
  if constexpr (requires { Model::read(p, arguments...); }) {
    return Model::read(p, arguments...);
  } else {
    Model model;
    read_declared(p, model, role);
    return model;
  }
}

}  // namespace sheaf
