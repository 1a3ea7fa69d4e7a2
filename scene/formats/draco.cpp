// Meshes compressed by Draco (library draco).
#include "scene/formats/draco.h"

#include "core/io/error.h"

#ifdef SHEAF_HAS_DRACO
#include <draco/compression/decode.h>
#endif

namespace sheaf {

#ifdef SHEAF_HAS_DRACO

namespace {

/// The values of an attribute for each point of the mesh; nothing if they cannot be converted.
std::optional<DracoMesh::Attribute> values_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  constexpr int kMaxComponents = 16;
  const int components = attribute.num_components();
  if (components < 1 || components > kMaxComponents) return std::nullopt;
  DracoMesh::Attribute out;
  out.components = components;
  out.is_normalized = attribute.normalized();
  out.values.resize(std::size_t{mesh.num_points()} * static_cast<std::size_t>(components));
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    float* const to = out.values.data() + std::size_t{i} * static_cast<std::size_t>(components);
    if (value.value() >= attribute.size()) return std::nullopt;
    if (!attribute.ConvertValue(value, static_cast<std::int8_t>(components), to)) return std::nullopt;
  }
  return out;
}

}  // namespace

std::optional<DracoMesh> decode_draco(std::span<const std::uint8_t> bytes, const std::map<std::string, int>& ids) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return std::nullopt;
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  if (mesh == nullptr) return std::nullopt;
  DracoMesh out;
  for (const auto& [name, id] : ids) {
    const draco::PointAttribute* attribute =
        id < 0 ? nullptr : mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
    if (attribute == nullptr) return std::nullopt;
    std::optional<DracoMesh::Attribute> values = values_of(*mesh, *attribute);
    if (!values) return std::nullopt;
    out.attributes.emplace(name, std::move(*values));
  }
  out.triangles.reserve(mesh->num_faces());
  for (std::uint32_t i = 0; i < mesh->num_faces(); ++i) {
    const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(i));
    const std::array<std::uint32_t, 3> triangle{face[0].value(), face[1].value(), face[2].value()};
    for (const std::uint32_t corner : triangle)
      if (corner >= mesh->num_points()) return std::nullopt;
    out.triangles.push_back(triangle);
  }
  return out;
}

#else

std::optional<DracoMesh> decode_draco(std::span<const std::uint8_t>, const std::map<std::string, int>&) {
  throw SceneError("this build of Sheaf cannot read KHR_draco_mesh_compression: it was built without Draco");
}

#endif

}  // namespace sheaf
