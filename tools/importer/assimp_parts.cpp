// Cameras and lights that Assimp has read, for formats that Sheaf does not read beside it (3D Studio).
#include "tools/importer/conversion.h"
#include "tools/importer/lens.h"

#include <assimp/camera.h>
#include <assimp/light.h>

#include <algorithm>
#include <cmath>

namespace sheaf::importer {

namespace {

std::array<double, 3> numbers(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Camera camera_of(const aiCamera& from) {
  constexpr double kAspect = 4.0 / 3, kAngle = 0.7;  // of cameras that do not say them
  Camera camera;
  camera.name = text(from.mName);
  camera.position = numbers(from.mPosition);
  camera.forward = numbers(from.mLookAt);
  camera.up = numbers(from.mUp);
  const double aspect = from.mAspect > 0 && std::isfinite(from.mAspect) ? double{from.mAspect} : kAspect;
  const double angle = from.mHorizontalFOV > 0 ? std::clamp(finite(from.mHorizontalFOV), 0.01, 3.1) : kAngle;
  set_perspective(camera, {std::tan(angle / 2), std::nullopt, aspect});
  return camera;
}

Light light_of(const aiLight& from) {
  Light light;
  light.name = text(from.mName);
  light.position = numbers(from.mPosition);
  light.direction = numbers(from.mDirection);
  light.kind = from.mType == aiLightSource_DIRECTIONAL ? Light::Kind::kDirectional
               : from.mType == aiLightSource_POINT     ? Light::Kind::kPoint
               : from.mType == aiLightSource_SPOT      ? Light::Kind::kSpot
                                                       : Light::Kind::kOther;
  light.color = {from.mColorDiffuse.r, from.mColorDiffuse.g, from.mColorDiffuse.b};
  light.attenuation = {from.mAttenuationConstant, from.mAttenuationLinear, from.mAttenuationQuadratic};
  light.inner_angle = from.mAngleInnerCone / 2;
  light.outer_angle = from.mAngleOuterCone / 2;
  return light;
}

}  // namespace

FileParts assimp_parts(const aiScene& scene) {
  FileParts out;
  const auto parts = [&](const aiString& name) -> NodeParts& {
    const bool exists = scene.mRootNode->FindNode(name) != nullptr;
    std::vector<NodeParts>& list = out.nodes[text(exists ? name : scene.mRootNode->mName)];
    list.resize(1);
    return list.front();
  };
  for (unsigned i = 0; i < scene.mNumCameras; ++i)
    add_valid(camera_of(*scene.mCameras[i]), parts(scene.mCameras[i]->mName), out.notes);
  for (unsigned i = 0; i < scene.mNumLights; ++i)
    parts(scene.mLights[i]->mName).lights.push_back(light_of(*scene.mLights[i]));
  return out;
}

}  // namespace sheaf::importer
