#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>

#include "app/bench/comparison/fcl_peer.h"
#include "app/bench/comparison/peer_support.h"
#include "engine/contact/field/touch_query.h"
#include "engine/contact/pair/contact_pair.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/realtime/clock.h"

// Times one haptic frame beside FCL's collision and distance queries, at the poses of a file, one
// thread.
namespace tandem {
namespace {

constexpr int kFrames = 200;   // about each pose, the first half to warm up
constexpr double kMass = 0.3;  // kg, for the contacts' gains
constexpr double kFrameS = 1e-3;
constexpr double kClassS = 2;  // processor time of each figure of a class, at least

FclPair::Mesh Plain(const TriangleMesh& mesh) {
  FclPair::Mesh plain;
  for (const Vec3& v : mesh.vertices) plain.vertices.push_back({v.x(), v.y(), v.z()});
  for (const auto& t : mesh.triangles) plain.triangles.push_back({t[0], t[1], t[2]});
  return plain;
}

FclPair::Placed Plain(const Pose& X) {
  return {{X.q.w(), X.q.x(), X.q.y(), X.q.z()}, {X.p.x(), X.p.y(), X.p.z()}};
}

/// Figures of a class of poses; times in us, one for each pose.
struct Figures {
  std::vector<double> frame, frame_p99, all_points, touch, first_touch, contacts, yes_no, distance;
  std::vector<double> our_contacts, their_contacts, distance_voxels;
};

/// Returns the median processor time of a call, us.
double CallUs(double least_s, const std::function<void()>& call) {
  std::vector<double> times;
  LoopClock& clock = MachineClock();
  double used = 0;
  while (used < 1e6 * least_s) {
    const std::int64_t begin = clock.ThreadCpuNs();
    call();
    times.push_back(1e-3 * static_cast<double>(clock.ThreadCpuNs() - begin));
    used += times.back();
  }
  return MedianOf(times);
}

/// Times frames as a hand makes them, 0.05 to 0.5 voxels a frame about the pose. Returns the body's
/// poses.
std::vector<Pose> TimeFrames(BodyPair& pair, const Pose& X_WB, double voxel, double radius,
                             std::mt19937_64& random, Figures& figures) {
  std::uniform_real_distribution<double> side(-1, 1);
  std::uniform_real_distribution<double> step(0.05, 0.5);
  LoopClock& clock = MachineClock();
  std::vector<double> times;
  std::vector<Pose> poses_WB;
  double contacts = 0;
  for (int frame = 0; frame < 2 * kFrames; ++frame) {
    // there and back, so that it stays about the pose
    Pose X = X_WB;
    const double way = 0.5 * step(random) * voxel;
    X.p += 0.7 * way * Vec3{side(random), side(random), side(random)};
    X.q = (RotationBy(0.3 * way / radius * Vec3{side(random), side(random), side(random)}) * X.q)
              .normalized();
    LinearizedForce on_shell;
    LinearizedForce on_map;
    const std::int64_t begin = clock.ThreadCpuNs();
    const PairReport report = pair.Collide({.X_WB = X, .V_WB = {}}, {}, on_shell, on_map);
    if (frame < kFrames) continue;
    poses_WB.push_back(X);
    times.push_back(1e-3 * static_cast<double>(clock.ThreadCpuNs() - begin));
    contacts += report.contact_points;
  }
  figures.frame.push_back(MedianOf(times));
  std::sort(times.begin(), times.end());
  figures.frame_p99.push_back(times[times.size() * 99 / 100]);
  figures.our_contacts.push_back(contacts / kFrames);
  return poses_WB;
}

/// Times yes or no at the same poses: one after the other, and each as if it were the first.
void TimeTouch(TouchQuery& query, const std::vector<Pose>& poses_WB, Figures& figures) {
  LoopClock& clock = MachineClock();
  std::array<std::vector<double>, 2> times;
  for (const bool first : {false, true}) {
    for (const Pose& X_WB : poses_WB) {
      if (first) query.Forget();
      const std::int64_t begin = clock.ThreadCpuNs();
      query.Find(X_WB, {});
      times[first ? 1 : 0].push_back(1e-3 * static_cast<double>(clock.ThreadCpuNs() - begin));
    }
  }
  figures.touch.push_back(MedianOf(times[0]));
  figures.first_touch.push_back(MedianOf(times[1]));
}

/// Returns the figures of one kind of poses: medians over the poses.
nlohmann::ordered_json AsJson(const std::string& kind, const Figures& f) {
  const double frame = MedianOf(f.frame);
  nlohmann::ordered_json row{{"kind", kind},
                             {"poses", f.frame.size()},
                             {"distance_voxels", MedianOf(f.distance_voxels)},
                             {"frame_us", frame},
                             {"frame_p99_us", MedianOf(f.frame_p99)},
                             {"frame_contacts", MedianOf(f.our_contacts)},
                             {"all_points_us", MedianOf(f.all_points)},
                             {"fcl_contacts_us", MedianOf(f.contacts)},
                             {"fcl_contacts", MedianOf(f.their_contacts)},
                             {"fcl_yes_no_us", MedianOf(f.yes_no)},
                             {"fcl_distance_us", MedianOf(f.distance)},
                             {"contacts_ratio", MedianOf(f.contacts) / frame},
                             {"yes_no_ratio", MedianOf(f.yes_no) / frame},
                             {"touch_us", nullptr},
                             {"first_touch_us", nullptr},
                             {"distance_ratio", MedianOf(f.distance) / frame}};
  if (!f.touch.empty()) {
    row["touch_us"] = MedianOf(f.touch);
    row["first_touch_us"] = MedianOf(f.first_touch);
    row["touch_yes_no_ratio"] = MedianOf(f.yes_no) / MedianOf(f.touch);
    row["first_touch_yes_no_ratio"] = MedianOf(f.yes_no) / MedianOf(f.first_touch);
  }
  return row;
}

std::optional<Error> Run(const PeerPair& files) {
  const ContactModel model = files.plain ? ContactModel::kPlain : ContactModel::kRefined;
  const Result<PeerModels> models = LoadPeerModels(files, model);
  if (!models) return models.error();
  const FclPair fcl(Plain(models->fixed), Plain(models->moving));
  const double voxel = models->voxmap.voxel_size();
  const ContactGains gains = DefaultContactGains(voxel, kMass, kFrameS);
  std::unique_ptr<BodyPair> made;
  if (files.plain) {
    made = std::make_unique<ContactPair>(
        models->points, models->voxmap, Pose{Quat::Identity(), models->voxmap.p_WVo()}, 0,
        PairOptions{.force_layer = DefaultForceLayer(model)}, gains);
  } else {
    made = std::make_unique<FieldPair>(models->moving_surface, models->fixed_surface,
                                       FieldPair::Options{}, gains);
  }
  BodyPair& pair = *made;
  std::optional<TouchQuery> touch;
  if (!files.plain) touch.emplace(models->moving_surface, models->fixed_surface);

  std::vector<std::pair<std::string, Figures>> kinds;
  std::mt19937_64 random(1);
  for (const FilePose& pose : models->poses) {
    auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& known) {
      return known.first == pose.kind;
    });
    if (kind == kinds.end()) kind = kinds.insert(kinds.end(), {pose.kind, {}});
    Figures& figures = kind->second;
    const auto of_kind =
        std::count_if(models->poses.begin(), models->poses.end(), [&](const FilePose& other) {
          return other.kind == pose.kind;
        });
    const double share = kClassS / static_cast<double>(of_kind);
    const Pose X_WB = pose.X_WM * models->X_MB;
    const FclPair::Placed at = Plain(pose.X_WM);
    figures.all_points.push_back(CallUs(share, [&] {
      pair.Read({.X_WB = X_WB, .V_WB = {}}, {});
    }));
    const std::vector<Pose> frames_WB =
        TimeFrames(pair, X_WB, voxel, models->points.radius, random, figures);
    if (touch) TimeTouch(*touch, frames_WB, figures);
    std::size_t contacts = 0;
    double distance = 0;
    figures.contacts.push_back(CallUs(share, [&] {
      contacts = fcl.Contacts(at);
    }));
    figures.yes_no.push_back(CallUs(share, [&] {
      fcl.Touch(at);
    }));
    figures.distance.push_back(CallUs(share, [&] {
      distance = fcl.Distance(at);
    }));
    figures.their_contacts.push_back(static_cast<double>(contacts));
    figures.distance_voxels.push_back(std::max(0.0, distance) / voxel);
  }

  nlohmann::ordered_json out{{"fixed", files.fixed.filename()},
                             {"moving", files.moving.filename()},
                             {"voxel_m", voxel},
                             {"points", models->points.size()},
                             {"map_bytes", models->voxmap.header().bytes},
                             {"model", files.plain ? "plain" : "refined"},
                             {"kinds", nlohmann::ordered_json::array()}};
  for (const auto& [name, f] : kinds) out["kinds"].push_back(AsJson(name, f));
  std::printf("%s\n", out.dump(2).c_str());
  return std::nullopt;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  tandem::PeerPair pair;
  CLI::App app{"Measure haptic frames beside FCL; print JSON"};
  tandem::AddPeerPair(app, pair);
  app.add_flag("--plain", pair.plain, "use the plain contact model; default: refined");
  return tandem::RunPeer(app, argc, argv, [&] {
    return tandem::Run(pair);
  });
}
