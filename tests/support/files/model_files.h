// A cube with a red and a green half as models of several formats.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace sheaf::test {

/// The cube [-1, 1]^2 x [2, 4]: corners, faces, and the material of each face.
inline constexpr float kCubeCorners[8][3] = {{-1, -1, 2}, {1, -1, 2}, {1, 1, 2}, {-1, 1, 2},
                                             {-1, -1, 4}, {1, -1, 4}, {1, 1, 4}, {-1, 1, 4}};
inline constexpr int kCubeFaces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                         {2, 3, 7, 6}, {1, 2, 6, 5}, {0, 4, 7, 3}};
inline constexpr int kCubeMaterials[6] = {0, 0, 0, 1, 1, 1};
inline constexpr float kCubeColors[2][3] = {{0.75f, 0.125f, 0.125f}, {0.125f, 0.5f, 0.25f}};

/// Numbers with separators between them.
template <class Range> std::string joined(const Range& numbers, const char* separator) {
  std::string out;
  for (const auto number : numbers) out += (out.empty() ? "" : separator) + std::to_string(number);
  return out;
}
inline std::string cube_corners(const char* separator) {
  std::vector<float> numbers;
  for (const auto& corner : kCubeCorners) numbers.insert(numbers.end(), corner, corner + 3);
  return joined(numbers, separator);
}

inline std::string cube_mtl() {
  std::string out;
  for (int i = 0; i < 2; ++i) out += "newmtl m" + std::to_string(i) + "\nKd " + joined(kCubeColors[i], " ") + "\n";
  return out;
}
/// Names cube.mtl.
inline std::string cube_obj() {
  std::string out = "mtllib cube.mtl\n";
  for (const auto& corner : kCubeCorners) out += "v " + joined(corner, " ") + "\n";
  for (std::size_t i = 0; i < 6; ++i) {
    out += "usemtl m" + std::to_string(kCubeMaterials[i]) + "\nf";
    for (const int vertex : kCubeFaces[i]) out += " " + std::to_string(vertex + 1);
    out += "\n";
  }
  return out;
}

inline std::string cube_off() {
  std::string out = "OFF\n8 6 12\n";
  for (const auto& corner : kCubeCorners) out += joined(corner, " ") + "\n";
  for (std::size_t i = 0; i < 6; ++i)
    out += "4 " + joined(kCubeFaces[i], " ") + " " + joined(kCubeColors[kCubeMaterials[i]], " ") + "\n";
  return out;
}

/// Parts of a COLLADA file that tests vary.
struct ColladaParts {
  std::string up = "Y_UP", meter = "1";
  std::string shading = "<lambert>$</lambert>";  ///< with $ for the diffuse color
  std::string libraries, nodes;                  ///< more of them
};
inline std::string cube_dae(const ColladaParts& parts = {}) {
  std::string effects, materials, polygons, bindings;
  for (int m = 0; m < 2; ++m) {
    const std::string number = std::to_string(m);
    std::string shading = parts.shading;
    shading.replace(shading.find('$'), 1, "<diffuse><color>" + joined(kCubeColors[m], " ") + " 1</color></diffuse>");
    effects += "<effect id='e" + number + "'><profile_COMMON><technique sid='t'>" + shading +
               "</technique></profile_COMMON></effect>";
    materials +=
        "<material id='m" + number + "' name='m" + number + "'><instance_effect url='#e" + number + "'/></material>";
    std::string corners;
    for (std::size_t i = 0; i < 6; ++i)
      if (kCubeMaterials[i] == m) corners += joined(kCubeFaces[i], " ") + " ";
    polygons += "<polylist material='m" + number + "' count='3'><input semantic='VERTEX' source='#v' offset='0'/>" +
                "<vcount>4 4 4</vcount><p>" + corners + "</p></polylist>";
    bindings += "<instance_material symbol='m" + number + "' target='#m" + number + "'/>";
  }
  return "<?xml version='1.0'?>\n<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>\n"
         "<asset><unit name='u' meter='" +
         parts.meter + "'/><up_axis>" + parts.up + "</up_axis></asset>\n" + parts.libraries + "<library_effects>" +
         effects + "</library_effects>\n<library_materials>" + materials +
         "</library_materials>\n<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='a' "
         "count='24'>" +
         cube_corners(" ") +
         "</float_array><technique_common><accessor source='#a' count='8' stride='3'>"
         "<param name='X' type='float'/><param name='Y' type='float'/><param name='Z' type='float'/></accessor>"
         "</technique_common></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>" +
         polygons +
         "</mesh></geometry></library_geometries>\n<library_visual_scenes><visual_scene id='s'><node id='n'>"
         "<translate sid='move'>0 0 0</translate><instance_geometry url='#g'><bind_material><technique_common>" +
         bindings + "</technique_common></bind_material></instance_geometry></node>" + parts.nodes +
         "</visual_scene></library_visual_scenes>\n<scene><instance_visual_scene url='#s'/></scene></COLLADA>\n";
}

