#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/formats/collada/collada_controller.h"
#include "engine/geometry/formats/collada/collada_joints.h"
#include "engine/geometry/formats/collada/collada_mesh.h"
#include "engine/geometry/formats/collada/xml_tree.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

constexpr int kDeepestPlacing = 128;

/// Reads the scene of a COLLADA file: its nodes with their transforms, and what they instance.
class ColladaReader {
 public:
  ColladaReader(const XmlTree& tree, std::string_view part)
      : tree_(tree), part_(part), meshes_(tree, remarks_), controllers_(meshes_) {}

  ReadAnswer Read() {
    ReadAsset();
    const XmlElement* scene = VisualScene();
    if (scene != nullptr) {
      for (const XmlElement* node : scene->Children("node")) {
        joints_.Place(*node, Affine34::Identity(), 0, [this](const XmlElement& element) {
          return LocalOf(element);
        });
      }
      for (const XmlElement* node : scene->Children("node")) {
        Append(*node, Affine34::Identity(), part_.empty(), 0);
      }
    } else {
      AppendAllGeometries();
    }
    std::string fault = meshes_.fault();
    if (fault.empty() && !part_.empty() && !found_) fault = NoPartWords(part_, names_);
    if (!fault.empty()) return {ReadAnswer::Kind::kRefused, "COLLADA: " + fault, {}, 0};
    for (const XmlElement* library : tree_.root().Children("library_animations")) {
      if (!library->children.empty()) {
        remarks_.Say("its animations are not played: its rest pose is read");
      }
    }
    answer_.remarks = remarks_.Lines();
    return std::move(answer_);
  }

 private:
  void ReadAsset() {
    answer_.metres_per_unit = 1;
    answer_.unit_of_format = true;
    TellUnitsWithin(tree_.root(), 0);
    const XmlElement* asset = tree_.root().Child("asset");
    if (asset == nullptr) return;
    if (const XmlElement* unit = asset->Child("unit")) ReadUnit(*unit);
    const XmlElement* up = asset->Child("up_axis");
    if (up == nullptr || up->Words().empty()) return;
    const std::string axis(up->Words()[0]);
    if (axis != "Z_UP") {
      remarks_.Say("it declares " + axis.substr(0, 8) +
                   ": its axes are kept as they are; turn it by its pose if it lies on its side");
    }
  }

  /// Reads a unit: its metres, or its name where they are missing.
  void ReadUnit(const XmlElement& unit) {
    constexpr double kSame = 1e-3;
    const std::string name = unit.Attribute("name").substr(0, 40);
    const double named = MetresOfUnit(name);
    if (unit.HasAttribute("meter")) {
      double metres = 0;
      const bool sound = ParseNumber(unit.Attribute("meter"), metres) && metres > 0;
      answer_.metres_per_unit = sound && std::isfinite(metres) ? metres : 0;
      answer_.unit_of_format = false;
      if (sound && named > 0 && std::abs(named / metres - 1) > kSame) {
        remarks_.Say("it names its unit '" + name + "', and says that it is " +
                     unit.Attribute("meter").substr(0, 40) + " m: the number is taken");
      }
      return;
    }
    if (named > 0) {
      answer_.metres_per_unit = named;
      answer_.unit_of_format = false;
      remarks_.Say("it names its unit '" + name + "' without its metres: the name is taken");
    } else if (!name.empty()) {
      remarks_.Say("it names a unit '" + name +
                   "' that is not known, without its metres: it is "
                   "read in metres");
    }
  }

  /// Tells of units that parts of the file have besides its own.
  void TellUnitsWithin(const XmlElement& element, int depth) {
    for (const auto& child : element.children) {
      if (depth > 0 && child->name == "asset" && child->Child("unit") != nullptr) {
        remarks_.Count("unit of a part of the file", "units of parts of the file",
                       "not honoured: that of the file is taken for all of it");
      }
      TellUnitsWithin(*child, depth + 1);
    }
  }

