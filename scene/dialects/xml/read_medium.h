// Reading of participating media, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/dialects/xml/read_volume.h"

namespace sheaf {

/// Reads `sigma_t` and `albedo`, or `sigma_a` and `sigma_s`, into `medium`. A missing one of a pair keeps its default
/// (1 and 0.75, or 0 and 0). Returns false if all four are absent. Throws SceneError if the pairs are mixed.
bool read_coefficients(Properties& p, const VolumeDialect& dialect, MediumDescription& medium);

/// Reads `scale`, `emission` or `temperature`, `emission_scale`, `temperature_scale` and the phase function. Throws
/// SceneError.
void read_medium_rest(Properties& p, const VolumeDialect& dialect, MediumDescription& medium);

/// Throws SceneError if any property of the medium varies in space.
void expect_homogeneous(const Properties& p, const MediumDescription& medium);

/// Returns the medium read earlier from this element, or nullopt.
std::optional<MediumId> find_read_medium(const XmlElement& element, const ReadContext& context);
/// Finishes `p`, appends the medium with the location and id of its element, and records that the element is read.
MediumId add_medium(Properties& p, MediumDescription medium);

}  // namespace sheaf
