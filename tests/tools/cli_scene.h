// A scene that renders in a moment, for tests of the command line.
#pragma once

namespace sheaf::test {

/// A gray sphere in a white environment, `size` x 16 pixels with a default `size` of 24.
inline constexpr const char* kScene = R"(<scene version="3.0.0">
  <default name="size" value="24"/>
  <integrator type="path"><integer name="max_depth" value="6"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="$size"/><integer name="height" value="16"/><rfilter type="box"/>
    </film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
  <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
</scene>)";

}  // namespace sheaf::test
