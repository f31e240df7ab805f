#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/formats/affine34.h"
#include "engine/geometry/formats/amf_instance.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/package/slicer_parts.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"
#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

namespace {

// The additive manufacturing format (ISO/ASTM 52915): objects of one list of vertices and several
// volumes of triangles, and constellations that place objects. Without a unit it is in millimetres.
// Slic3r and its descendants write angles in radians in place of degrees, add sizes and mirrors,
// and number their constellations without regard to their objects.

constexpr int kDeepestPlaces = 32;

struct AmfObject {
  std::string name;
  std::vector<FilePoint> points;
  std::vector<TriangleMesh::Triangle> triangles;
};

struct AmfConstellation {
  std::string id;
  std::vector<AmfInstance> instances;
};

/// The programs of Slic3r's line.
bool IsOfSlic3r(std::string_view program) {
  const std::string small = InSmallLetters(program);
  return small.starts_with("slic3r") || small.starts_with("prusaslicer") ||
         small.starts_with("superslicer");
}

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
  return text.substr(0, text.find_last_not_of(kSpace) + 1);
}

class AmfReader {
 public:
  AmfReader(std::string_view text, std::string_view part) : xml_(text), part_(part) {}

  ReadAnswer Read() {
    while (fault_.empty()) {
      const XmlScanner::Piece piece = xml_.Next();
      if (piece == XmlScanner::Piece::kEnd) break;
      if (piece == XmlScanner::Piece::kFault)
        fault_ = "it is not whole: it is damaged or cut short";
      if (piece == XmlScanner::Piece::kOpen) Open();
      if (piece == XmlScanner::Piece::kText) text_ += xml_.text();
      if (piece == XmlScanner::Piece::kClose) Close(std::string(xml_.name()));
    }
    if (fault_.empty() && !is_amf_) fault_ = "it holds no amf element: it is of another format";
    if (fault_.empty()) Place();
    if (fault_.empty() && !part_.empty() && !found_) fault_ = NoPartWords(part_, NamesOfObjects());
    if (!fault_.empty()) return {ReadAnswer::Kind::kRefused, "AMF: " + fault_, {}, 0};
    answer_.remarks = remarks_.Lines();
    return std::move(answer_);
  }

 private:
  void Open() {
    const std::string name(xml_.name());
    text_.clear();
    if (name == "amf") {
      is_amf_ = true;
      const std::string unit = xml_.Attribute("unit").value_or("millimeter");
      answer_.unit_of_format = !xml_.Attribute("unit");
      answer_.metres_per_unit = MetresOfUnit(unit);
    }
    if (name == "object") BeginObject();
    if (name == "constellation") {
      constellations_.push_back({xml_.Attribute("id").value_or(""), {}});
      in_constellation_ = true;
    }
    if (in_instance_) CheckWordOfInstance(name);
    if (name == "instance") {
      instance_ = {};
      instance_.object = xml_.Attribute("objectid").value_or("");
      in_instance_ = true;
    }
    if (name == "vertex") point_ = {NAN, NAN, NAN};
    if (name == "triangle") corners_ = {-1, -1, -1};
    if (name == "volume") {
      in_volume_ = true;
      use_ = PartUse::kShape;
      volume_begin_ = object_ == nullptr ? 0 : object_->triangles.size();
      if (InSmallLetters(xml_.Attribute("type").value_or("")) == "support") {
        use_ = PartUse::kLeftOut;
      }
    }
    if (name == "metadata") metadata_ = xml_.Attribute("type").value_or("");
    if (name == "edge" || name == "normal") curved_ = true;
    if (xml_.empty()) Close(name);
  }

  void BeginObject() {
    std::string id = xml_.Attribute("id").value_or("#" + std::to_string(order_.size()));
    const auto [object, is_new] = objects_.try_emplace(id);
    if (!is_new) {
      return Fault("it has several objects of the id " + id.substr(0, 40) +
                   ": give each an id of its own");
    }
    object_ = &object->second;
    order_.push_back(std::move(id));
  }