  const XmlElement* VisualScene() {
    if (const XmlElement* scene = tree_.root().Child("scene")) {
      if (const XmlElement* instance = scene->Child("instance_visual_scene")) {
        return meshes_.Referred(instance->Attribute("url"), {"visual_scene"});
      }
    }
    std::vector<const XmlElement*> scenes;
    for (const XmlElement* library : tree_.root().Children("library_visual_scenes")) {
      for (const XmlElement* scene : library->Children("visual_scene")) scenes.push_back(scene);
    }
    if (scenes.size() > 1) {
      remarks_.Say("it does not say which of its " + std::to_string(scenes.size()) +
                   " scenes is shown: the first is read");
    }
    return scenes.empty() ? nullptr : scenes[0];
  }

  void AppendAllGeometries() {
    for (const XmlElement* library : tree_.root().Children("library_geometries")) {
      for (const XmlElement* geometry : library->Children("geometry")) {
        AppendShape(*geometry, Affine34::Identity(), part_.empty(), {});
      }
    }
  }

  static std::string NameOf(const XmlElement& node) {
    for (const char* key : {"id", "sid", "name"}) {
      if (std::string name = node.Attribute(key); !name.empty()) return name;
    }
    return {};
  }
  bool IsPart(const XmlElement& element) const {
    return !part_.empty() &&
           (element.Attribute("id") == part_ || element.Attribute("name") == part_ ||
            element.Attribute("sid") == part_);
  }

  /// Returns a node's own transform: the product of its elements, in their order.
  Affine34 LocalOf(const XmlElement& node) {
    Affine34 X = Affine34::Identity();
    for (const auto& child : node.children) {
      static const std::map<std::string, std::size_t> kCounts{{"matrix", 16}, {"translate", 3},
                                                              {"rotate", 4},  {"scale", 3},
                                                              {"skew", 7},    {"lookat", 9}};
      const auto count = kCounts.find(child->name);
      if (count == kCounts.end()) continue;
      std::vector<double> n;
      if (!meshes_.ReadNumbers(*child, n)) return X;
      if (n.size() != count->second) {
        meshes_.Fault("a <" + child->name + "> has " + std::to_string(n.size()) +
                      " numbers in place of " + std::to_string(count->second));
        return X;
      }
      X = ProductOf(X, StepOf(child->name, n));
    }
    return X;
  }

  Affine34 StepOf(const std::string& name, const std::vector<double>& n) {
    Affine34 X = Affine34::Identity();
    if (name == "matrix") {
      const auto whole = AffineOf(n.data());
      if (!whole) {
        meshes_.Fault("a <matrix> has another last row than 0 0 0 1, which no placing has");
      }
      return whole.value_or(X);
    }
    const Vec3 v(n[0], n[1], n[2]);
    if (name == "translate") X.col(3) = v;
    if (name == "scale") X.leftCols<3>() = v.asDiagonal();
    if (name == "rotate" && v.norm() > 0) {
      X.leftCols<3>() =
          Eigen::AngleAxisd(n[3] * std::numbers::pi / 180, v.normalized()).toRotationMatrix();
      // quarter turns are exact, so that placed corners meet
      if (n[3] == 90 * std::round(n[3] / 90) && v.cwiseAbs().maxCoeff() == v.norm()) {
        X.leftCols<3>() = X.leftCols<3>().array().round().matrix();
      }
    }
    if (name == "skew") {
      meshes_.Fault("it has a <skew>, which is not read: export it with matrices");
    }
    if (name == "lookat") {
      const Vec3 back = (v - Vec3(n[3], n[4], n[5])).normalized();
      const Vec3 right = Vec3(n[6], n[7], n[8]).cross(back).normalized();
      X << right, back.cross(right), back, v;
    }
    return X;
  }

