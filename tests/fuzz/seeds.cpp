// sheaf_fuzz_seeds FOLDER: writes FOLDER/<target>/, small seed files of each kind, and FOLDER/<target>.dict, the
// dictionary of each kind. The files are those of the repository's scenes and tests, or generated here. The dictionary
// holds the strings in the sources of the reader.
#include "core/image/exr.h"
#include "core/image/formats/tiff.h"
#include "core/image/image.h"
#include "core/io/inflate.h"
#include "kernels/render/render_state.h"
#include "scene/formats/nanovdb.h"
#include "tests/fuzz/image_extensions.h"
#include "tests/support/files/deflate.h"
#include "tests/support/files/exr_files.h"
#include "tests/support/files/gltf_samples.h"
#include "tests/support/files/image_files.h"
#include "tests/support/files/import_files.h"
#include "tests/support/files/jpeg_files.h"
#include "tests/support/files/model_files.h"
#include "tests/support/files/png_files.h"
#include "tests/support/files/tiff_files.h"
#include "tests/support/temporary_folder.h"
#include "tools/job/parts.h"

#include <cctype>
#include <cstdio>
#include <set>

namespace sheaf::fuzz {

namespace {

namespace fs = std::filesystem;

template <class T> std::string raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}
template <class T> std::string raw(T value) { return raw(std::vector<T>{value}); }

class Seeds {
 public:
  explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}

  void add(const std::string& target, const std::string& bytes) {
    const fs::path to = folder_ / target;
    fs::create_directories(to);
    write_bytes(to / std::to_string(count_++), bytes);
  }

  /// Adds all files with an extension below a folder of the repository, except large ones.
  void add_files(const std::string& target, const char* below, const std::string& extension) {
    constexpr std::uintmax_t kLargest = 6000;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / below))
      if (entry.is_regular_file() && entry.path().extension() == extension && entry.file_size() <= kLargest)
        add(target, read_bytes(entry.path()));
  }

  /// Adds the words in string literals of the sources whose paths begin with a prefix, which may be a folder.
  void add_words(const std::string& target, const std::vector<std::string>& sources) {
    std::set<std::string> words;
    for (const std::string& source : sources) {
      const fs::path path = fs::path(SHEAF_SOURCE_DIR) / source;
      for (const fs::directory_entry& entry : fs::directory_iterator(path.parent_path()))
        if (entry.is_regular_file() && entry.path().filename().string().starts_with(path.filename().string()))
          add_words(words, read_bytes(entry.path()));
    }
    std::string dictionary;
    for (const std::string& word : words) dictionary += "\"" + word + "\"\n";
    write_bytes(folder_ / (target + ".dict"), dictionary);
  }

 private:
  static void add_words(std::set<std::string>& words, const std::string& source) {
    constexpr std::size_t kLongest = 24;
    const auto is_letter = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '-'; };
    for (std::size_t at = source.find('"'), end; at != std::string::npos; at = source.find('"', end)) {
      end = at + 1;
      while (end < source.size() && is_letter(static_cast<unsigned char>(source[end]))) ++end;
      if (end < source.size() && source[end] == '"' && end > at + 2 && end <= at + 1 + kLongest)
        words.insert(source.substr(at + 1, end - at - 1));
    }
  }

  fs::path folder_;
  int count_ = 0;
};

