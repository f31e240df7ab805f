#include "engine/geometry/formats/package/model_3mf.h"

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
#include "engine/geometry/formats/affine34.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/package/extensions_3mf.h"
#include "engine/geometry/formats/package/slicer_parts.h"
#include "engine/geometry/formats/package/zip_archive.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"
#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

namespace {

constexpr std::size_t kLargestModel = std::size_t{1} << 30U;  // bytes, unpacked
constexpr int kDeepest = 32;                                  // depth of nested components

/// A placed object: its model, and its placing.
struct Instance {
  std::string path;
  std::string id;
  Affine34 X = Affine34::Identity();
};

struct Object {
  std::string name;
  RawMesh mesh;
  std::vector<Instance> components;
  PartUse use = PartUse::kShape;
};

struct Model {
  std::string unit;
  bool names_unit = false;
  std::map<std::string, Object> objects;
  std::vector<Instance> build;
};

template <typename T>
bool IsNumber(const std::optional<std::string>& word, T& number) {
  if (!word) return false;
  std::string_view plain(*word);
  plain.remove_prefix(std::min(plain.find_first_not_of(' '), plain.size()));
  plain = plain.substr(0, plain.find_last_not_of(' ') + 1);
  return ParseNumber(plain, number);
}

/// Reads twelve numbers: three rows that the axes become, and the place of the origin.
bool TakePlacing(const std::optional<std::string>& text, Affine34& X) {
  X = Affine34::Identity();
  if (!text) return true;
  std::istringstream words(*text);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      std::string word;
      words >> word;
      if (!IsNumber(std::optional(word), X(row, column))) return false;
    }
  }
  std::string more;
  words >> more;
  return more.empty();
}

/// Reads one model's XML, and says what is wrong with it.
class ModelReader {
 public:
  ModelReader(std::string_view text, std::string path, RemarkList& remarks)
      : xml_(text), path_(std::move(path)), remarks_(remarks) {}

  std::string Read(Model& model) {
    for (auto piece = xml_.Next(); piece != XmlScanner::Piece::kEnd; piece = xml_.Next()) {
      if (piece == XmlScanner::Piece::kFault) return "is not whole";
      if (piece == XmlScanner::Piece::kClose && IsCore() && xml_.name() == "object") {
        object_ = nullptr;
      }
      if (piece == XmlScanner::Piece::kText && object_ != nullptr) TakeMetadata();
      if (piece != XmlScanner::Piece::kOpen) continue;
      metadata_.clear();
      if (std::string fault = Open(model); !fault.empty()) return fault;
    }
    return is_model_ ? "" : "is no model";
  }

 private:
  /// Tells whether an element's prefix is one of the format itself, and not of an extension.
  bool IsCore() const { return std::ranges::count(core_, xml_.prefix()) > 0; }

  std::string BeginModel(Model& model) {
    is_model_ = true;
    core_.assign(1, std::string(xml_.prefix()));
    const auto space_of = [&](const std::string& prefix) {
      return xml_.AttributeAsWritten(prefix.empty() ? "xmlns" : "xmlns:" + prefix);
    };
    const auto space = space_of(core_[0]);
    for (const auto& [name, value] : xml_.Attributes()) {
      if (space && value == *space && name.starts_with("xmlns:")) core_.push_back(name.substr(6));
      if (space && value == *space && name == "xmlns") core_.emplace_back();
    }
    model.unit = xml_.Attribute("unit").value_or("millimeter");
    model.names_unit = xml_.Attribute("unit").has_value();
    return ExtensionFaultOf3mf(xml_);
  }

