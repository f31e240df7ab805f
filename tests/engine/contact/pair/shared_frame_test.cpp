#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/contact/pair/contact_pair.h"
#include "engine/realtime/worker_pool.h"
#include "tests/engine/contact/schedule/random_walk.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

using testing::Bodies;
using testing::Box;
using testing::RandomWalker;

constexpr double kFineVoxel = 0.003;

Bodies FineRods() {
  return {Box(Vec3(0.5, 0.3, 0.2)), Box(Vec3(0.45, 0.08, 0.06)), kFineVoxel};
}

// A schedule, with its own workers.
struct Shared {
  Shared(const Bodies& bodies, int threads, ScheduleOptions options)
      : workers({.threads = threads, .priority = 0}) {
    options.workers = threads > 1 ? &workers : nullptr;
    options.shared_from = 40;
    schedule = MakeSchedule(bodies.blocks, bodies.voxmap, 1, options);
  }
  WorkerPool workers;
  std::unique_ptr<Schedule> schedule;
};

void ExpectSame(const Schedule& a, const Schedule& b, int frame) {
  ASSERT_EQ(a.contacts().size(), b.contacts().size()) << "frame " << frame;
  for (std::size_t k = 0; k < a.contacts().size(); ++k) {
    ASSERT_EQ(a.contacts()[k].block, b.contacts()[k].block) << "frame " << frame;
    ASSERT_EQ(a.contacts()[k].lanes, b.contacts()[k].lanes) << "frame " << frame;
  }
  ASSERT_EQ(a.counts().looked_up, b.counts().looked_up) << "frame " << frame;
  ASSERT_EQ(a.counts().drifted, b.counts().drifted) << "frame " << frame;
  ASSERT_EQ(a.counts().chunks, b.counts().chunks) << "frame " << frame;
  const TestDemand demand_a = a.Demand();
  const TestDemand demand_b = b.Demand();
  for (const auto& [x, y] : {std::pair{demand_a.mandatory, demand_b.mandatory},
                             std::pair{demand_a.per_metre, demand_b.per_metre},
                             std::pair{demand_a.bound, demand_b.bound}}) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(x), std::bit_cast<std::uint64_t>(y))
        << "frame " << frame;
  }
}

/// Records how many threads the largest frame has: at most one a processor.
void RecordThreads(const WorkerPool& asked_four) {
  ::testing::Test::RecordProperty("threads", asked_four.threads());
}

// Moves two bodies at random. One, two and four threads test the same motion.
void MoveTogether(const Bodies& bodies, const ScheduleOptions& options, std::uint64_t seed) {
  Shared one(bodies, 1, options);
  Shared two(bodies, 2, options);
  Shared four(bodies, 4, options);
  RecordThreads(four.workers);
  std::mt19937_64 random(seed);
  RandomWalker shell;
  RandomWalker map;
  shell.X_WB = {testing::RandomRotation(random), 0.15 * testing::RandomDirection(random)};
  double travel = std::numeric_limits<double>::infinity();
  int shared = 0;
  double contacts = 0;
  for (int frame = 0; frame < 4000; ++frame) {
    const Pose X_VS = (map.X_WB * bodies.X_MV()).Inverse() * shell.X_WB;
    const int layer = static_cast<int>(random() % 4);
    const double displacement = testing::Uniform(random, -1.0, 1.0) * kFineVoxel;
    for (Shared* each : {&one, &two, &four}) {
      if (frame % 500 == 250) each->schedule->SetForceLayer(layer);
      if (frame % 300 == 150) each->schedule->SetDisplacement(displacement);
      each->schedule->Test(X_VS, travel);
      each->workers.ReleaseWorkers();
    }
    ASSERT_NO_FATAL_FAILURE(ExpectSame(*one.schedule, *two.schedule, frame));
    ASSERT_NO_FATAL_FAILURE(ExpectSame(*one.schedule, *four.schedule, frame));
    const TestCounts& counts = one.schedule->counts();
    shared += static_cast<int>(counts.looked_up + counts.drifted > 40 * PointBlocks::kLanes);
    contacts += static_cast<double>(one.schedule->contacts().size());
    const double most = one.schedule->Demand().bound;
    shell.Push(random, Vec3::Zero());
    map.Push(random, Vec3(0.1, 0, 0));
    travel = shell.Move(0.5 * most, bodies.shell.radius + 3 * kFineVoxel);
    travel += map.Move(0.5 * most, bodies.map_radius + 3 * kFineVoxel);
  }
  EXPECT_GT(shared, 1000);
  EXPECT_GT(contacts, 300);
  EXPECT_EQ(testing::UntestedPoints(bodies.blocks, bodies.voxmap, *four.schedule), 0U);
}