void add_scenes(Seeds& seeds) {
  for (const char* const below : {"scenes", "tests/references/scenes", "tests/renders/pbrt_twins"})
    seeds.add_files("xml", below, ".xml");
  seeds.add_words("xml", {"scene/dialects/common/", "scene/dialects/mitsuba/", "scene/dialects/nori/",
                          "scene/textures/", "scene/materials/", "scene/lights/", "scene/xml/"});
  for (const char* const below : {"scenes", "tests/renders/pbrt_twins"}) seeds.add_files("pbrt", below, ".pbrt");
  seeds.add_words("pbrt", {"scene/dialects/pbrt/"});
  seeds.add("pbrt", "WorldBegin\nTranslate $(1 + 2) $(cos(pi)) 0\nShape \"sphere\" \"float radius\" [ $(6 / 4) ]\n");
  seeds.add("xml",
            "<scene version='3.0.0'><sensor type='perspective'><float name='shutter_close' value='0.5'/>"
            "<float name='shutter_ramp' value='0.2'/><animation name='to_world'><transform time='0'/>"
            "<transform time='1'><lookat origin='0,1,5' target='0,0,0'/></transform></animation></sensor>"
            "<shape type='shapegroup' id='g'><shape type='cube'><animation name='to_world'><transform time='-1'>"
            "<rotate y='1' angle='170'/></transform><transform time='2'><scale x='2'/></transform></animation></shape>"
            "</shape><shape type='instance'><ref id='g'/><animation name='to_world'><transform time='0'/>"
            "<transform time='1'><translate x='1'/></transform></animation></shape></scene>");
  seeds.add("pbrt",
            "TransformTimes 0 0.5\nActiveTransform EndTime Translate 1 0 0\nCamera \"perspective\" \"float "
            "shutterclose\" 0.5\nWorldBegin\nActiveTransform StartTime Rotate 90 0 1 0 Scale 1 2 3\nActiveTransform "
            "All\nCoordinateSystem \"a\" Shape \"disk\"\nObjectBegin \"o\" Shape \"sphere\" ObjectEnd\nIdentity "
            "ActiveTransform EndTime Translate 0 1 0 ObjectInstance \"o\" CoordSysTransform \"a\"\n");
  for (const char* const text :
       {"0$(frame * 36)", "1f_$frame0_$(size % 4).png", "0$(-(1 + sin(2 * pi * frame / 48)) * 1e-3)",
        "1$name $x $(1 / 0)", "0$((((1))) - --2) $", "1$(cos(size)$(2"})
    seeds.add("expression", text);
  seeds.add_words("expression", {"scene/xml/expression", "scene/xml/definitions"});
}

void add_meshes(Seeds& seeds) {
  for (const char* const below : {"scenes", "tests/references/scenes/meshes"}) seeds.add_files("obj", below, ".obj");
  seeds.add("obj",
            "mtllib model.mtl\nv 0 0 0 1\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvn 0 0 1\nvt 0 0\nvt 1 1\n"
            "usemtl a\nf 1/1/1 2/2/1 3//1 \\\n4\nusemtl b\nf -1 -2 -3\ng other\nf 1 2 3 4 # cut\n");
  seeds.add("obj",
            "\xef\xbb\xbfmtllib \"model.mtl\"\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\ns 1\nusemtl \"a\"\nf 1 2 3\ns "
            "off\nf 1 3 4\n");
  seeds.add_words("obj", {"scene/formats/obj"});
  seeds.add("mtl",
            "# two\nnewmtl a\nKd 0.5 0.25 1\nKs 0.1 0.1 0.1\nNs 30\nNi 1.5\nd 0.5\nillum 2\nmap_Kd -s 2 2 1 -o 0.5 "
            "0 0 -clamp on image.png\nbump -bm 0.2 image.png\nnewmtl b\nKe 1 2 3\nPr 0.3\nPm 1\nTr 0.25\n");
  seeds.add("mtl",
            "newmtl a\r\nillum 7\r\nTf 1 1 0.5\r\nNi 1.33\r\nnewmtl b\r\nillum 3\r\nKs 1 1 1\r\nPs 0.5\r\nPc 1\r\n"
            "Pcr 0.1\r\naniso 0.7\r\nnorm image.png\r\nmap_d image.png\r\nnewmtl c\r\nillum 4\r\n");
  seeds.add("mtl", "newmtl \"a b\"\nmap_Kd \"my image.png\" -s 2 2 -clamp on # why\nmap_Ks image.png -o 1\n");
  seeds.add_words("mtl", {"scene/formats/mtl"});
}

void add_gltf(Seeds& seeds) {
  const test::GltfBuilder sample = test::gltf_sample();
  seeds.add("gltf", sample.text());
  seeds.add("gltf", sample.binary());
  test::GltfBuilder triangle;
  triangle.add_triangle();
  seeds.add("gltf", triangle.binary());
  seeds.add_words("gltf", {"scene/formats/gltf"});
  seeds.add("stl",
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\n"
            "endfacet\nendsolid a\n");
  seeds.add("stl", std::string(80, ' ') + raw<std::uint32_t>(1) + raw<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) +
                       raw<std::uint16_t>(0));
  seeds.add_words("stl", {"scene/formats/stl"});
}

