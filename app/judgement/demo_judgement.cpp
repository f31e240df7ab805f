#include "app/judgement/demo_judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include "engine/base/units.h"
#include "engine/geometry/exact/bodies_meeting.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr double kRestSpeed = 2e-3;               // m/s
constexpr double kRestTurn = 2.0 * M_PI / 180.0;  // rad/s
constexpr double kStill = 1e-4;                   // m/s
constexpr std::size_t kWindow = 500;              // frames
constexpr double kDeepest = 30;                   // voxels; depths up to this are exact

struct Rms {
  double speed = 0;
  double turn = 0;
};

Rms RmsOf(const std::vector<TraceSample>& trace, std::size_t begin, std::size_t end) {
  double speed = 0;
  double turn = 0;
  for (std::size_t i = begin; i < end; ++i) {
    speed += trace[i].V_WB.v.squaredNorm();
    turn += trace[i].V_WB.w.squaredNorm();
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, end - begin));
  return {std::sqrt(speed / count), std::sqrt(turn / count)};
}

/// Returns the slope of the least-squares line through the values, per index.
double Slope(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum_i = 0;
  double sum_v = 0;
  double sum_ii = 0;
  double sum_iv = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto i = static_cast<double>(k);
    sum_i += i;
    sum_v += values[k];
    sum_ii += i * i;
    sum_iv += i * values[k];
  }
  return (n * sum_iv - sum_i * sum_v) / std::max(n * sum_ii - sum_i * sum_i, 1e-300);
}

}  // namespace

TraceDivergence DivergenceOf(const std::vector<TraceSample>& a, const std::vector<TraceSample>& b) {
  TraceDivergence divergence;
  std::size_t j = 0;
  for (const TraceSample& sample : a) {
    while (j + 1 < b.size() && b[j + 1].time_ns <= sample.time_ns) ++j;
    if (j + 1 >= b.size()) break;
    const TraceSample& before = b[j];
    const TraceSample& after = b[j + 1];
    if (sample.time_ns < before.time_ns) continue;
    const double t = static_cast<double>(sample.time_ns - before.time_ns) /
                     static_cast<double>(after.time_ns - before.time_ns);
    const Vec3 p = before.X_WB.p + t * (after.X_WB.p - before.X_WB.p);
    divergence.last = (sample.X_WB.p - p).norm();
    divergence.peak = std::max(divergence.peak, divergence.last);
  }
  return divergence;
}

std::pair<double, double> HandsApart(const std::vector<TraceSample>& a,
                                     const std::vector<TraceSample>& b) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double later = ToSeconds(b[i].time_ns - a[i].time_ns);
    least = std::min(least, later);
    most = std::max(most, later);
  }
  return {least, most};
}

bool IsAtRest(const std::vector<TraceSample>& trace) {
  const std::size_t begin = trace.size() - trace.size() / 3;
  const Rms whole = RmsOf(trace, begin, trace.size());
  if (trace.empty() || whole.speed >= kRestSpeed || whole.turn >= kRestTurn) return false;
  std::vector<double> logs;
  double tail = 0;
  for (std::size_t i = begin; i + kWindow <= trace.size(); i += kWindow) {
    tail = RmsOf(trace, i, i + kWindow).speed;
    logs.push_back(std::log(std::max(tail, 1e-12)));
  }
  return !logs.empty() && (tail < kStill || Slope(logs) <= 0);
}

Outcome OutcomeOf(const WorldModel& model, std::size_t body, const Pose& X_WB) {
  Outcome outcome;
  const Pose& X_WB0 = model.bodies[body].X_WB0;
  outcome.travel = (X_WB.p - X_WB0.p).norm();
  const Pose X_W = X_WB * X_WB0.Inverse();
  Bounds fixture;
  Bounds moved;
  for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
    if (model.body_index[i] < 0) {
      const Bounds part = BoundsOf(model.meshes_W[i]);
      fixture.Add(part.min);
      fixture.Add(part.max);
    } else if (model.body_index[i] == static_cast<int>(body)) {
      const Bounds part = BoundsOf(Transformed(model.meshes_W[i], X_W));
      moved.Add(part.min);
      moved.Add(part.max);
    }
  }
  outcome.out = !moved.Overlaps(fixture);
  return outcome;
}

PenetrationReport Penetration(const WorldModel& model, std::size_t body,
                              const std::vector<std::vector<Pose>>& series, double voxel_size,
                              double seconds_limit) {
  TriangleMesh fixture_W;
  TriangleMesh part_B;
  for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
    if (model.body_index[i] < 0) {
      Append(fixture_W, model.meshes_W[i]);
    } else if (model.body_index[i] == static_cast<int>(body)) {
      Append(part_B, Transformed(model.meshes_W[i], model.bodies[body].X_WB0.Inverse()));
    }
  }
  // bodies that the part never comes near are left out: in a large scene their union takes minutes
  // to make
  Bounds part;
  for (const Vec3& v : part_B.vertices) part.Add(v);
  Bounds way;
  for (const std::vector<Pose>& poses : series) {
    for (const Pose& X_WB : poses) {
      for (int corner = 0; corner < 8; ++corner) {
        way.Add(X_WB * Vec3((corner & 1) != 0 ? part.max.x() : part.min.x(),
                            (corner & 2) != 0 ? part.max.y() : part.min.y(),
                            (corner & 4) != 0 ? part.max.z() : part.min.z()));
      }
    }
  }
  way.min -= Vec3::Constant(kDeepest * voxel_size);
  way.max += Vec3::Constant(kDeepest * voxel_size);
  const PenetrationOracle oracle(BodiesMeeting(fixture_W, way), part_B, voxel_size);
  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const std::int64_t start_ns = MonotonicNowNs();
  PenetrationReport report = oracle.Check(series, threads, [&] {
    return ToSeconds(MonotonicNowNs() - start_ns) > seconds_limit;
  });
  oracle.Refine(series, report);
  return report;
}

PenetrationReport Penetration(const WorldModel& model, std::size_t body,
                              const std::vector<std::vector<TraceSample>>& instances,
                              double seconds_limit) {
  std::vector<std::vector<Pose>> series;
  for (const std::vector<TraceSample>& trace : instances) {
    std::vector<Pose>& poses = series.emplace_back();
    for (std::size_t i = 0; i < trace.size(); ++i) {
      if (i % 10 == 0 || trace[i].pushing) poses.push_back(trace[i].X_WB);
    }
  }
  return Penetration(model, body, series, model.scene.voxel_size, seconds_limit);
}

}  // namespace tandem
