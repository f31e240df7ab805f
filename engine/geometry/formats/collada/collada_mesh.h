#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/formats/collada/xml_tree.h"
#include "engine/geometry/formats/raw_mesh.h"
#include "engine/geometry/formats/remark_list.h"

namespace tandem {

/// The rows of a source: as many numbers each as its accessor has.
struct ColladaRows {
  std::size_t width = 0;
  std::vector<double> numbers;
  std::vector<std::size_t> named;  // places of the numbers named X, Y and Z in a row

  std::size_t count() const { return width == 0 ? 0 : numbers.size() / width; }
};

/// Reads the geometry of a COLLADA file. The first fault stays.
class ColladaMeshReader {
 public:
  ColladaMeshReader(const XmlTree& tree, RemarkList& remarks) : tree_(tree), remarks_(remarks) {}

  /// Reads a <geometry>: points as in its source, and triangles.
  RawMesh Read(const XmlElement& geometry);
  /// Reads the numbers of a <source>.
  std::optional<ColladaRows> ReadRows(const XmlElement& source);
  /// Reads numbers; false: a fault is noted.
  bool ReadNumbers(const XmlElement& element, std::vector<double>& numbers);
  bool ReadWholes(const XmlElement& element, std::vector<std::int64_t>& numbers);
  /// Names of elements, one of which a reference leads to.
  using Kinds = std::initializer_list<std::string_view>;
  /// Returns the element of a reference such as "#id" in this file, of one of these kinds.
  const XmlElement* Referred(const std::string& url, Kinds kinds);
  RemarkList& remarks() { return remarks_; }
  const std::string& fault() const noexcept { return fault_; }
  void Fault(std::string why) {
    if (fault_.empty()) fault_ = std::move(why);
  }

 private:
  struct Corners {
    std::size_t stride = 1;  // numbers of a corner
    std::size_t offset = 0;  // place of its vertex among them
  };
  bool ReadPoints(const XmlElement& mesh, RawMesh& read);
  void ReadPrimitive(const XmlElement& primitive, RawMesh& read);
  std::optional<Corners> CornersOf(const XmlElement& primitive);
  std::optional<std::vector<std::uint32_t>> Polygon(const XmlElement& p, const Corners& corners,
                                                    const RawMesh& read);
  void ReadPolygons(const XmlElement& primitive, const Corners& corners, RawMesh& read);
  void ReadPolylist(const XmlElement& primitive, const Corners& corners, RawMesh& read);
  /// Tells where a primitive says another number of its parts than it has.
  void CompareCount(const XmlElement& primitive, std::string_view parts, std::size_t found);
  void AddPolygon(std::span<const std::uint32_t> polygon, RawMesh& read);

  const XmlTree& tree_;
  RemarkList& remarks_;
  std::string fault_;
};

}  // namespace tandem
