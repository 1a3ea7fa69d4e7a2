#include "scene/materials/flattener.h"

#include <utility>

namespace sheaf {

namespace {

/// Maximum total number of rows.
constexpr std::size_t kMaxRows = std::size_t{1} << 24;

}  // namespace

std::uint32_t MaterialFlattener::flatten(MaterialId id, MaterialWrappers around) {
  const MaterialDescription& m = materials_.at(static_cast<std::size_t>(id));
  const Key key(static_cast<std::size_t>(id), around.two_sided, around.map, around.coat, around.part);
  if (const auto known = known_.find(key); known != known_.end()) return known->second;
  if (rows.size() >= kMaxRows)
    throw SceneError(m.where, fmt::format("more than {} combinations of materials", kMaxRows));
  ++around.depth;
  std::uint32_t row = 0;
  try {
    if (around.depth > kMaxMaterialDepth + 1)
      throw SceneError(m.where, fmt::format("materials are nested more than {} deep", kMaxMaterialDepth),
                       SceneErrorCode::kTooLarge);
    row = std::visit([&](const auto& model) { return flatten_model(m, model, around); }, m.model);
  } catch (const SceneError& error) {
    report_to(errors_, error, kDiffuseSubstitute);
    row = flatten_model(m, DiffuseDescription{}, around);
  }
  known_.emplace(key, row);
  return row;
}

template <class Model>
std::uint32_t MaterialFlattener::flatten_model(const MaterialDescription& m, const Model& model,
                                               const MaterialWrappers& around) {
  if constexpr (CompositeMaterial<Model>) {
    return model.flatten(*this, around, m.where);
  } else {
    MaterialRow row = make(m, model, around.coat);
    if (around.two_sided) row.flags |= kTwoSided;
    if (around.part) row.flags |= kPart;
    if (around.map != MaterialWrappers::kNoMap) {
      row.flags |= kNeedsUv | kMapped;
      row.map = around.map;
    }
    return push(row, context_.rows);
  }
}

template <class Model>
MaterialRow MaterialFlattener::make(const MaterialDescription& m, const Model& model, const CoatDescription* coat) {
  try {
    context_.rows = {};
    context_.warning = nullptr;
    MaterialRow row = make_row(model, context_);
    if (coat != nullptr) row = coat->make_row_over(row, context_);
    const float largest = std::exchange(context_.largest_reflectance, 0.0f);
    if (largest > 1 && warned_.emplace(&m, false).second)
      warnings.push_back(SceneError(m.where, clamped_reflectance(largest)).what());
    if (context_.warning != nullptr && warned_.emplace(&m, true).second)
      warnings.push_back(SceneError(m.where, context_.warning).what());
    return row;
  } catch (const SceneError& error) { throw SceneError(m.where, error); }
}

std::uint32_t MaterialFlattener::flatten_mapped(const NormalMapRow& map, MaterialId nested,
                                                const MaterialWrappers& around, const SourceLocation& where) {
  if (around.map != MaterialWrappers::kNoMap) throw SceneError(where, "a normal or bump map cannot hold another one");
  MaterialWrappers inside = around;
  inside.map = static_cast<std::uint32_t>(maps.size());
  maps.push_back(map);
  return flatten(nested, inside);
}

std::uint32_t MaterialFlattener::push_default() {
  const MaterialRow row = make({}, DiffuseDescription{});
  return push(row, context_.rows);
}

std::uint32_t MaterialFlattener::push(MaterialRow row, const MaterialSpectra& spectra_of_row) {
  row.back = static_cast<std::uint32_t>(rows.size());
  rows.push_back(row);
  if (context_.set != nullptr) spectra.push_back(spectra_of_row);
  return row.back;
}

std::uint32_t MaterialFlattener::push_choice(std::uint32_t first, std::uint32_t second, const ScalarInput& weight) {
  MaterialRow row;
  row.flags = kComposite;
  row.choice[0] = first;
  row.choice[1] = second;
  if (const float* value = std::get_if<float>(&weight)) {
    row.words[0] = *value;
  } else {
    row.first_binding = static_cast<std::uint32_t>(bindings.size());
    row.binding_count = 1;
    bindings.push_back({static_cast<std::uint32_t>(std::get<TextureId>(weight)), 0, 1, TextureRole::kScalar});
  }
  return push(row);
}

std::uint32_t MaterialFlattener::push_sides(std::uint32_t front, std::uint32_t back) {
  const std::uint32_t row = push(rows[front], context_.set != nullptr ? spectra[front] : MaterialSpectra{});
  rows[row].back = back;
  return row;
}

}  // namespace sheaf
