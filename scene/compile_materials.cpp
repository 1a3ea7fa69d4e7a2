#include "scene/compile_materials.h"

#include "core/bucket_sort.h"
#include "core/color.h"

#include <algorithm>
#include <numeric>

namespace sheaf {

namespace {

using TableToRgb = Vec3f (*)(std::span<const float>, std::span<const float>);

Vec3f to_rgb(const SpectrumDescription& spectrum, TableToRgb table_to_rgb) {
  using S = SpectrumDescription;
  Vec3f rgb{};
  if (const auto* c = std::get_if<S::Constant>(&spectrum.value)) rgb = {c->value, c->value, c->value};
  if (const auto* c = std::get_if<S::Rgb>(&spectrum.value)) rgb = c->value;
  if (const auto* t = std::get_if<S::Table>(&spectrum.value)) rgb = table_to_rgb(t->wavelengths, t->values);
  if (const auto* b = std::get_if<S::Blackbody>(&spectrum.value)) rgb = blackbody_to_rgb(b->temperature, b->scale);
  return {std::max(rgb.x, 0.0f), std::max(rgb.y, 0.0f), std::max(rgb.z, 0.0f)};
}

Spectrum4 lanes(Vec3f rgb) { return {rgb.x, rgb.y, rgb.z, 0.0f}; }

MaterialRow make_row(const DiffuseDescription& d) {
  MaterialRow row;
  set_parameters<DiffuseParameters>(row, {lanes(reflectance_rgb(d.reflectance))});
  return row;
}

MaterialRow make_row(const ConductorDescription& d) {
  // The fourth lane is no colour in RGB mode; eta 0, k 1 keeps its Fresnel term finite.
  ConductorParameters<Scalar> p{{0, 0, 0, 0}, {1, 1, 1, 1}, lanes(reflectance_rgb(d.specular_reflectance))};
  if (d.ior) {
    const Vec3f eta = unbounded_rgb(d.ior->eta), k = unbounded_rgb(d.ior->k);
    p.eta = {eta.x, eta.y, eta.z, 0};
    p.k = {k.x, k.y, k.z, 1};
  }
  MaterialRow row;
  set_parameters<ConductorParameters>(row, p);
  return row;
}

MaterialRow make_row(const DielectricDescription& d) {
  MaterialRow row;
  set_parameters<DielectricParameters>(row, {d.int_ior / d.ext_ior, lanes(reflectance_rgb(d.specular_reflectance)),
                                             lanes(reflectance_rgb(d.specular_transmittance))});
  return row;
}

MaterialRow make_row(const TwoSidedDescription&) { return {}; }

/// Rows in the order of the description, with the second row of each two-sided material behind them.
struct Flattener {
  const std::vector<MaterialDescription>& materials;
  std::vector<MaterialRow> rows;
  std::vector<std::uint32_t> row_of;

  const MaterialDescription& child(const MaterialDescription& parent, MaterialId id) const {
    const MaterialDescription& m = materials.at(static_cast<std::size_t>(id));
    if (std::holds_alternative<TwoSidedDescription>(m.model))
      throw SceneError(parent.where, "a two-sided material cannot hold another one");
    if (std::holds_alternative<DielectricDescription>(m.model))
      throw SceneError(parent.where, "a two-sided material cannot hold one that transmits light");
    return m;
  }

  std::uint32_t push(MaterialRow row) {
    const auto index = static_cast<std::uint32_t>(rows.size());
    row.back = index;
    rows.push_back(row);
    return index;
  }

  std::uint32_t push_two_sided(const MaterialDescription& m, const TwoSidedDescription& sides) {
    MaterialRow sided[2];
    for (int i = 0; i < 2; ++i) {
      const MaterialDescription& side = child(m, i == 0 ? sides.front : sides.back);
      sided[i] = std::visit([](const auto& model) { return make_row(model); }, side.model);
      sided[i].two_sided = 1;
    }
    const std::uint32_t front = push(sided[0]);
    if (sides.back == sides.front) return front;
    const std::uint32_t back = push(sided[1]);
    rows[front].back = back;
    return front;
  }

  void run() {
    for (const MaterialDescription& m : materials) {
      const auto* sides = std::get_if<TwoSidedDescription>(&m.model);
      row_of.push_back(sides ? push_two_sided(m, *sides)
                             : push(std::visit([](const auto& model) { return make_row(model); }, m.model)));
    }
  }
};

}  // namespace

Vec3f emission_rgb(const SpectrumDescription& spectrum) { return to_rgb(spectrum, emission_table_to_rgb); }

Vec3f reflectance_rgb(const SpectrumDescription& spectrum) {
  const Vec3f rgb = to_rgb(spectrum, reflectance_table_to_rgb);
  return {std::min(rgb.x, 1.0f), std::min(rgb.y, 1.0f), std::min(rgb.z, 1.0f)};
}

Vec3f unbounded_rgb(const SpectrumDescription& spectrum) { return to_rgb(spectrum, unbounded_table_to_rgb); }

CompiledMaterials compile_materials(const std::vector<MaterialDescription>& materials) {
  Flattener flat{materials, {}, {}};
  flat.run();
  const std::uint32_t default_row = flat.push(make_row(DiffuseDescription{}));

  // Sort by kind, and carry all references along.
  std::vector<std::uint32_t> order(flat.rows.size()), position(flat.rows.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return flat.rows[a].kind < flat.rows[b].kind; });
  for (std::uint32_t i = 0; i < order.size(); ++i) position[order[i]] = i;

  CompiledMaterials out;
  const bool bucket_per_material = order.size() <= static_cast<std::size_t>(kMaxBuckets);
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    MaterialRow row = flat.rows[order[i]];
    row.back = position[row.back];
    row.bucket = bucket_per_material ? i : static_cast<std::uint32_t>(row.kind);
    out.rows.push_back(row);
  }
  out.bucket_count = bucket_per_material ? static_cast<std::uint32_t>(order.size()) : std::uint32_t{kClosureKinds};
  for (int kind = 0; kind <= kClosureKinds; ++kind) {
    const auto first = std::find_if(out.rows.begin(), out.rows.end(),
                                    [kind](const MaterialRow& r) { return static_cast<int>(r.kind) >= kind; });
    out.bucket_begin[kind] = bucket_per_material ? static_cast<std::uint32_t>(first - out.rows.begin())
                                                 : static_cast<std::uint32_t>(kind);
  }
  for (std::uint32_t row : flat.row_of) out.row_of.push_back(position[row]);
  out.default_row = position[default_row];
  return out;
}

}  // namespace sheaf