  void Close(const std::string& name) {
    if (name == "metadata") return TakeMetadata();
    if (name == "volume") return EndVolume();
    if (name == "constellation") in_constellation_ = false;
    if (name == "instance") EndInstance();
    if (name == "object") object_ = nullptr;
    if (in_instance_) TakePlace(name);
    if (object_ == nullptr) return;
    if (name == "x" || name == "y" || name == "z") {
      TakeNumber(point_[static_cast<std::size_t>(name[0] - 'x')]);
    }
    if (name == "vertex") EndVertex();
    if (name == "v1" || name == "v2" || name == "v3") {
      std::int64_t& corner = corners_[static_cast<std::size_t>(name[1] - '1')];
      if (!ParseNumber(Trimmed(text_), corner)) {
        Fault("'" + std::string(Trimmed(text_).substr(0, 40)) + "' is no corner of a triangle");
      }
    }
    if (name == "triangle") EndTriangle();
  }

  /// Notes what an instance says besides its place.
  void CheckWordOfInstance(const std::string& name) {
    of_slic3r_ = of_slic3r_ || name.starts_with("scale") || name.starts_with("mirror");
    if (IsPlaceOfAmf(name) || name == "printable") return;
    remarks_.Count("unknown element of an instance", "unknown elements of instances",
                   "left out, the first is <" + name.substr(0, 40) + ">");
  }

  /// Takes a word of an instance: a move, a turn, a size.
  void TakePlace(const std::string& name) {
    if (name == "printable" && Trimmed(text_) == "0") {
      remarks_.Count("object that is not to be printed", "objects that are not to be printed",
                     "read like the others");
    }
    double number = 0;
    if (!IsPlaceOfAmf(name)) return;
    TakeNumber(number);
    TakePlaceOfAmf(name, number, instance_);
  }

  void EndInstance() {
    in_instance_ = false;
    if (in_constellation_) return constellations_.back().instances.push_back(instance_);
    remarks_.Count("instance", "instances", "outside of all constellations left out");
  }

  void TakeNumber(double& number) {
    if (!ParseNumber(Trimmed(text_), number)) Fault(NoNumberWords(Trimmed(text_)));
  }

  void TakeMetadata() {
    const std::string value(Trimmed(text_));
    if (metadata_ == "name" && object_ != nullptr && !in_volume_) object_->name = value;
    if (metadata_ == "cad") of_slic3r_ = of_slic3r_ || IsOfSlic3r(value);
    if (metadata_ == "slic3r.volume_type") use_ = PartUseNamed(value);
    if (metadata_ == "slic3r.modifier" && value == "1" && use_ == PartUse::kShape) {
      use_ = PartUse::kLeftOut;
    }
  }

  void EndVolume() {
    in_volume_ = false;
    if (object_ == nullptr || use_ == PartUse::kShape) return;
    if (use_ == PartUse::kNegative) {
      return Fault(
          "it has a negative part, which takes material away, and which is not read: merge the "
          "parts in the slicer, and export the result");
    }
    object_->triangles.resize(volume_begin_);
    remarks_.Count("modifier or support of a slicer", "modifiers or supports of a slicer",
                   "left out: they are no material");
  }

  void EndVertex() {
    if (std::isnan(point_[0]) || std::isnan(point_[1]) || std::isnan(point_[2])) {
      return Fault("a vertex has not its three numbers");
    }
    object_->points.push_back(point_);
  }