std::string ply_header(const std::string& encoding) {
  return "ply\nformat " + encoding +
         " 1.0\ncomment of four vertices\nelement vertex 4\nproperty float x\n"
         "property double y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float "
         "u\n"
         "property float v\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n"
         "property list uchar int vertex_indices\nend_header\n";
}

/// Cameras, lights, animations, holes and properties of imported models.
void add_import_parts(Seeds& seeds) {
  const std::string animation =
      "<library_animations><animation id='a'>" + test::collada_source("t", {0, 1}, 1) +
      test::collada_source("o", {0, 400}, 1) + test::collada_source("k", {0, 1, 2, 3}, 2) +
      "<source id='i'><Name_array id='ia' count='2'>BEZIER STEP</Name_array><technique_common><accessor source='#ia' "
      "count='2' stride='1'/></technique_common></source><sampler id='m'><input semantic='INPUT' source='#t'/><input "
      "semantic='OUTPUT' source='#o'/><input semantic='INTERPOLATION' source='#i'/><input semantic='IN_TANGENT' "
      "source='#k'/><input semantic='OUT_TANGENT' source='#k'/></sampler><channel source='#m' target='n/r.ANGLE'/>"
      "</animation></library_animations>";
  const std::string optics =
      "<library_cameras><camera id='c'><optics><technique_common><perspective><xfov>40</xfov></perspective>"
      "</technique_common></optics></camera></library_cameras><library_lights><light id='l'><technique_common><spot>"
      "<color>1 1 1</color><falloff_angle>40</falloff_angle><falloff_exponent>2</falloff_exponent></spot>"
      "</technique_common></light></library_lights>";
  const std::string frame = "<geometry id='g'><mesh>" +
                            test::collada_source("p", {0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, 0, 2, 1, 0, 1, 2, 0}, 3) +
                            "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices><polygons "
                            "count='1'><input semantic='VERTEX' "
                            "source='#v' offset='0'/><ph><p>0 1 2</p><h>3 4 5</h></ph></polygons></mesh></geometry>";
  const std::string node =
      "<node id='n'><rotate sid='r'>0 0 1 0</rotate><translate>2 0 0</translate><instance_geometry url='#g'/>"
      "<instance_camera url='#c'/><instance_light url='#l'/></node><node><instance_node url='#n'/></node>";
  seeds.add("import", '\0' + test::collada_file(frame, node, animation + optics));
  test::FbxFile fbx;
  fbx.add_square("q", {test::fbx_property("Visibility", "Visibility", 0.0)});
  fbx.add_attribute("c", "Camera", {test::fbx_property("FocalLength", "Number", 50.0)});
  fbx.add_attribute("l", "Light", {test::fbx_property("OuterAngle", "Number", 50.0)});
  for (const std::string& bytes : {fbx.text(), fbx.binary(7400), fbx.binary(7500)}) seeds.add("import", '\1' + bytes);
}

void add_models(Seeds& seeds) {
  seeds.add("import", '\0' + test::cube_dae());
  seeds.add("import", '\1' + test::cube_fbx());
  seeds.add("import", '\2' + test::cube_3ds());
  seeds.add("import", '\3' + test::cube_off());
  seeds.add("import", "\3COFF\n3 1 3\n0 0 0 255 0 0 255\n1 0 0 0 128 0 255\n0 1 0 0 0 255 0\n3 0 1 2\n");
  add_import_parts(seeds);
}

void add_ply(Seeds& seeds) {
  for (const char* const below : {"tests/references/scenes/meshes", "tests/renders/pbrt_twins"})
    seeds.add_files("ply", below, ".ply");
  std::string text = ply_header("ascii"), binary = ply_header("binary_little_endian");
  for (int i = 0; i < 4; ++i) {
    const float x = i == 1 || i == 2, y = i > 1;
    text += std::to_string(x) + " " + std::to_string(y) + " 0 0 0 1 0.5 0.5 255 0 " + std::to_string(i) + "\n";
    binary += raw(x) + raw(double{y}) + raw(std::vector<float>{0, 0, 0, 1, 0.5f, 0.5f}) + "\xff\x10" + char(i);
  }
  seeds.add("ply", text + "4 0 1 2 3\n3 0 2 3\n");
  seeds.add("ply", binary + '\4' + raw(std::vector<int>{0, 1, 2, 3}) + '\3' + raw(std::vector<int>{0, 2, 3}));
  seeds.add("ply",
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
            "0 0 0\n1 0 0\n0 1 0\n1 1 1\n6 0 1 2 -1 1 3\n");
  seeds.add("ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "property float scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float rot_0\n"
            "property float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n"
            "0 0 1 -2 -1 0.5 1 0 0.5 0\n");
  seeds.add("ply",
            "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nproperty float other\nelement face 2\nproperty list uchar int vertex_indices\n"
            "property list uchar float texcoord\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2 6 0 0 1 0 1 1\n"
            "3 2 1 0 6 0.5 0 1 0 1 1\n");
  seeds.add_words("ply", {"scene/formats/ply", "scene/formats/ellipsoids"});
}