  std::string Open(Model& model) {
    const std::string_view name = xml_.name();
    if (!is_model_) return name == "model" ? BeginModel(model) : "is no model";
    if (const std::string_view unread = UnreadPartOf3mf(name); !unread.empty()) {
      remarks_.Count(unread, std::string(unread) + "s",
                     "left out: it is an extension of the format that is not read");
    }
    if (!IsCore()) return {};
    if (name == "object") {
      const auto id = xml_.Attribute("id");
      if (!id) return "has an object without a number";
      const auto [object, is_new] = model.objects.try_emplace(*id);
      if (!is_new) return "has several objects of the number " + id->substr(0, 40);
      object_ = &object->second;
      *object_ = {xml_.Attribute("name").value_or("Object_" + *id), {}, {}, PartUse::kShape};
      const std::string type = xml_.Attribute("type").value_or("model");
      if (type == "support" || type == "solidsupport") object_->use = PartUse::kLeftOut;
      if (xml_.empty()) object_ = nullptr;
    }
    if (name == "item") {
      if (xml_.Attribute("printable").value_or("1") == "0") {
        remarks_.Count("object that is not to be printed", "objects that are not to be printed",
                       "read like the others");
      }
      return AddInstance(model.build);
    }
    if (object_ == nullptr) return {};
    if (name == "metadata") metadata_ = xml_.Attribute("name").value_or("");
    if (name == "component") return AddInstance(object_->components);
    if (name == "vertex") return AddVertex();
    if (name == "triangle") return AddTriangle();
    return {};
  }

  /// Takes Cura's marks on objects that are no material.
  void TakeMetadata() {
    const std::string value = InSmallLetters(xml_.text());
    if (value != "true" && value != "1") return;
    for (const char* mark : {"infill_mesh", "cutting_mesh", "anti_overhang_mesh", "support_mesh"}) {
      if (metadata_.ends_with(mark)) object_->use = PartUse::kLeftOut;
    }
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
    FilePoint point{};
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
  RemarkList& remarks_;
  std::vector<std::string> core_;  // prefixes of the format's own elements
  std::string metadata_;
  Object* object_ = nullptr;
  bool is_model_ = false;
};

/// Assembles all models that the first one leads to.
class Assembly {
 public:
  Assembly(const ZipArchive& archive, std::string part, std::string root)
      : archive_(archive), part_(std::move(part)), root_(std::move(root)) {}

  ReadAnswer Read() {
    Result<SlicerParts> slicer = ReadSlicerParts(archive_);
    if (!slicer) Fault(slicer.error().what);
    if (slicer) slicer_ = *std::move(slicer);
    const Model* model = fault_.empty() ? ModelAt(root_) : nullptr;
    if (model != nullptr) {
      unit_ = model->unit;
      // the map keeps its places while other models are read
      for (const Instance& item : model->build) Add(item, part_.empty(), 0, PartUse::kShape);
      if (fault_.empty() && model->build.empty()) {
        Fault("its build places none of its objects: put them on the plate, and export it again");
      }
      answer_.metres_per_unit = MetresOf(unit_);
      answer_.unit_of_format = !model->names_unit;
    }
    if (fault_.empty() && !part_.empty() && !found_) fault_ = NoPartWords(part_, NamesOfObjects());
    if (!fault_.empty()) return {ReadAnswer::Kind::kRefused, "3MF: " + fault_, {}, 0};
    answer_.remarks = remarks_.Lines();
    return std::move(answer_);
  }

 private:
  static double MetresOf(const std::string& unit) {
    constexpr std::array<std::string_view, 6> kUnits{"micron", "millimeter", "centimeter",
                                                     "inch",   "foot",       "meter"};
    return std::ranges::count(kUnits, std::string_view(unit)) > 0 ? MetresOfUnit(unit) : 0;
  }

  const Model* ModelAt(const std::string& path) {
    const auto known = models_.find(path);
    if (known != models_.end()) return &known->second;
    const Result<std::string> text = archive_.Read(path, kLargestModel);
    if (!text) {
      Fault("its model " + path + " " + text.error().what);
      return nullptr;
    }
    Model& model = models_[path];
    const std::string plain = InUtf8(*text);
    if (const std::string wrong = ModelReader(plain, path, remarks_).Read(model); !wrong.empty()) {
      Fault("its model " + path + " " + wrong);
    }
    if (fault_.empty() && !unit_.empty() && model.unit != unit_) {
      Fault("its models are of several units, " + unit_ + " and " + model.unit);
    }
    return &model;
  }

