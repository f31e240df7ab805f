#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/spatial.h"
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

constexpr int kDeepestPlaces = 32;

struct AmfObject {
  std::string name;
  std::vector<FilePoint> points;
  std::vector<TriangleMesh::Triangle> triangles;
};

struct AmfInstance {
  std::string object;
  std::array<double, 3> delta{};
  std::array<double, 3> angle{};  // degrees about x, y, z, in that order
};

/// A placing of an object or a constellation.
struct AmfPlace {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();
};

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
  return text.substr(0, text.find_last_not_of(kSpace) + 1);
}

Mat3 Turn(int axis, double degrees) {
  // quarter turns are exact, so that placed corners meet
  const double radians = degrees * std::numbers::pi / 180;
  const double quarter = degrees / 90;
  const bool exact = quarter == std::round(quarter);
  const double c = exact ? std::round(std::cos(radians)) : std::cos(radians);
  const double s = exact ? std::round(std::sin(radians)) : std::sin(radians);
  Mat3 R = Mat3::Identity();
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  R(a, a) = c;
  R(a, b) = -s;
  R(b, a) = s;
  R(b, b) = c;
  return R;
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
      answer_.metres_per_unit = MetresOfUnit(unit);
    }
    if (name == "object") {
      id_ = xml_.Attribute("id").value_or("");
      object_ = &objects_[id_];
      order_.push_back(id_);
    }
    if (name == "constellation") {
      constellation_ = xml_.Attribute("id").value_or("#" + std::to_string(constellations_.size()));
      constellations_[constellation_];
    }
    if (name == "instance") {
      instance_ = {xml_.Attribute("objectid").value_or(""), {}, {}};
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

  void Close(const std::string& name) {
    if (name == "metadata") return TakeMetadata();
    if (name == "volume") return EndVolume();
    if (name == "constellation") constellation_.clear();
    if (name == "instance" && !constellation_.empty()) {
      constellations_[constellation_].push_back(instance_);
    }
    if (name == "object") object_ = nullptr;
    static constexpr std::array<const char*, 6> kPlaces{"deltax", "deltay", "deltaz",
                                                        "rx",     "ry",     "rz"};
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      if (name != kPlaces[k] || constellation_.empty()) continue;
      TakeNumber(k < 3 ? instance_.delta[k] : instance_.angle[k - 3]);
    }
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

  void TakeNumber(double& number) {
    if (!ParseNumber(Trimmed(text_), number)) Fault(NoNumberWords(Trimmed(text_)));
  }

  void TakeMetadata() {
    const std::string value(Trimmed(text_));
    if (metadata_ == "name" && object_ != nullptr && !in_volume_) object_->name = value;
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

  /// Places all objects as they are, or those of constellations that stand in no other one.
  void Place() {
    if (constellations_.empty()) {
      for (const std::string& id : order_) Append(id, {}, part_.empty(), 0);
      return;
    }
    std::vector<std::string> placed;
    for (const auto& [id, instances] : constellations_) {
      for (const AmfInstance& instance : instances) placed.push_back(instance.object);
    }
    bool any = false;
    for (const auto& [id, instances] : constellations_) {
      if (std::ranges::count(placed, id) > 0) continue;
      any = true;
      Append(id, {}, part_.empty(), 0);
    }
    if (!any) return Fault("its constellations are within one another");
    for (const std::string& id : order_) {
      if (std::ranges::count(placed, id) > 0) continue;
      remarks_.Count("object that no constellation places", "objects that no constellation places",
                     "left out");
    }
  }

  void Append(const std::string& id, const AmfPlace& X, bool wanted, int depth) {
    if (depth > kDeepestPlaces) return Fault("its constellations are within one another");
    const auto constellation = constellations_.find(id);
    if (constellation != constellations_.end()) {
      for (const AmfInstance& instance : constellation->second) {
        AmfPlace placed;
        const Mat3 R =
            Turn(2, instance.angle[2]) * Turn(1, instance.angle[1]) * Turn(0, instance.angle[0]);
        placed.R = X.R * R;
        placed.p = X.p + X.R * Vec3(instance.delta[0], instance.delta[1], instance.delta[2]);
        Append(instance.object, placed, wanted, depth + 1);
      }
      return;
    }
    const auto found = objects_.find(id);
    if (found == objects_.end()) return Fault("there is no object " + id.substr(0, 40));
    const AmfObject& object = found->second;
    wanted = wanted || object.name == part_ || id == part_ || "Object_" + id == part_;
    found_ = found_ || (wanted && !part_.empty());
    RawMesh& whole = answer_.mesh;
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    for (const TriangleMesh::Triangle& t : object.triangles) {
      for (const std::uint32_t corner : t) {
        if (corner < object.points.size()) continue;
        return Fault("a triangle uses vertex " + std::to_string(corner) + ", but there are only " +
                     std::to_string(object.points.size()));
      }
      if (wanted) whole.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    if (!wanted) return;
    for (const FilePoint& point : object.points) {
      const Vec3 p = X.R * Vec3(point[0], point[1], point[2]) + X.p;
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
  std::map<std::string, std::vector<AmfInstance>> constellations_;
  std::string constellation_;  // id of the one that is open
  AmfInstance instance_;
  AmfObject* object_ = nullptr;
  std::string id_;
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