  void Append(const XmlElement& node, const Affine34& X_MP, bool wanted, int depth) {
    if (!meshes_.fault().empty()) return;
    if (depth > kDeepestPlacing) return meshes_.Fault("its nodes are within one another");
    const Affine34 X_MN = ProductOf(X_MP, LocalOf(node));
    if (IsPart(node)) wanted = found_ = true;
    for (const auto& child : node.children) {
      if (child->name == "node") Append(*child, X_MN, wanted, depth + 1);
      if (child->name == "instance_node") {
        const XmlElement* other = meshes_.Referred(child->Attribute("url"), {"node"});
        if (other != nullptr) Append(*other, X_MN, wanted, depth + 1);
      }
      if (child->name != "instance_geometry" && child->name != "instance_controller") continue;
      const std::string name = NameOf(node);
      if (!part_.empty() && !name.empty() && seen_.insert(name).second) names_.push_back(name);
      const bool plain = child->name == "instance_geometry";
      const XmlElement* shape =
          meshes_.Referred(child->Attribute("url"), {plain ? "geometry" : "controller"});
      if (shape != nullptr) AppendShape(*shape, X_MN, wanted, SkeletonsOf(*child));
    }
  }

  /// Returns the nodes below which the joints of an instance of a skin are.
  std::vector<const XmlElement*> SkeletonsOf(const XmlElement& instance) {
    std::vector<const XmlElement*> roots;
    for (const XmlElement* skeleton : instance.Children("skeleton")) {
      const std::vector<std::string_view> words = skeleton->Words();
      const XmlElement* root =
          words.empty() ? nullptr : meshes_.Referred(std::string(words[0]), {"node"});
      if (root != nullptr) roots.push_back(root);
    }
    return roots;
  }

  void AppendShape(const XmlElement& shape, const Affine34& X_MN, bool wanted,
                   const std::vector<const XmlElement*>& skeletons) {
    if (!meshes_.fault().empty()) return;
    if (IsPart(shape)) wanted = found_ = true;
    if (!wanted) return;
    const auto find_joint = [&](const std::string& name, bool by_id) {
      return joints_.Find(name, by_id, skeletons);
    };
    const ControlledMesh read = controllers_.Read(shape, find_joint);
    RawMesh& whole = answer_.mesh;
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    const Affine34 X = read.placed ? Affine34(Affine34::Identity()) : X_MN;
    for (const FilePoint& point : read.mesh.points) {
      const Vec3 p = X.leftCols<3>() * Vec3(point[0], point[1], point[2]) + X.col(3);
      whole.points.push_back({p.x(), p.y(), p.z()});
    }
    const bool turned = X.leftCols<3>().determinant() < 0;
    for (const TriangleMesh::Triangle& t : read.mesh.triangles) {
      const bool mirrored = read.placed ? read.mirrored[t[0]] : turned;
      whole.triangles.push_back(
          {first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
  }

  const XmlTree& tree_;
  std::string_view part_;
  RemarkList remarks_;
  ColladaMeshReader meshes_;
  ColladaControllers controllers_;
  ColladaJoints joints_;
  std::vector<std::string> names_;
  std::set<std::string> seen_;  // names_ again
  bool found_ = false;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

}  // namespace

std::optional<ReadAnswer> ReadCollada(std::string_view text, std::string_view part) {
  const Result<XmlTree> tree = XmlTree::Parse(text);
  if (!tree) return ReadAnswer{ReadAnswer::Kind::kRefused, "COLLADA: " + tree.error().what, {}, 0};
  const XmlElement& root = tree->root();
  if (root.name != "COLLADA") {
    return ReadAnswer{
        ReadAnswer::Kind::kRefused, "COLLADA: it begins with another element than COLLADA", {}, 0};
  }
  // its layout before 1.4 is another
  if (root.Attribute("version").starts_with("1.3")) return std::nullopt;
  return ColladaReader(*tree, part).Read();
}

}  // namespace tandem
