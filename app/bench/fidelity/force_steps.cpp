#include "app/bench/fidelity/force_steps.h"

#include <algorithm>

namespace tandem {

std::unique_ptr<BodyPair> FixturePair(const WorldModel& model) {
  const BodyModel& body = model.bodies[0];
  const Scene& scene = model.scene;
  const ContactGains gains = DefaultContactGains(scene.voxel_size, body.inertia.mass, kFrame);
  if (scene.contact == ContactModel::kRefined) {
    return std::make_unique<FieldPair>(body.surface, model.fixture_surface, FieldPair::Options{},
                                       gains);
  }
  return std::make_unique<ContactPair>(body.points, model.fixture,
                                       Pose{Quat::Identity(), model.fixture.p_WVo()}, 0.0,
                                       PairOptions{.force_layer = scene.force_layer}, gains);
}

Vec3 ForceAtRest(BodyPair& pair, const Pose& X_WB) {
  return AsWrench(pair.Read({X_WB, {}}, {}).on_shell.force).f;
}

double LargestForceStep(const std::function<Vec3(double)>& force_at, int parts, double largest) {
  constexpr int kCuts = 20;  // after these, a millionth of the part is left
  Vec3 at_end = force_at(0);
  for (int part = 0; part < parts; ++part) {
    double low = part / static_cast<double>(parts);
    double high = (part + 1) / static_cast<double>(parts);
    Vec3 below = at_end;
    Vec3 above = at_end = force_at(high);
    for (int cut = 0; cut < kCuts && (above - below).norm() > largest; ++cut) {
      const double middle = 0.5 * (low + high);
      const Vec3 between = force_at(middle);
      const bool lower = (between - below).norm() > (above - between).norm();
      (lower ? high : low) = middle;
      (lower ? above : below) = between;
    }
    largest = std::max(largest, (above - below).norm());
  }
  return largest;
}

}  // namespace tandem
