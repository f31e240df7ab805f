#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/files/regular_file.h"
#include "engine/base/spatial.h"
#include "engine/base/text/json_reader.h"
#include "engine/geometry/formats/gltf/gltf_instances.h"
#include "engine/geometry/formats/gltf/gltf_mesh.h"
#include "engine/geometry/formats/gltf/gltf_numbers.h"
#include "engine/geometry/formats/gltf/gltf_placing.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/remark_list.h"

namespace tandem {

namespace {

constexpr int kDeepestNodes = 256;
const char* const kUnreadNeeds = "what it needs cannot be read: the file is damaged";

/// Tells whether an extension is read, or affects only what surfaces look like.
bool IsReadOrOfLooks(std::string_view extension) {
  constexpr std::array<std::string_view, 11> kBegins{"KHR_materials_",
                                                     "KHR_texture_",
                                                     "EXT_texture_",
                                                     "MSFT_texture_",
                                                     "KHR_lights_",
                                                     "EXT_lights_",
                                                     "KHR_xmp",
                                                     "EXT_mesh_features",
                                                     "KHR_draco_mesh",
                                                     "EXT_meshopt_",
                                                     "EXT_structural_metadata"};
  return extension == "EXT_mesh_gpu_instancing" || extension == "KHR_mesh_quantization" ||
         extension == "KHR_animation_pointer" ||
         std::ranges::any_of(kBegins, [&](std::string_view begin) {
           return extension.starts_with(begin);
         });
}

/// Returns a name that a file gives; in place of one that is long, or not plain text, its number.
std::string NameOf(const JsonNode& named, const std::string& kind, std::uint64_t number) {
  constexpr std::size_t kLongest = 4096;  // bytes
  const std::string otherwise = kind + "[" + std::to_string(number) + "]";
  const std::string written = named.Has("name") ? named["name"].Compact() : std::string();
  if (written.size() < 2 || written.front() != '"' || written.size() > 2 * kLongest) {
    return otherwise;
  }
  std::string name;
  for (std::size_t i = 1; i + 1 < written.size(); ++i) {
    if (written[i] == '\\' && written[++i] != '"' && written[i] != '\\') return otherwise;
    name += written[i];
  }
  return name.size() <= kLongest && IsPlainText(name) ? name : otherwise;
}

class GltfReader {
 public:
  GltfReader(const JsonNode& root, const std::filesystem::path& file, std::string_view chunk,
             std::string_view part)
      : root_(root),
        numbers_(root, file, chunk),
        part_(part),
        nodes_(ItemsOf(root, "nodes")),
        meshes_(ItemsOf(root, "meshes")),
        skins_(ItemsOf(root, "skins")) {}

  ReadAnswer Read() {
    ReadExtensions();
    GltfMeshReader reader(numbers_, remarks_, quantized_);
    reader_ = &reader;
    if (fault_.empty()) PlaceNodes();
    for (const std::uint64_t node : RootsOfScene()) Append(node, part_.empty());
    if (fault_.empty() && skipped_ > 0) {
      fault_ = std::to_string(skipped_) + " of its " + std::to_string(stated_) +
               " triangles cannot be had: they use vertices that there are not";
    }
    if (fault_.empty() && !part_.empty() && !found_) fault_ = NoPartWords(part_, names_);
    if (!fault_.empty()) return {ReadAnswer::Kind::kRefused, "glTF: " + fault_, {}, 0};
    if (root_.Has("animations") && !root_["animations"].Items().empty()) {
      remarks_.Say("its animations are not played: its rest pose is read");
    }
    answer_.single_precision = true;
    answer_.metres_per_unit = 1;
    answer_.unit_of_format = true;
    answer_.remarks = remarks_.Lines();
    return std::move(answer_);
  }

