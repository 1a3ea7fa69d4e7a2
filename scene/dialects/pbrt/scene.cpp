// The pbrt dialect: files, the table of directives, and final processing.
#include "scene/dialects/pbrt/scene.h"

#include "scene/dialects/common/moving_groups.h"
#include "scene/dialects/pbrt/read_pbrt.h"
#include "scene/formats/mesh_io.h"
#include "scene/xml/missing_file.h"

#include <algorithm>
#include <iterator>

namespace sheaf::pbrt {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxIncludeDepth = 32;
constexpr int kMaxIncludes = 10'000;

}  // namespace

void Reader::note(const SourceLocation& where, const std::string& message) {
  description.notes.push_back(fmt::format("{}:{}: {}", where.file.string(), where.line, message));
}

void Reader::note_once(const SourceLocation& where, const std::string& message) {
  if (noted.insert(message).second) note(where, message);
}

void Reader::warn(const SourceLocation& where, const std::string& message) {
  description.warnings.push_back(SceneError(where, message).what());
}

void Reader::unsupported(const SourceLocation& where, const std::string& what, const std::string& instead) {
  errors.report(SceneError(where, what + ": not supported", SceneErrorCode::kUnsupported), instead);
}

Placement Reader::placement(const TransformPair& transform, const SourceLocation& where) {
  if (!transform.moves()) return Placement(transform.start);
  if (transform.start.swaps_handedness() != transform.end.swaps_handedness()) {
    unsupported(where, "motion between a transform and a mirrored one", "rendered with the transform at the start");
    return Placement(transform.start);
  }
  try {
    return Placement(AnimatedTransform({{start_time, transform.start}, {end_time, transform.end}}));
  } catch (const SceneError& error) { throw SceneError(where, error); }
}

std::optional<MotionId> Reader::motion_of(const TransformPair& transform, const Transform& local,
                                          const SourceLocation& where) {
  if (!transform.moves()) return std::nullopt;
  const std::array<Matrix4, 3> matrices{transform.start.matrix(), transform.end.matrix(), local.matrix()};
  const auto equal = [](const Matrix4& a, const Matrix4& b) { return a.m == b.m; };
  if (!last_motion || !std::equal(matrices.begin(), matrices.end(), last_motion->matrices.begin(), equal))
    last_motion = {matrices, add_motion(description.motions, placement(transform, where) * local)};
  return last_motion->motion;
}

void Reader::note_rest(const SourceLocation& where, const std::string& what) {
  if (attributes.transform.moves())
    note_once(where, what + " do not move, as in pbrt: rendered with the transform at the start");
}

fs::path Reader::find_file(const std::string& name, const SourceLocation& where) {
  if (name.empty()) throw SceneError(where, "empty file name");
  std::error_code error;
  const fs::path own = fs::path(where.file.string()).parent_path();
  for (const fs::path& base : {folder, own}) {
    fs::path candidate = base / name;
    if (!fs::exists(candidate, error)) continue;
    if (!fs::is_regular_file(candidate, error))
      throw SceneError(where, fmt::format("'{}' is not a regular file", candidate.string()));
    std::vector<fs::path>& files = description.files;
    if (std::find(files.begin(), files.end(), candidate) == files.end()) files.push_back(candidate);
    return candidate;
  }
  throw SceneError(where, missing_file(name, {folder}), SceneErrorCode::kMissingFile);
}

SceneBuilder::SceneBuilder(Description& description, const Defines& defines, ErrorSink& errors)
    : reader_{description, errors, {}, {}}, definitions_(defines) {}

std::span<const SceneBuilder::Directive> SceneBuilder::directives() {
  using B = SceneBuilder;
  constexpr Section kAnywhere = Section::kAnywhere, kOptions = Section::kOptions, kWorld = Section::kWorld;
  static constexpr Directive kDirectives[] = {{"Accelerator", &B::accelerator, kOptions},
                                              {"ActiveTransform", &B::active_transform, kAnywhere},
                                              {"AreaLightSource", &B::area_light_source, kWorld},
                                              {"Attribute", &B::attribute, kAnywhere},
                                              {"AttributeBegin", &B::attribute_begin, kWorld},
                                              {"AttributeEnd", &B::attribute_end, kWorld},
                                              {"Camera", &B::camera, kOptions},
                                              {"ColorSpace", &B::color_space, kAnywhere},
                                              {"ConcatTransform", &B::concat_transform, kAnywhere},
                                              {"CoordSysTransform", &B::coord_sys_transform, kAnywhere},
                                              {"CoordinateSystem", &B::coordinate_system, kAnywhere},
                                              {"Film", &B::film, kOptions},
                                              {"Identity", &B::identity, kAnywhere},
                                              {"Import", &B::import, kWorld},
                                              {"Include", &B::include, kAnywhere},
                                              {"Integrator", &B::integrator, kOptions},
                                              {"LightSource", &B::light_source, kWorld},
                                              {"LookAt", &B::look_at, kAnywhere},
                                              {"MakeNamedMaterial", &B::make_named_material, kWorld},
                                              {"MakeNamedMedium", &B::make_named_medium, kAnywhere},
                                              {"Material", &B::material, kWorld},
                                              {"MediumInterface", &B::medium_interface, kAnywhere},
                                              {"NamedMaterial", &B::named_material, kWorld},
                                              {"ObjectBegin", &B::object_begin, kWorld},
                                              {"ObjectEnd", &B::object_end, kWorld},
                                              {"ObjectInstance", &B::object_instance, kWorld},
                                              {"Option", &B::option, kOptions},
                                              {"PixelFilter", &B::pixel_filter, kOptions},
                                              {"ReverseOrientation", &B::reverse_orientation, kWorld},
                                              {"Rotate", &B::rotate, kAnywhere},
                                              {"Sampler", &B::sampler, kOptions},
                                              {"Scale", &B::scale, kAnywhere},
                                              {"Shape", &B::shape, kWorld},
                                              {"Texture", &B::texture, kWorld},
                                              {"Transform", &B::transform, kAnywhere},
                                              {"TransformBegin", &B::transform_begin, kWorld},
                                              {"TransformEnd", &B::transform_end, kWorld},
                                              {"TransformTimes", &B::transform_times, kOptions},
                                              {"Translate", &B::translate, kAnywhere},
                                              {"WorldBegin", &B::world_begin, kOptions}};
  return kDirectives;
}