/// The content of a mesh in a serialized file: a square.
std::string serialized_content(std::uint32_t flags, bool named) {
  std::string bytes =
      raw(flags) + (named ? std::string("name") + '\0' : "") + raw(std::uint64_t{4}) + raw(std::uint64_t{2});
  const auto numbers = [&](const std::vector<float>& values) {
    bytes += (flags & 0x2000) != 0 ? raw(std::vector<double>(values.begin(), values.end())) : raw(values);
  };
  numbers({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.25f});
  if ((flags & 1) != 0) numbers({0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0, 1});
  if ((flags & 2) != 0) numbers({0, 0, 1, 0, 1, 0.75f, 0, 1});
  if ((flags & 8) != 0) numbers({1, 0, 0, 0, 1, 0, 0, 0, 1, 0.25f, 0.5f, 0.75f});
  return bytes + raw(std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
}

void add_serialized(Seeds& seeds) {
  for (const std::uint32_t flags : {0x1000u, 0x2013u, 0x100bu}) {
    seeds.add("serialized", '\2' + serialized_content(flags, false));
    seeds.add("serialized", '\3' + serialized_content(flags, true));
  }
  std::string mesh("\x1c\x04\4\0", 4);
  mesh += test::deflated(serialized_content(0x1001, true));
  const std::string file = mesh + mesh + raw(std::uint64_t{0}) + raw(std::uint64_t{mesh.size()}) + raw(2u);
  seeds.add("serialized", '\0' + file);
  seeds.add("serialized", '\4' + file);
}

void add_volumes(Seeds& seeds) {
  for (const int encoding : {1, 2, 3})
    for (const int channels : {1, 3, 6}) {
      const int size = encoding == 1 ? 4 : 3 - encoding + 1;
      seeds.add("vol", "VOL\3" + raw(std::vector<int>{encoding, 2, 3, 2, channels}) +
                           raw(std::vector<float>{-1, -1, -1, 1, 1, 2}) +
                           std::string(static_cast<std::size_t>(12 * channels * size), '\x3c'));
    }
  using Values = NanoVdbGrid::Values;
  for (const Values values : {Values::kFloat, Values::kFp4, Values::kFp8, Values::kFp16, Values::kFpN})
    for (const int channels : {1, 3}) {
      if (channels == 3 && values != Values::kFloat) continue;
      VoxelBlocks blocks(channels);
      float value = 0;
      for (float& voxel : blocks.add({0, 1, -1})) voxel = value += 0.001f;
      const float one[] = {1, 1, 1};
      if (values == Values::kFloat) blocks.add_constant({3, 0, 0}, one);  // the library cannot quantize a constant
      const TemporaryFolder folder;
      const NanoVdbGrid grids[] = {{"density", &blocks, Transform::scale({1, 2, 3}), values, false}};
      write_nanovdb(folder / "a.nvdb", grids, NanoVdbCodec::kZip);
      seeds.add("nvdb", read_bytes(folder / "a.nvdb"));
    }
  for (const char* const name : {"small_zip", "small_blosc"}) {
    const std::string stored = read_bytes(fmt::format("{}/tests/scene/formats/vdb/{}.vdb.gz", SHEAF_SOURCE_DIR, name));
    std::string bytes(std::size_t{1} << 20, '\0');
    bytes.resize(Inflater(stored).read(bytes));
    seeds.add("vdb", bytes);
  }
}

void add_measured(Seeds& seeds) {
  struct Field {
    std::string name;
    std::uint8_t type;
    std::vector<std::uint64_t> shape;
    std::string bytes;
  };
  const auto floats = [](std::string name, std::vector<std::uint64_t> shape, std::size_t count) {
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i) * 0.25f;
    return Field{std::move(name), 10, std::move(shape), raw(values)};
  };
  const auto add = [&](const std::vector<Field>& fields) {
    std::string bytes("tensor_file\0\1\0", 14), data;
    bytes += raw(static_cast<std::uint32_t>(fields.size()));
    std::uint64_t offset = bytes.size();
    for (const Field& f : fields) offset += 13 + f.name.size() + 8 * f.shape.size();
    for (const Field& f : fields) {
      bytes += raw(static_cast<std::uint16_t>(f.name.size())) + f.name +
               raw(static_cast<std::uint16_t>(f.shape.size())) + raw(f.type) + raw(offset + data.size()) + raw(f.shape);
      data += f.bytes;
    }
    seeds.add("measured", bytes + data);
  };
  for (const bool spectral : {false, true}) {
    std::vector<Field> fields = {floats("phi_i", {1}, 1),
                                 floats("theta_i", {2}, 2),
                                 floats("ndf", {2, 2}, 4),
                                 floats("sigma", {2, 2}, 4),
                                 floats("vndf", {1, 2, 2, 2}, 8),
                                 floats("luminance", {1, 2, 2, 2}, 8),
                                 floats("rgb", {1, 2, 3, 2, 2}, 24),
                                 {"jacobian", 1, {1}, std::string(1, '\1')}};
    if (spectral) {
      fields[6] = floats("spectra", {1, 2, 2, 2, 2}, 16);
      fields.push_back({"wavelengths", 10, {2}, raw(std::vector<float>{400, 700})});
    }
    add(fields);
  }
  add({floats("phi_d", {1, 2}, 2),
       floats("theta_d", {1, 2}, 2),
       floats("theta_h", {1, 2}, 2),
       {"wvls", 3, {2}, raw(std::vector<std::uint16_t>{450, 650})},
       floats("M", {2, 2, 2, 2, 4, 4}, 256)});
  seeds.add_words("measured", {"scene/formats/measured_file", "scene/formats/polarized_brdf"});
}

