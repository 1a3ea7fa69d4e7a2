#include "scene/compile/scene_naming.h"

#include "scene/compile/overloaded.h"

namespace sheaf {

namespace {

/// Base of the names of unnamed shapes.
std::string kind_of(const ShapeDescription& shape) {
  return std::visit(Overloaded{
                        [](const MeshFileShape& mesh) { return mesh.file.stem().string(); },
                        [](const Mesh&) { return std::string("mesh"); },
                        [](const SphereShape&) { return std::string("sphere"); },
                        [](const RectangleShape&) { return std::string("rectangle"); },
                        [](const CubeShape&) { return std::string("cube"); },
                        [](const DiskShape&) { return std::string("disk"); },
                        [](const CylinderShape&) { return std::string("cylinder"); },
                        [](const Curves&) { return std::string("curves"); },
                        [](const SdfGrid&) { return std::string("sdfgrid"); },
                        [](const HeightFieldShape&) { return std::string("heightfield"); },
                        [](const DeformingMesh&) { return std::string("deformable"); },
                        [](const DeformingCurves&) { return std::string("deformable"); },
                    },
                    shape.geometry);
}

}  // namespace

std::uint32_t SceneNaming::index_of(const std::string& name, Index& index, std::vector<std::string>& names) {
  const auto [known, added] = index.try_emplace(name, static_cast<std::uint32_t>(names.size()));
  if (added) names.push_back(name);
  return known->second;
}

void SceneNaming::add_materials(const std::vector<MaterialDescription>& materials) {
  for (const MaterialDescription& material : materials)
    names_.materials.push_back(material.id.empty() ? fmt::format("material_{}", names_.materials.size() + 1)
                                                   : material.id);
  names_.materials.emplace_back("default");
}

void SceneNaming::add_shape(const ShapeDescription& shape, const ShapeGroup* group) {
  const std::string& given = shape.id.empty() && group != nullptr ? group->id : shape.id;
  const std::string name = given.empty() ? fmt::format("{}_{}", kind_of(shape), names_.objects.size() + 1) : given;
  names_.object_of_shape.push_back(index_of(name, objects_, names_.objects));
  const std::size_t no_material = names_.materials.size() - 1;
  const std::size_t material = shape.material ? static_cast<std::size_t>(*shape.material) : no_material;
  names_.material_of_shape.push_back(static_cast<std::uint32_t>(std::min(material, no_material)));
}

void SceneNaming::add_light(const std::string& label, const std::string& name) {
  // Distinguishes a light named "point" from unnamed point lights.
  const std::string key = name.empty() ? std::string(1, '\0') + label : name;
  const auto [known, added] = lights_.try_emplace(key, static_cast<std::uint32_t>(names_.lights.size()));
  if (added) names_.lights.push_back(name.empty() ? label : name);
  names_.light_of_row.push_back(known->second);
}

}  // namespace sheaf
