// The pbrt dialect: handlers of all directives except transforms.
#include "scene/dialects/common/moving_groups.h"
#include "scene/dialects/pbrt/scene.h"

#include <algorithm>

namespace sheaf::pbrt {

namespace {

constexpr std::size_t kMaxSaved = 10'000;

/// Removes the parameter "type" from the list and returns its value.
std::string take_type(DirectiveArguments& entity, const std::string& directive) {
  for (const Parameter& parameter : entity.parameters)
    if (parameter.name == "type" && parameter.type == "string" && parameter.strings.size() == 1) {
      std::string type = parameter.strings[0];
      std::erase_if(entity.parameters, [](const Parameter& p) { return p.name == "type"; });
      return type;
    }
  throw SceneError(entity.where, directive + " needs the string 'type'");
}

}  // namespace

std::string SceneBuilder::read_string(Tokens& tokens, const char* what) {
  if (tokens.current().kind != Token::Kind::kString)
    throw SceneError(tokens.where(),
                     fmt::format("found {}, expected {} in double quotes", displayed(tokens.current()), what));
  std::string text(tokens.current().text);
  tokens.advance();
  return text;
}

DirectiveArguments SceneBuilder::read_arguments(Tokens& tokens, const char* target) {
  DirectiveArguments entity{read_string(tokens, "a name"), read_parameters(tokens), where_};
  const auto found = reader_.attributes.defaults.find(target);
  if (found != reader_.attributes.defaults.end())
    entity.parameters.insert(entity.parameters.end(), found->second->begin(), found->second->end());
  return entity;
}

void SceneBuilder::save(const char* by) {
  if (saved_.size() >= kMaxSaved)
    throw SceneError(where_, fmt::format("attributes are saved more than {} deep", kMaxSaved));
  saved_.push_back({by, where_, reader_.attributes});
}

void SceneBuilder::restore(const char* by, Attributes& attributes) {
  if (saved_.empty() || std::string_view(saved_.back().by) != by)
    throw SceneError(where_,
                     fmt::format("an end without {}{}", by,
                                 saved_.empty() ? "" : ", expected the end of " + std::string(saved_.back().by)));
  attributes = std::move(saved_.back().attributes);
  saved_.pop_back();
}

void SceneBuilder::accelerator(Tokens& tokens) { read_arguments(tokens, "accelerator"); }

void SceneBuilder::area_light_source(Tokens& tokens) {
  DirectiveArguments entity = read_arguments(tokens, "light");
  read_or_omit("light", [&] { reader_.attributes.area_light = read_area_light(reader_, std::move(entity)); });
}

void SceneBuilder::attribute(Tokens& tokens) {
  const std::string target = read_string(tokens, "the target of the attributes");
  const std::vector<std::string> known = {"light", "material", "medium", "shape", "texture"};
  if (std::find(known.begin(), known.end(), target) == known.end())
    throw SceneError(where_, fmt::format("Attribute '{}', expected light, material, medium, shape or texture{}", target,
                                         did_you_mean(target, known)));
  std::vector<Parameter> list = read_parameters(tokens);
  for (Parameter& parameter : list) parameter.optional = true;
  auto& before = reader_.attributes.defaults[target];
  if (before)
    for (const Parameter& old : *before)
      if (std::none_of(list.begin(), list.end(), [&](const Parameter& p) { return p.name == old.name; }))
        list.push_back(old);
  before = std::make_shared<const std::vector<Parameter>>(std::move(list));
}

void SceneBuilder::attribute_begin(Tokens&) { save("AttributeBegin"); }
void SceneBuilder::attribute_end(Tokens&) { restore("AttributeBegin", reader_.attributes); }

void SceneBuilder::camera(Tokens& tokens) {
  options_["Camera"] = read_arguments(tokens, "camera");
  world_from_camera_ = reader_.attributes.transform.inverse();
  coordinate_systems_["camera"] = world_from_camera_;
  camera_medium_ = reader_.attributes.outside;
}

void SceneBuilder::color_space(Tokens& tokens) {
  const std::string name = read_string(tokens, "a color space");
  const std::vector<std::string>& known = color_space_names();
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end())
    throw SceneError(where_,
                     fmt::format("unknown color space '{}'{}{}", name, did_you_mean(name, known), known_names(known)));
  reader_.attributes.color_space = static_cast<std::size_t>(found - known.begin());
}

void SceneBuilder::film(Tokens& tokens) { options_["Film"] = read_arguments(tokens, "film"); }

void SceneBuilder::import(Tokens& tokens) {
  save("Import");
  include(tokens);
  restore("Import", reader_.attributes);
}

void SceneBuilder::include(Tokens& tokens) {
  const std::string name = read_string(tokens, "a file name");
  const SourceLocation where = where_;
  read_file(reader_.find_file(name, where), where);
  where_ = where;
}

void SceneBuilder::integrator(Tokens& tokens) { options_["Integrator"] = read_arguments(tokens, "integrator"); }

void SceneBuilder::light_source(Tokens& tokens) {
  DirectiveArguments entity = read_arguments(tokens, "light");
  read_or_omit("light", [&] { read_light(reader_, std::move(entity)); });
}

void SceneBuilder::make_named_material(Tokens& tokens) {
  DirectiveArguments entity = read_arguments(tokens, "material");
  const std::string name = entity.type;
  if (reader_.materials.contains(name)) throw SceneError(where_, fmt::format("a second material '{}'", name));
  entity.type = take_type(entity, "MakeNamedMaterial");
  reader_.materials[name] = make_material(reader_, name, std::move(entity));
}

