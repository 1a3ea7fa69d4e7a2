// What the dialects share in reading participating media.
#pragma once

#include "scene/dialects/read_volume.h"

namespace sheaf {

/// Reads `sigma_t` and `albedo`, or `sigma_a` and `sigma_s`, into `medium`; of a pair, what is missing keeps its
/// default (1 and 0.75, or 0 and 0). Returns false if none of the four is there. Throws SceneError for a mixture.
bool read_coefficients(Properties& p, const VolumeDialect& dialect, MediumDescription& medium);

/// Reads `scale`, `emission` or `temperature`, `emission_scale`, `temperature_scale` and the phase function. Throws
/// SceneError.
void read_medium_rest(Properties& p, const VolumeDialect& dialect, MediumDescription& medium);

/// Throws SceneError if something of the medium varies in space.
void expect_homogeneous(const Properties& p, const MediumDescription& medium);

/// What was read from an element before, or nothing.
std::optional<MediumId> find_read_medium(const XmlElement& element, const ReadContext& context);
/// Finishes `p` and appends the medium with the place and id of its element, which is then read.
MediumId add_medium(Properties& p, MediumDescription medium);

}  // namespace sheaf
