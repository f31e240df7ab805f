#include "app/bench/comparison/fcl_peer.h"

#include <fcl/fcl.h>

struct FclPair::Models {
  using Model = fcl::BVHModel<fcl::OBBRSSd>;

  static std::shared_ptr<Model> Make(const Mesh& mesh) {
    std::vector<fcl::Vector3d> vertices;
    std::vector<fcl::Triangle> triangles;
    for (const auto& v : mesh.vertices) vertices.emplace_back(v[0], v[1], v[2]);
    for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto model = std::make_shared<Model>();
    model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
    model->addSubModel(vertices, triangles);
    model->endModel();
    return model;
  }
  static fcl::Transform3d At(const Placed& at) {
    fcl::Transform3d X = fcl::Transform3d::Identity();
    X.linear() = fcl::Quaterniond(at.q_wxyz[0], at.q_wxyz[1], at.q_wxyz[2], at.q_wxyz[3]).matrix();
    X.translation() = fcl::Vector3d(at.p[0], at.p[1], at.p[2]);
    return X;
  }
  std::size_t Collide(const Placed& at, std::size_t most, bool contacts) const {
    const fcl::CollisionRequestd request(most, contacts);
    fcl::CollisionResultd result;
    fcl::collide(fixed.get(), fcl::Transform3d::Identity(), moving.get(), At(at), request, result);
    return result.numContacts();
  }

  std::shared_ptr<Model> fixed;
  std::shared_ptr<Model> moving;
};

FclPair::FclPair(const Mesh& fixed, const Mesh& moving)
    : models_(new Models{Models::Make(fixed), Models::Make(moving)}) {}

FclPair::~FclPair() = default;

std::size_t FclPair::Contacts(const Placed& at) const {
  return models_->Collide(at, std::size_t{1} << 30U, true);
}

bool FclPair::Touch(const Placed& at) const {
  return models_->Collide(at, 1, false) > 0;
}

double FclPair::Distance(const Placed& at) const {
  const fcl::DistanceRequestd request(false, 0.0, 0.0);
  fcl::DistanceResultd result;
  return fcl::distance(models_->fixed.get(), fcl::Transform3d::Identity(), models_->moving.get(),
                       Models::At(at), request, result);
}
