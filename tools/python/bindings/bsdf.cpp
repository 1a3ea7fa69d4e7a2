#include "tools/python/bindings/bsdf.h"

#include "core/io/error.h"
#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"

#include <algorithm>

namespace sheaf {

namespace {

using L = Wide;
using Indices = std::vector<std::size_t>;

/// A plain material of a composite one, and its weight. kNothing: light passes unchanged.
struct Part {
  std::uint32_t row;
  float fraction;
};

/// Appends the parts of a material as seen from one side.
void add_parts(const MaterialView& materials, std::uint32_t row, bool behind, float fraction,
               std::vector<Part>& parts) {
  if (row == MaterialRow::kNothing) {
    parts.push_back({row, fraction});
    return;
  }
  if (behind) row = materials.rows[row].back;
  const MaterialRow& material = materials.rows[row];
  if (material.binding_count > 0 || (material.flags & kMapped) != 0)
    throw Error(ExitCode::kUsage, "textures or maps vary the material (expected constant parameters)");
  if ((material.flags & kComposite) == 0) {
    parts.push_back({row, fraction});
    return;
  }
  const float second = material.second_weight();
  add_parts(materials, material.choice[0], behind, fraction * (1 - second), parts);
  add_parts(materials, material.choice[1], behind, fraction * second, parts);
}

/// The directions of kWidth elements; the last one repeats.
Vec3<L> load_directions(const std::vector<Vec3f>& values, const Indices& elements, std::size_t first) {
  const auto at = [&](int lane) -> const Vec3f& {
    return values[elements[std::min(first + static_cast<std::size_t>(lane), elements.size() - 1)]];
  };
  return {make_lanes<Float<L>>([&](int lane) { return at(lane).x; }),
          make_lanes<Float<L>>([&](int lane) { return at(lane).y; }),
          make_lanes<Float<L>>([&](int lane) { return at(lane).z; })};
}

/// Two-sided materials are shaded in a frame on the side of wo: -1 for lanes where it is turned.
Float<L> side_of(const MaterialRow& material, const Vec3<L>& wo) {
  const Mask<L> flipped = (wo.z < Float<L>(0.0f)) & Mask<L>((material.flags & kTwoSided) != 0);
  return select(flipped, Float<L>(-1.0f), Float<L>(1.0f));
}

/// Calls f(bsdf, material) with the BSDF of a row, the same in all lanes.
template <class F> void with_bsdf(const MaterialView& materials, std::uint32_t row, F&& f) {
  const MaterialRow& material = materials.rows[row];
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!kIsPhaseFunction<Bsdf<L>>) {
      if (kind != material.kind) return;
      const auto bsdf = bsdf_of_words<Bsdf<L>>(materials.closure_tables, [&](int k, auto& word) {
        word = std::remove_reference_t<decltype(word)>(material.words[k]);
      });
      f(bsdf, material);
    }
  });
}

/// Adds the value of a part to those of the elements.
void add_values(const MaterialView& materials, const Part& part, const std::vector<Vec3f>& wo,
                const std::vector<Vec3f>& wi, const Indices& elements, BsdfValues& out) {
  if (part.row == MaterialRow::kNothing) return;
  with_bsdf(materials, part.row, [&](const auto& bsdf, const MaterialRow& material) {
    for (std::size_t first = 0; first < elements.size(); first += L::width) {
      Vec3<L> o = load_directions(wo, elements, first), i = load_directions(wi, elements, first);
      const Float<L> side = side_of(material, o);
      o.z = o.z * side;
      i.z = i.z * side;
      const BsdfValue<L> value = bsdf.evaluate(o, i);
      const LaneRows<L, Spectrum> f_cos(value.f_cos);
      const LaneArray<Float<L>> pdf(value.pdf_solid_angle);
      for (int lane = 0; lane < L::width && first + static_cast<std::size_t>(lane) < elements.size(); ++lane) {
        const std::size_t at = elements[first + static_cast<std::size_t>(lane)];
        const Spectrum<Scalar> f = f_cos[lane];
        out.f_cos[at] = out.f_cos[at] + Vec3f{f.c0, f.c1, f.c2} * part.fraction;
        out.pdf[at] += pdf[lane] * part.fraction;
      }
    }
  });
}

