// Two-sided materials: reading, and their rows.
#include "scene/materials/two_sided.h"

#include "scene/materials/flattener.h"
#include "scene/materials/material.h"
#include "scene/materials/reading.h"

namespace sheaf {

namespace {

/// Returns the material of one side: the nested material, or its front if that is two-sided.
MaterialId front_of(Properties& p, MaterialId id) {
  expect_opaque(p, id);
  const MaterialDescription& child = p.context().material_list[static_cast<std::size_t>(id)];
  if (const auto* both = std::get_if<TwoSidedDescription>(&child.model)) return both->front;
  return id;
}

}  // namespace

TwoSidedDescription TwoSidedDescription::read(Properties& p, const BsdfDialect& dialect) {
  const std::vector<const XmlElement*> sides = nested_bsdfs(p, 1, 2, "one or two");
  const MaterialId front = front_of(p, dialect.nested(*sides[0]));
  return {front, sides.size() == 2 ? front_of(p, dialect.nested(*sides[1])) : front};
}

std::uint32_t TwoSidedDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                                           const SourceLocation& where) const {
  if (around.two_sided) throw SceneError(where, "a two-sided material cannot hold another one");
  for (const MaterialId side : {front, back})
    if (flattener.transmits(side)) throw SceneError(where, "a two-sided material cannot hold one that transmits light");
  MaterialWrappers inside = around;
  inside.two_sided = true;
  const std::uint32_t front_row = flattener.flatten(front, inside);
  if (back == front) return front_row;
  return flattener.push_sides(front_row, flattener.flatten(back, inside));
}

}  // namespace sheaf