 private:
  void ReadExtensions() {
    for (const JsonNode& extension : ItemsOf(root_, "extensionsRequired")) {
      const std::string name = extension.PlainText(80);
      const bool packed = name == "EXT_meshopt_compression";
      if (!IsReadOrOfLooks(name) || packed) {
        return Fault("it needs " + name + ", which is not read: export it without");
      }
    }
    for (const JsonNode& extension : ItemsOf(root_, "extensionsUsed")) {
      const std::string name = extension.PlainText(80);
      quantized_ = quantized_ || name == "KHR_mesh_quantization";
      if (!IsReadOrOfLooks(name)) {
        remarks_.Say("it uses " + name + ", which is not read: its shape is read without");
      }
    }
    for (const JsonNode& extension : ItemsOf(root_, "extensionsRequired")) {
      quantized_ = quantized_ || extension.PlainText(80) == "KHR_mesh_quantization";
    }
  }

  /// Returns the roots of the default scene; without scenes, all nodes that are nobody's child.
  std::vector<std::uint64_t> RootsOfScene() {
    std::vector<std::uint64_t> roots;
    if (!fault_.empty()) return roots;
    const std::vector<JsonNode> scenes = ItemsOf(root_, "scenes");
    if (scenes.empty()) {
      for (std::uint64_t n = 0; n < nodes_.size(); ++n) {
        if (!is_child_[n]) roots.push_back(n);
      }
      return roots;
    }
    const std::uint64_t scene = UnsignedOf(root_, "scene", 0);
    if (scene >= scenes.size()) {
      Fault("its default scene " + std::to_string(scene) + " is none of its scenes");
      return roots;
    }
    if (scenes.size() > 1) {
      remarks_.Say("scene " + std::to_string(scene) + " of its " + std::to_string(scenes.size()) +
                   " scenes is read, the others are not");
    }
    for (const JsonNode& node : ItemsOf(scenes[scene], "nodes")) roots.push_back(node.Unsigned());
    return roots;
  }

  /// Computes where all nodes stand, for skins need joints anywhere.
  void PlaceNodes() {
    placed_.assign(nodes_.size(), Affine34::Identity());
    is_child_.assign(nodes_.size(), false);
    children_.resize(nodes_.size());
    for (std::uint64_t n = 0; n < nodes_.size(); ++n) {
      for (const JsonNode& child : ItemsOf(nodes_[n], "children")) {
        const std::uint64_t c = child.Unsigned();
        if (c >= nodes_.size() || is_child_[c]) {
          return Fault("its node " + std::to_string(c) + " is missing, or has several parents");
        }
        is_child_[c] = true;
        children_[n].push_back(c);
      }
    }
    std::size_t seen = 0;
    for (std::uint64_t n = 0; n < nodes_.size(); ++n) {
      if (!is_child_[n]) PlaceNode(n, Affine34::Identity(), 0, seen);
    }
    if (fault_.empty() && seen != nodes_.size()) Fault("its nodes are within one another");
  }

  void PlaceNode(std::uint64_t n, const Affine34& X_MP, int depth, std::size_t& seen) {
    if (depth > kDeepestNodes) return Fault("its nodes are nested too deep");
    ++seen;
    const Result<Affine34> X_PN = LocalPlacing(nodes_[n]);
    if (!X_PN) return Fault(X_PN.error().what);
    placed_[n] = ProductOf(X_MP, *X_PN);
    for (const std::uint64_t child : children_[n]) PlaceNode(child, placed_[n], depth + 1, seen);
  }

  void Append(std::uint64_t n, bool wanted) {
    if (!fault_.empty()) return;
    if (n >= nodes_.size()) return Fault("its scene has no node " + std::to_string(n));
    const JsonNode& node = nodes_[n];
    const std::string name = NameOf(node, "nodes", n);
    if (!part_.empty() && name == part_) wanted = found_ = true;
    if (node.Has("mesh")) AppendMesh(node, n, name, wanted);
    for (const std::uint64_t child : children_[n]) Append(child, wanted);
  }

