// The phase function of a medium, whatever it is made of.
#pragma once

#include "kernels/bsdf/all.h"
#include "scene/tables/scene.h"

namespace sheaf {

/// The phase function that material `row` is, per steradian: a simple one, or a mixture of two that may be mixtures.
/// `wi`: from where light comes, in a frame whose z axis is where it goes.
template <class L> Float<L> phase_value(const SceneView& scene, std::uint32_t row, Vec3<L> wi) {
  using F = Float<L>;
  const MaterialRow& material = scene.materials[row];
  if ((material.flags & kComposite) != 0) {
    const float share = clamp(material.second_share(), 0.0f, 1.0f);
    return phase_value<L>(scene, material.choice[0], wi) * F(1.0f - share) +
           phase_value<L>(scene, material.choice[1], wi) * F(share);
  }
  F value(0.0f);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (kIsPhaseFunction<Bsdf<L>>) {
      if (static_cast<ClosureKind>(material.kind) != kind) return;
      const auto bsdf = bsdf_of_words<Bsdf<L>>(
          scene.closure_tables, [&](int k, Float<L>& word) SHEAF_LAMBDA_INLINE { word = F(material.words[k]); });
      value = bsdf.evaluate({F(0.0f), F(0.0f), F(1.0f)}, wi).pdf_solid_angle;
    }
  });
  return value;
}

}  // namespace sheaf
