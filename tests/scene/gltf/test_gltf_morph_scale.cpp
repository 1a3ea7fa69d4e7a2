// Morph targets that move vertices by much less than the size of the mesh.
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_gltf_morph_scale {

TEST_CASE("gltf morph scale: keys are kept however little the vertices move") {
  for (const float distance : {1e-5f, 1e-4f, 1e-2f, 1.0f}) {
    CAPTURE(distance);
    test::GltfBuilder gltf;
    gltf.add_triangle()["targets"] = {
        {{"POSITION", gltf.add<float>({0, 0, distance, 0, 0, distance, 0, 0, distance}, "VEC3")}}};
    // There and back
    const int times = gltf.add<float>({0, 0.5f, 1}, "SCALAR"), weights = gltf.add<float>({0, 1, 0}, "SCALAR");
    gltf.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                                {"samplers", {{{"input", times}, {"output", weights}, {"interpolation", "LINEAR"}}}}}};
    const TemporaryFolder folder;
    ReadOptions options;
    options.moment.time = 0;
    options.shutter = ShutterDescription{0, 1, 0};
    const Description d = read_scene(test::write_below(folder, "model.gltf", gltf.text()), options);
    const auto& mesh = std::get<DeformingMesh>(d.shapes.at(0).geometry);
    REQUIRE(mesh.keys.size() == 3);
    CHECK(double(std::get<Mesh>(mesh.keys[1].mesh).positions.at(1).z) == near(double(distance), 1e-5));
  }
}

}  // namespace sheaf::test_gltf_morph_scale