  void AppendMesh(const JsonNode& node, std::uint64_t n, const std::string& name, bool wanted) {
    const std::uint64_t index = node["mesh"].Unsigned();
    if (index >= meshes_.size()) return Fault("there is no mesh " + std::to_string(index));
    const JsonNode& mesh = meshes_[index];
    const std::string mesh_name = NameOf(mesh, "meshes", index);
    if (!part_.empty() && seen_.insert(name).second) names_.push_back(name);
    std::vector<double> weights;
    for (const JsonNode& weight : ItemsOf(node.Has("weights") ? node : mesh, "weights")) {
      weights.push_back(weight.Number());
    }
    const Result<std::vector<Affine34>> places = GltfInstancesOf(node, placed_[n], numbers_);
    if (!places) return Fault(places.error().what);
    if (node.Has("skin") && HasGltfInstances(node)) {
      remarks_.Count("node of a skin has instances", "nodes of skins have instances",
                     "that are not read: the skin is read once");
    }
    const std::vector<JsonNode> primitives = ItemsOf(mesh, "primitives");
    for (std::size_t k = 0; k < primitives.size() && fault_.empty(); ++k) {
      const bool this_one =
          wanted || mesh_name == part_ || mesh_name + "-" + std::to_string(k) == part_;
      if (!part_.empty() && this_one) found_ = true;
      if (!this_one) continue;
      GltfPrimitive primitive = reader_->Read(primitives[k], weights);
      if (!reader_->fault().empty()) return Fault(reader_->fault());
      stated_ += primitive.stated;
      skipped_ += primitive.stated - primitive.triangles.size();
      if (node.Has("skin") && !primitive.joints.empty()) {
        AppendSkinned(node["skin"].Unsigned(), primitive, placed_[n]);
      } else {
        for (const Affine34& X : *places) AppendPlaced(primitive, X);
      }
    }
  }

  void AppendPlaced(const GltfPrimitive& primitive, const Affine34& X) {
    std::vector<Vec3> points;
    points.reserve(primitive.points.size());
    for (const Vec3& p : primitive.points) points.emplace_back(X.leftCols<3>() * p + X.col(3));
    const bool mirrored = X.leftCols<3>().determinant() < 0;
    AppendTriangles(primitive, points, [mirrored](std::uint32_t) {
      return mirrored;
    });
  }

  /// Appends a mesh as the joints of its skin hold it at rest. Its own node places only vertices
  /// that hang on no joint.
  void AppendSkinned(std::uint64_t skin, const GltfPrimitive& primitive, const Affine34& X_MN) {
    if (skin >= skins_.size()) return Fault("there is no skin " + std::to_string(skin));
    std::vector<Affine34> joints;
    for (const JsonNode& joint : ItemsOf(skins_[skin], "joints")) {
      const std::uint64_t n = joint.Unsigned();
      if (n >= nodes_.size()) return Fault("a skin has a joint that is no node");
      joints.push_back(placed_[n]);
    }
    if (skins_[skin].Has("inverseBindMatrices")) {
      const auto matrices = numbers_.Read(skins_[skin]["inverseBindMatrices"].Unsigned());
      if (!matrices) return Fault(numbers_.fault());
      if (matrices->components != 16 || matrices->count < joints.size()) {
        return Fault("the matrices of a skin do not fit its joints");
      }
      for (std::size_t j = 0; j < joints.size(); ++j) {
        Affine34 X;
        for (std::size_t k = 0; k < 16; ++k) {
          if (k % 4 < 3) X(static_cast<int>(k % 4), static_cast<int>(k / 4)) = matrices->At(j, k);
        }
        joints[j] = ProductOf(joints[j], X);
      }
    }
    std::vector<Vec3> points;
    std::vector<bool> mirrored;
    for (std::size_t i = 0; i < primitive.points.size(); ++i) {
      Affine34 X = Affine34::Zero();
      double sum = 0;
      for (const auto& [joint, weight] : primitive.joints[i]) {
        if (joint >= joints.size()) return Fault("a vertex hangs on a joint that there is not");
        X += weight * joints[joint];
        sum += weight;
      }
      if (primitive.joints[i].empty()) {
        remarks_.Count("vertex of a skin hangs", "vertices of skins hang",
                       "on no joint: read where its node stands");
        X = X_MN;
        sum = 1;
      }
      if (!(sum > 0)) return Fault("a vertex of a skin has weights below 0");
      X /= sum;
      points.emplace_back(X.leftCols<3>() * primitive.points[i] + X.col(3));
      mirrored.push_back(X.leftCols<3>().determinant() < 0);
    }
    AppendTriangles(primitive, points, [&](std::uint32_t corner) {
      return mirrored[corner];
    });
  }

