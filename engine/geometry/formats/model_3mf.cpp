#include "engine/geometry/formats/model_3mf.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <new>
#include <sstream>
#include <utility>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/xml_scanner.h"
#include "engine/geometry/formats/zip_archive.h"

namespace tandem {

namespace {

constexpr std::size_t kLargestModel = std::size_t{1} << 30U;  // bytes, unpacked
constexpr int kDeepest = 32;                                  // depth of nested components

using Placing = Eigen::Matrix<double, 3, 4>;

/// A placed object: its model, and its placing.
struct Instance {
  std::string path;
  std::string id;
  Placing X = Placing::Identity();
};

struct Object {
  std::string name;
  RawMesh mesh;
  std::vector<Instance> components;
};

struct Model {
  std::string unit;
  std::map<std::string, Object> objects;
  std::vector<Instance> build;
};

template <typename T>
bool IsNumber(const std::optional<std::string>& word, T& number) {
  if (!word) return false;
  const std::size_t begin = std::min(word->find_first_not_of(' '), word->size());
  return ParseNumber(std::string_view(*word).substr(begin), number);
}

/// Reads twelve numbers: three rows that the axes become, and the place of the origin.
bool TakePlacing(const std::optional<std::string>& text, Placing& X) {
  X = Placing::Identity();
  if (!text) return true;
  std::istringstream words(*text);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      std::string word;
      words >> word;
      if (!IsNumber(std::optional(word), X(row, column))) return false;
    }
  }
  return true;
}

/// Returns what is wrong with the extensions that an opened <model> requires; empty: nothing. A
/// model may hold triangles and require slices, beams or encrypted parts in their place.
std::string ExtensionFault(const XmlScanner& model) {
  // extensions that are supported, and extensions that affect looks or names only
  constexpr std::array<std::string_view, 4> kTaken{"core/2015/02", "production/2015/06",
                                                   "material/2015/02", "trianglesets/2021/07"};
  constexpr std::string_view kBegin = "http://schemas.microsoft.com/3dmanufacturing/";
  std::istringstream prefixes(model.AttributeAsWritten("requiredextensions").value_or(""));
  for (std::string prefix; prefixes >> prefix;) {
    const std::string space = model.AttributeAsWritten("xmlns:" + prefix).value_or(prefix);
    const bool taken =
        space.starts_with(kBegin) &&
        std::ranges::count(kTaken, std::string_view(space).substr(kBegin.size())) > 0;
    if (!taken) return "needs the extension " + space + ", which is not read: export it without";
  }
  return {};
}

/// Does the same for a model's text. A text that is no XML is left to its reader.
std::string ExtensionFault(std::string_view text) {
  XmlScanner xml(text);
  for (auto piece = xml.Next(); piece != XmlScanner::Piece::kEnd; piece = xml.Next()) {
    if (piece == XmlScanner::Piece::kFault) return {};
    if (piece == XmlScanner::Piece::kOpen) return ExtensionFault(xml);
  }
  return {};
}

/// Reads one model's XML, and says what is wrong with it.
class ModelReader {
 public:
  ModelReader(std::string_view text, std::string path) : xml_(text), path_(std::move(path)) {}

  std::string Read(Model& model) {
    for (auto piece = xml_.Next(); piece != XmlScanner::Piece::kEnd; piece = xml_.Next()) {
      if (piece == XmlScanner::Piece::kFault) return "is not whole";
      if (piece == XmlScanner::Piece::kClose && xml_.name() == "object") object_ = nullptr;
      if (piece != XmlScanner::Piece::kOpen) continue;
      if (std::string fault = Open(model); !fault.empty()) return fault;
    }
    return {};
  }

 private:
  std::string Open(Model& model) {
    const std::string_view name = xml_.name();
    if (name == "model") {
      model.unit = xml_.Attribute("unit").value_or("millimeter");
      if (std::string fault = ExtensionFault(xml_); !fault.empty()) return fault;
    }
    if (name == "object") {
      const auto id = xml_.Attribute("id");
      if (!id) return "has an object without a number";
      object_ = &model.objects[*id];
      *object_ = {xml_.Attribute("name").value_or("Object_" + *id), {}, {}};
      if (xml_.empty()) object_ = nullptr;
    }
    if (name == "item") return AddInstance(model.build);
    if (object_ == nullptr) return {};
    if (name == "component") return AddInstance(object_->components);
    if (name == "vertex") return AddVertex();
    if (name == "triangle") return AddTriangle();
    return {};
  }

  std::string AddInstance(std::vector<Instance>& instances) {
    Instance instance;
    const auto id = xml_.Attribute("objectid");
    if (!id || !TakePlacing(xml_.Attribute("transform"), instance.X)) {
      return "places an object in a way that is not known";
    }
    instance.id = *id;
    instance.path = xml_.Attribute("path").value_or(path_);
    if (instance.path.starts_with('/')) instance.path.erase(0, 1);
    instances.push_back(std::move(instance));
    return {};
  }

  std::string AddVertex() {
    FloatPoint point{};
    if (!IsNumber(xml_.Attribute("x"), point[0]) || !IsNumber(xml_.Attribute("y"), point[1]) ||
        !IsNumber(xml_.Attribute("z"), point[2])) {
      return "has a vertex without its three numbers";
    }
    object_->mesh.points.push_back(point);
    return {};
  }

