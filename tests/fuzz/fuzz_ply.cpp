// Stanford PLY as a mesh, as ellipsoids and as a model.
#include "scene/formats/ellipsoids.h"
#include "tests/fuzz/fuzz_mesh.h"
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("mesh.ply", input);
  for (const BadFaces bad_faces : {BadFaces::kError, BadFaces::kDrop})
    reads([&] { try_mesh(read_ply(file, true, bad_faces)); });
  reads([&] { (void)read_ellipsoids(file, 2); });
  if (!leads_out(input)) try_scene(file);
}

}  // namespace sheaf::fuzz