void add_curves(Seeds& seeds) {
  seeds.add_files("curves", "tests/renders/pbrt_twins", ".txt");
  seeds.add("curves", "0 0 0 0.1\n0 0 1 0.1\n0 0.1 2 0.05\n1 0 3 0\n\n0 0 0 1\n1 1 1 1\n2 1 1 1\n3 1 1 0.5\n");
  seeds.add("curves", "# hair\n0 0 0\n0 0 1\n0 1 2\n\n1 0 0\r\n1 0 1\r\n");
  const float apart = std::numeric_limits<float>::infinity();
  seeds.add("curves", "BINARY_HAIR" + raw(5u) +
                          raw(std::vector<float>{apart, 0, 0, 0, 0, 0, 1, 0, 1, 2, apart, 1, 0, 0, 1, 0, 1}));
  seeds.add("spectrum", "# nm value\n400 0.5\n500.5 1e-1\n\n700 .25\n");
  seeds.add("spectrum", "400:0.5, 500:1 600:2");
  seeds.add("spectrum", "#ff8000");
  seeds.add("spectrum", "0.25 0.5, 1");
}

void add_checkpoints(Seeds& seeds) {
  const TemporaryFolder folder;
  const fs::path file = folder / "a";
  const auto add = [&](const RenderState& state) {
    write_checkpoint(file, {{"spp", "16"}}, state);
    const std::string bytes = read_bytes(file);
    const std::size_t begin = bytes.find('\n') + 1;
    seeds.add("checkpoint", bytes.substr(begin, bytes.size() - begin - sizeof(std::uint32_t)));
  };
  const PixelRect crop{1, 0, 4, 3};
  RenderState state;
  state.division = {16, 8, 0, 256, {0, 16}};
  state.film = Film(5, 3, crop);
  state.tiles = {1, 0};
  add(state);
  state.film = Film(5, 3, crop, FilmLayout({{"R", true, true}, {"G", true}, {"B", true}, {"A"}}), 2,
                    VarianceUnit::kReplicate, true);
  FilmTile tile;
  state.film.begin(tile, {1, 0, 3, 3}, nullptr);
  state.film.add(tile);
  state.borders = {tile.border()};
  add(state);
  state.adaptive.emplace(state.film, std::vector<PixelRect>{{0, 0, 3, 3}, {3, 0, 5, 3}}, 1, AdaptiveGoal{0.1, 64});
  state.adaptive->begin_round();
  add(state);
  state.adaptive.reset();
  state.splats.emplace(crop);
  add(state);
}