/// Axes and unit of an FBX file: the axis that points upwards, and the one to the viewer with its sign.
struct FbxAxes {
  int up = 1, front = 2, front_sign = 1;
  const char* centimeters = "100";
};
/// A text file of FBX 7.3. `material`: more properties of the materials.
inline std::string cube_fbx(const FbxAxes& axes = {}, const std::string& material = "") {
  const auto property = [](const std::string& name, const char* types, const std::string& value) {
    return "P: \"" + name + "\", " + types + "," + value + "\n";
  };
  constexpr const char* kInteger = "\"int\", \"Integer\", \"\"";
  std::string corners, materials, connections;
  for (const auto& face : kCubeFaces)
    for (int k = 0; k < 4; ++k)
      corners += (corners.empty() ? "" : ",") + std::to_string(k == 3 ? -face[k] - 1 : face[k]);
  for (int m = 0; m < 2; ++m) {
    const std::string id = std::to_string(20 + m);
    materials += "Material: " + id + ", \"Material::m" + std::to_string(m) + "\", \"\" {\nVersion: 102\n" +
                 "ShadingModel: \"lambert\"\nMultiLayer: 0\nProperties70:  {\n" +
                 property("DiffuseColor", "\"Color\", \"\", \"A\"", joined(kCubeColors[m], ",")) + material + "}\n}\n";
    connections += "C: \"OO\"," + id + ",11\n";
  }
  return "; FBX 7.3.0 project file\nFBXHeaderExtension:  {\nFBXHeaderVersion: 1003\nFBXVersion: 7300\n}\n"
         "GlobalSettings:  {\nVersion: 1000\nProperties70:  {\n" +
         property("UpAxis", kInteger, std::to_string(axes.up)) + property("UpAxisSign", kInteger, "1") +
         property("FrontAxis", kInteger, std::to_string(axes.front)) +
         property("FrontAxisSign", kInteger, std::to_string(axes.front_sign)) + property("CoordAxis", kInteger, "0") +
         property("CoordAxisSign", kInteger, "1") +
         property("UnitScaleFactor", "\"double\", \"Number\", \"\"", axes.centimeters) +
         "}\n}\nDefinitions:  {\nVersion: 100\nCount: 0\n}\nObjects:  {\nGeometry: 10, \"Geometry::cube\", \"Mesh\" {\n"
         "Vertices: *24 {\na: " +
         cube_corners(",") + "\n}\nPolygonVertexIndex: *24 {\na: " + corners +
         "\n}\nGeometryVersion: 124\nLayerElementMaterial: 0 {\nVersion: 101\nName: \"\"\nMappingInformationType: "
         "\"ByPolygon\"\nReferenceInformationType: \"IndexToDirect\"\nMaterials: *6 {\na: " +
         joined(kCubeMaterials, ",") +
         "\n}\n}\nLayer: 0 {\nVersion: 100\nLayerElement:  {\nType: "
         "\"LayerElementMaterial\"\nTypedIndex: 0\n}\n}\n}\nModel: 11, \"Model::cube\", \"Mesh\" {\nVersion: 232\n"
         "Shading: T\nCulling: \"CullingOff\"\n}\n" +
         materials + "}\nConnections:  {\nC: \"OO\",11,0\nC: \"OO\",10,11\n" + connections + "}\n";
}

/// The bytes of a number in little-endian order.
template <class T> std::string bytes_of(T value) {
  std::string out(sizeof(T), '\0');
  std::memcpy(out.data(), &value, sizeof(T));
  return out;
}

/// A file of 3D Studio, whose z axis points upwards.
inline std::string cube_3ds() {
  const auto chunk = [](std::uint16_t id, const std::string& data) {
    return bytes_of(id) + bytes_of(static_cast<std::uint32_t>(data.size() + 6)) + data;
  };
  const auto floats = [](const auto& values) {
    std::string out;
    for (const float value : values) out += bytes_of(value);
    return out;
  };
  std::string materials, vertices = bytes_of<std::uint16_t>(8), triangles = bytes_of<std::uint16_t>(12), groups;
  for (const auto& corner : kCubeCorners) vertices += floats(corner);
  for (const auto& f : kCubeFaces)
    for (int k = 1; k < 3; ++k)
      for (const int number : {f[0], f[k], f[k + 1], 0}) triangles += bytes_of(static_cast<std::uint16_t>(number));
  for (int m = 0; m < 2; ++m) {
    const std::string name = "m" + std::to_string(m) + std::string(1, '\0');
    materials += chunk(0xafff, chunk(0xa000, name) + chunk(0xa020, chunk(0x0010, floats(kCubeColors[m]))));
    std::string group = name + bytes_of<std::uint16_t>(6);
    for (int i = 0; i < 6; ++i) group += bytes_of(static_cast<std::uint16_t>(6 * m + i));
    groups += chunk(0x4130, group);
  }
  const std::string mesh = chunk(0x4100, chunk(0x4110, vertices) + chunk(0x4120, triangles + groups));
  const std::string object = chunk(0x4000, std::string("cube") + std::string(1, '\0') + mesh);
  return chunk(0x4d4d, chunk(0x0002, bytes_of(3u)) + chunk(0x3d3d, chunk(0x3d3e, bytes_of(3u)) + materials + object));
}

}  // namespace sheaf::test
