// Evaluation of a medium's phase function, which may be a mixture.
#pragma once

#include "kernels/bsdf/list.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// Value of the phase function of material `row`, per steradian. The material is a single phase function or a mixture
/// of two, which may be mixtures themselves. `wi`: direction that light comes from, in a frame whose z axis is the
/// direction it is scattered to.
template <class L> Float<L> phase_value(const SceneView& scene, std::uint32_t row, Vec3<L> wi) {
  using F = Float<L>;
  const MaterialRow& material = scene.materials.rows[row];
  if ((material.flags & kComposite) != 0) {
    const float weight = clamp(material.second_weight(), 0.0f, 1.0f);
    return phase_value<L>(scene, material.choice[0], wi) * F(1.0f - weight) +
           phase_value<L>(scene, material.choice[1], wi) * F(weight);
  }
  F value(0.0f);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (kIsPhaseFunction<Bsdf<L>>) {
      if (static_cast<ClosureKind>(material.kind) != kind) return;
      const auto bsdf =
          bsdf_of_words<Bsdf<L>>(scene.materials.closure_tables,
                                 [&](int k, Float<L>& word) SHEAF_LAMBDA_INLINE { word = F(material.words[k]); });
      value = bsdf.evaluate({F(0.0f), F(0.0f), F(1.0f)}, wi).pdf_solid_angle;
    }
  });
  return value;
}

}  // namespace sheaf
