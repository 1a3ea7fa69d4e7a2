// Flattens combinations of materials (two-sided, masks, blends, maps) into rows that refer to other rows.
#include "scene/compile/compile_materials.h"

#include "core/bucket_sort.h"
#include "scene/compile/material_rows.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace sheaf {

namespace {

/// Maximum total number of rows.
constexpr std::size_t kMaxRows = std::size_t{1} << 24;

constexpr std::uint32_t kNoMap = 0xffffffffu;

/// Properties that enclosing materials impose on a nested material.
struct MaterialWrappers {
  bool two_sided = false;
  std::uint32_t map = kNoMap;                 ///< index of NormalMapRow
  const MaterialDescription* coat = nullptr;  ///< material with a CoatDescription
  bool part = false;                          ///< part of a blend
  int depth = 0;
};

/// Whether a metallic material has no specular reflection (kernels/bsdf/principled.h).
bool is_black_metal(const MaterialDescription& m) {
  const auto* principled = std::get_if<PrincipledDescription>(&m.model);
  const ScalarInput nothing = 0.0f;
  return principled != nullptr && principled->eta == 1.0f && principled->metallic != nothing &&
         principled->spec_trans == nothing;
}
constexpr const char* kBlackMetal =
    "the metallic part of this principled material is black: with 'specular' 0, an index of refraction of 1, nothing "
    "reflects specularly, as in Mitsuba (expected 'specular' above 0 or another 'eta')";

/// Makes rows in the order of the description. Rows of nested materials precede the row that refers to them.
class Flattener {
 public:
  Flattener(const std::vector<MaterialDescription>& materials, SpectrumSet* set)
      : context_{bindings, tables, set}, materials_(materials) {}

  std::vector<MaterialRow> rows;
  std::vector<MaterialSpectra> spectra;  ///< per row, in spectral mode
  std::vector<TextureBinding> bindings;
  std::vector<NormalMapRow> maps;
  ClosureTables tables;
  std::vector<std::string> warnings;

  /// The row of a material that is nested in `around`.
  std::uint32_t flatten(MaterialId id, MaterialWrappers around) {
    const MaterialDescription& m = materials_.at(static_cast<std::size_t>(id));
    if (around.depth > kMaxMaterialDepth)
      throw SceneError(m.where, "materials are nested more than " + std::to_string(kMaxMaterialDepth) + " deep");
    const auto key = std::tuple(static_cast<std::size_t>(id), around.two_sided, around.map, around.coat, around.part);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    if (rows.size() >= kMaxRows)
      throw SceneError(m.where, "more than " + std::to_string(kMaxRows) + " combinations of materials");
    ++around.depth;
    const std::uint32_t row = std::visit([&](const auto& model) { return flatten_model(m, model, around); }, m.model);
    known_.emplace(key, row);
    return row;
  }

  /// The row of a phase function.
  std::uint32_t flatten(const std::vector<PhaseDescription>& phases, PhaseId id, int depth = 0) {
    const PhaseDescription& phase = phases.at(static_cast<std::size_t>(id));
    if (depth > kMaxMaterialDepth)
      throw SceneError(phase.where,
                       "phase functions are nested more than " + std::to_string(kMaxMaterialDepth) + " deep");
    if (const auto* blend = std::get_if<BlendPhaseDescription>(&phase.model)) {
      const std::uint32_t first = flatten(phases, blend->nested[0], depth + 1);
      return push_choice(first, flatten(phases, blend->nested[1], depth + 1), blend->weight);
    }
    MaterialRow row;
    if (std::holds_alternative<SggxDescription>(phase.model)) {
      if (depth > 0)
        throw SceneError(phase.where,
                         "microflakes cannot be mixed with other phase functions: they determine the "
                         "extinction of their medium");
      set_parameters<SggxParameters>(row, ClosureKind::kSggx, {1, 1, 1, 0, 0, 0});
    } else if (std::holds_alternative<RayleighDescription>(phase.model)) {
      set_parameters<RayleighParameters>(row, ClosureKind::kRayleigh, {});
    } else if (const auto* table = std::get_if<TabulatedPhaseDescription>(&phase.model)) {
      set_parameters<TabulatedPhaseParameters>(row, ClosureKind::kTabulatedPhase, {tables.phase(table->values)});
    } else {
      const auto* hg = std::get_if<HenyeyGreensteinDescription>(&phase.model);
      set_parameters<HenyeyGreensteinParameters>(row, ClosureKind::kHenyeyGreenstein, {hg != nullptr ? hg->g : 0.0f});
    }
    return push(row, {});
  }

