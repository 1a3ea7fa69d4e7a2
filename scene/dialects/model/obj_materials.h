// Conversion of OBJ/MTL materials to materials of the description.
#pragma once

#include "scene/description.h"
#include "scene/description/error_sink.h"
#include "scene/formats/mtl.h"

namespace sheaf {

/// Splits every OBJ shape without a material, whose faces use materials of an MTL file, into one in-memory mesh per
/// material. Transform, flags and radiance are kept. Faces without a library material get none. Splitting does not
/// change vertex normals. `creased`: computes missing normals with compute_creased_normals(); OBJ files without
/// materials become in-memory meshes, too. Adds materials and textures to the description, and notes for unsupported
/// features and for missing libraries. A shape without radiance gets the radiance Ke of its material, times its
/// opacity. Throws SceneError for malformed OBJ and MTL files. Throws it for materials that no library defines, if all
/// libraries were found. `lenient`: drops such shapes, or leaves them without a material, and reports it.
void expand_obj_materials(Description& description, ErrorSink& errors, bool creased = false);

/// Adds `material` with its textures to the description. `flip_tex_coords`: the flag passed to read_obj(). Selects the
/// first model whose conditions hold:
///   - illum 4, 6, 7 or 9 and Ni above 1 (or no Ni, and d < 1 or Tf): a dielectric with transmittance Tf, rough if Pr
///     is above 0.
///   - Pr, Pm, Ps, Pc, aniso or their maps: principled, with base color Kd.
///   - illum 3 or 5 and Ks above Kd: a mirror with reflectance Ks.
///   - Ks, unless illum is 0 or 1: a rough plastic with specular reflectance Ks, or a rough metal if Kd is less than a
///     tenth of Ks. The roughness is sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5.2).
///   - Otherwise: Lambertian reflection with albedo Kd.
/// Maps replace the constants that they belong to. norm, or else map_Bump, perturbs the normal. All materials except
/// dielectrics are two-sided and masked by map_d or d.
MaterialId add_mtl_material(const MtlMaterial& material, bool flip_tex_coords, Description& description);

}  // namespace sheaf
