// Reading of glTF: tinygltf parses the document; this file checks it and converts it to structures of our own.
#include <nlohmann/json.hpp>

#include <fstream>

#define TINYGLTF_IMPLEMENTATION
#include "scene/formats/gltf_library.h"
#undef TINYGLTF_IMPLEMENTATION

#include "scene/formats/gltf_document.h"
#include "scene/formats/meshopt.h"

#include <algorithm>
#include <cstdlib>
#include <set>

namespace sheaf {

namespace {

/// Largest number of elements in accessors without a buffer view: they are zero, or in a compressed mesh.
constexpr std::size_t kMaxZeros = std::size_t{1} << 25;

/// Extensions that are read, or that change nothing.
constexpr std::string_view kSupported[] = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
};

std::string at(const char* list, std::size_t i) { return fmt::format("{}[{}]", list, i); }

/// Converts a parsed document.
class Converter : GltfChecker {
 public:
  Converter(const tinygltf::Model& from, GltfFile& to) : GltfChecker(from, to) {}

  void convert() {
    out.generator = model.asset.generator;
    check_extensions();
    convert_views();
    for (std::size_t i = 0; i < model.accessors.size(); ++i)
      out.accessors.push_back(accessor(model.accessors[i], at("accessors", i)));
    take_embedded_images();
    convert_materials(*this);
    for (std::size_t i = 0; i < model.meshes.size(); ++i) out.meshes.push_back(mesh(model.meshes[i], at("meshes", i)));
    convert_lights();
    for (std::size_t i = 0; i < model.cameras.size(); ++i)
      out.cameras.push_back(camera(model.cameras[i], at("cameras", i)));
    for (std::size_t i = 0; i < model.skins.size(); ++i) out.skins.push_back(skin(model.skins[i], at("skins", i)));
    for (std::size_t i = 0; i < model.nodes.size(); ++i) out.nodes.push_back(node(model.nodes[i], at("nodes", i)));
    for (std::size_t i = 0; i < model.animations.size(); ++i)
      out.animations.push_back(animation(model.animations[i], at("animations", i)));
    choose_scene();
  }

 private:
  void check_extensions() const {
    const auto supported = [](const std::string& name) {
      return std::find(std::begin(kSupported), std::end(kSupported), name) != std::end(kSupported);
    };
    for (const std::string& name : model.extensionsRequired)
      if (!supported(name))
        throw out.error("extensionsRequired",
                        fmt::format("the file needs {}, which Sheaf does not support", in_quotes(name)));
    for (const std::string& name : model.extensionsUsed)
      if (!supported(name))
        out.notes.push_back(out.error("extensionsUsed", in_quotes(name) + " is not supported (ignored)").what());
  }