  /// The row of a material that is not a combination, possibly under a coat.
  MaterialRow make(const MaterialDescription& m, const MaterialDescription* coat = nullptr) {
    try {
      const MaterialRow row = coat == nullptr ? make_material_row(m, context_)
                                              : make_coated_row(std::get<CoatDescription>(coat->model), m, context_);
      const float largest = std::exchange(context_.largest_reflectance, 0.0f);
      if (largest > 1 && clamped_.insert(&m).second)
        warnings.push_back(SceneError(m.where, clamped_reflectance(largest)).what());
      if (is_black_metal(m) && black_metals_.insert(&m).second)
        warnings.push_back(SceneError(m.where, kBlackMetal).what());
      return row;
    } catch (const SceneError& error) { throw SceneError(m.where, error.what()); }
  }

  /// Adds a row with the spectra of the most recently made row.
  std::uint32_t push(MaterialRow row) { return push(row, context_.rows); }
  std::uint32_t push(MaterialRow row, const MaterialSpectra& spectra_of_row) {
    row.back = static_cast<std::uint32_t>(rows.size());
    rows.push_back(row);
    if (context_.set != nullptr) spectra.push_back(spectra_of_row);
    return row.back;
  }

 private:
  template <class Model>
  std::uint32_t flatten_model(const MaterialDescription& m, const Model&, const MaterialWrappers& around) {
    MaterialRow row = make(m, around.coat);
    if (around.two_sided) row.flags |= kTwoSided;
    if (around.part) row.flags |= kPart;
    if (around.map != kNoMap) {
      row.flags |= kNeedsUv | kMapped;
      row.map = around.map;
    }
    return push(row);
  }

  std::uint32_t flatten_model(const MaterialDescription& m, const TwoSidedDescription& sides,
                              const MaterialWrappers& around) {
    if (around.two_sided) throw SceneError(m.where, "a two-sided material cannot hold another one");
    for (const MaterialId side : {sides.front, sides.back})
      if (transmits(materials_, side))
        throw SceneError(m.where, "a two-sided material cannot hold one that transmits light");
    MaterialWrappers inside = around;
    inside.two_sided = true;
    const std::uint32_t front = flatten(sides.front, inside);
    if (sides.back == sides.front) return front;
    const std::uint32_t back = flatten(sides.back, inside);
    const std::uint32_t row = push(rows[front], context_.set != nullptr ? spectra[front] : MaterialSpectra{});
    rows[row].back = back;
    return row;
  }

  std::uint32_t flatten_model(const MaterialDescription&, const NullDescription&, const MaterialWrappers&) {
    MaterialRow row;
    row.flags = kComposite;
    row.choice[0] = row.choice[1] = MaterialRow::kNothing;
    return push(row);
  }

  std::uint32_t flatten_model(const MaterialDescription&, const MaskDescription& mask, const MaterialWrappers& around) {
    return push_choice(MaterialRow::kNothing, flatten(mask.nested, around), mask.opacity);
  }

  std::uint32_t flatten_model(const MaterialDescription&, const BlendDescription& blend,
                              const MaterialWrappers& around) {
    MaterialWrappers inside = around;
    inside.part = true;
    const std::uint32_t first = flatten(blend.nested[0], inside);
    return push_choice(first, flatten(blend.nested[1], inside), blend.weight);
  }

  std::uint32_t flatten_model(const MaterialDescription& m, const CoatDescription& coat,
                              const MaterialWrappers& around) {
    if (around.coat != nullptr) throw SceneError(m.where, "a coat cannot hold another one");
    if (transmits(materials_, coat.nested))
      throw SceneError(m.where, "a coat cannot hold a material that transmits light");
    MaterialWrappers inside = around;
    inside.coat = &m;
    return flatten(coat.nested, inside);
  }

  std::uint32_t flatten_model(const MaterialDescription& m, const BumpMapDescription& bump,
                              const MaterialWrappers& around) {
    const std::uint32_t flags = NormalMapRow::kBump | options(m);
    return flatten_mapped(m, {static_cast<std::uint32_t>(bump.displacement), flags, bump.scale}, bump.nested, around);
  }

  std::uint32_t flatten_model(const MaterialDescription& m, const NormalMapDescription& map,
                              const MaterialWrappers& around) {
    const std::uint32_t flags = (map.flip_green ? NormalMapRow::kFlipGreen : 0u) | options(m);
    return flatten_mapped(m, {static_cast<std::uint32_t>(map.normals), flags, 1.0f}, map.nested, around);
  }

  static std::uint32_t options(const MaterialDescription& m) {
    return (m.fix_invalid_normals ? NormalMapRow::kFixInvalid : 0u) |
           (m.soften_terminator ? NormalMapRow::kSoften : 0u);
  }

