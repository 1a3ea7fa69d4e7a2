// The interface of material models, and of the closures by which kernels refer to them.
//
// A model is a struct XDescription in scene/materials/<name>.h that holds the parameters as a file gives them, with
// their defaults, and declares
//   Closures           a ClosureList of the closures that its rows can have; empty for composite materials
//   kPlugins           its names in files: an array of Plugin, or kNoPlugins
//   fields()           all parameters
//   transmits()        whether light can pass through it; composites take a NestedTransmission, which answers for
//                      nested materials
// If each field becomes a parameter of the row, in the same order, it needs no code, neither for reading nor for rows:
//   kParameters        the names of its fields (scene/description/parameter_names.h)
// Otherwise it defines some of these functions in scene/materials/<name>.cpp:
//   read(p, dialect)   reads the properties (scene/materials/reading.h)
//   make_row(context)  derives the row (scene/materials/row_builder.h)
//   flatten(flattener, around, where)  composites: makes rows that refer to rows (scene/materials/flattener.h)
// scene/materials/list.h lists all models. One that omits something does not compile.
#pragma once

#include "core/color/spectrum.h"
#include "core/soa/record_table.h"
#include "scene/description/parameter_names.h"
#include "scene/tables/material.h"

#include <concepts>
#include <cstddef>
#include <tuple>
#include <vector>

namespace sheaf {

struct BsdfDialect;
struct MaterialDescription;
struct MaterialWrappers;
struct RowContext;
struct SourceLocation;
class MaterialFlattener;
class Properties;

/// Properties of a closure that are known without its parameters.
struct ClosureInfo {
  const char* name = nullptr;       ///< for reports
  bool is_thin_dielectric = false;  ///< only reflects and transmits straight on
  bool is_phase = false;            ///< a phase function; see kernels/bsdf/bsdf.h
  bool is_coatable = false;         ///< opaque and not a coat itself; see kernels/bsdf/coated.h
};

/// Base of closures with the parameters P. A closure is a struct with a constant kInfo, a ClosureInfo; its BSDF in
/// kernels/bsdf/ names it.
template <template <class> class P> struct ClosureOf { template <class L> using Parameters = P<L>; };

/// Closures in an order.
template <class... Closures> struct ClosureList {
  static constexpr int kCount = static_cast<int>(sizeof...(Closures));

  /// Position of a closure, which must be in the list once.
  template <class Closure> static consteval int position_of() {
    static_assert((int{std::is_same_v<Closure, Closures>} + ... + 0) == 1, "the closure is not in the list once");
    int position = 0;
    bool found = false;
    ((found = found || std::is_same_v<Closure, Closures>, position += found ? 0 : 1), ...);
    return position;
  }
};

/// The closures of two lists.
template <class... A, class... B> ClosureList<A..., B...> operator+(ClosureList<A...>, ClosureList<B...>);

/// A name of a model in files, and the function that reads its properties, unless read_model() does.
template <class Model> struct Plugin {
  using Reader = Model (*)(Properties& p, const BsdfDialect& dialect);

  constexpr Plugin(const char* name_in) : name(name_in) {}
  constexpr Plugin(const char* name_in, Reader read_in) : name(name_in), read(read_in), has_reader(true) {}

  const char* name;
  Reader read = nullptr;
  bool has_reader = false;  ///< g++ does not compare `read` with nullptr in constant expressions under sanitizers
};
/// Whether a material nested in a composite one transmits light.
struct NestedTransmission {
  const std::vector<MaterialDescription>& materials;
  int depth;
  bool operator()(MaterialId id) const;
};

/// A model with custom code for its row.
template <class Model>
concept DerivedBsdf = requires(const Model& model, RowContext& context) {
  { model.make_row(context) } -> std::same_as<MaterialRow>;
};

/// A model whose fields are the parameters of its row: kParameters names all of them.
template <class Model>
concept DeclarativeBsdf = !DerivedBsdf<Model> && DeclaresParameters<Model>;

/// A model that combines other materials.
template <class Model>
concept CompositeMaterial = requires(const Model& model, MaterialFlattener& flattener, const MaterialWrappers& around,
                                     const SourceLocation& where) {
  { model.flatten(flattener, around, where) } -> std::same_as<std::uint32_t>;
};

/// The requirements on a model that the compiler can check; see above.
template <class Model>
concept CompleteModel = (int{DeclarativeBsdf<Model>} + int{DerivedBsdf<Model>} + int{CompositeMaterial<Model>} == 1) &&
                        requires(const Model& model, const NestedTransmission& nested) {
  typename Model::Closures;
  Model::kPlugins;
  Model::fields(model);
  requires requires { model.transmits(); } || requires {
    model.transmits(nested);
  };
};

}  // namespace sheaf