  void convert_views() {
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
      const tinygltf::BufferView& from = model.bufferViews[i];
      const std::string part = at("bufferViews", i);
      GltfView view = {required(from.buffer, out.buffers.size(), part, "buffer"), from.byteOffset, from.byteLength,
                       from.byteStride};
      for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const auto found = from.extensions.find(name);
        if (found == from.extensions.end()) continue;
        view = decompress(found->second, part);
        break;
      }
      check_range(view, part);
      out.views.push_back(view);
    }
  }

  void check_range(const GltfView& view, const std::string& part) const {
    const std::size_t size = out.buffers[static_cast<std::size_t>(view.buffer)].size();
    if (view.offset <= size && view.length <= size - view.offset) return;
    throw out.error(part, fmt::format("ends behind its buffer of {} bytes", size));
  }

  std::size_t size(const tinygltf::Value& object, const char* name, const std::string& part) const {
    const int value = integer(object, name, 0, part);
    if (value < 0) throw out.error(part, fmt::format("'{}' is negative", name));
    return static_cast<std::size_t>(value);
  }

  /// Decompresses a view into a buffer of its own.
  GltfView decompress(const tinygltf::Value& from, const std::string& part) {
    const GltfView packed = {required(integer(from, "buffer", kNoIndex, part), out.buffers.size(), part, "buffer"),
                             size(from, "byteOffset", part), size(from, "byteLength", part), 0};
    check_range(packed, part);
    const MeshoptCompression compression{size(from, "count", part), size(from, "byteStride", part),
                                         text(from, "mode", ""), text(from, "filter", "NONE")};
    const std::span<const std::uint8_t> bytes(out.buffers[static_cast<std::size_t>(packed.buffer)]);
    auto decoded = decode_meshopt(compression, bytes.subspan(packed.offset, packed.length));
    if (!decoded) throw out.error(part, "its compressed data is invalid");
    out.buffers.push_back(std::move(*decoded));
    return {static_cast<int>(out.buffers.size() - 1), 0, out.buffers.back().size(), compression.stride};
  }

  GltfComponent component(int type, const std::string& part) const {
    for (const GltfComponent known :
         {GltfComponent::kByte, GltfComponent::kUnsignedByte, GltfComponent::kShort, GltfComponent::kUnsignedShort,
          GltfComponent::kUnsignedInt, GltfComponent::kFloat})
      if (static_cast<int>(known) == type) return known;
    throw out.error(part, fmt::format("'componentType' is {}, expected 5120 to 5123, 5125 or 5126", type));
  }

  /// Throws SceneError unless `count` elements lie inside the view.
  void check_elements(int view_index, std::size_t offset, std::size_t count, std::size_t element,
                      const std::string& part) const {
    const GltfView& view = out.views[static_cast<std::size_t>(view_index)];
    const std::size_t stride = std::max(view.stride, element);
    const bool fits = offset <= view.length && element <= view.length - offset &&
                      count - 1 <= (view.length - offset - element) / stride;
    if (count > 0 && !fits) throw out.error(part, "ends behind its buffer view");
  }

  GltfAccessor accessor(const tinygltf::Accessor& from, const std::string& part) const {
    GltfAccessor to;
    to.view = index(from.bufferView, out.views.size(), part, "bufferView");
    to.offset = from.byteOffset;
    to.count = from.count;
    to.type = component(from.componentType, part);
    to.normalized = from.normalized && to.type != GltfComponent::kFloat;
    to.components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(from.type));
    if (to.components < 1) throw out.error(part, "'type' is not valid");
    const std::size_t element = element_bytes(to.type, to.components);
    if (to.view != kNoIndex) {
      check_elements(to.view, to.offset, to.count, element, part);
    } else if (to.count > kMaxZeros) {
      throw out.error(part, fmt::format("has {} elements without data", to.count));
    }
    if (from.sparse.isSparse) to.sparse = sparse(from, to, element, part);
    return to;
  }

  GltfAccessor::Sparse sparse(const tinygltf::Accessor& from, const GltfAccessor& to, std::size_t element,
                              const std::string& part) const {
    const auto& s = from.sparse;
    GltfAccessor::Sparse out_sparse;
    if (s.count < 0 || static_cast<std::size_t>(s.count) > to.count || s.indices.byteOffset < 0 ||
        s.values.byteOffset < 0)
      throw out.error(part, "its sparse elements are not valid");
    out_sparse.count = static_cast<std::size_t>(s.count);
    out_sparse.index_view = required(s.indices.bufferView, out.views.size(), part, "sparse.indices.bufferView");
    out_sparse.value_view = required(s.values.bufferView, out.views.size(), part, "sparse.values.bufferView");
    out_sparse.index_offset = static_cast<std::size_t>(s.indices.byteOffset);
    out_sparse.value_offset = static_cast<std::size_t>(s.values.byteOffset);
    out_sparse.index_type = component(s.indices.componentType, part);
    check_elements(out_sparse.index_view, out_sparse.index_offset, out_sparse.count,
                   element_bytes(out_sparse.index_type, 1), part);
    check_elements(out_sparse.value_view, out_sparse.value_offset, out_sparse.count, element, part);
    return out_sparse;
  }

  /// Copies the bytes of images in buffer views; see take_bytes().
  void take_embedded_images() {
    for (std::size_t i = 0; i < model.images.size(); ++i) {
      if (model.images[i].uri != "view") continue;
      const std::string part = at("images", i);
      int view_index = kNoIndex;
      const std::string& digits = model.images[i].name;
      if (digits.size() < 10) view_index = std::stoi(digits);
      view_index = required(view_index, out.views.size(), part, "bufferView");
      const GltfView& view = out.views[static_cast<std::size_t>(view_index)];
      const std::uint8_t* first = out.buffers[static_cast<std::size_t>(view.buffer)].data() + view.offset;
      out.images[i].encoded = std::make_shared<const EncodedImage>(
          EncodedImage{{first, first + view.length}, fmt::format("{}: {}", out.file.string(), part)});
    }
  }

  GltfAttributes attributes(const std::map<std::string, int>& from, const std::string& part) const {
    for (const auto& [name, value] : from) required(value, out.accessors.size(), part, name.c_str());
    return from;
  }

  GltfMesh mesh(const tinygltf::Mesh& from, const std::string& part) const {
    GltfMesh to;
    to.name = from.name;
    for (std::size_t i = 0; i < from.primitives.size(); ++i)
      to.primitives.push_back(primitive(from.primitives[i], fmt::format("{}.{}", part, at("primitives", i))));
    for (const double weight : from.weights) to.weights.push_back(number(weight, part, "weights"));
    return to;
  }

  GltfPrimitive primitive(const tinygltf::Primitive& from, const std::string& part) const {
    GltfPrimitive to;
    to.attributes = attributes(from.attributes, part);
    const auto without_view = from.extensions.find(kIndicesWithoutView);
    const int indices = without_view == from.extensions.end()
                            ? from.indices
                            : integer(without_view->second, "accessor", kNoIndex, part);
    to.indices = index(indices, out.accessors.size(), part, "indices");
    to.material = index(from.material, out.materials.size(), part, "material");
    if (from.mode < 0 || from.mode > TINYGLTF_MODE_TRIANGLE_FAN)
      throw out.error(part, fmt::format("'mode' is {}, expected 0 to 6", from.mode));
    to.mode = static_cast<GltfPrimitive::Mode>(from.mode);
    for (const auto& target : from.targets) to.targets.push_back(attributes(target, part));
    const auto draco = from.extensions.find("KHR_draco_mesh_compression");
    if (draco == from.extensions.end()) return to;
    to.draco.emplace();
    to.draco->view =
        required(integer(draco->second, "bufferView", kNoIndex, part), out.views.size(), part, "bufferView");
    if (const tinygltf::Value* ids = find(draco->second, "attributes"))
      for (const std::string& name : ids->Keys()) to.draco->ids[name] = integer(*ids, name.c_str(), 0, part);
    return to;
  }

  void convert_lights() {
    for (std::size_t i = 0; i < model.lights.size(); ++i) {
      const tinygltf::Light& from = model.lights[i];
      const std::string part = at("KHR_lights_punctual.lights", i);
      GltfLight to;
      to.name = from.name;
      if (from.type == "directional") {
        to.kind = GltfLight::Kind::kDirectional;
      } else if (from.type == "spot") {
        to.kind = GltfLight::Kind::kSpot;
      } else if (from.type != "point") {
        throw out.error(part,
                        fmt::format("'type' is {}, expected 'directional', 'point' or 'spot'", in_quotes(from.type)));
      }
      if (from.color.size() == 3)
        to.color = {number(from.color[0], part, "color"), number(from.color[1], part, "color"),
                    number(from.color[2], part, "color")};
      to.intensity = number(from.intensity, part, "intensity");
      to.inner_angle = number(from.spot.innerConeAngle, part, "innerConeAngle");
      to.outer_angle = number(from.spot.outerConeAngle, part, "outerConeAngle");
      out.lights.push_back(std::move(to));
    }
  }

  GltfCamera camera(const tinygltf::Camera& from, const std::string& part) const {
    GltfCamera to;
    to.name = from.name;
    to.perspective = from.type != "orthographic";
    to.yfov = number(from.perspective.yfov, part, "yfov");
    to.aspect = number(from.perspective.aspectRatio, part, "aspectRatio");
    to.xmag = number(from.orthographic.xmag, part, "xmag");
    to.ymag = number(from.orthographic.ymag, part, "ymag");
    to.near_clip = number(to.perspective ? from.perspective.znear : from.orthographic.znear, part, "znear");
    const double far = number(to.perspective ? from.perspective.zfar : from.orthographic.zfar, part, "zfar");
    if (far > 0) to.far_clip = far;
    if (to.perspective && !(to.yfov > 0 && to.yfov < 3.14159)) throw out.error(part, "'yfov' is not in (0, pi)");
    if (!to.perspective && (to.xmag == 0 || to.ymag == 0)) throw out.error(part, "'xmag' or 'ymag' is zero");
    const auto read_extra = [&](const char* name, double& value) {
      if (!from.extras.IsObject() || !from.extras.Has(name)) return;
      const tinygltf::Value& extra = from.extras.Get(name);
      if (!extra.IsNumber()) throw out.error(part, in_quotes(name) + " of 'extras' is not a number");
      value = number(extra.GetNumberAsDouble(), part, name);
    };
    read_extra("aperture_radius", to.aperture_radius);
    read_extra("focus_distance", to.focus_distance);
    read_extra("principal_point_offset_x", to.principal_point_offset_x);
    read_extra("principal_point_offset_y", to.principal_point_offset_y);
    return to;
  }

  GltfSkin skin(const tinygltf::Skin& from, const std::string& part) const {
    GltfSkin to;
    for (const int joint : from.joints) to.joints.push_back(required(joint, model.nodes.size(), part, "joints"));
    to.inverse_bind_matrices = index(from.inverseBindMatrices, out.accessors.size(), part, "inverseBindMatrices");
    if (to.inverse_bind_matrices == kNoIndex) return to;
    const GltfAccessor& matrices = out.accessors[static_cast<std::size_t>(to.inverse_bind_matrices)];
    if (matrices.count < to.joints.size() || matrices.components != 16)
      throw out.error(part, "'inverseBindMatrices' has no matrix for every joint");
    return to;
  }

  template <std::size_t kSize>
  void set(std::array<double, kSize>& to, const std::vector<double>& from, const std::string& part,
           const char* name) const {
    if (from.empty()) return;
    if (from.size() != kSize)
      throw out.error(part, fmt::format("'{}' has {} numbers, expected {}", name, from.size(), kSize));
    for (std::size_t i = 0; i < kSize; ++i) to[i] = precise_number(from[i], part, name);
  }

  GltfNode node(const tinygltf::Node& from, const std::string& part) const {
    GltfNode to;
    to.name = from.name;
    for (const int child : from.children) to.children.push_back(required(child, model.nodes.size(), part, "children"));
    to.mesh = index(from.mesh, out.meshes.size(), part, "mesh");
    to.skin = index(from.skin, out.skins.size(), part, "skin");
    to.camera = index(from.camera, out.cameras.size(), part, "camera");
    set(to.pose.translation, from.translation, part, "translation");
    set(to.pose.rotation, from.rotation, part, "rotation");
    set(to.pose.scale, from.scale, part, "scale");
    std::array<double, 16> columns{};
    set(columns, from.matrix, part, "matrix");
    if (!from.matrix.empty()) {
      to.matrix.emplace();
      for (std::size_t i = 0; i < 16; ++i) to.matrix->m[i % 4][i / 4] = columns[i];
    }
    for (const double weight : from.weights) to.weights.push_back(number(weight, part, "weights"));
    const auto light = from.extensions.find("KHR_lights_punctual");
    if (light != from.extensions.end())
      to.light = index(integer(light->second, "light", kNoIndex, part), out.lights.size(), part, "light");
    const auto instancing = from.extensions.find("EXT_mesh_gpu_instancing");
    if (instancing == from.extensions.end()) return to;
    if (const tinygltf::Value* accessors = find(instancing->second, "attributes"))
      for (const std::string& name : accessors->Keys())
        to.instances[name] =
            required(integer(*accessors, name.c_str(), kNoIndex, part), out.accessors.size(), part, name.c_str());
    return to;
  }

  GltfAnimation animation(const tinygltf::Animation& from, const std::string& part) const {
    using Channel = GltfAnimation::Channel;
    constexpr const char* kPaths[] = {"translation", "rotation", "scale", "weights"};
    GltfAnimation to;
    to.name = from.name;
    for (std::size_t i = 0; i < from.channels.size(); ++i) {
      const std::string location = fmt::format("{}.{}", part, at("channels", i));
      const tinygltf::AnimationChannel& channel = from.channels[i];
      if (channel.target_node == kNoIndex) continue;  // the target is defined by an extension
      const auto path = std::find(std::begin(kPaths), std::end(kPaths), channel.target_path);
      if (path == std::end(kPaths)) continue;
      const int sampler = required(channel.sampler, from.samplers.size(), location, "sampler");
      const tinygltf::AnimationSampler& s = from.samplers[static_cast<std::size_t>(sampler)];
      Channel c;
      c.node = index(channel.target_node, model.nodes.size(), location, "target.node");
      c.path = static_cast<Channel::Path>(path - std::begin(kPaths));
      c.times = required(s.input, out.accessors.size(), location, "input");
      c.values = required(s.output, out.accessors.size(), location, "output");
      if (s.interpolation == "STEP") c.interpolation = Channel::Interpolation::kStep;
      if (s.interpolation == "CUBICSPLINE") c.interpolation = Channel::Interpolation::kCubic;
      to.channels.push_back(c);
    }
    return to;
  }

  /// Sets the roots of the default scene and checks that the nodes form a forest.
  void choose_scene() {
    std::vector<int> parents(out.nodes.size(), kNoIndex);
    for (std::size_t i = 0; i < out.nodes.size(); ++i)
      for (const int child : out.nodes[i].children) {
        int& parent = parents[static_cast<std::size_t>(child)];
        if (parent != kNoIndex) throw out.error(at("nodes", static_cast<std::size_t>(child)), "has two parents");
        parent = static_cast<int>(i);
      }
    if (model.scenes.empty()) {
      for (std::size_t i = 0; i < parents.size(); ++i)
        if (parents[i] == kNoIndex) out.roots.push_back(static_cast<int>(i));
    } else {
      const int scene = index(model.defaultScene, model.scenes.size(), "scene", "scene");
      const std::size_t chosen = scene == kNoIndex ? 0 : static_cast<std::size_t>(scene);
      std::set<int> roots;
      for (const int root : model.scenes[chosen].nodes) {
        const std::string part = at("scenes", chosen);
        required(root, out.nodes.size(), part, "nodes");
        if (parents[static_cast<std::size_t>(root)] != kNoIndex)
          throw out.error(part, fmt::format("node {} is no root", root));
        if (roots.insert(root).second) out.roots.push_back(root);
      }
    }
  }
};

