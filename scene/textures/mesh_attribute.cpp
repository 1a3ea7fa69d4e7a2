#include "scene/textures/mesh_attribute.h"

#include "scene/xml/properties.h"

namespace sheaf {

MeshAttributeDescription MeshAttributeDescription::read(Properties& p) {
  if (p.type() == "vertexcolors") return {"vertex_color"};
  const std::string name = p.required_string("name");
  if (!is_attribute_name(name))
    p.fail_at("name", fmt::format("is {}, expected a name that begins with vertex_ or face_", in_quotes(name)));
  return {name, p.number("scale", 1)};
}

}  // namespace sheaf
