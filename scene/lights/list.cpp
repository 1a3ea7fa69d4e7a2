#include "scene/lights/list.h"

#include "scene/lights/light_context.h"
#include "scene/tables/scene_view.h"
#include "scene/xml/properties.h"

namespace sheaf {

namespace {

template <class Description> void add_readers(std::vector<LightReader>& all) {
  if constexpr (std::size(Description::kPlugins) > 0)
    for (const char* name : Description::kPlugins)
      all.push_back({name, [](Properties& p, LightDescription& out) { out.model = Description::read(p); }});
}

template <class... Descriptions> std::vector<LightReader> readers_of(const std::variant<Descriptions...>*) {
  std::vector<LightReader> all;
  (add_readers<Descriptions>(all), ...);
  return all;
}

}  // namespace

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
