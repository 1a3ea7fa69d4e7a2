// A glTF file of a triangle that rises by 0.5 within a second, seen by a camera.
#pragma once

#include "tests/support/files/gltf_files.h"

namespace sheaf::test {

inline GltfBuilder rising_triangle() {
  GltfBuilder gltf;
  gltf.add_triangle();
  const int times = gltf.add<float>({0, 1}, "SCALAR"), positions = gltf.add<float>({0, 0, 0, 0, 0.5f, 0}, "VEC3");
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 4}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  gltf.json["animations"].push_back(
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
       {"samplers", {{{"input", times}, {"output", positions}}}}});
  return gltf;
}

}  // namespace sheaf::test