/// Kinds of PNG and JPEG files that Sheaf does not write.
void add_png_and_jpeg(Seeds& seeds) {
  const std::string png(1, '\0'), jpeg(1, '\1');  // places in kImageExtensions
  test::PngSample sample{9, 3, 3, 2, {}, test::png_chunk("PLTE", "abcdefghi") + test::png_chunk("tRNS", "\1\2")};
  for (int i = 0; i < 27; ++i) sample.values.push_back(i % 3);
  seeds.add("image", png + test::png_file(sample));
  sample.interlaced = true;
  seeds.add("image", png + test::png_file(sample));
  for (const int color_type : {0, 4, 6}) {
    test::PngSample wide{3, 2, color_type, 16, std::vector<int>(24, 40000), "", color_type == 6};
    if (color_type == 0) wide.chunks = test::png_chunk("tRNS", "\x9c\x40");
    seeds.add("image", png + test::png_file(wide));
  }
  std::vector<unsigned char> values;
  for (int i = 0; i < 17 * 17 * 4; ++i) values.push_back(static_cast<unsigned char>(i * i));
  for (const bool progressive : {false, true}) {
    seeds.add("image", jpeg + test::jpeg_file({17, 17, JCS_RGB, JCS_YCbCr, 3, values, 20, 2, progressive}));
    seeds.add("image", jpeg + test::jpeg_file({9, 9, JCS_CMYK, JCS_YCCK, 4, values, 20, 1, progressive, true}));
  }
}

/// Kinds of the other image files: packed, planar and float TIFF, palettes, and run-length encoded rows.
void add_image_kinds(Seeds& seeds) {
  const std::string tiff(1, '\2'), hdr(1, '\3'), bmp(1, '\4'), tga(1, '\5'), pnm(1, '\6');
  for (const std::uint32_t bits : {1u, 4u, 12u, 16u, 32u, 64u})
    for (const bool is_separate : {false, true}) {
      test::TiffSample sample{.width = 8, .height = 2, .bits = bits, .samples = 4, .photometric = 2};
      sample.format = bits >= 16 ? 3 : 1;
      sample.is_separate = is_separate;
      sample.extra_samples = {2};
      seeds.add("image", tiff + test::tiff_file(sample, std::string(8 * bits, 'x')));
    }
  seeds.add("image", tiff + test::tiff_file({.width = 2, .samples = 4, .photometric = 5}, "abcdefgh"));
  test::TiffSample palette{.width = 8, .bits = 1, .photometric = 3};
  palette.palette = {1, 2, 3, 4, 5, 60000};
  seeds.add("image", tiff + test::tiff_file(palette, "x"));
  const std::vector<std::uint16_t> values(9 * 5 * 4, 1000);
  std::string problem;
  const std::vector<unsigned char> packed = encode_tiff({9, 5, 4, true, 16, values.data()}, "text", problem);
  seeds.add("image", tiff + std::string(packed.begin(), packed.end()));
  using namespace std::string_literals;
  seeds.add("image",
            hdr + "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n+X 1 -Y 8\n\2\2\0\x08\x88\1\x84\2\4\3\4\5\6\x88\0\x88\x89"s);
  seeds.add("image", bmp + "BM\0\0\0\0\0\0\0\0\x3e\0\0\0\x28\0\0\0\6\0\0\0\2\0\0\0\1\0\x08\0\1\0\0\0"s +
                         std::string(12, '\0') +
                         "\2\0\0\0\0\0\0\0\1\2\3\0\4\5\6\0\2\1\0\3\0\1\0\0\0\0\0\2\3\0\3\1\0\1"s);
  seeds.add("image", bmp + "BM\0\0\0\0\0\0\0\0\x46\0\0\0\x38\0\0\0\1\0\0\0\2\0\0\0\1\0\x20\0\3\0\0\0"s +
                         std::string(20, '\0') +
                         "\xff\0\0\0\0\xff\0\0\0\0\xff\0\0\0\0\xff"
                         "12345678"s);
  seeds.add("image", tga + "\0\1\x09\0\0\2\0\x18\0\0\0\0\3\0\2\0\x08\x20\1\2\3\4\5\6\x81\1\3\0\1\0\1"s);
  for (const char* const text :
       {"P1 # bits\n3 2\n1 0 1\n010", "P2 3 1 10 0 5 11", "P3 1 1 255 1 2 3", "P4 9 1 \xaa\x80"})
    seeds.add("image", pnm + text);
}

