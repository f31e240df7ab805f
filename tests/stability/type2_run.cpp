#include "tests/stability/type2_run.h"

#include <algorithm>
#include <cmath>

#include "engine/haptics/scripted_device.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem::testing {

namespace {

/// A scripted hand that somebody knocks once.
class KickedDevice : public Device {
 public:
  KickedDevice(const HandScript& script, const Pose& X_WB0, double kick)
      : hand_(script, X_WB0), kick_(kick) {}
  void Start() noexcept override {
    hand_.Start();
    started_ = true;
  }
  Anchor Read() noexcept override { return hand_.Read(); }
  void Render(const Wrench& F_D_W) noexcept override {
    Wrench sum = F_D_W;
    if (started_ && frame_ >= 1000 && frame_ < 1050) sum.f.x() += kick_;
    frame_ += started_ ? 1 : 0;
    hand_.Render(sum);
  }

 private:
  ScriptedDevice hand_;
  double kick_;
  bool started_ = false;
  int frame_ = 0;
};

double RootMeanSquare(const std::vector<double>& squares, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += squares[i];
  return std::sqrt(sum / static_cast<double>(to - from));
}

/// Slope of ln RMS over windows, by least squares.
double GrowthOf(const std::vector<double>& squares, double window_s) {
  const auto window = static_cast<std::size_t>(1000 * window_s);
  std::vector<double> logs;
  for (std::size_t i = squares.size() / 3; i + window <= squares.size(); i += window) {
    logs.push_back(std::log(std::max(1e-12, RootMeanSquare(squares, i, i + window))));
  }
  double n = 0, st = 0, sy = 0, stt = 0, sty = 0;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const double t = window_s * static_cast<double>(i);
    n += 1, st += t, sy += logs[i], stt += t * t, sty += t * logs[i];
  }
  return n < 2 ? 0.0 : (n * sty - st * sy) / (n * stt - st * st);
}

}  // namespace

HandImpedance HandsOff() {
  return {.mass = 0.2,
          .damping = 0.3,
          .stiffness = 0,
          .inertia = 1e-4,
          .rotation_damping = 0.002,
          .rotation_stiffness = 0};
}

HandImpedance HeavyHand() {
  HandImpedance hand = HandsOff();
  hand.mass = 1.2;
  hand.damping = 2.3;
  return hand;
}

std::shared_ptr<const WorldModel> SharedBoxInSpace() {
  static const std::shared_ptr<const WorldModel> kModel = [] {
    auto model =
        std::make_shared<WorldModel>(*MakeWorldModel({{Box(Vec3(0.03, 0.02, 0.02))}}, 0.002));
    model->scene.bodies[0].shared = true;
    return model;
  }();
  return kModel;
}

std::unique_ptr<PeerNode> UserOf(const Type2Case& test, std::size_t user) {
  const auto model = SharedBoxInSpace();
  HandScript script;
  script.impedance = user < test.hands.size() ? test.hands[user] : test.hand;
  if (user < test.ways.size()) script.waypoints = test.ways[user];
  NodeOptions options;
  options.peer.id = 1 + user;
  options.peer.held_object = 0;
  options.peer.wait_for = 1;
  options.peer.coupling = test.coupling;
  options.publish_hz = test.publish_hz;
  options.name = std::to_string(1 + user);
  options.conditions = test.conditions;
  options.conditions.seed = 17 + user;
  return std::make_unique<PeerNode>(
      model,
      std::make_unique<KickedDevice>(script, model->bodies[0].X_WB0, user == 0 ? test.kick : 0.0),
      42, options);
}

Type2Run RunType2(const Type2Case& test) {
  SimulatedSession session;
  for (std::size_t user = 0; user < test.users; ++user) session.Add(UserOf(test, user), 1 + user);
  const auto ready = [&] {
    for (std::size_t user = 0; user < test.users; ++user) {
      const SharedBody* shared = session.node(user).peer().shared();
      if (shared == nullptr || shared->coupled() + 1 < test.users) return false;
    }
    return true;
  };
  for (int i = 0; i < 8000 && !ready(); ++i) session.Step();
  Type2Run run;
  std::vector<double> squares;
  double work = 0;
  std::uint64_t clips = 0;
  std::array<LinkView, kMaxLinks> views;
  const int frames = static_cast<int>(1000 * test.seconds);
  for (int frame = 0; frame < frames; ++frame) {
    if (test.before) test.before(session, frame);
    session.Step();
    double square = 0;
    for (std::size_t user = 0; user < session.size(); ++user) {
      if (!session.present(user)) continue;
      const Peer& peer = session.node(user).peer();
      if (peer.shared() == nullptr) continue;  // has not got it yet
      const RigidState& state = *peer.held_state();
      square += state.V_WB.v.squaredNorm();
      const std::size_t links = peer.shared()->Links(0, views);
      work -= 1e-3 * peer.shared()->ground_damping() * state.V_WB.v.squaredNorm();
      for (std::size_t link = 0; link < links; ++link) {
        const Wrench& F = peer.report().links_B_W[link];
        work += 1e-3 * (F.f.dot(state.V_WB.v) + F.tau.dot(state.V_WB.w));
        clips += views[link].clipped ? 1 : 0;
      }
    }
    run.generated = std::max(run.generated, work);
    squares.push_back(square);
    const Peer& first = session.node(0).peer();
    Vec3 links = Vec3::Zero();
    const std::size_t count = first.shared()->Links(0, views);
    for (std::size_t link = 0; link < count; ++link) links += first.report().links_B_W[link].f;
    run.hand_force.push_back(first.report().hand_B_W.f.norm());
    run.link_force.push_back(links.norm());
    run.link_each.push_back(count > 0 ? first.report().links_B_W[0].f.norm() : 0.0);
    if (session.size() < 2 || !session.present(1)) continue;
    if (session.node(1).peer().held_state() == nullptr) continue;
    const double apart =
        (first.held_state()->X_WB.p - session.node(1).peer().held_state()->X_WB.p).norm();
    run.peak_apart = std::max(run.peak_apart, apart);
    if (frame >= frames - 1000) {
      run.last_apart += 1e-3 * apart;
      run.last_force += 1e-3 * run.link_each.back();
    }
    if (!(apart < 10)) break;  // blown up
  }
  const double tau = 1e-3 * test.conditions.delay_ms;
  run.growth = GrowthOf(squares, std::max(0.5, 4 * tau));
  run.tail_rms = RootMeanSquare(squares, squares.size() - squares.size() / 10, squares.size());
  run.clip_share = static_cast<double>(clips) / static_cast<double>(squares.size());
  const std::int64_t local = session.network().LocalNow(1) - 1'000'000;
  if (session.node(0).peer().shared()->Links(local, views) > 0) {
    run.last_stiffness = views[0].stiffness;
    run.disagreement = views[0].disagreement;
    run.longest_loop = views[0].loop_age_s;
  }
  return run;
}

}  // namespace tandem::testing
