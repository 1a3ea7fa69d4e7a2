// Camera and sampler properties shared by the Nori and Mitsuba dialects.
#include "scene/dialects/xml/read_camera.h"

#include "scene/dialects/common/setting_names.h"

namespace sheaf {

void read_clip(NamedValues& p, CameraDescription& camera, float near_clip) {
  constexpr float kFarClip = 10'000;
  camera.near_clip = p.number("near_clip", near_clip, kPositive);
  camera.far_clip = p.number("far_clip", kFarClip, kPositive);
  if (camera.near_clip < camera.far_clip) return;
  p.report_at(p.has("far_clip") ? "far_clip" : "near_clip",
              fmt::format("puts the far plane at {}, expected it beyond the near plane at {}", camera.far_clip,
                          camera.near_clip),
              SceneErrorCode::kOutOfRange);
  if (!(camera.near_clip < kFarClip)) camera.near_clip = near_clip;
  camera.far_clip = kFarClip;
}

ShutterDescription read_shutter(Properties& p) {
  const float open = p.number("shutter_open", 0), close = p.number("shutter_close", 0);
  if (close < open) {
    p.report_at(
        p.has("shutter_close") ? "shutter_close" : "shutter_open",
        fmt::format("makes the shutter open at {} and close at {}, expected it to close at the same time or later",
                    number_text(double{open}), number_text(double{close})),
        SceneErrorCode::kOutOfRange);
    return {double{open}, double{open}, 0};
  }
  return {double{open}, double{close}, p.number("shutter_ramp", 0, {0, 0.5, false})};
}

CameraDescription::FovAxis read_fov_axis(NamedValues& p) {
  using Axis = CameraDescription::FovAxis;
  static constexpr NameTable<Axis> kAxes{{{"x", Axis::kX},
                                          {"y", Axis::kY},
                                          {"diagonal", Axis::kDiagonal},
                                          {"smaller", Axis::kSmaller},
                                          {"larger", Axis::kLarger}}};
  return p.choice("fov_axis", kAxes, Axis::kX);
}

SamplerKind read_sampler_kind(Properties& p, const char* substitute) {
  const SamplerKind kind = p.plugin_or(substitute, kSamplers);
  if (const std::string note = sampler_substitution_note(p.type()); !note.empty()) p.context().note(p.where(), note);
  return kind;
}

}  // namespace sheaf
