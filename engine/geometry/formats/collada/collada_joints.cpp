#include "engine/geometry/formats/collada/collada_joints.h"

#include <algorithm>
#include <utility>

namespace tandem {

namespace {

constexpr int kDeepestJoint = 128;

}  // namespace

void ColladaJoints::Place(const XmlElement& node, const Affine34& X_MP, int depth,
                          const LocalOf& local_of) {
  if (depth > kDeepestJoint) return;
  const Affine34 X_MN = ProductOf(X_MP, local_of(node));
  const std::size_t joint = joints_.size();
  joints_.push_back({X_MN, 0});
  of_element_.emplace(&node, joint);
  for (const auto& [key, names] :
       {std::pair{"sid", &by_sid_}, std::pair{"id", &by_id_}, std::pair{"name", &by_name_}}) {
    const std::string name = node.Attribute(key);
    if (!name.empty()) names->emplace(name, joint);
  }
  for (const XmlElement* child : node.Children("node")) Place(*child, X_MN, depth + 1, local_of);
  joints_[joint].end = joints_.size();
}

ColladaJoints::Match ColladaJoints::Look(const Names& names, const std::string& name,
                                         const std::vector<std::size_t>& below, Affine34& X) const {
  Match match = Match::kNone;
  const auto [begin, end] = names.equal_range(name);
  for (auto at = begin; at != end; ++at) {
    const std::size_t joint = at->second;
    const bool wanted = below.empty() || std::ranges::any_of(below, [&](std::size_t root) {
                          return root <= joint && joint < joints_[root].end;
                        });
    if (!wanted) continue;
    // several at the same place are as good as one
    if (match == Match::kOne && joints_[joint].X != X) return Match::kSeveral;
    match = Match::kOne;
    X = joints_[joint].X;
  }
  return match;
}

Result<Affine34> ColladaJoints::Find(const std::string& name, bool by_id,
                                     const std::vector<const XmlElement*>& skeleton) const {
  std::vector<std::size_t> roots;
  for (const XmlElement* root : skeleton) {
    const auto known = of_element_.find(root);
    if (known != of_element_.end()) roots.push_back(known->second);
  }
  std::vector<std::pair<const Names*, bool>> order;  // and whether below the skeleton only
  if (by_id) order.emplace_back(&by_id_, false);
  for (const bool below : {true, false}) {
    if (below && roots.empty()) continue;
    for (const Names* names : {&by_sid_, &by_id_, &by_name_}) order.emplace_back(names, below);
  }
  for (const auto& [names, below] : order) {
    Affine34 X;
    const Match match = Look(*names, name, below ? roots : std::vector<std::size_t>(), X);
    if (match == Match::kOne) return X;
    if (match == Match::kSeveral) {
      return Error{
          "that stands in several places: name its skeleton, or give each joint a sid of "
          "its own"};
    }
  }
  return Error{"that stands nowhere"};
}

}  // namespace tandem
