#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <random>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/bench_scene.h"
#include "app/bench/measure/field_bench.h"
#include "app/bench/measure/memory_limit.h"
#include "app/bench/reference/gathered_lookup.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "engine/base/text/json_text.h"
#include "engine/contact/schedule/voxmap_lookup.h"

namespace tandem {

namespace {

constexpr int kThreads = 4;
constexpr double kRoundNs = 2e8;          // ns, least work for a figure and round
constexpr std::size_t kRandom = 1 << 22;  // points, and lines

struct PointsArguments {
  BenchScene scene{.scene = "clutter"};
  int rounds = 7;  // rounds whose medians count
  bool json = false;
};

struct PointsFigures {
  double transform_ns = 0;
  double coherent_ns = 0;
  double random_ns = 0;
  double limit_ns = 0;
  double random_4t_ns = 0;
  double limit_4t_ns = 0;
  std::size_t points = 0;
  std::size_t map_bytes = 0;
  std::uint64_t sum = 0;  // sum over the lines that are read
};

/// Makes poses as a hand does: each is 0.05 to 0.5 voxels from the previous one, about the first.
std::vector<Pose> Wander(const Pose& X_VS, double voxel, double radius, std::size_t count) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> step(0.05, 0.5);
  std::vector<Pose> poses;
  Pose pose = X_VS;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 way(normal(random), normal(random), normal(random));
    const Vec3 turn(normal(random), normal(random), normal(random));
    const double travel = step(random) * voxel;
    const Vec3 home = 0.05 * (X_VS.p - pose.p);
    pose.p += home + 0.7 * travel * way.normalized();
    pose.q = (RotationBy(0.3 * travel / radius * turn.normalized()) * pose.q).normalized();
    poses.push_back(pose);
  }
  return poses;
}

/// Random places in chunks that store a plane, a third of them in each field.
struct RandomPlaces {
  std::array<std::vector<float>, 3> axes;
  std::array<std::size_t, kFields + 1> first{};  // first place of each field

  RandomPlaces(const Voxmap& voxmap, std::size_t count) {
    const auto& size = voxmap.header().size;
    std::mt19937_64 random(2);
    for (const Field field : kAllFields) {
      std::vector<GridIndex> chunks;
      for (std::uint32_t z = 0; z < 8 * size[2]; ++z) {
        for (std::uint32_t y = 0; y < 8 * size[1]; ++y) {
          for (std::uint32_t x = 0; x < 8 * size[0]; ++x) {
            const GridIndex chunk{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                                  static_cast<std::int32_t>(z)};
            if (voxmap.PlaneOf(field, chunk) > kPlaneInterior) chunks.push_back(chunk);
          }
        }
      }
      const std::size_t f = static_cast<std::size_t>(field);
      first[f] = axes[0].size();
      if (chunks.empty()) continue;
      for (std::size_t i = 0; i < count / kFields; ++i) {
        const GridIndex chunk = chunks[random() % chunks.size()];
        const std::uint64_t cell = random();
        axes[0].push_back(static_cast<float>(8 * chunk.x + static_cast<int>(cell & 7)) + 0.5F);
        axes[1].push_back(static_cast<float>(8 * chunk.y + static_cast<int>(cell >> 3 & 7)) + 0.5F);
        axes[2].push_back(static_cast<float>(8 * chunk.z + static_cast<int>(cell >> 6 & 7)) + 0.5F);
      }
    }
    first[kFields] = axes[0].size();
  }
  std::size_t size() const { return axes[0].size(); }
  /// Reads the `part`-th of `parts` of every field.
  void Read(const Voxmap& voxmap, std::size_t part, std::size_t parts, std::uint8_t* marks) const {
    for (const Field field : kAllFields) {
      const std::size_t f = static_cast<std::size_t>(field);
      const std::size_t count = first[f + 1] - first[f];
      const std::size_t begin = first[f] + count * part / parts;
      const std::size_t length = first[f] + count * (part + 1) / parts - begin;
      const auto of = [&](std::size_t axis) {
        return std::span<const float>(axes[axis]).subspan(begin, length);
      };
      TestScattered({of(0), of(1), of(2)}, voxmap, field, marks + begin);
    }
  }
};

/// Returns the wall time of `work(part)` on kThreads threads that begin together, ns.
template <class Work>
double OnThreads(const Work& work) {
  return WallNs([&] {
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < kThreads; ++t) threads.emplace_back(work, t);
    for (std::thread& thread : threads) thread.join();
  });
}

