// From the materials of OBJ files to those of the renderer.
#pragma once

#include "scene/description/description.h"
#include "scene/formats/mtl.h"

namespace sheaf {

/// Replaces every shape that is an OBJ file, has no material and whose faces use materials of an MTL file by one shape
/// for each material, a mesh in memory with the same transform, flags and radiance. Faces without a material of the
/// library have none. Normals of vertices are the same as without the cut; `creased`: where the file has none, they are
/// those of compute_creased_normals(), and files without materials become meshes in memory, too. Materials and textures
/// are added to the description, and notes for what is not supported and for libraries that are not found. A shape
/// without radiance gets the radiance Ke of its material. Throws SceneError for malformed OBJ and MTL files, and for
/// materials that none of the libraries has, all being there; `lenient`: leaves such shapes out, or gives them no
/// material, and says so.
void expand_obj_materials(Description& description, bool lenient = false, bool creased = false);

/// Adds what `material` looks like to the description, with its textures. `flip_tex_coords`: as read_obj() had it. The
/// first of these that fits:
///   - With illum 4, 6, 7 or 9 and Ni above 1 (or without Ni and d < 1 or Tf): a dielectric with transmittance Tf,
///     rough if Pr is above 0.
///   - With Pr, Pm, Ps, Pc, aniso or their maps: principled, with Kd for base colour.
///   - With illum 3 or 5 and Ks above Kd: a mirror that reflects Ks.
///   - With Ks, unless illum is 0 or 1: a rough plastic with Ks as factor on the coat's reflection, or a rough metal if
///     Kd is less than a tenth of Ks. The roughness is sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5.2).
///   - Else Lambertian reflection of Kd.
/// Maps take the place of what they are maps of. norm, or else map_Bump, turns the normal. All but dielectrics show
/// the same on both sides, and are masked by map_d or d.
MaterialId add_mtl_material(const MtlMaterial& material, bool flip_tex_coords, Description& description);

}  // namespace sheaf