  template <typename Mirrored>
  void AppendTriangles(const GltfPrimitive& primitive, const std::vector<Vec3>& points,
                       const Mirrored& mirrored) {
    RawMesh& whole = answer_.mesh;
    const auto first = static_cast<std::uint32_t>(whole.points.size());
    for (const Vec3& p : points) whole.points.push_back({p.x(), p.y(), p.z()});
    for (const TriangleMesh::Triangle& t : primitive.triangles) {
      const bool turned = mirrored(t[0]);
      whole.triangles.push_back(
          {first + t[0], first + t[turned ? 2 : 1], first + t[turned ? 1 : 2]});
    }
  }

  void Fault(std::string why) {
    if (fault_.empty()) fault_ = std::move(why);
  }

  JsonNode root_;
  GltfNumbers numbers_;
  RemarkList remarks_;
  GltfMeshReader* reader_ = nullptr;
  std::string_view part_;
  std::vector<JsonNode> nodes_, meshes_, skins_;
  std::vector<Affine34> placed_;  // X_MN by node
  std::vector<std::vector<std::uint64_t>> children_;
  std::vector<bool> is_child_;
  std::vector<std::string> names_;
  std::set<std::string> seen_;  // names_ again
  bool quantized_ = false;
  bool found_ = false;
  std::size_t stated_ = 0;
  std::size_t skipped_ = 0;
  std::string fault_;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

std::uint32_t Number32At(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  if (at + 4 <= bytes.size()) std::memcpy(&number, bytes.data() + at, 4);
  return number;
}

ReadAnswer RefusedGltf(const std::string& why) {
  return {ReadAnswer::Kind::kRefused, "glTF: " + why, {}, 0};
}

}  // namespace

std::optional<ReadAnswer> ReadGltf(std::string content, const std::filesystem::path& file,
                                   std::string_view part) {
  std::string text;
  std::string_view chunk;
  const std::string_view bytes = content;
  if (!bytes.starts_with("glTF")) {
    text = std::move(content);
  } else {
    constexpr std::size_t kHead = 12;
    if (Number32At(bytes, 4) == 1) return std::nullopt;  // glTF 1 has another layout
    const std::uint32_t length = Number32At(bytes, 12);
    if (bytes.size() < kHead + 8 || length > bytes.size() - kHead - 8) {
      return RefusedGltf("it ends within its text: it is cut short");
    }
    text = bytes.substr(kHead + 8, length);
    const std::size_t next = kHead + 8 + (length + 3) / 4 * 4;
    if (next + 8 <= bytes.size() && bytes.substr(next + 4, 4) == std::string_view("BIN\0", 4)) {
      chunk = bytes.substr(next + 8, Number32At(bytes, next));
      if (chunk.size() < Number32At(bytes, next)) {
        return RefusedGltf("it ends within its numbers: it is cut short");
      }
    }
  }
  const Result<JsonFile> json = JsonFile::Parse(text, "its text");
  if (!json) {
    if (text.find("extensionsRequired") != std::string::npos) return RefusedGltf(kUnreadNeeds);
    const std::string& why = json.error().what;
    const std::size_t other = why.find(": this is no file of Tandem's");
    if (other == std::string::npos) return RefusedGltf(why);
    return RefusedGltf(why.substr(0, other) + ": export it in several files");
  }
  const JsonNode root = json->root();
  if (root.Has("meshes") && root["meshes"].IsObject()) return std::nullopt;  // glTF 1
  ReadAnswer answer = GltfReader(root, file, chunk, part).Read();
  if (const auto fault = json->fault()) {
    const bool needs = fault->what.find("extensionsRequired") != std::string::npos;
    return RefusedGltf(needs ? kUnreadNeeds : fault->what);
  }
  return answer;
}

}  // namespace tandem