/// Images of 3 x 2 pixels, and parts of one for merging.
void add_images(Seeds& seeds) {
  const TemporaryFolder folder;
  const std::vector<int> gray = {0, 50, 100, 150, 200, 250},
                         rgb = {0, 1, 2, 50, 51, 52, 100, 101, 102, 150, 151, 152, 200, 201, 202, 250, 251, 252};
  const auto path = [&](std::string_view extension) { return folder / ("a." + std::string(extension)); };
  Image image(3, 2, {"R", "G", "B", "A"});
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i % 7) / 7;
  write_png(path("png"), image);
  write_jpeg(path("jpg"), 200);
  write_tiff(path("tif"), 3, 2, 3, 16, rgb);
  write_hdr(path("hdr"), 3, 2, rgb);
  write_bmp(path("bmp"), 3, 2, rgb);
  write_tga(path("tga"), 3, 2, 3, rgb);
  write_pnm(path("pgm"), 3, 2, 1, 255, gray);
  write_pnm(path("ppm"), 3, 2, 3, 65535, rgb);
  write_bytes(path("pfm"), "PF\n3 2\n-1.0\n" + raw(std::vector<float>(18, 0.5f)));
  write_bytes(path("webp"), webp_bytes(2, 1, {200, 30, 0, 255, 100, 30, 0, 128}));
  for (std::size_t i = 0; i < std::size(kImageExtensions); ++i)
    seeds.add("image", static_cast<char>(i) + read_bytes(path(kImageExtensions[i])));
  add_png_and_jpeg(seeds);
  add_image_kinds(seeds);
  ExrMetadata metadata;
  metadata.software = "seeds";
  metadata.half_channels = {"R"};
  write_exr(path("exr"), image, metadata);
  seeds.add("exr", read_bytes(path("exr")));
  Image part(3, 2, {"R", "sampleCount"});
  part.x0 = 1;
  part.frame_width = 6;
  part.frame_height = 4;
  metadata.half_channels.clear();
  metadata.attributes = {{"sheaf/samplesPerPixel", 8}, {"sheaf/droppedRays", 0}, {"sheaf/droppedSamples", "0"}};
  add_part_attributes(metadata, "--spp 8\n", std::nullopt);
  write_exr(path("exr"), part, metadata);
  seeds.add("exr", read_bytes(path("exr")));
  part.channels = {"R", "part.weight"};
  add_part_attributes(metadata, "", SampleRange{0, 4});
  metadata.attributes.push_back({"sheaf/ids/object", "00000001 00000002"});
  part.channels = {"R", "sampleCount", "part.weight"};
  part.data.resize(18, 1.0f);
  write_exr(path("exr"), part, metadata);
  seeds.add("exr", read_bytes(path("exr")));
  const std::vector<float> p3{0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
  ExrTestPart window = exr_part(2, 2, {{"a.R", 1}, {"a.G", 2}, {"a.B", 3}, {"Z", 4}}, p3);
  window.window = {1, 1, 2, 2};
  write_exr_parts(path("exr"), {window});
  seeds.add("exr", read_bytes(path("exr")));
  write_exr_parts(path("exr"),
                  {exr_part(1, 1, {{"Z", 1}}, {}, "a"), exr_part(1, 1, {{"X", 1}, {"Y", 1}, {"Z", 1}}, {}, "b")});
  seeds.add("exr", read_bytes(path("exr")));
  seeds.add_words("exr", {"tools/job/parts", "core/image/exr", "kernels/film/cryptomatte", "kernels/film/merge"});
}

}  // namespace

void make_seeds(const fs::path& folder) {
  Seeds seeds(folder);
  add_scenes(seeds);
  add_meshes(seeds);
  add_ply(seeds);
  add_gltf(seeds);
  add_models(seeds);
  add_serialized(seeds);
  add_volumes(seeds);
  add_measured(seeds);
  add_curves(seeds);
  add_checkpoints(seeds);
  add_images(seeds);
}

}  // namespace sheaf::fuzz

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: sheaf_fuzz_seeds FOLDER\n");
    return 2;
  }
  sheaf::fuzz::make_seeds(argv[1]);
  return 0;
}
