// Flattening of combinations of materials (two-sided, masks, blends, coats, maps) into rows that refer to other rows.
#pragma once

#include "scene/description/error_sink.h"
#include "scene/materials/material.h"
#include "scene/materials/row_builder.h"

#include <map>
#include <set>
#include <tuple>

namespace sheaf {

/// Properties that enclosing materials impose on a nested material.
struct MaterialWrappers {
  static constexpr std::uint32_t kNoMap = 0xffffffffu;
  bool two_sided = false;
  std::uint32_t map = kNoMap;             ///< index of NormalMapRow
  const CoatDescription* coat = nullptr;  ///< the coat around the material
  bool part = false;                      ///< part of a blend
  int depth = 0;
};

/// What becomes of a material that cannot be compiled, for messages.
inline constexpr const char* kDiffuseSubstitute = "rendered as diffuse";

/// Makes rows in the order of the description. Rows of nested materials precede the row that refers to them.
class MaterialFlattener {
 public:
  /// `errors`: receives the errors of materials that become diffuse; null: they are thrown.
  MaterialFlattener(const std::vector<MaterialDescription>& materials, SpectrumSet* set, ErrorSink* errors = nullptr)
      : materials_(materials), context_{bindings, tables, set}, errors_(errors) {}

  std::vector<MaterialRow> rows;
  std::vector<MaterialSpectra> spectra;  ///< per row, in spectral mode
  std::vector<TextureBinding> bindings;
  std::vector<NormalMapRow> maps;
  ClosureTables tables;
  std::vector<std::string> warnings;

  /// The row of a material that is nested in `around`. Reports too deep nesting, combinations that are not supported,
  /// and spectra that are not finite; the material becomes diffuse.
  std::uint32_t flatten(MaterialId id, MaterialWrappers around);
  /// The row of a material below a bump or normal map.
  std::uint32_t flatten_mapped(const NormalMapRow& map, MaterialId nested, const MaterialWrappers& around,
                               const SourceLocation& where);
  bool transmits(MaterialId id) const { return sheaf::transmits(materials_, id); }

  /// Adds the row of shapes without a material.
  std::uint32_t push_default();
  /// Adds a row with its spectra.
  std::uint32_t push(MaterialRow row, const MaterialSpectra& spectra_of_row = {});
  /// Adds a row that chooses `second` with probability `weight`, otherwise `first`. Either may be kNothing.
  std::uint32_t push_choice(std::uint32_t first, std::uint32_t second, const ScalarInput& weight);
  /// Adds a row that is `front` from the front and `back` from the back.
  std::uint32_t push_sides(std::uint32_t front, std::uint32_t back);

 private:
  using Key = std::tuple<std::size_t, bool, std::uint32_t, const CoatDescription*, bool>;

  template <class Model>
  std::uint32_t flatten_model(const MaterialDescription& m, const Model& model, const MaterialWrappers& around);
  /// The row of a material that is not a combination, possibly under a coat.
  template <class Model>
  MaterialRow make(const MaterialDescription& m, const Model& model, const CoatDescription* coat = nullptr);

  const std::vector<MaterialDescription>& materials_;
  RowContext context_;
  ErrorSink* errors_;
  /// Materials with a warning about a reflectance above 1 (false) or about the model (true).
  std::set<std::pair<const MaterialDescription*, bool>> warned_;
  std::map<Key, std::uint32_t> known_;
};

}  // namespace sheaf
