#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/check.h"
#include "tests/engine/geometry/shapes.h"

namespace tandem::testing {

/// A folder of its own that goes with the object.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "tandem-XXXXXX").string();
    TANDEM_CHECK(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~TempFolder() { std::filesystem::remove_all(path_); }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path Write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

// Unit cubes with a corner at the origin, as squares.
inline const std::string kObjCube =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
inline const std::string kOffCube =
    "OFF\n8 6 12\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
    "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
inline const std::string kPlyCube =
    "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
    "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
    "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

inline const std::string kAsciiStl =
    "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid t\n";

inline std::string Bytes(std::uint64_t number, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i, number >>= 8U) bytes += static_cast<char>(number);
  return bytes;
}

/// Returns files in a ZIP archive, stored as they are.
inline std::string Zip(const std::vector<std::pair<std::string, std::string>>& files) {
  const auto crc = [](const std::string& content) {
    std::uint32_t state = 0xffffffff;
    for (const char c : content) {
      state ^= static_cast<unsigned char>(c);
      for (int bit = 0; bit < 8; ++bit) state = (state >> 1U) ^ ((state & 1U) * 0xedb88320U);
    }
    return ~state;
  };
  std::string archive;
  std::string directory;
  for (const auto& [name, content] : files) {
    const std::string common = Bytes(20, 2) + Bytes(0, 8) + Bytes(crc(content), 4) +
                               Bytes(content.size(), 4) + Bytes(content.size(), 4) +
                               Bytes(name.size(), 2) + Bytes(0, 2);
    directory +=
        "PK\x01\x02" + Bytes(20, 2) + common + Bytes(0, 10) + Bytes(archive.size(), 4) + name;
    archive += "PK\x03\x04" + common + name + content;
  }
  return archive + directory + "PK\x05\x06" + Bytes(0, 4) + Bytes(files.size(), 2) +
         Bytes(files.size(), 2) + Bytes(directory.size(), 4) + Bytes(archive.size(), 4) +
         Bytes(0, 2);
}

inline std::string ThreeMfBox(int x, int y, int z) {
  std::string mesh = "<mesh><vertices>";
  for (int i = 0; i < 8; ++i) {
    mesh += "<vertex x=\"" + std::to_string((i & 1) * x) + "\" y=\"" +
            std::to_string(((i >> 1) & 1) * y) + "\" z=\"" + std::to_string(((i >> 2) & 1) * z) +
            "\"/>";
  }
  mesh += "</vertices><triangles>";
  constexpr int kCorners[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                   {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                   {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  for (const auto& corner : kCorners) {
    mesh += "<triangle v1=\"" + std::to_string(corner[0]) + "\" v2=\"" + std::to_string(corner[1]) +
            "\" v3=\"" + std::to_string(corner[2]) + "\"/>";
  }
  return mesh + "</triangles></mesh>";
}

/// Returns a 3MF file of four objects: boxes of 1 x 1 x 1 (1) and 2 x 2 x 3 (2), both (3), in which
/// the first is lifted by 5, and a box of 1 x 1 x 1 (4), which is placed at x = 10. `unit`:
/// attribute of its model, or nothing.
inline std::string ThreeMf(const std::string& unit) {
  const std::string kHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  const std::string model =
      kHead + "<model " + unit +
      " xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources>"
      "<object id=\"1\" name=\"lid\" type=\"model\">" +
      ThreeMfBox(1, 1, 1) + "</object><object id=\"2\" name=\"cup\" type=\"model\">" +
      ThreeMfBox(2, 2, 3) +
      "</object><object id=\"3\" type=\"model\"><components><component objectid=\"1\" "
      "transform=\"1 0 0 0 1 0 0 0 1 0 0 5\"/><component objectid=\"2\"/></components></object>"
      "<object id=\"4\" type=\"model\">" +
      ThreeMfBox(1, 1, 1) +
      "</object></resources><build><item objectid=\"3\"/><item objectid=\"4\" "
      "transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/></build></model>";
  return Zip(
      {{"[Content_Types].xml",
        kHead + "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
                "<Default Extension=\"rels\" "
                "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
                "<Default Extension=\"model\" "
                "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>"
                "</Types>"},
       {"_rels/.rels", kHead +
                           "<Relationships "
                           "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
                           "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
                           "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
                           "</Relationships>"},
       {"3D/3dmodel.model", model}});
}

/// The triangle (0,0,3) (2,0,3) (0,1,3), Z up, on a node that takes (x, y, z) to (10 - y, x, -z):
/// a quarter turn, a mirror and a move.
inline const std::string kDaeTriangle =
    R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
 <library_geometries><geometry id="g"><mesh>
  <source id="p"><float_array id="a" count="9">0 0 3 2 0 3 0 1 3</float_array>
   <technique_common><accessor source="#a" count="3" stride="3">
    <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
   </accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node id="n">
  <matrix>0 -1 0 10  1 0 0 0  0 0 -1 0  0 0 0 1</matrix>
  <instance_geometry url="#g"/>
 </node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";

inline std::string BinaryStl(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  const auto add = [&bytes](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  add(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) add(0.0F);  // a normal that readers work out
    for (std::size_t k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) add(static_cast<float>(mesh.corner(t, k)[axis]));
    }
    add(std::uint16_t{0});
  }
  return bytes;
}
inline std::string BinaryStlCube() {
  return BinaryStl(BoxMesh(Vec3::Constant(1)));
}
inline std::string BinaryStlSphere(int levels) {
  return BinaryStl(SphereMesh(1, levels));
}

/// Returns the content with one to eight random edits: a byte or bit changed, a digit made large, a
/// piece cut out, doubled, or the end cut off.
inline std::string Damaged(std::string content, std::mt19937& random) {
  const auto below = [&random](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  for (std::size_t edits = 1 + below(8); edits > 0 && content.size() > 8; --edits) {
    const std::size_t at = below(content.size());
    const std::size_t length = 1 + below(8);
    switch (below(6)) {
      case 0:
        content[at] = static_cast<char>(below(256));
        break;
      case 1:
        content[at] = static_cast<char>(content[at] ^ (1 << below(8)));
        break;
      case 2:
        content.insert(at, "99999999");
        break;
      case 3:
        content.erase(at, length);
        break;
      case 4:
        content.insert(at, content.substr(at, length));
        break;
      default:
        if (below(4) == 0) content.resize(at);
    }
  }
  return content;
}

}  // namespace tandem::testing
