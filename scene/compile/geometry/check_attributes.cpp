// Checks that meshes have the attributes that their textures use.
#include "scene/compile/compile_lights.h"
#include "scene/compile/geometry/compile_geometry.h"

#include <set>

namespace sheaf {

namespace {

/// Finds the textures of materials that meshes must have an attribute for.
class AttributeFinder {
 public:
  /// `required`: the attributes of such textures, by row.
  AttributeFinder(const std::vector<MaterialRow>& materials, const std::vector<TextureBinding>& bindings,
                  const std::vector<NormalMapRow>& maps, const std::vector<TextureRow>& textures,
                  const std::map<std::uint32_t, std::uint32_t>& required)
      : materials_(materials), bindings_(bindings), maps_(maps), textures_(textures), required_(required) {}

  /// Rows of such textures that a material uses, including those of materials that it combines.
  std::set<std::uint32_t> of_material(std::uint32_t row) const {
    std::set<std::uint32_t> found, visited;
    add_material(row, visited, found);
    return found;
  }

  /// The same for a texture.
  std::set<std::uint32_t> of_texture(std::uint32_t row) const {
    std::set<std::uint32_t> found;
    add_texture(row, found);
    return found;
  }

 private:
  void add_material(std::uint32_t index, std::set<std::uint32_t>& visited, std::set<std::uint32_t>& found) const {
    if (index == MaterialRow::kNothing || !visited.insert(index).second) return;
    const MaterialRow& row = materials_[index];
    for (std::uint32_t i = 0; i < row.binding_count; ++i) add_texture(bindings_[row.first_binding + i].texture, found);
    if ((row.flags & kMapped) != 0) add_texture(maps_[row.map].texture, found);
    add_material(row.back, visited, found);
    if ((row.flags & kComposite) == 0) return;
    for (const std::uint32_t choice : row.choice) add_material(choice, visited, found);
  }

  void add_texture(std::uint32_t index, std::set<std::uint32_t>& found) const {
    const TextureRow& row = textures_[index];
    if (required_.contains(index)) found.insert(index);
    for (const std::uint32_t input : row.used_inputs()) add_texture(input, found);
  }

  const std::vector<MaterialRow>& materials_;
  const std::vector<TextureBinding>& bindings_;
  const std::vector<NormalMapRow>& maps_;
  const std::vector<TextureRow>& textures_;
  const std::map<std::uint32_t, std::uint32_t>& required_;
};

std::string title(const TextureDescription& texture) {
  return texture.id.empty() ? "texture" : fmt::format("texture '{}'", texture.id);
}

}  // namespace

std::vector<std::string> check_attributes(const Description& description, const CompiledGeometry& geometry,
                                          ErrorSink& errors, SceneTables& scene) {
  std::vector<std::string> warnings;
  if (scene.textures.required_attributes.empty()) return warnings;
  const std::map<std::uint32_t, std::uint32_t> required(scene.textures.required_attributes.begin(),
                                                        scene.textures.required_attributes.end());
  const AttributeFinder finder(scene.materials.rows, scene.materials.bindings, scene.materials.normal_maps,
                               scene.textures.rows, required);
  const auto name_of = [&](std::uint32_t texture) -> const std::string& {
    return scene.textures.attribute_names[required.at(texture)];
  };
  // Count the shapes with and without the attribute, by material and texture
  struct Use {
    std::size_t with = 0, without = 0;  ///< shapes with and without the attribute
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, Use> uses;
  std::map<std::uint32_t, std::set<std::uint32_t>> shown_by;
  const auto has = [&](std::uint32_t shape, std::uint32_t texture) {
    return geometry.attributes.has(shape, required.at(texture));
  };
  for (std::uint32_t shape = 0; shape < geometry.sources.size(); ++shape) {
    const std::uint32_t material = scene.geometry.shapes[shape].material;
    const auto [displayed, is_new] = shown_by.try_emplace(material);
    if (is_new) displayed->second = finder.of_material(material);
    for (const std::uint32_t texture : displayed->second) {
      Use& use = uses[{material, texture}];
      ++(has(shape, texture) ? use.with : use.without);
    }
  }
  std::set<std::uint32_t> missing;
  const auto report = [&](std::uint32_t texture, const char* what) {
    const std::string& name = name_of(texture);
    std::string known;
    for (const std::string& other : geometry.known_attributes) known += (known.empty() ? "" : ", ") + other;
    if (!missing.insert(texture).second) return;
    const SceneError error(
        description.textures[texture].where,
        fmt::format("{}: {} the attribute '{}' ({}){}", title(description.textures[texture]), what, name,
                    known.empty() ? "no mesh of the scene has any" : "the scene's meshes have " + known,
                    did_you_mean(name, {geometry.known_attributes.begin(), geometry.known_attributes.end()})),
        SceneErrorCode::kUnknownName);
    errors.report(error, kGraySubstitute);
  };
  // Report materials without any mesh that has the attribute, and warn if only some lack it
  for (const auto& [key, use] : uses) {
    if (use.without == 0) continue;
    if (use.with == 0) {
      report(key.second, "no mesh with this material has");
      continue;
    }
    const TextureDescription& texture = description.textures[key.second];
    warnings.push_back(
        SceneError(texture.where,
                   fmt::format("{}: {} of {} shapes with this material lack the attribute '{}', which is 0 there",
                               title(texture), use.without, use.with + use.without, name_of(key.second)))
            .what());
  }
  // Report emitters that lack it
  for (std::uint32_t shape = 0; shape < geometry.sources.size(); ++shape)
    for (const TextureId texture : emission_textures(*geometry.sources[shape].shape))
      for (const std::uint32_t displayed : finder.of_texture(static_cast<std::uint32_t>(texture)))
        if (!has(shape, displayed)) report(displayed, "the shape that emits it lacks");
  for (const std::uint32_t texture : missing) scene.textures.rows[texture] = gray_texture_row();
  return warnings;
}

}  // namespace sheaf