  void Add(const Instance& instance, bool wanted, int depth, PartUse use) {
    if (!fault_.empty()) return;
    if (depth > kDeepest) return Fault("its components are within one another");
    const Model* model = ModelAt(instance.path);
    if (model == nullptr || !fault_.empty()) return;
    const auto found = model->objects.find(instance.id);
    if (found == model->objects.end()) {
      return Fault("there is no object " + instance.id + " in " + instance.path);
    }
    const Object& object = found->second;
    if (use == PartUse::kShape) use = object.use;
    wanted = wanted || object.name == part_ || "Object_" + instance.id == part_;
    found_ = found_ || (wanted && !part_.empty());
    if (wanted && use == PartUse::kShape) AppendMaterial(object.mesh, instance);
    if (wanted && use != PartUse::kShape) NotesLeftOut(use);
    for (Instance component : object.components) {
      component.X = ProductOf(instance.X, component.X);
      const PartUse said =
          IsOfRoot(instance) ? slicer_.UseOf(instance.id, component.id) : PartUse::kShape;
      Add(component, wanted, depth + 1, use == PartUse::kShape ? said : use);
    }
  }

  void AppendMaterial(const RawMesh& mesh, const Instance& instance) {
    const auto ranges = slicer_.ranges_of.find(instance.id);
    if (ranges == slicer_.ranges_of.end() || !IsOfRoot(instance)) return Append(mesh, instance.X);
    Append(WithoutSettings(mesh, ranges->second), instance.X);
  }

  /// Tells whether the settings of slicers, which name objects by number alone, mean its object.
  bool IsOfRoot(const Instance& instance) {
    const auto [known, is_new] = is_root_.try_emplace(instance.path, false);
    if (is_new) known->second = archive_.IsSame(instance.path, root_);
    return known->second;
  }

  /// Notes a part that is no material; false: the file is refused for it.
  bool NotesLeftOut(PartUse use) {
    if (use == PartUse::kNegative) {
      Fault(
          "it has a negative part, which takes material away, and which is not read: merge the "
          "parts in the slicer, and export the result");
      return false;
    }
    remarks_.Count("modifier or support of a slicer", "modifiers or supports of a slicer",
                   "left out: they are no material");
    return true;
  }

  /// Returns a mesh without the triangles that a slicer marks as settings.
  RawMesh WithoutSettings(const RawMesh& mesh, const std::vector<SlicerParts::Range>& ranges) {
    RawMesh kept{mesh.points, {}};
    std::vector<bool> out(mesh.triangles.size(), false);
    for (const SlicerParts::Range& range : ranges) {
      if (!NotesLeftOut(range.use)) continue;
      for (std::uint64_t t = range.first; t <= range.last && t < out.size(); ++t) out[t] = true;
    }
    for (std::size_t t = 0; t < out.size(); ++t) {
      if (!out[t]) kept.triangles.push_back(mesh.triangles[t]);
    }
    return kept;
  }

  void Append(const RawMesh& mesh, const Affine34& X) {
    RawMesh& whole = answer_.mesh;
    if (whole.points.size() + mesh.points.size() > std::numeric_limits<std::uint32_t>::max() - 1) {
      throw std::bad_alloc();
    }
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    for (const FilePoint& p : mesh.points) {
      const Vec3 placed = X.leftCols<3>() * Vec3(p[0], p[1], p[2]) + X.col(3);
      whole.points.push_back({placed.x(), placed.y(), placed.z()});
    }
    const bool mirrored = X.leftCols<3>().determinant() < 0;
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      whole.triangles.push_back(
          {first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
  }

  std::vector<std::string> NamesOfObjects() const {
    std::vector<std::string> names;
    for (const auto& [path, model] : models_) {
      for (const auto& [id, object] : model.objects) {
        if (!object.mesh.triangles.empty()) names.push_back(object.name);
      }
    }
    return names;
  }

  void Fault(std::string words) {
    if (fault_.empty()) fault_ = std::move(words);
  }

  const ZipArchive& archive_;
  std::string part_;
  std::string root_;                     // name of the first model
  std::map<std::string, bool> is_root_;  // by path
  SlicerParts slicer_;
  RemarkList remarks_;
  std::map<std::string, Model> models_;
  std::string unit_;
  std::string fault_;
  bool found_ = false;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

}  // namespace

ReadAnswer Read3mf(const std::filesystem::path& file, const std::string& part) {
  const std::optional<ZipArchive> archive = ZipArchive::Open(file);
  const std::string root = archive ? archive->Model() : std::string();
  if (root.empty()) {
    return {ReadAnswer::Kind::kRefused,
            "3MF: it is no archive that holds a model: it is damaged or of another format",
            {},
            0};
  }
  return Assembly(*archive, part, root).Read();
}

}  // namespace tandem