/// Samples a part for the elements.
void sample_part(const MaterialView& materials, const Part& part, const std::vector<Vec3f>& wo,
                 const std::vector<Vec3f>& u, const Indices& elements, BsdfSamples& out) {
  if (part.row == MaterialRow::kNothing) {
    for (const std::size_t at : elements) {
      out.wi[at] = -wo[at];
      out.weight[at] = {1, 1, 1};
      out.valid[at] = 1;
    }
    return;
  }
  with_bsdf(materials, part.row, [&](const auto& bsdf, const MaterialRow& material) {
    for (std::size_t first = 0; first < elements.size(); first += L::width) {
      Vec3<L> o = load_directions(wo, elements, first);
      const Vec3<L> numbers = load_directions(u, elements, first);
      const Float<L> side = side_of(material, o);
      o.z = o.z * side;
      BsdfSample<L> sample = bsdf.sample(o, {numbers.x, numbers.y, numbers.z, Float<L>(0.5f)});
      sample.wi.z = sample.wi.z * side;
      const LaneRows<L, Vec3> wi(sample.wi);
      const LaneRows<L, Spectrum> weight(sample.weight);
      const LaneArray<Float<L>> pdf(sample.pdf_solid_angle), eta_scale(sample.eta_scale);
      const std::uint32_t valid = mask_bits(sample.valid);
      for (int lane = 0; lane < L::width && first + static_cast<std::size_t>(lane) < elements.size(); ++lane) {
        if ((valid >> lane & 1u) == 0) continue;
        const std::size_t at = elements[first + static_cast<std::size_t>(lane)];
        const Spectrum<Scalar> w = weight[lane];
        out.wi[at] = wi[lane];
        out.weight[at] = {w.c0, w.c1, w.c2};
        out.pdf[at] = pdf[lane];
        out.eta_scale[at] = eta_scale[lane];
        out.valid[at] = 1;
      }
    }
  });
}

/// Samples a composite material: chooses a part, and weighs by the mean of all, unless the part's lobe is a delta lobe.
void sample_parts(const MaterialView& materials, const std::vector<Part>& parts, const std::vector<Vec3f>& wo,
                  std::vector<Vec3f> u, const Indices& elements, BsdfSamples& out) {
  // Choose parts. The remainder of the random number is uniform again
  std::vector<Indices> chosen(parts.size());
  for (const std::size_t at : elements) {
    float rest = u[at].x;
    std::size_t k = 0;
    while (k + 1 < parts.size() && rest >= parts[k].fraction) rest -= parts[k++].fraction;
    u[at].x = std::clamp(rest / std::max(parts[k].fraction, 1e-20f), 0.0f, kOneMinusEpsilon);
    chosen[k].push_back(at);
  }
  for (std::size_t k = 0; k < parts.size(); ++k) sample_part(materials, parts[k], wo, u, chosen[k], out);
  if (parts.size() == 1) return;
  // Weigh by all parts
  Indices smooth;
  for (const std::size_t at : elements)
    if (out.valid[at] != 0 && out.pdf[at] > 0) smooth.push_back(at);
  BsdfValues all{std::vector<Vec3f>(wo.size()), std::vector<float>(wo.size())};
  for (const Part& part : parts) add_values(materials, part, wo, out.wi, smooth, all);
  for (const std::size_t at : smooth) {
    out.pdf[at] = all.pdf[at];
    out.weight[at] = all.f_cos[at] * (1 / all.pdf[at]);
  }
}

/// Calls f(parts, elements) for the directions on each side of the surface.
template <class F> void for_each_side(const Scene& scene, std::uint32_t row, const std::vector<Vec3f>& wo, F&& f) {
  for (const bool behind : {false, true}) {
    Indices elements;
    for (std::size_t i = 0; i < wo.size(); ++i)
      if ((wo[i].z < 0) == behind) elements.push_back(i);
    if (elements.empty()) continue;
    std::vector<Part> parts;
    add_parts(scene.view().materials, row, behind, 1, parts);
    f(parts, elements);
  }
}

}  // namespace

std::uint32_t material_row(const Scene& scene, const std::string& name) {
  const SceneNames& names = scene.names();
  for (std::size_t shape = 0; shape < names.material_of_shape.size(); ++shape)
    if (names.materials[names.material_of_shape[shape]] == name) return scene.view().geometry.shapes[shape].material;
  throw Error(ExitCode::kUsage, fmt::format("no shape has the material '{}'", name));
}

BsdfValues evaluate_bsdf(const Scene& scene, std::uint32_t row, const std::vector<Vec3f>& wo,
                         const std::vector<Vec3f>& wi) {
  BsdfValues out{std::vector<Vec3f>(wo.size()), std::vector<float>(wo.size())};
  for_each_side(scene, row, wo, [&](const std::vector<Part>& parts, const Indices& elements) {
    for (const Part& part : parts) add_values(scene.view().materials, part, wo, wi, elements, out);
  });
  return out;
}

BsdfSamples sample_bsdf(const Scene& scene, std::uint32_t row, const std::vector<Vec3f>& wo,
                        const std::vector<Vec3f>& u) {
  BsdfSamples out{std::vector<Vec3f>(wo.size()), std::vector<Vec3f>(wo.size()), std::vector<float>(wo.size()),
                  std::vector<float>(wo.size(), 1.0f), std::vector<unsigned char>(wo.size())};
  for_each_side(scene, row, wo, [&](const std::vector<Part>& parts, const Indices& elements) {
    sample_parts(scene.view().materials, parts, wo, u, elements, out);
  });
  return out;
}

}  // namespace sheaf