PointsFigures Measure(const WorldModel& world, int rounds_asked) {
  const Voxmap& voxmap = world.fixture;
  const BodyModel& body = world.bodies[0];
  const PointBlocks blocks(body.points);
  const Pose X_VS = Pose{Quat::Identity(), voxmap.p_WVo()}.Inverse() * body.X_WB0;
  const std::vector<Pose> poses = Wander(X_VS, voxmap.voxel_size(), body.points.radius, 64);
  std::vector<std::uint32_t> all(blocks.size());
  std::iota(all.begin(), all.end(), 0U);
  std::vector<BlockReading> readings(blocks.size());
  const auto points = static_cast<double>(body.points.size());
  const int passes = static_cast<int>(std::max(3.0, kRoundNs / points));

  const RandomPlaces places(voxmap, kRandom);
  std::vector<std::uint8_t> marks(places.size());
  const std::span<const std::byte> image(reinterpret_cast<const std::byte*>(&voxmap.header()),
                                         voxmap.header().bytes);
  const RandomLines lines(image, kRandom, 3);
  std::array<std::uint64_t, kThreads> sums{};  // keep the compiler from leaving reads out

  std::size_t at = 0;
  const auto pass = [&](const auto& test) {
    return CpuNs([&] {
             for (int i = 0; i < passes; ++i) {
               const Pose& pose = poses[at++ % poses.size()];
               test(VoxelTransform(pose, voxmap.voxel_size(), 0));
             }
           }) /
           points / passes;
  };
  std::array<std::vector<double>, 6> rounds;
  for (int round = 0; round < rounds_asked; ++round) {
    rounds[0].push_back(pass([&](const VoxelTransform& transform) {
      TransformBlocks(blocks, transform, 3, all, readings.data());
    }));
    rounds[1].push_back(pass([&](const VoxelTransform& transform) {
      TestBlocks(blocks, transform, voxmap, 3, all, readings.data());
    }));
    rounds[2].push_back(CpuNs([&] {
                          places.Read(voxmap, 0, 1, marks.data());
                        }) /
                        static_cast<double>(places.size()));
    rounds[3].push_back(CpuNs([&] {
                          sums[0] += lines.Read(0, lines.count());
                        }) /
                        static_cast<double>(lines.count()));
    rounds[4].push_back(OnThreads([&](std::size_t t) {
                          places.Read(voxmap, t, kThreads, marks.data());
                        }) /
                        static_cast<double>(places.size()));
    rounds[5].push_back(OnThreads([&](std::size_t t) {
                          sums[t] += lines.Read(lines.count() * t / kThreads,
                                                lines.count() * (t + 1) / kThreads);
                        }) /
                        static_cast<double>(lines.count()));
  }
  return {Median(rounds[0]),  Median(rounds[1]), Median(rounds[2]),
          Median(rounds[3]),  Median(rounds[4]), Median(rounds[5]),
          body.points.size(), image.size(),      std::reduce(sums.begin(), sums.end())};
}

int RunPoints(const PointsArguments& arguments) {
  BenchScene requested = arguments.scene;
  requested.needs_fixture = true;
  requested.needs_plain_parts = true;
  const auto world = LoadBenchScene(requested);
  if (!world) return Fail(kExitFile, world.error().what);
  if (!(*world)->has_fixture)
    return Fail(kExitFile, arguments.scene.scene + ": the scene has no fixed body");
  const PointsFigures f = Measure(**world, arguments.rounds);
  const Result<FieldFigures> field = MeasureField(**world, 0, arguments.rounds);
  if (!field) return Fail(kExitFile, field.error().what);
  if (arguments.json) {
    const nlohmann::ordered_json out{{"scene", arguments.scene.scene},
                                     {"voxel_m", (*world)->scene.voxel_size},
                                     {"points", f.points},
                                     {"map_bytes", f.map_bytes},
                                     {"isa", KernelIsa()},
                                     {"transform_ns", f.transform_ns},
                                     {"coherent_ns", f.coherent_ns},
                                     {"random_ns", f.random_ns},
                                     {"limit_ns", f.limit_ns},
                                     {"random_4t_ns", f.random_4t_ns},
                                     {"limit_4t_ns", f.limit_4t_ns},
                                     {"field_ns", field->field_ns},
                                     {"field_with_gradient_ns", field->field_with_gradient_ns},
                                     {"error_voxels",
                                      {{"p50", field->error_voxels.p50},
                                       {"p99", field->error_voxels.p99},
                                       {"max", field->error_voxels.max}}},
                                     {"field_bytes_per_band_voxel", field->bytes_per_band_voxel},
                                     {"field_build_cpu_s", field->build_cpu_s},
                                     {"field_voxelize_cpu_s", field->voxelize_cpu_s}};
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf("%zu points against %.2f GB of voxels, %s\n", f.points,
              1e-9 * static_cast<double>(f.map_bytes), KernelIsa());
  std::printf("  pointshell   %6.2f ns a point, %.2f times its transform alone (%.2f ns)\n",
              f.coherent_ns, f.coherent_ns / f.transform_ns, f.transform_ns);
  std::printf("  random       %6.2f ns a point, %.0f %% of the speed of random lines (%.2f ns)\n",
              f.random_ns, 100 * f.limit_ns / f.random_ns, f.limit_ns);
  std::printf("  on %d threads %6.2f ns a point, %.0f %% of the speed of random lines (%.2f ns)\n",
              kThreads, f.random_4t_ns, 100 * f.limit_4t_ns / f.random_4t_ns, f.limit_4t_ns);
  std::printf("  distance     %6.2f ns a value, %.1f times the transform; with gradient %.2f ns\n",
              field->field_ns, field->field_ns / f.transform_ns, field->field_with_gradient_ns);
  std::printf("  its error    %.4f, %.4f, %.4f voxels (p50, p99, most)\n", field->error_voxels.p50,
              field->error_voxels.p99, field->error_voxels.max);
  std::printf("  its field    %.3f bytes a band voxel; %.3f s to build, marks %.3f s\n",
              field->bytes_per_band_voxel, field->build_cpu_s, field->voxelize_cpu_s);
  return kExitOk;
}

}  // namespace

void AddBenchPoints(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<PointsArguments>();
  CLI::App* command = bench.add_subcommand("points",
                                           "Measure the time of a point's test: of a pointshell, "
                                           "and of random points beside random memory access");
  AddBenchScene(*command, arguments->scene);
  command
      ->add_option("--rounds", arguments->rounds, "duration of the measurement, s; medians count")
      ->check(WholeNumberFrom(1, 99))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunPoints(*arguments);
  });
}

}  // namespace tandem
