// Makes the rows of all materials and phase functions, sorts them by kind and assigns buckets.
#include "scene/compile/compile_materials.h"

#include "scene/materials/flattener.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace sheaf {

namespace {

/// The row of a phase function.
std::uint32_t flatten_phase(MaterialFlattener& flat, const std::vector<PhaseDescription>& phases, PhaseId id,
                            int depth = 0) {
  const PhaseDescription& phase = phases.at(static_cast<std::size_t>(id));
  if (depth > kMaxMaterialDepth)
    throw SceneError(phase.where, fmt::format("phase functions are nested more than {} deep", kMaxMaterialDepth));
  if (const auto* blend = std::get_if<BlendPhaseDescription>(&phase.model)) {
    const std::uint32_t first = flatten_phase(flat, phases, blend->nested[0], depth + 1);
    return flat.push_choice(first, flatten_phase(flat, phases, blend->nested[1], depth + 1), blend->weight);
  }
  MaterialRow row;
  if (std::holds_alternative<SggxDescription>(phase.model)) {
    if (depth > 0)
      throw SceneError(phase.where,
                       "microflakes cannot be mixed with other phase functions: they determine the "
                       "extinction of their medium");
    set_parameters<SggxParameters>(row, kClosureKind<SggxClosure>, {1, 1, 1, 0, 0, 0});
  } else if (std::holds_alternative<RayleighDescription>(phase.model)) {
    set_parameters<RayleighParameters>(row, kClosureKind<RayleighClosure>, {});
  } else if (const auto* table = std::get_if<TabulatedPhaseDescription>(&phase.model)) {
    set_parameters<TabulatedPhaseParameters>(row, kClosureKind<TabulatedPhaseClosure>,
                                             {flat.tables.phase(table->values)});
  } else {
    const auto* hg = std::get_if<HenyeyGreensteinDescription>(&phase.model);
    set_parameters<HenyeyGreensteinParameters>(row, kClosureKind<HenyeyGreensteinClosure>,
                                               {hg != nullptr ? hg->g : 0.0f});
  }
  return flat.push(row);
}

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
                                    const std::vector<PhaseDescription>& phases, ErrorSink* errors) {
  // Flatten materials and phase functions
  MaterialFlattener flat(materials, set, errors);
  CompiledMaterials out;
  for (std::size_t i = 0; i < materials.size(); ++i) out.row_of.push_back(flat.flatten(static_cast<MaterialId>(i), {}));
  for (std::size_t i = 0; i < phases.size(); ++i)
    out.row_of_phase.push_back(flatten_phase(flat, phases, static_cast<PhaseId>(i)));
  out.default_row = flat.push_default();
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
