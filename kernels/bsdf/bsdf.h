// What every BSDF offers.
//
// A BSDF is a template over the lane that holds its parameters (scene/material.h) and has
//   kIsSpecular                     only delta distributions: neither evaluated nor lit by light sampling
//   evaluate(wo, wi)                f times |cos(wi)|; zero where nothing is scattered
//   pdf_solid_angle(wo, wi)         density with which sample() returns wi
//   sample(wo, u)                   a direction; u.x chooses the lobe, u.y and u.z the direction
// Directions are unit vectors in the shading frame, pointing away from the surface. To add one: its parameters and
// its kind in scene/material.h, its header here, a line in all.h, the parsing in scene/, and its tests.
#pragma once

#include "core/sampler.h"
#include "core/spectrum.h"

namespace sheaf {

/// A direction sampled from a BSDF.
template <class L> struct BsdfSample {
  Vec3<L> wi;
  Spectrum<L> weight;                  ///< f times |cos(wi)| over the density; specular: the scattered share
  typename L::Float pdf_solid_angle;   ///< density; 0: specular
  typename L::Float eta_scale;         ///< 1, or the squared relative index of refraction that was entered
  typename L::Mask valid;              ///< false: absorbed
};

}  // namespace sheaf