/// Throws SceneError for files of another major version, and for those that need a later minor version (glTF 2.0, 3.2).
void check_version(const nlohmann::json& document, GltfFile& out) {
  const auto member = [&](const char* name) {
    const nlohmann::json::json_pointer location(std::string("/asset/") + name);
    return document.contains(location) && document[location].is_string() ? document[location].get<std::string>()
                                                                         : std::string();
  };
  const std::string version = member("version"), needed = member("minVersion");
  if (!version.empty() && !version.starts_with("2."))
    throw SceneError(SourceLocation{out.file.string(), 0},
                     fmt::format("has version {} of glTF, expected 2; convert it with a tool for glTF 1", version));
  if (std::strtod(needed.c_str(), nullptr) > 2)
    throw out.error("asset", fmt::format("'minVersion' is {}, but Sheaf reads version 2.0", in_quotes(needed)));
  if (!version.empty() && version != "2.0")
    out.notes.push_back(out.error("asset", fmt::format("has version {} (read as version 2.0)", version)).what());
}

tinygltf::Model parse(const GltfDocument& document, const std::filesystem::path& file) {
  tinygltf::Model model;
  tinygltf::TinyGLTF parser;
  std::string error, warning;
  bool parsed = false;
  try {
    const std::string text = document.json->dump();
    if (text.size() > 0xffffffffu)
      throw SceneError(SourceLocation{file.string(), 0}, "has a document of more than 4 GB");
    parsed = parser.LoadASCIIFromString(&model, &error, &warning, text.data(), static_cast<unsigned int>(text.size()),
                                        "", tinygltf::REQUIRE_VERSION);
  } catch (const Error&) { throw; } catch (const std::exception& failure) {
    error = failure.what();
  }
  if (parsed && error.empty()) return model;
  error.erase(std::min(error.find('\n'), error.size()));
  throw SceneError(SourceLocation{file.string(), 0}, "is not a valid glTF document: " + error);
}

}  // namespace

std::vector<std::uint8_t> decode_base64(const std::string& text) {
  std::vector<std::uint8_t> bytes;
  std::string type;
  tinygltf::DecodeDataURI(&bytes, type, "data:application/octet-stream;base64," + text, 0, false);
  return bytes;
}

GltfFile read_gltf_file(const std::filesystem::path& file, const std::filesystem::path& folder) {
  GltfFile out;
  out.file = file;
  out.folder = folder;
  GltfDocument document = read_gltf_document(out);
  check_version(*document.json, out);
  take_bytes(document, out);
  adapt_document(*document.json, out);
  const tinygltf::Model model = parse(document, file);
  Converter(model, out).convert();
  return out;
}

}  // namespace sheaf