  std::string AddTriangle() {
    TriangleMesh::Triangle triangle{};
    if (!IsNumber(xml_.Attribute("v1"), triangle[0]) ||
        !IsNumber(xml_.Attribute("v2"), triangle[1]) ||
        !IsNumber(xml_.Attribute("v3"), triangle[2])) {
      return "has a triangle without its three corners";
    }
    for (const std::uint32_t corner : triangle) {
      if (corner >= object_->mesh.points.size()) {
        return "uses vertex " + std::to_string(corner) + ", but there are only " +
               std::to_string(object_->mesh.points.size());
      }
    }
    object_->mesh.triangles.push_back(triangle);
    return {};
  }

  XmlScanner xml_;
  std::string path_;
  Object* object_ = nullptr;
};

Placing Product(const Placing& a, const Placing& b) {
  Placing product;
  product << a.leftCols<3>() * b.leftCols<3>(), a.leftCols<3>() * b.col(3) + a.col(3);
  return product;
}

/// Assembles all models that the first one leads to.
class Assembly {
 public:
  Assembly(const ZipArchive& archive, std::string part)
      : archive_(archive), part_(std::move(part)) {}

  ReadAnswer Read(const std::string& root) {
    if (const Model* model = ModelAt(root)) {
      unit_ = model->unit;
      // the map keeps its places while other models are read
      for (const Instance& item : model->build) Add(item, part_.empty(), 0);
    }
    if (fault_.empty() && !part_.empty() && !found_) fault_ = NoPart();
    if (!fault_.empty()) return {ReadAnswer::Kind::kRefused, "3MF: " + fault_, {}, 0};
    return std::move(answer_);
  }

 private:
  const Model* ModelAt(const std::string& path) {
    const auto known = models_.find(path);
    if (known != models_.end()) return &known->second;
    const Result<std::string> text = archive_.Read(path, kLargestModel);
    if (!text) {
      Fault("its model " + path + " " + text.error().what);
      return nullptr;
    }
    Model& model = models_[path];
    if (const std::string wrong = ModelReader(*text, path).Read(model); !wrong.empty()) {
      Fault("its model " + path + " " + wrong);
    }
    if (!unit_.empty() && model.unit != unit_) {
      Fault("its models are of several units, " + unit_ + " and " + model.unit);
    }
    return &model;
  }

  void Add(const Instance& instance, bool wanted, int depth) {
    if (!fault_.empty()) return;
    if (depth > kDeepest) return Fault("its components are within one another");
    const Model* model = ModelAt(instance.path);
    if (model == nullptr || !fault_.empty()) return;
    const auto found = model->objects.find(instance.id);
    if (found == model->objects.end()) {
      return Fault("there is no object " + instance.id + " in " + instance.path);
    }
    const Object& object = found->second;
    wanted = wanted || object.name == part_ || "Object_" + instance.id == part_;
    found_ = found_ || (wanted && !part_.empty());
    if (wanted) Append(object.mesh, instance.X);
    for (Instance component : object.components) {
      component.X = Product(instance.X, component.X);
      Add(component, wanted, depth + 1);
    }
  }

  void Append(const RawMesh& mesh, const Placing& X) {
    RawMesh& whole = answer_.mesh;
    if (whole.points.size() + mesh.points.size() > std::numeric_limits<std::uint32_t>::max() - 1) {
      throw std::bad_alloc();
    }
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    for (const FloatPoint& p : mesh.points) {
      const Vec3 placed =
          X.leftCols<3>() * Vec3(double{p[0]}, double{p[1]}, double{p[2]}) + X.col(3);
      whole.points.push_back({static_cast<float>(placed.x()), static_cast<float>(placed.y()),
                              static_cast<float>(placed.z())});
    }
    const bool mirrored = X.leftCols<3>().determinant() < 0;
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      whole.triangles.push_back(
          {first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
  }

  std::string NoPart() const {
    constexpr std::size_t kMostNames = 12;
    std::string words = "it has no part '" + part_ + "', but ";
    std::size_t count = 0;
    for (const auto& [path, model] : models_) {
      for (const auto& [id, object] : model.objects) {
        if (count < kMostNames) words += (count == 0 ? "" : ", ") + object.name;
        ++count;
      }
    }
    return count > kMostNames ? words + " and " + std::to_string(count - kMostNames) + " more"
                              : words;
  }

  void Fault(std::string words) {
    if (fault_.empty()) fault_ = std::move(words);
  }

  const ZipArchive& archive_;
  std::string part_;
  std::map<std::string, Model> models_;
  std::string unit_;
  std::string fault_;
  bool found_ = false;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

}  // namespace

std::optional<ReadAnswer> ReadSeveralModels(const std::filesystem::path& file,
                                            const std::string& part) {
  const std::optional<ZipArchive> archive = ZipArchive::Open(file);
  if (!archive) return std::nullopt;
  const std::string root = archive->Model();
  if (root.empty()) return std::nullopt;
  const Result<std::string> text = archive->Read(root, kLargestModel);
  // the library takes what it can unpack of a damaged model
  if (!text) {
    return ReadAnswer{
        ReadAnswer::Kind::kRefused, "3MF: its model " + root + " " + text.error().what, {}, 0};
  }
  if (const std::string fault = ExtensionFault(*text); !fault.empty()) {
    return ReadAnswer{ReadAnswer::Kind::kRefused, "3MF: its model " + root + " " + fault, {}, 0};
  }
  // an attribute of this name is the extension's, whatever its prefix
  if (text->find(":path") == std::string::npos) return std::nullopt;
  return Assembly(*archive, part).Read(root);
}

}  // namespace tandem
