// The Mitsuba dialect: shapes.
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_emitter.h"
#include "scene/dialects/read_geometry.h"

namespace sheaf::mitsuba {

namespace {

/// What light sources without a bsdf are made of: they reflect nothing.
MaterialId black_material(Reader& reader) {
  if (!reader.black) {
    MaterialDescription material;
    material.model = DiffuseDescription{SpectrumDescription::constant(0)};
    reader.black = add_material(reader.context, std::move(material));
  }
  return *reader.black;
}

/// A boundary that light does not notice.
MaterialId null_material(Reader& reader) {
  if (!reader.null) reader.null = add_material(reader.context, {NullDescription{}, true, true, {}, {}});
  return *reader.null;
}

void read_media(Properties& p, Reader& reader, ShapeDescription& shape) {
  if (const XmlElement* medium = p.named_object("medium", "interior")) shape.interior = medium_of(*medium, reader);
  if (const XmlElement* medium = p.named_object("medium", "exterior")) shape.exterior = medium_of(*medium, reader);
}

}  // namespace

void read_shape(const XmlElement& element, Reader& reader) {
  if (read_instancing(element, reader.context, [&](const XmlElement& e) { read_shape(e, reader); })) return;
  Properties p(element, reader.context);
  ShapeDescription shape;
  shape.where = element.where;
  if (!read_shared_geometry(p, true, shape)) p.fail_plugin(shared_shape_names());
  shape.to_world = p.transform("to_world");
  shape.flip_normals = p.boolean("flip_normals", false);
  if (const XmlElement* bsdf = p.object("bsdf")) shape.material = material_of(*bsdf, reader);
  if (const XmlElement* emitter = p.object("emitter"))
    read_area_emitter(*emitter, reader.context, shape,
                      {"sampling_weight", "caustic_emitter_single", "caustic_emitter_multi"});
  if (const XmlElement* sensor = p.object("sensor")) {
    const Transform turned = shape.flip_normals ? Transform::scale({-1, 1, -1}) : Transform();
    reader.shape_sensors.push_back({sensor, p.type(), shape.to_world * turned});
  }
  read_media(p, reader, shape);
  if (reader.before_version_2 && !shape.material && (shape.interior || shape.exterior))
    shape.material = null_material(reader);
  if (shape.radiance && !shape.material) shape.material = black_material(reader);
  p.accept({"silhouette_sampling_weight"});
  // Which shapes specular manifold sampling (Zeltner et al. 2020) makes caustics with: hints, no light.
  p.accept({"caustic_caster_single", "caustic_caster_multi", "caustic_bouncer", "caustic_receiver"});
  p.finish();
  reader.context.description.shapes.push_back(std::move(shape));
}

}  // namespace sheaf::mitsuba