  void EndTriangle() {
    TriangleMesh::Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (corners_[k] < 0 || corners_[k] > std::int64_t{0xfffffffe}) {
        return Fault("a triangle has not its three corners");
      }
      triangle[k] = static_cast<std::uint32_t>(corners_[k]);
    }
    if (curved_) {
      remarks_.Say("its curved triangles are read as flat ones");
    }
    object_->triangles.push_back(triangle);
  }

  /// Returns the constellation of an id that no object has; nothing: there is none.
  std::optional<std::size_t> ConstellationOf(const std::string& id) const {
    if (objects_.contains(id)) return std::nullopt;
    const auto found = constellation_of_.find(id);
    return found == constellation_of_.end() ? std::nullopt : std::optional(found->second);
  }

  /// Places all objects as they are, or those of constellations that stand in no other one.
  void Place() {
    if (constellations_.empty()) {
      for (const std::string& id : order_) AppendObject(id, Affine34::Identity(), part_.empty());
      return;
    }
    for (std::size_t c = 0; c < constellations_.size(); ++c) {
      const std::string& id = constellations_[c].id;
      if (id.empty() || constellation_of_.emplace(id, c).second) continue;
      return Fault("it has several constellations of the id " + id.substr(0, 40) +
                   ": give each an id of its own");
    }
    std::set<std::string> objects_placed;
    std::vector<bool> placed(constellations_.size(), false);
    for (const AmfConstellation& constellation : constellations_) {
      for (const AmfInstance& instance : constellation.instances) {
        if (const auto other = ConstellationOf(instance.object)) placed[*other] = true;
        objects_placed.insert(instance.object);
        NoteRadians(instance);
      }
    }
    bool any = false;
    for (std::size_t c = 0; c < constellations_.size(); ++c) {
      if (placed[c]) continue;
      any = true;
      AppendConstellation(c, Affine34::Identity(), part_.empty(), 0);
    }
    if (!any) return Fault("its constellations are within one another");
    for (const std::string& id : order_) {
      if (objects_placed.contains(id)) continue;
      remarks_.Count("object that no constellation places", "objects that no constellation places",
                     "left out");
    }
  }

  void NoteRadians(const AmfInstance& instance) {
    if (!of_slic3r_ || instance.angle == std::array<double, 3>{}) return;
    remarks_.Say(
        "its angles are taken as radians, as Slic3r and its descendants write them: the format's "
        "own are degrees");
  }

  void AppendConstellation(std::size_t index, const Affine34& X, bool wanted, int depth) {
    if (!fault_.empty()) return;
    if (depth > kDeepestPlaces) return Fault("its constellations are within one another");
    for (const AmfInstance& instance : constellations_[index].instances) {
      const Affine34 placed = ProductOf(X, PlacingOf(instance, of_slic3r_));
      if (const auto other = ConstellationOf(instance.object)) {
        AppendConstellation(*other, placed, wanted, depth + 1);
      } else {
        AppendObject(instance.object, placed, wanted);
      }
    }
  }

  void AppendObject(const std::string& id, const Affine34& X, bool wanted) {
    const auto found = objects_.find(id);
    if (found == objects_.end()) return Fault("there is no object " + id.substr(0, 40));
    const AmfObject& object = found->second;
    wanted = wanted || object.name == part_ || id == part_ || "Object_" + id == part_;
    found_ = found_ || (wanted && !part_.empty());
    RawMesh& whole = answer_.mesh;
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    const bool mirrored = X.leftCols<3>().determinant() < 0;
    for (const TriangleMesh::Triangle& t : object.triangles) {
      for (const std::uint32_t corner : t) {
        if (corner < object.points.size()) continue;
        return Fault("a triangle uses vertex " + std::to_string(corner) + ", but there are only " +
                     std::to_string(object.points.size()));
      }
      if (!wanted) continue;
      whole.triangles.push_back(
          {first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
    if (!wanted) return;
    for (const FilePoint& point : object.points) {
      const Vec3 p = Placed(X, Vec3(point[0], point[1], point[2]));
      whole.points.push_back({p.x(), p.y(), p.z()});
    }
  }

  std::vector<std::string> NamesOfObjects() const {
    std::vector<std::string> names;
    for (const std::string& id : order_) {
      const std::string& name = objects_.at(id).name;
      names.push_back(name.empty() ? "Object_" + id : name);
    }
    return names;
  }

  void Fault(std::string why) {
    if (fault_.empty()) fault_ = std::move(why);
  }

  XmlScanner xml_;
  std::string_view part_;
  bool is_amf_ = false;
  std::map<std::string, AmfObject> objects_;
  std::vector<std::string> order_;
  std::vector<AmfConstellation> constellations_;
  std::map<std::string, std::size_t> constellation_of_;  // by id
  bool in_constellation_ = false;
  AmfInstance instance_;
  bool in_instance_ = false;
  bool of_slic3r_ = false;
  AmfObject* object_ = nullptr;
  FilePoint point_{};
  std::array<std::int64_t, 3> corners_{};
  std::size_t volume_begin_ = 0;
  bool in_volume_ = false;
  PartUse use_ = PartUse::kShape;
  bool curved_ = false;
  std::string metadata_;
  std::string text_;
  std::string fault_;
  bool found_ = false;
  RemarkList remarks_;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

}  // namespace

ReadAnswer ReadAmf(std::string_view text, std::string_view part) {
  return AmfReader(text, part).Read();
}

}  // namespace tandem