const SceneBuilder::Directive& SceneBuilder::directive(const Token& token, const SourceLocation& where) {
  std::vector<std::string> known;
  if (token.kind == Token::Kind::kWord) {
    for (const Directive& candidate : directives())
      if (token.text == candidate.name) return candidate;
    for (const Directive& candidate : directives()) known.emplace_back(candidate.name);
  }
  if (token.text == "WorldEnd")
    throw SceneError(where, "WorldEnd belongs to pbrt-v3, expected a scene of pbrt-v4; convert it with pbrt --upgrade");
  throw SceneError(where, fmt::format("found {}, expected a directive{}", displayed(token),
                                      did_you_mean(std::string(token.text.substr(0, 40)), known)));
}

void SceneBuilder::read_directive(Tokens& tokens) {
  where_ = tokens.where();
  const Directive& found = directive(tokens.current(), where_);
  if (found.section == Section::kWorld && !in_world_)
    throw SceneError(where_, std::string(found.name) + " before WorldBegin, expected it after");
  if (found.section == Section::kOptions && in_world_)
    throw SceneError(where_, std::string(found.name) + " after WorldBegin, expected it before");
  tokens.advance();
  (this->*found.handler)(tokens);
}

void SceneBuilder::read_file(const fs::path& file, const SourceLocation& where) {
  std::error_code error;
  for (const fs::path& open : open_)
    if (open == file || fs::equivalent(open, file, error))
      throw SceneError(where, fmt::format("'{}' includes itself", file.string()));
  if (open_.size() > kMaxIncludeDepth)
    throw SceneError(where, fmt::format("files are included more than {} deep", kMaxIncludeDepth));
  if (++included_ > kMaxIncludes) throw SceneError(where, fmt::format("more than {} files are included", kMaxIncludes));
  open_.push_back(file);
  Tokens tokens(read_mesh_text(file, "scene file"), file.string(), &definitions_);
  while (tokens.current().kind != Token::Kind::kEnd) read_directive(tokens);
  open_.pop_back();
}

void SceneBuilder::read(const fs::path& file, const fs::path& folder) {
  reader_.folder = folder;
  reader_.description.files.push_back(file);
  read_file(file, {file.string(), 0});
  definitions_.reject_unused(file.string());
  if (!saved_.empty())
    throw SceneError(saved_.back().where, std::string(saved_.back().by) + " is not closed at the end of the file");
  if (!in_world_) throw SceneError({file.string(), 0}, "the scene has no WorldBegin");
  finish();
}

void SceneBuilder::finish() {
  Description& description = reader_.description;
  for (auto& [name, object] : reader_.objects) {
    if (!object.defined) throw SceneError(object.where, fmt::format("the object '{}' is not defined", name));
    if (object.instances.empty()) continue;
    const auto group = static_cast<std::uint32_t>(description.groups.size());
    object.group.id = name;
    description.groups.push_back(std::move(object.group));
    for (InstanceDescription& instance : object.instances) instance.group = group;
    std::vector<InstanceDescription>& all = description.instances;
    if (all.empty())
      all = std::move(object.instances);
    else
      all.insert(all.end(), std::move_iterator(object.instances.begin()), std::move_iterator(object.instances.end()));
  }
  separate_moving_shapes(description, reader_.errors);
  for (MediumDescription& medium : description.media) medium.emission_scale *= reader_.exposure;
  if (reader_.visibility) white_scene(reader_.visibility->found, reader_.visibility->length, true, description);
}

}  // namespace sheaf::pbrt

namespace sheaf {

void read_pbrt(const std::filesystem::path& file, const std::filesystem::path& folder, Description& description,
               const std::vector<std::pair<std::string, std::string>>& defines, ErrorSink& errors) {
  pbrt::SceneBuilder(description, defines, errors).read(file, folder);
}

}  // namespace sheaf
