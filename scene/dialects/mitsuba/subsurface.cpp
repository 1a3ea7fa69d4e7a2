// The Mitsuba dialect: subsurface scattering of Mitsuba 0.6. A random walk in the medium replaces the dipole's
// diffusion approximation (Jensen et al. 2001, "A Practical Model for Subsurface Light Transport").
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_medium.h"
#include "scene/dialects/xml/read_phase.h"
#include "scene/materials/reading.h"

namespace sheaf::mitsuba {

namespace {

/// Returns the roughness of a material's dielectric boundary or coat; nullopt for smooth and other materials.
std::optional<RoughnessDescription> boundary_roughness(const Description& description, MaterialId material) {
  const auto& model = description.materials[static_cast<std::size_t>(material)].model;
  if (const auto* sides = std::get_if<TwoSidedDescription>(&model))
    return boundary_roughness(description, sides->front);
  if (const auto* plastic = std::get_if<PlasticDescription>(&model)) return plastic->roughness;
  if (const auto* dielectric = std::get_if<DielectricDescription>(&model)) return dielectric->roughness;
  if (const auto* coat = std::get_if<CoatDescription>(&model)) return coat->roughness;
  return std::nullopt;
}

/// Reads `intIOR` and `extIOR`. If both are absent, uses the preset's index of refraction against a vacuum.
void read_indices(Properties& p, Subsurface& subsurface) {
  const bool given = p.has("int_ior") || p.has("ext_ior");
  subsurface.int_ior = given ? read_ior(p, "int_ior", 1.5046f) : read_measured_medium(p).eta;
  subsurface.ext_ior = given ? read_ior(p, "ext_ior", 1.000277f) : 1.0f;
}

Subsurface read_dipole(Properties& p, Reader& reader) {
  Subsurface subsurface;
  MediumDescription medium;
  read_measured_coefficients(p, {.bbox_of_file = true}, medium);
  read_indices(p, subsurface);
  medium.scale = p.number("scale", 1, kNotNegative);
  if (const float g = p.number("g", 0, {-1, 1, true}); g != 0.0f) {
    Description& description = reader.context.description;
    description.phases.push_back({HenyeyGreensteinDescription{g}, p.where()});
    medium.phase = static_cast<PhaseId>(description.phases.size() - 1);
  }
  expect_homogeneous(p, medium);
  p.ignore({"irr_samples", "irr_indirect", "samples_per_pass", "quality", "sample_multiplier"});
  subsurface.medium = add_medium(p, std::move(medium));
  reader.context.note(
      p.where(),
      "'dipole' rendered as a dielectric around a scattering medium in place of the bsdf: its shape must be "
      "closed, and 'maxDepth' counts every scattering event");
  return subsurface;
}

constexpr NameTable<Subsurface (*)(Properties&, Reader&)> kSubsurface{{{"dipole", read_dipole}}};

}  // namespace

void read_subsurface(const XmlElement& element, Reader& reader, ShapeDescription& shape) {
  auto known = reader.subsurfaces.find(&element);
  if (known == reader.subsurfaces.end()) {
    Properties p(element, reader.context);
    known = reader.subsurfaces.emplace(&element, p.plugin(kSubsurface)(p, reader)).first;
  }
  const Subsurface& subsurface = known->second;
  DielectricDescription boundary;
  boundary.int_ior = subsurface.int_ior;
  boundary.ext_ior = subsurface.ext_ior;
  if (shape.material) boundary.roughness = boundary_roughness(reader.context.description, *shape.material);
  MaterialDescription material;
  material.model = std::move(boundary);
  material.where = element.where;
  shape.material = add_material(reader.context, std::move(material));
  shape.interior = subsurface.medium;
}

}  // namespace sheaf::mitsuba
