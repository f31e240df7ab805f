#include "engine/geometry/formats/collada/collada_controller.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "engine/geometry/formats/number_word.h"

namespace tandem {

namespace {

constexpr int kDeepestControllers = 16;

}  // namespace

std::optional<Affine34> AffineOf(const double* numbers) {
  Affine34 X;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) X(row, column) = numbers[4 * row + column];
  }
  const bool affine = numbers[12] == 0 && numbers[13] == 0 && numbers[14] == 0 && numbers[15] == 1;
  return affine ? std::optional(X) : std::nullopt;
}

ControlledMesh ColladaControllers::Read(const XmlElement& element, const FindJoint& joints,
                                        int depth) {
  if (depth > kDeepestControllers) {
    meshes_.Fault("its controllers are within one another");
    return {};
  }
  if (element.name == "geometry") return {meshes_.Read(element), false, {}};
  if (const XmlElement* skin = element.Child("skin")) return ReadSkin(*skin, joints, depth);
  if (const XmlElement* morph = element.Child("morph")) return ReadMorph(*morph, joints, depth);
  meshes_.Fault("its controller '" + element.Attribute("id") + "' is neither a skin nor a morph");
  return {};
}

const XmlElement* ColladaControllers::InputOf(const XmlElement& parent, const char* semantic) {
  for (const XmlElement* input : parent.Children("input")) {
    if (input->Attribute("semantic") == semantic) {
      return meshes_.Referred(input->Attribute("source"), {"source"});
    }
  }
  meshes_.Fault("a controller has no input " + std::string(semantic));
  return nullptr;
}

std::pair<std::vector<std::string>, bool> ColladaControllers::NamesOf(const XmlElement& source) {
  std::vector<std::string> names;
  for (const char* array : {"Name_array", "IDREF_array", "SIDREF_array"}) {
    const XmlElement* found = source.Child(array);
    if (found == nullptr) continue;
    for (const std::string_view word : found->Words()) names.emplace_back(word);
  }
  return {std::move(names), source.Child("IDREF_array") != nullptr};
}

ControlledMesh ColladaControllers::ReadMorph(const XmlElement& morph, const FindJoint& joints,
                                             int depth) {
  const XmlElement* base = meshes_.Referred(morph.Attribute("source"), {"geometry", "controller"});
  const XmlElement* targets = morph.Child("targets");
  if (base == nullptr || targets == nullptr) {
    meshes_.Fault("a morph has no targets");
    return {};
  }
  ControlledMesh shaped = Read(*base, joints, depth + 1);
  const XmlElement* names = InputOf(*targets, "MORPH_TARGET");
  const XmlElement* weights = InputOf(*targets, "MORPH_WEIGHT");
  if (names == nullptr || weights == nullptr) return {};
  const auto rows = meshes_.ReadRows(*weights);
  const std::vector<std::string> ids = NamesOf(*names).first;
  if (!rows || rows->count() < ids.size()) {
    meshes_.Fault("a morph has fewer weights than targets");
    return {};
  }
  const bool relative = morph.Attribute("method") == "RELATIVE";
  double sum = 0;
  std::vector<FilePoint> moved(shaped.mesh.points.size(), FilePoint{});
  for (std::size_t t = 0; t < ids.size(); ++t) {
    const double weight = rows->numbers[t * rows->width];
    if (weight == 0) continue;
    const XmlElement* target = meshes_.Referred("#" + ids[t], {"geometry", "controller"});
    if (target == nullptr) return {};
    const ControlledMesh other = Read(*target, joints, depth + 1);
    if (other.mesh.points.size() != moved.size()) {
      meshes_.Fault("a morph target does not fit its mesh");
      return {};
    }
    sum += weight;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) moved[i][k] += weight * other.mesh.points[i][k];
    }
  }
  const double kept = relative ? 1 : 1 - sum;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      shaped.mesh.points[i][k] = kept * shaped.mesh.points[i][k] + moved[i][k];
    }
  }
  return shaped;
}

std::optional<std::vector<Affine34>> ColladaControllers::JointsOf(const XmlElement& skin,
                                                                  const FindJoint& joints) {
  const XmlElement* group = skin.Child("joints");
  if (group == nullptr) {
    meshes_.Fault("a skin has no joints");
    return std::nullopt;
  }
  const XmlElement* names = InputOf(*group, "JOINT");
  const XmlElement* binds = InputOf(*group, "INV_BIND_MATRIX");
  if (names == nullptr || binds == nullptr) return std::nullopt;
  const auto [ids, by_id] = NamesOf(*names);
  const auto rows = meshes_.ReadRows(*binds);
  if (!rows) return std::nullopt;
  if (rows->width != 16 || rows->count() < ids.size()) {
    meshes_.Fault("a skin has fewer matrices than joints");
    return std::nullopt;
  }
  std::vector<Affine34> placed;
  for (std::size_t j = 0; j < ids.size(); ++j) {
    const Result<Affine34> X = joints(ids[j], by_id);
    const std::optional<Affine34> bind = AffineOf(rows->numbers.data() + 16 * j);
    if (!X || !bind) {
      meshes_.Fault("a skin has a joint '" + ids[j].substr(0, 40) + "' " +
                    (X ? "with a matrix that is no placing" : X.error().what));
      return std::nullopt;
    }
    placed.push_back(ProductOf(*X, *bind));
  }
  return placed;
}

