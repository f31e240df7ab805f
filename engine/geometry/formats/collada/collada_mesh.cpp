#include "engine/geometry/formats/collada/collada_mesh.h"

#include <algorithm>
#include <span>

#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/polygon_split.h"

namespace tandem {

namespace {

bool IsSurface(std::string_view name) {
  return name == "triangles" || name == "polylist" || name == "polygons" || name == "trifans" ||
         name == "tristrips";
}

}  // namespace

const XmlElement* ColladaMeshReader::Referred(const std::string& url, Kinds kinds) {
  if (!url.starts_with('#')) {
    Fault("it takes '" + url.substr(0, 80) + "' from another file: export all in one file");
    return nullptr;
  }
  const XmlElement* found = nullptr;
  for (const XmlElement* element : tree_.ById(std::string_view(url).substr(1))) {
    if (std::ranges::count(kinds, std::string_view(element->name)) == 0) continue;
    if (found != nullptr) {
      Fault("it has several <" + element->name.substr(0, 40) + "> of the id '" + url.substr(1, 80) +
            "': give each an id of its own");
      return nullptr;
    }
    found = element;
  }
  if (found == nullptr) {
    Fault("there is no <" + std::string(*kinds.begin()) + "> '" + url.substr(1, 80) + "'");
  }
  return found;
}

bool ColladaMeshReader::ReadNumbers(const XmlElement& element, std::vector<double>& numbers) {
  for (const std::string_view word : element.Words()) {
    double number = 0;
    if (!ParseNumber(word, number)) {
      Fault("in its <" + element.name + ">, " + NoNumberWords(word));
      return false;
    }
    numbers.push_back(number);
  }
  return true;
}

bool ColladaMeshReader::ReadWholes(const XmlElement& element, std::vector<std::int64_t>& numbers) {
  for (const std::string_view word : element.Words()) {
    std::int64_t number = 0;
    if (!ParseNumber(word, number)) {
      Fault("in its <" + element.name + ">, '" + std::string(word.substr(0, 40)) +
            "' is not a whole number");
      return false;
    }
    numbers.push_back(number);
  }
  return true;
}

std::optional<ColladaRows> ColladaMeshReader::ReadRows(const XmlElement& source) {
  const XmlElement* technique = source.Child("technique_common");
  const XmlElement* accessor = technique == nullptr ? nullptr : technique->Child("accessor");
  const XmlElement* array =
      accessor == nullptr ? source.Child("float_array")
                          : Referred(accessor->Attribute("source"), {"float_array", "int_array"});
  if (!fault_.empty()) return std::nullopt;
  if (array == nullptr) {
    Fault("its source '" + source.Attribute("id") + "' has no numbers");
    return std::nullopt;
  }
  std::vector<double> numbers;
  if (!ReadNumbers(*array, numbers)) return std::nullopt;
  std::uint64_t said = 0;
  const std::string id = array->Attribute("id");
  if (!ParseNumber(array->Attribute("count"), said)) {
    Fault("its array '" + id + "' does not say how many numbers it has");
    return std::nullopt;
  }
  if (said != numbers.size()) {
    Fault("its array '" + id + "' says that it has " + std::to_string(said) + " numbers, and has " +
          std::to_string(numbers.size()));
    return std::nullopt;
  }
  ColladaRows rows;
  if (accessor == nullptr) {
    rows.width = 3;
    rows.named = {0, 1, 2};
    rows.numbers = std::move(numbers);
    return rows;
  }
  std::uint64_t count = 0;
  std::uint64_t stride = 1;
  std::uint64_t offset = 0;
  if (!ParseNumber(accessor->Attribute("count"), count) ||
      (accessor->HasAttribute("stride") && !ParseNumber(accessor->Attribute("stride"), stride)) ||
      (accessor->HasAttribute("offset") && !ParseNumber(accessor->Attribute("offset"), offset))) {
    Fault("an accessor of its array '" + id + "' has no sound count, stride or offset");
    return std::nullopt;
  }
  if (stride == 0 || offset > said || count > (said - offset) / stride) {
    Fault("takes " + std::to_string(count) + " times " + std::to_string(stride) +
          " numbers from its array '" + id + "' of " + std::to_string(said));
    return std::nullopt;
  }
  rows.width = stride;
  rows.numbers.assign(numbers.begin() + static_cast<std::ptrdiff_t>(offset),
                      numbers.begin() + static_cast<std::ptrdiff_t>(offset + count * stride));
  const std::vector<const XmlElement*> params = accessor->Children("param");
  for (const char* axis : {"X", "Y", "Z"}) {
    for (std::size_t k = 0; k < std::min<std::size_t>(params.size(), stride); ++k) {
      if (params[k]->Attribute("name") == axis) rows.named.push_back(k);
    }
  }
  if (rows.named.size() != 3) rows.named = {0, 1, 2};
  return rows;
}

bool ColladaMeshReader::ReadPoints(const XmlElement& mesh, RawMesh& read) {
  const XmlElement* vertices = mesh.Child("vertices");
  if (vertices == nullptr) return true;
  for (const XmlElement* input : vertices->Children("input")) {
    if (input->Attribute("semantic") != "POSITION") continue;
    const XmlElement* source = Referred(input->Attribute("source"), {"source"});
    if (source == nullptr) return false;
    const auto rows = ReadRows(*source);
    if (!rows) return false;
    if (rows->width < 3) {
      Fault("its vertices are not of three numbers");
      return false;
    }
    for (std::size_t i = 0; i < rows->count(); ++i) {
      FilePoint point{};
      for (std::size_t k = 0; k < 3; ++k) {
        point[k] = rows->numbers[i * rows->width + rows->named[k]];
      }
      read.points.push_back(point);
    }
    return true;
  }
  return true;
}

RawMesh ColladaMeshReader::Read(const XmlElement& geometry) {
  RawMesh read;
  for (const char* curved : {"spline", "brep"}) {
    if (geometry.Child(curved) == nullptr) continue;
    remarks_.Count("geometry of curves or exact surfaces", "geometries of curves or exact surfaces",
                   "left out: export them as triangles");
  }
  const XmlElement* mesh = geometry.Child("mesh");
  if (mesh == nullptr) mesh = geometry.Child("convex_mesh");
  if (mesh == nullptr) return read;
  if (mesh->HasAttribute("convex_hull_of")) {
    remarks_.Count("convex hull of another geometry", "convex hulls of other geometries",
                   "left out");
    return read;
  }
  if (!ReadPoints(*mesh, read)) return read;
  for (const auto& child : mesh->children) {
    if (child->name == "lines" || child->name == "linestrips") {
      remarks_.Count("primitive of lines", "primitives of lines", "without a surface left out");
    }
    if (IsSurface(child->name) && fault_.empty()) ReadPrimitive(*child, read);
  }
  return read;
}

std::optional<ColladaMeshReader::Corners> ColladaMeshReader::CornersOf(
    const XmlElement& primitive) {
  Corners corners;
  bool has_vertex = false;
  for (const XmlElement* input : primitive.Children("input")) {
    std::size_t offset = 0;
    if (input->HasAttribute("offset") && !ParseNumber(input->Attribute("offset"), offset)) {
      Fault("a primitive has an input without a sound offset");
      return std::nullopt;
    }
    if (offset > 64) {
      Fault("a primitive has an input at offset " + std::to_string(offset));
      return std::nullopt;
    }
    corners.stride = std::max(corners.stride, offset + 1);
    if (input->Attribute("semantic") != "VERTEX") continue;
    corners.offset = offset;
    has_vertex = true;
  }
  if (has_vertex) return corners;
  Fault("a primitive has no vertices");
  return std::nullopt;
}

std::optional<std::vector<std::uint32_t>> ColladaMeshReader::Polygon(const XmlElement& p,
                                                                     const Corners& corners,
                                                                     const RawMesh& read) {
  std::vector<std::int64_t> numbers;
  if (!ReadWholes(p, numbers)) return std::nullopt;
  if (numbers.size() % corners.stride != 0) {
    Fault("a <p> has " + std::to_string(numbers.size()) + " numbers, which are no corners of " +
          std::to_string(corners.stride));
    return std::nullopt;
  }
  std::vector<std::uint32_t> polygon;
  for (std::size_t i = corners.offset; i < numbers.size(); i += corners.stride) {
    if (numbers[i] < 0 || numbers[i] >= static_cast<std::int64_t>(read.points.size())) {
      Fault("a <p> uses vertex " + std::to_string(numbers[i]) + ", but there are only " +
            std::to_string(read.points.size()));
      return std::nullopt;
    }
    polygon.push_back(static_cast<std::uint32_t>(numbers[i]));
  }
  return polygon;
}

void ColladaMeshReader::CompareCount(const XmlElement& primitive, std::string_view parts,
                                     std::size_t found) {
  std::uint64_t said = 0;
  if (!ParseNumber(primitive.Attribute("count"), said) || said == found) return;
  remarks_.Say("a <" + primitive.name + "> says that it has " + std::to_string(said) + " " +
               std::string(parts) + ", and has " + std::to_string(found) + ": these are read");
}

void ColladaMeshReader::AddPolygon(std::span<const std::uint32_t> polygon, RawMesh& read) {
  if (polygon.size() < 3) {
    remarks_.Count("polygon with fewer than three corners",
                   "polygons with fewer than three corners", "left out");
  }
  SplitPolygon(read.points, polygon, read.triangles);
}

void ColladaMeshReader::ReadPolygons(const XmlElement& primitive, const Corners& corners,
                                     RawMesh& read) {
  std::size_t count = 0;
  for (const auto& child : primitive.children) {
    if (child->name != "p" && child->name != "ph") continue;
    ++count;
    const bool holed = child->name == "ph";
    const XmlElement* outline = holed ? child->Child("p") : child.get();
    if (outline == nullptr) return Fault("a <ph> has no outline");
    auto polygon = Polygon(*outline, corners, read);
    if (!polygon) return;
    std::vector<std::vector<std::uint32_t>> holes;
    for (const XmlElement* h : holed ? child->Children("h") : std::vector<const XmlElement*>()) {
      auto hole = Polygon(*h, corners, read);
      if (!hole) return;
      holes.push_back(*std::move(hole));
    }
    if (holes.empty()) {
      AddPolygon(*polygon, read);
    } else if (!SplitPolygonWithHoles(read.points, *std::move(polygon), std::move(holes),
                                      read.triangles)) {
      return Fault("a polygon has a hole that does not lie within it: export it as triangles");
    }
  }
  CompareCount(primitive, "polygons", count);
}

void ColladaMeshReader::ReadPolylist(const XmlElement& primitive, const Corners& corners,
                                     RawMesh& read) {
  std::vector<std::int64_t> counts;
  const XmlElement* vcount = primitive.Child("vcount");
  const XmlElement* p = primitive.Child("p");
  if (vcount == nullptr || p == nullptr) {
    std::uint64_t said = 0;
    if (vcount == p && (!ParseNumber(primitive.Attribute("count"), said) || said == 0)) return;
    return Fault("a <polylist> has no <" + std::string(vcount == nullptr ? "vcount" : "p") +
                 ">: it is damaged");
  }
  if (!ReadWholes(*vcount, counts)) return;
  const auto polygon = Polygon(*p, corners, read);
  if (!polygon) return;
  std::size_t at = 0;
  for (const std::int64_t count : counts) {
    if (count < 0 || static_cast<std::uint64_t>(count) > polygon->size() - at) {
      return Fault("its polygons have more corners than its <p>");
    }
    AddPolygon(std::span(*polygon).subspan(at, static_cast<std::size_t>(count)), read);
    at += static_cast<std::size_t>(count);
  }
  if (at != polygon->size()) Fault("its <p> has more corners than its polygons");
  CompareCount(primitive, "polygons", counts.size());
}

void ColladaMeshReader::ReadPrimitive(const XmlElement& primitive, RawMesh& read) {
  const auto corners = CornersOf(primitive);
  if (!corners) return;
  if (primitive.name == "polygons") return ReadPolygons(primitive, *corners, read);
  if (primitive.name == "polylist") return ReadPolylist(primitive, *corners, read);
  std::size_t triangles = 0;
  const std::vector<const XmlElement*> runs = primitive.Children("p");
  for (const XmlElement* p : runs) {
    const auto polygon = Polygon(*p, *corners, read);
    if (!polygon) return;
    const std::size_t count = polygon->size();
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      read.triangles.push_back({(*polygon)[a], (*polygon)[b], (*polygon)[c]});
      ++triangles;
    };
    if (primitive.name == "triangles") {
      if (count % 3 != 0) return Fault("its triangles have no three corners each");
      for (std::size_t i = 0; i + 2 < count; i += 3) add(i, i + 1, i + 2);
      continue;
    }
    for (std::size_t i = 0; i + 2 < count; ++i) {
      if (primitive.name == "trifans") {
        add(0, i + 1, i + 2);
      } else {
        add(i, i + 1 + i % 2, i + 2 - i % 2);
      }
    }
  }
  const bool plain = primitive.name == "triangles";
  CompareCount(primitive, plain ? "triangles" : "strips or fans", plain ? triangles : runs.size());
}

}  // namespace tandem
