#include "app/capacity/capacity.h"

#include <algorithm>
#include <array>
#include <memory>

#include "engine/base/units.h"
#include "engine/contact/schedule/schedule.h"
#include "engine/paging/resident_voxels.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem {

namespace {
constexpr std::uint32_t kStride = 7;  // from one tested block to the next: due blocks are scattered
constexpr std::size_t kPiece = 128;   // blocks that one thread takes at a time
constexpr std::int64_t kLongEnoughNs = 20'000'000;
/// The further work for each test, as a share of its time: queues, which threads share as well, and
/// the work of one thread alone.
constexpr double kQueueShare = 0.25;
constexpr double kAloneShare = 0.05;
/// Voxels along each axis that the body stands beside itself. Near its own sharp edges nearly every
/// place asks a list of faces, at up to four times the price. Two voxels off hardly any place does.
/// Frames are between: the follower corrects by a half or twice (CapacityFollower).
constexpr std::array kAside{0.6, 2.0};

/// Returns the time of one test among many, s, on the calling thread alone.
template <class Test>
double TimeAlone(std::size_t points, const Test& test) {
  LoopClock& clock = MachineClock();
  const std::int64_t begin = clock.ThreadCpuNs();
  double tested = 0;
  std::int64_t spent = 0;
  do {
    test();
    tested += static_cast<double>(points);
    spent = clock.ThreadCpuNs() - begin;
  } while (spent < kLongEnoughNs);
  return ToSeconds(spent) / tested;
}

/// Returns the same for several threads. It takes the median of rounds, each of which ends when all
/// threads have done, because any thread may be held up. Its thread is as urgent as the haptic
/// thread: an ordinary one would wait for the processor of its own workers.
template <class Test>
double TimeShared(std::size_t points, const Test& test) {
  std::vector<double> rounds;
  PeriodicThread thread({}, [&](std::int64_t, std::int64_t begin) {
    std::int64_t end = begin;
    while (end - begin < kLongEnoughNs) {
      const std::int64_t round = end;
      test();
      end = MonotonicNowNs();
      rounds.push_back(static_cast<double>(end - round));
    }
    return false;
  });
  thread.Join();
  const auto middle = rounds.begin() + static_cast<std::ptrdiff_t>(rounds.size() / 2);
  std::nth_element(rounds.begin(), middle, rounds.end());
  return 1e-9 * *middle / static_cast<double>(points);
}

/// Returns the fixture's voxels round a body where it stands at first, for a world that has only
/// part of them in memory; else null.
std::unique_ptr<ResidentVoxels> VoxelsNear(const WorldModel& world, const BodyModel& body,
                                           const PointBlocks& blocks) {
  if (world.fixture_pages == nullptr) return nullptr;
  constexpr std::uint64_t kEnough = std::uint64_t{64} << 20U;
  const std::uint64_t fixed = VoxelArena::FixedBytes(world.fixture_pages->outline());
  auto made = ResidentVoxels::Make(world.fixture_pages,
                                   std::min(world.voxel_memory_bytes, fixed + kEnough));
  if (!made) return nullptr;
  const Voxmap& voxmap = (*made)->voxmap();
  const Pose X_VS = Pose{Quat::Identity(), voxmap.p_WVo()}.Inverse() * body.X_WB0;
  VoxelReader& reader = (*made)->AddReader(Vec3::Zero(), Vec3::Constant(body.radius));
  reader.MoveTo(X_VS, 0);
  (*made)->Start();
  const double s = voxmap.voxel_size();
  for (const PointBlocks::Chunk& chunk : blocks.chunks()) {
    reader.Announce(X_VS * chunk.p_BC / s, chunk.radius / s + 1, 0);
  }
  (*made)->WaitUntilResident();
  return std::move(*made);
}

/// Measures a frame of the plain model, by tests of the largest pointshell's blocks.
FrameCapacity OfPoints(const WorldModel& world, double seconds, WorkerPool* workers) {
  const auto largest = std::ranges::max_element(world.bodies, {}, [](const BodyModel& body) {
    return body.points.size();
  });
  if (largest == world.bodies.end() || largest->points.size() == 0) return {};
  const PointBlocks blocks(largest->points);
  const std::unique_ptr<ResidentVoxels> near = VoxelsNear(world, *largest, blocks);
  const Voxmap& voxmap = near != nullptr     ? near->voxmap()
                         : world.has_fixture ? world.fixture
                                             : world.bodies[0].voxmap;
  if (voxmap.empty()) return {};
  const Pose X_VS = Pose{Quat::Identity(), voxmap.p_WVo()}.Inverse() * largest->X_WB0;
  const VoxelTransform transform(X_VS, voxmap.voxel_size(), 0);
  std::vector<std::uint32_t> list;
  for (std::uint32_t b = 0; b < blocks.size(); b += kStride) list.push_back(b);
  std::vector<BlockReading> readings(list.size());
  const auto test = [&](std::size_t begin, std::size_t end, int) {
    TestBlocks(blocks, transform, voxmap, 3, std::span(list).subspan(begin, end - begin),
               readings.data() + begin);
  };
  const std::size_t points = PointBlocks::kLanes * list.size();
  const double alone = TimeAlone(points, [&] {
    test(0, list.size(), 0);
  });
  const double shared = workers == nullptr ? alone : TimeShared(points, [&] {
    workers->WakeWorkers();
    workers->ParallelFor(list.size(), kPiece, test);
    workers->ReleaseWorkers();
  });
  const double test_s = (1 + kQueueShare) * shared + kAloneShare * alone;
  return {.tests = std::max(1000.0, seconds / test_s)};
}

/// Measures a frame of the refined model, by look-ups of a body's features in its own field. The
/// body stands beside that field.
FrameCapacity OfFeatures(const WorldModel& world, double seconds, WorkerPool* workers) {
  const auto largest = std::ranges::max_element(world.bodies, {}, [](const BodyModel& body) {
    return body.surface.features.point_count();
  });
  if (largest == world.bodies.end() || largest->surface.features.point_count() == 0) return {};
  const BodyFeatures& features = largest->surface.features;
  const DistanceField& field = largest->surface.field;
  const auto time_all = [&](WorkerPool* of_helpers, const auto& timed) {
    FieldSchedule schedule(features, field, nullptr, {}, {.workers = of_helpers});
    const auto read = [&] {
      for (const double aside : kAside) {
        schedule.Read({Quat::Identity(), Vec3::Constant(aside)}, 0, 0);
      }
    };
    read();
    return timed(kAside.size() * schedule.counts().looked_up, read);
  };
  const double alone = time_all(nullptr, [](std::size_t count, const auto& test) {
    return TimeAlone(count, test);
  });
  const double shared =
      workers == nullptr ? alone : time_all(workers, [&](std::size_t count, const auto& test) {
        return TimeShared(count, [&] {
          test();
          workers->ReleaseWorkers();
        });
      });
  const double test_s = (1 + kQueueShare) * shared + kAloneShare * alone;
  FrameCapacity capacity{.tests = std::max(1000.0, seconds / test_s)};
  // a query reads how a point is pushed, a third of a voxel off the surface
  FieldPushes pushes;
  std::vector<Vec3> places_V;
  for (std::size_t b = 0; b < features.blocks().size(); ++b) {
    const Vec3 off = -features.point(b, 0).inward.cast<double>() / 3;
    places_V.push_back(features.place(b, 0) + off);
  }
  const double query_s = TimeAlone(places_V.size(), [&] {
    for (std::size_t at = 0; at < places_V.size(); at += FieldPushes::kMostPlaces) {
      const std::size_t count = std::min(FieldPushes::kMostPlaces, places_V.size() - at);
      field.Pushes(std::span(places_V).subspan(at, count), 0.45, pushes);
    }
  });
  capacity.query_price = query_s / test_s;
  return capacity;
}
}  // namespace

FrameCapacity MeasureCapacity(const WorldModel& world, double seconds, WorkerPool* workers) {
  return world.scene.contact == ContactModel::kPlain ? OfPoints(world, seconds, workers)
                                                     : OfFeatures(world, seconds, workers);
}

}  // namespace tandem
