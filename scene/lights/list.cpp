#include "scene/lights/list.h"

#include "scene/tables/scene_view.h"
#include "scene/xml/read_declared.h"

namespace sheaf {

namespace {

template <class Description> void add_readers(std::vector<LightReader>& all) {
  if constexpr (std::size(Description::kPlugins) > 0)
    for (const char* name : Description::kPlugins)
      all.push_back({name, [](Properties& p, LightDescription& out) {
                       out.model = read_model<Description>(p, SpectrumRole::kEmission);
                     }});
}

template <class... Descriptions> std::vector<LightReader> readers_of(const std::variant<Descriptions...>*) {
  std::vector<LightReader> all;
  (add_readers<Descriptions>(all), ...);
  return all;
}

}  // namespace

float scene_disk_area(const SceneView& scene) { return kPi * scene.radius * scene.radius; }

std::optional<CompiledLight> compile_light(const LightDescription& light, LightContext& context) {
  return std::visit(
      [&]<class Description>(const Description& model) {
        context.kind = LightKinds::kind_for<Description>();
        return model.compile(light.where, context);
      },
      light.model);
}

std::span<const LightCompiler> light_compilers() {
  static constexpr std::array kCompilers = [] {
    std::array<LightCompiler, LightKinds::kCount> all{};
    std::size_t next = 0;
    LightKinds::for_each([&]<class Kind>() { all[next++] = make_light_compiler<Kind>(); });
    return all;
  }();
  return kCompilers;
}

const LightCompiler& light_compiler_of(const LightRow& light) { return light_compilers()[light.kind]; }

std::span<const LightReader> light_readers() {
  static const std::vector<LightReader> kReaders = readers_of(static_cast<const LightKinds::Model*>(nullptr));
  return kReaders;
}

bool is_infinite(const LightRow& light) { return light_compiler_of(light).domain != LightDomain::kBounded; }

}  // namespace sheaf
