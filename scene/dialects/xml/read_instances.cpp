// Shape groups and instances.
#include "scene/dialects/xml/read_instances.h"

#include "scene/dialects/common/moving_groups.h"

namespace sheaf {

namespace {

bool is_group(const std::string& type) { return type == "shapegroup" || type == "ref"; }

/// Returns the index of a group. Reads each element once.
std::uint32_t group_of(const XmlElement& element, ReadContext& context, const ShapeReader& read_shape) {
  if (const auto known = context.groups.find(&element); known != context.groups.end()) return known->second;
  Properties p(element, context);
  ShapeGroup group;
  group.where = element.where;
  if (const std::string* id = element.find_attribute("id")) group.id = *id;
  std::vector<ShapeDescription>& shapes = context.description.shapes;
  const auto first = static_cast<std::ptrdiff_t>(shapes.size());
  context.in_group = true;
  for (const XmlElement* child : p.objects(element.name.c_str()))
    read_or_omit(*child, context, [&] { read_shape(*child); });
  context.in_group = false;
  p.reject_unused();
  std::move(shapes.begin() + first, shapes.end(), std::back_inserter(group.shapes));
  shapes.erase(shapes.begin() + first, shapes.end());
  context.description.groups.push_back(std::move(group));
  const auto index = static_cast<std::uint32_t>(context.description.groups.size() - 1);
  context.groups.emplace(&element, index);
  return index;
}

/// Returns the group that the string `ref` names, a syntax of some Nori forks; null without `ref`.
const XmlElement* find_named_group(Properties& p) {
  const std::optional<std::string> name = p.find_string("ref");
  if (!name) return nullptr;
  for (const XmlElement& child : p.context().scene.root().children) {
    const std::string *type = child.find_attribute("type"), *own = child.find_attribute("name");
    if (type != nullptr && is_group(*type) && own != nullptr && *own == *name) return &child;
  }
  p.fail_at("ref", fmt::format("is {}, expected the name of a shape group", in_quotes(*name)),
            SceneErrorCode::kUnknownName);
}

void read_instance(const XmlElement& element, ReadContext& context, const ShapeReader& read_shape) {
  Properties p(element, context);
  const XmlElement* target = p.object(element.name.c_str());
  if (target == nullptr) target = find_named_group(p);
  if (target == nullptr) p.fail("needs a <ref> to a shapegroup", SceneErrorCode::kMissing);
  if (!is_group(target->attribute("type")))
    p.fail(fmt::format("refers to a {}, expected a 'shapegroup'", in_quotes(target->attribute("type"))));
  InstanceDescription instance;
  instance.group = group_of(*target, context, read_shape);
  const auto read = [&] {
    Placement given = p.placement("to_world");
    if (!is_usable_placement(given))
      p.fail_at("to_world", "is singular or too extreme, expected scale factors between 1e-9 and 1e9",
                SceneErrorCode::kOutOfRange);
    return given;
  };
  const Placement placement = p.attempt("to_world", read).value_or(Placement());
  instance.to_world = rows_of(placement.to_world);
  p.reject_unused();
  instance.motion = add_motion(context.description.motions, placement);
  context.description.instances.push_back(instance);
}

}  // namespace

bool read_instancing(const XmlElement& element, ReadContext& context, const ShapeReader& read_shape) {
  const std::string* type = element.find_attribute("type");
  if (type == nullptr || (!is_group(*type) && *type != "instance")) return false;
  if (context.in_group)
    throw SceneError(element.where, in_quotes(*type) + " inside a shape group, expected plain shapes");
  if (*type == "instance") {
    read_instance(element, context, read_shape);
  } else {
    group_of(element, context, read_shape);
  }
  return true;
}

}  // namespace sheaf