  std::uint32_t flatten_mapped(const MaterialDescription& m, NormalMapRow map, MaterialId nested,
                               const MaterialWrappers& around) {
    if (around.map != kNoMap) throw SceneError(m.where, "a normal or bump map cannot hold another one");
    MaterialWrappers inside = around;
    inside.map = static_cast<std::uint32_t>(maps.size());
    maps.push_back(map);
    return flatten(nested, inside);
  }

  std::uint32_t push_choice(std::uint32_t first, std::uint32_t second, const ScalarInput& share) {
    MaterialRow row;
    row.flags = kComposite;
    row.choice[0] = first;
    row.choice[1] = second;
    if (const float* value = std::get_if<float>(&share)) {
      row.words[0] = *value;
    } else {
      row.first_binding = static_cast<std::uint32_t>(bindings.size());
      row.binding_count = 1;
      bindings.push_back({static_cast<std::uint32_t>(std::get<TextureId>(share)), 0, 1, TextureRole::kScalar});
    }
    return push(row);
  }

  RowContext context_;
  const std::vector<MaterialDescription>& materials_;
  std::set<const MaterialDescription*> clamped_, black_metals_;  ///< already reported in a warning
  std::map<std::tuple<std::size_t, bool, std::uint32_t, const MaterialDescription*, bool>, std::uint32_t> known_;
};

/// Sort key: rows are ordered by kind. Composite rows, which are never shaded, come last.
int order_of(const MaterialRow& row) { return row.flags & kComposite ? kClosureKinds : static_cast<int>(row.kind); }

void renumber(std::uint32_t& row, const std::vector<std::uint32_t>& position) {
  if (row != MaterialRow::kNothing) row = position[row];
}

/// Assigns buckets: one per material if they are few, otherwise one per kind.
void set_buckets(MaterialTables& out) {
  const auto shaded =
      std::find_if(out.rows.begin(), out.rows.end(), [](const MaterialRow& r) { return r.flags & kComposite; });
  const auto count = static_cast<std::uint32_t>(shaded - out.rows.begin());
  const bool bucket_per_material = count <= std::uint32_t{kMaxBuckets};
  for (std::uint32_t i = 0; i < count; ++i)
    out.rows[i].bucket =
        static_cast<std::uint16_t>(bucket_per_material ? i : static_cast<std::uint32_t>(out.rows[i].kind));
  out.buckets.count = bucket_per_material ? count : std::uint32_t{kClosureKinds};
  for (int kind = 0; kind <= kClosureKinds; ++kind) {
    const auto first = std::find_if(out.rows.begin(), shaded,
                                    [kind](const MaterialRow& r) { return static_cast<int>(r.kind) >= kind; });
    out.buckets.begin[kind] =
        bucket_per_material ? static_cast<std::uint32_t>(first - out.rows.begin()) : static_cast<std::uint32_t>(kind);
  }
}

}  // namespace

CompiledMaterials compile_materials(const std::vector<MaterialDescription>& materials, SpectrumSet* set,
                                    const std::vector<PhaseDescription>& phases) {
  // Flatten materials and phase functions
  Flattener flat(materials, set);
  CompiledMaterials out;
  for (std::size_t i = 0; i < materials.size(); ++i) out.row_of.push_back(flat.flatten(static_cast<MaterialId>(i), {}));
  for (std::size_t i = 0; i < phases.size(); ++i)
    out.row_of_phase.push_back(flat.flatten(phases, static_cast<PhaseId>(i)));
  out.default_row = flat.push(flat.make({}));
  // Sort the rows by kind
  std::vector<std::uint32_t> order(flat.rows.size()), position(flat.rows.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return order_of(flat.rows[a]) < order_of(flat.rows[b]); });
  for (std::uint32_t i = 0; i < order.size(); ++i) position[order[i]] = i;
  // Copy them in that order, with references renumbered
  for (const std::uint32_t from : order) {
    MaterialRow row = flat.rows[from];
    row.back = position[row.back];
    if (row.flags & kComposite) {
      out.tables.has_composites = true;
      for (std::uint32_t& choice : row.choice) renumber(choice, position);
    } else {
      out.tables.buckets.kind_flags[static_cast<int>(row.kind)] |= row.flags;
    }
    out.tables.rows.push_back(row);
    if (set != nullptr) out.spectra.push_back(flat.spectra[from]);
  }
  set_buckets(out.tables);
  for (std::uint32_t& row : out.row_of) row = position[row];
  for (std::uint32_t& row : out.row_of_phase) row = position[row];
  out.default_row = position[out.default_row];
  out.tables.bindings = std::move(flat.bindings);
  out.tables.normal_maps = std::move(flat.maps);
  out.tables.closure_tables = flat.tables.take();
  out.warnings = std::move(flat.warnings);
  return out;
}

}  // namespace sheaf