TEST(SharedFrame, IsBitIdenticalOnOneTwoAndFourThreads) {
  const Bodies bodies = FineRods();
  for (const bool drift : {true, false}) {
    for (const bool chunks : {true, false}) {
      SCOPED_TRACE(::testing::Message() << "drift " << drift << " chunks " << chunks);
      MoveTogether(bodies, {.experiments = {.chunks = chunks, .drift = drift}}, 11);
    }
  }
}

// Boxes, one turned, that push one another with faces, edges and vertices.
struct PushingBoxes {
  static constexpr double kS = 0.001;
  PushingBoxes()
      : map_mesh(
            testing::At(Box(kS * Vec3(60, 40, 30)), Vec3::Zero(), RotationBy({0.3, 0.2, 0.1}))),
        voxmap(std::move(*Voxelize(map_mesh, {.voxel_size = kS, .flatness_voxels = kFlat}))),
        shell(std::move(*MakePointshell(Box(kS * Vec3(50, 36, 24)), Pose{},
                                        {.spacing = 0.5 * kS, .flatness_voxels = kFlat}))) {}
  std::unique_ptr<ContactPair> Pair(WorkerPool* workers) const {
    return std::make_unique<ContactPair>(
        shell, voxmap, Pose{Quat::Identity(), voxmap.p_WVo()}, 0.04,
        PairOptions{.force_layer = 1,
                    .both_move = true,
                    .schedule = {.workers = workers, .shared_from = 60}},
        ContactGains{1000.0, 20});
  }

  inline static const double kFlat = FlatnessVoxels(ContactModel::kPlain);
  TriangleMesh map_mesh;
  Voxmap voxmap;
  Pointshell shell;
};

template <class Matrix>
bool SameBits(const Matrix& a, const Matrix& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

TEST(SharedFrame, ForcesAreBitIdenticalOnOneTwoAndFourThreads) {
  const PushingBoxes boxes;
  WorkerPool one_helper({.threads = 2, .priority = 0});
  WorkerPool three_helpers({.threads = 4, .priority = 0});
  RecordThreads(three_helpers);
  const auto alone = boxes.Pair(nullptr);
  const std::array<std::unique_ptr<ContactPair>, 2> shared{boxes.Pair(&one_helper),
                                                           boxes.Pair(&three_helpers)};
  std::mt19937_64 random(3);
  int pushed = 0;
  int many = 0;
  BodyMotion body;
  for (int frame = 0; frame < 600; ++frame) {
    // from somewhere else every 20 frames; then on by up to a quarter of a voxel
    const double reach = PushingBoxes::kS * (frame % 20 == 0 ? 28 : 0.25);
    const Vec3 way = reach * testing::RandomDirection(random);
    if (frame % 20 == 0) body.X_WB = {testing::RandomRotation(random), way};
    if (frame % 20 != 0) body.X_WB.p += way;
    body.V_WB.v = way;
    LinearizedForce on_shell;
    LinearizedForce on_map;
    const PairReport report = alone->Collide(body, {}, on_shell, on_map);
    pushed += report.pushing_points;
    many += static_cast<int>(report.contact_points >= 10);
    for (const auto& pair : shared) {
      LinearizedForce same_shell;
      LinearizedForce same_map;
      const PairReport same = pair->Collide(body, {}, same_shell, same_map);
      ASSERT_EQ(same.contact_points, report.contact_points) << "frame " << frame;
      ASSERT_EQ(same.pushing_points, report.pushing_points) << "frame " << frame;
      ASSERT_TRUE(SameBits(same_shell.force, on_shell.force)) << "frame " << frame;
      ASSERT_TRUE(SameBits(same_shell.stiffness, on_shell.stiffness)) << "frame " << frame;
      ASSERT_TRUE(SameBits(same_shell.damping, on_shell.damping)) << "frame " << frame;
      ASSERT_TRUE(SameBits(same_map.force, on_map.force)) << "frame " << frame;
      ASSERT_TRUE(SameBits(pair->cross().stiffness, alone->cross().stiffness)) << "frame " << frame;
    }
    one_helper.ReleaseWorkers();
    three_helpers.ReleaseWorkers();
  }
  EXPECT_GT(pushed, 300);
  EXPECT_GT(many, 200);
}

TEST(SharedFrame, AllocatesNothing) {
  const Bodies bodies = FineRods();
  Shared four(bodies, 4, {.experiments = {.coherence = false, .chunks = false}});
  Pose X_VS = bodies.X_MV().Inverse();
  four.schedule->Test(X_VS, 0);
  const testing::AllocationCounter allocations;
  for (int frame = 0; frame < 100; ++frame) {
    X_VS.p.x() += 0.1 * kFineVoxel;
    four.schedule->Test(X_VS, 0.1 * kFineVoxel);
    four.workers.ReleaseWorkers();
  }
  EXPECT_EQ(allocations.count(), 0);
}

}  // namespace
}  // namespace tandem