void SceneBuilder::make_named_medium(Tokens& tokens) {
  DirectiveArguments entity = read_arguments(tokens, "medium");
  const std::string name = entity.type;
  entity.type = take_type(entity, "MakeNamedMedium");
  read_medium(reader_, name, std::move(entity));
}

void SceneBuilder::material(Tokens& tokens) {
  reader_.attributes.material = make_material(reader_, "", read_arguments(tokens, "material"));
}

void SceneBuilder::medium_interface(Tokens& tokens) {
  const std::string inside = read_string(tokens, "a medium");
  const bool two = tokens.current().kind == Token::Kind::kString;
  reader_.attributes.inside = inside;
  reader_.attributes.outside = two ? read_string(tokens, "a medium") : inside;
}

void SceneBuilder::named_material(Tokens& tokens) {
  const std::string name = read_string(tokens, "a material");
  const auto found = reader_.materials.find(name);
  if (found == reader_.materials.end()) {
    std::vector<std::string> known;
    for (const auto& entry : reader_.materials) known.push_back(entry.first);
    throw SceneError(where_, fmt::format("the material '{}' is not defined yet{}", name, did_you_mean(name, known)));
  }
  reader_.attributes.material = found->second;
}

void SceneBuilder::object_begin(Tokens& tokens) {
  const std::string name = read_string(tokens, "a name");
  if (reader_.object != nullptr) throw SceneError(where_, "ObjectBegin inside of another object");
  Object& object = reader_.objects[name];
  if (object.defined) throw SceneError(where_, fmt::format("a second object '{}'", name));
  object.defined = true;
  object.where = object.group.where = where_;
  save("ObjectBegin");
  reader_.object = &object;
}

void SceneBuilder::object_end(Tokens&) {
  restore("ObjectBegin", reader_.attributes);
  reader_.object = nullptr;
}

void SceneBuilder::object_instance(Tokens& tokens) {
  const std::string name = read_string(tokens, "an object");
  if (reader_.object != nullptr)
    throw SceneError(where_, "ObjectInstance inside an object, expected it after ObjectEnd");
  Object& object = reader_.objects[name];
  if (object.where.file.empty()) object.where = where_;
  const Placement placement = reader_.placement(reader_.attributes.transform, where_);
  if (!is_usable_placement(placement))
    throw SceneError(
        where_,
        "the transform of the instance is singular or too extreme, expected scale factors between 1e-9 and 1e9");
  object.instances.push_back({rows_of(placement.to_world), 0, add_motion(reader_.description.motions, placement)});
}

void SceneBuilder::option(Tokens& tokens) {
  constexpr std::string_view kKnown[] = {"disablepixeljitter",
                                         "disabletexturefiltering",
                                         "disablewavelengthjitter",
                                         "displacementedgescale",
                                         "forcediffuse",
                                         "msereferenceimage",
                                         "msereferenceout",
                                         "pixelstats",
                                         "rendercoordsys",
                                         "seed",
                                         "wavefront"};
  for (const Parameter& parameter : read_parameters(tokens)) {
    if (std::find(std::begin(kKnown), std::end(kKnown), parameter.name) == std::end(kKnown))
      throw SceneError(parameter.where,
                       fmt::format("unknown option '{}'{}", parameter.name,
                                   did_you_mean(parameter.name, {std::begin(kKnown), std::end(kKnown)})));
    if (parameter.name == "seed" && parameter.numbers.size() == 1 && parameter.numbers[0] >= 0 &&
        parameter.numbers[0] < 4294967296.0)
      reader_.description.sampler.seed = static_cast<std::uint32_t>(parameter.numbers[0]);
    else if (parameter.name == "forcediffuse" || parameter.name == "disablepixeljitter")
      reader_.note(parameter.where, fmt::format("option '{}' ignored", parameter.name));
  }
}

void SceneBuilder::pixel_filter(Tokens& tokens) { options_["PixelFilter"] = read_arguments(tokens, "filter"); }
void SceneBuilder::sampler(Tokens& tokens) { options_["Sampler"] = read_arguments(tokens, "sampler"); }

void SceneBuilder::shape(Tokens& tokens) {
  DirectiveArguments entity = read_arguments(tokens, "shape");
  read_or_omit("shape", [&] { read_shape(reader_, std::move(entity)); });
}

void SceneBuilder::texture(Tokens& tokens) {
  const std::string name = read_string(tokens, "a name"), kind = read_string(tokens, "float or spectrum");
  read_texture(reader_, name, kind, read_arguments(tokens, "texture"));
}

void SceneBuilder::world_begin(Tokens&) {
  in_world_ = true;
  const auto option = [&](const char* directive, const char* standard) {
    const auto found = options_.find(directive);
    return found != options_.end() ? std::move(found->second) : DirectiveArguments{standard, {}, where_};
  };
  // Determine the exposure time
  DirectiveArguments camera = option("Camera", "perspective");
  const ShutterDescription shutter = read_shutter(reader_, camera);
  // Read the rendering options, then reset the transform
  read_film(reader_, option("Film", "rgb"), static_cast<float>(exposure_time(shutter)));
  read_filter(reader_, option("PixelFilter", "gaussian"));
  reader_.description.shutter = shutter;
  pbrt::read_camera(reader_, std::move(camera), world_from_camera_, camera_medium_);
  read_sampler(reader_, option("Sampler", "zsobol"));
  read_integrator(reader_, option("Integrator", "volpath"));
  reader_.attributes.transform = {};
  reader_.attributes.start_is_active = reader_.attributes.end_is_active = true;
  coordinate_systems_["world"] = {};
}

}  // namespace sheaf::pbrt