ControlledMesh ColladaControllers::ReadSkin(const XmlElement& skin, const FindJoint& joints,
                                            int depth) {
  const XmlElement* base = meshes_.Referred(skin.Attribute("source"), {"geometry", "controller"});
  if (base == nullptr) return {};
  ControlledMesh shaped = Read(*base, joints, depth + 1);
  Affine34 bind_shape = Affine34::Identity();
  if (const XmlElement* matrix = skin.Child("bind_shape_matrix")) {
    std::vector<double> numbers;
    if (!meshes_.ReadNumbers(*matrix, numbers)) return {};
    const auto X = numbers.size() == 16 ? AffineOf(numbers.data()) : std::nullopt;
    if (!X) {
      meshes_.Fault("a skin has a bind_shape_matrix that is no placing");
      return {};
    }
    bind_shape = *X;
  }
  const auto placed = JointsOf(skin, joints);
  const XmlElement* hangs = skin.Child("vertex_weights");
  if (!placed || hangs == nullptr) {
    meshes_.Fault("a skin has no weights");
    return {};
  }
  std::size_t joint_offset = 0;
  std::size_t weight_offset = 1;
  std::size_t stride = 1;
  for (const XmlElement* input : hangs->Children("input")) {
    std::size_t offset = 0;
    if (!ParseNumber(input->Attribute("offset"), offset) || offset > 64) offset = 0;
    stride = std::max(stride, offset + 1);
    if (input->Attribute("semantic") == "JOINT") joint_offset = offset;
    if (input->Attribute("semantic") == "WEIGHT") weight_offset = offset;
  }
  const XmlElement* weights = InputOf(*hangs, "WEIGHT");
  const XmlElement* vcount = hangs->Child("vcount");
  const XmlElement* v = hangs->Child("v");
  const auto rows = weights == nullptr ? std::nullopt : meshes_.ReadRows(*weights);
  std::vector<std::int64_t> counts;
  std::vector<std::int64_t> pairs;
  if (!rows || vcount == nullptr || v == nullptr || !meshes_.ReadWholes(*vcount, counts) ||
      !meshes_.ReadWholes(*v, pairs) || counts.size() != shaped.mesh.points.size()) {
    meshes_.Fault("the weights of a skin do not fit its mesh");
    return {};
  }
  std::size_t at = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    Affine34 X = Affine34::Zero();
    double sum = 0;
    for (std::int64_t k = 0; k < counts[i]; ++k, at += stride) {
      if (at + stride > pairs.size()) {
        meshes_.Fault("the weights of a skin do not fit its mesh");
        return {};
      }
      const std::int64_t joint = pairs[at + joint_offset];
      const std::int64_t weight = pairs[at + weight_offset];
      if (joint >= static_cast<std::int64_t>(placed->size()) || joint < -1 || weight < 0 ||
          weight >= static_cast<std::int64_t>(rows->count())) {
        meshes_.Fault("a vertex of a skin hangs on a joint that there is not");
        return {};
      }
      const double share = rows->numbers[static_cast<std::size_t>(weight) * rows->width];
      // -1 is the shape itself
      X += share * (joint < 0 ? Affine34(Affine34::Identity())
                              : (*placed)[static_cast<std::size_t>(joint)]);
      sum += share;
    }
    if (sum == 0) {
      meshes_.remarks().Count("vertex of a skin hangs", "vertices of skins hang",
                              "on no joint: read where the skin's own shape is");
    } else if (!(sum > 0)) {
      meshes_.Fault("a vertex of a skin has weights below 0");
      return {};
    }
    X = sum == 0 ? bind_shape : ProductOf(X / sum, bind_shape);
    FilePoint& point = shaped.mesh.points[i];
    const Vec3 p = X.leftCols<3>() * Vec3(point[0], point[1], point[2]) + X.col(3);
    point = {p.x(), p.y(), p.z()};
    shaped.mirrored.push_back(X.leftCols<3>().determinant() < 0);
  }
  shaped.placed = true;
  return shaped;
}

}  // namespace tandem
