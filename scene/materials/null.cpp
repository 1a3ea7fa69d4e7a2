#include "scene/materials/null.h"

#include "scene/materials/flattener.h"

namespace sheaf {

NullDescription NullDescription::read(Properties&, const BsdfDialect&) { return {}; }

std::uint32_t NullDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers&,
                                       const SourceLocation&) const {
  return flattener.push_choice(MaterialRow::kNothing, MaterialRow::kNothing, 0.0f);
}

}  // namespace sheaf
