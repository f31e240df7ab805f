#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

#include "app/cli/push_judge.h"
#include "engine/base/result.h"
#include "engine/contact/contact_kind.h"
#include "engine/realtime/frame_stats.h"
#include "engine/world/world.h"

namespace tandem {

/// What `tandem bench fidelity` measures: how near the contact models come to exact surfaces. Pure
/// functions of their arguments, from fixed seeds.
struct Spread {
  double min = 0;
  double mean = 0;
  double max = 0;
};

/// A convex body that comes down on a plane.
enum class Approaching : std::uint8_t { kSphere, kBox, kCylinder };

/// The gap between exact surfaces, in voxels, in which the first force is felt: `approaches` bodies
/// at random attitudes come down on planes of `tilts` random tilts. Default force layer.
Spread MeasureFirstForce(ContactModel contact, Approaching body, int tilts, int approaches);

struct PressedFigures {
  double direction_error_mean = 0;  // degrees, of the summed force from the plane's normal
  double direction_error_max = 0;
  double ripple = 0;      // RMS over mean of the force while sliding 100 voxels at fixed height
  double ripple_max = 0;  // of one slide
};
/// Bodies that rest on planes of random tilts, pressed to half a voxel of mean depth, and slid.
PressedFigures MeasurePressed(ContactModel contact, int tilts);

/// Counts what frames take that run one after the other, whatever the time.
struct TimesOfFrames {
  FrameStats stats;
  std::uint64_t over_1ms = 0;
  std::uint64_t dropped = 0;  // frames that left contacts out for want of room
};
/// The figures of that.
struct FrameLengths {
  double cpu_p50_us = 0;
  double cpu_p99_us = 0;
  double wall_p999_us = 0;
  std::uint64_t frames = 0;
  std::uint64_t over_1ms = 0;
  /// Deadlines that pass within these frames: a loop at 1 kHz leaves out so many.
  std::uint64_t missed = 0;
  std::uint64_t dropped = 0;
};
FrameLengths LengthsOf(const TimesOfFrames& times);

/// A frame, whose times are counted.
struct TimedFrame {
  const StepReport& report;
  std::int64_t cpu_ns = 0;
};
TimedFrame TimedStep(World& world, const StepInputs& inputs, TimesOfFrames& times);

/// How contact stands against judges that share no code with it (CheckedSteps).
struct ContactChecks {
  FalsePushes pushes;
  /// The largest difference of any frame between the contact force that is reported and what the
  /// change of momentum leaves beside hand and gravity, N; but for frames in which the travel limit
  /// held the body back. That takes momentum, too, which `wrench_error_held_back` shows.
  double wrench_error = 0;
  double wrench_error_held_back = 0;
  ContactChecks& operator+=(const ContactChecks& other);
};

struct NutFigures {
  double voxel = 0;           // m
  double turned = 0;          // rad, by the nut, of the full turn
  double helix_error_mm = 0;  // the most that the nut's height is off the helix
  double push_mm = 0;         // how far a push along the axis moved it
  bool axial_blocked = false;
  /// The largest jump of the contact force that is left as steps between the turn's poses are cut
  /// down to nothing, N.
  double largest_force_step = 0;
  ContactChecks checks;
  FrameLengths frames;  // that test and look at all there is: no budget
};
/// An M16 nut on its bolt (models/factory of that folder), turned by a hand and pushed. `contacts`:
/// about how many pushes are judged.
Result<NutFigures> MeasureNut(ContactModel contact, const std::filesystem::path& models,
                              double voxel, std::size_t contacts);

struct TightNutFigures {
  double voxel = 0;           // m
  double turned = 0;          // rad, of the full turn
  double helix_error_mm = 0;  // as the loose nut's
  double crossing_mm = 0;     // the deepest that nut and bolt are in one another, of sampled frames
  FrameLengths frames;        // as the loose nut's
};
/// The tight M16 nut on its bolt, turned by the hand that turns the loose one.
Result<TightNutFigures> MeasureTightNut(ContactModel contact, const std::filesystem::path& models,
                                        double voxel);

struct PegFigures {
  double voxel = 0;  // m
  int trials = 0;
  double inserted_share = 0;
  double buzz = 0;  // the most of a peg: force RMS of 20 to 500 Hz over the mean force
  ContactChecks checks;
  FrameLengths frames;  // as the nut's
};
/// Round and rectangular pegs put into their holes by a hand that aims wrong by half a degree and
/// 0.2 mm and gives way; `seeds` trials in all. `contacts` as for the nut.
Result<PegFigures> MeasurePegs(ContactModel contact, const std::filesystem::path& models,
                               double voxel, int seeds, std::size_t contacts);

struct BallFigures {
  std::size_t points = 0;
  double turn_s = 0;       // simulated: frames, whatever they take
  double turn_1khz_s = 0;  // the same in real time: with the deadlines that pass within frames
  FrameLengths frames;
  double contacts_mean = 0;
};
/// The scene ball_and_socket in that file, a full turn of the ball. `voxel` in metres.
Result<BallFigures> MeasureBall(ContactModel contact, const std::filesystem::path& scene_file,
                                double voxel);

/// Points of the ball at that voxel size.
Result<std::size_t> CountBallPoints(ContactModel contact, const std::filesystem::path& scene_file,
                                    double voxel);

struct HoldFigures {
  int count = 0;
  int moving = 0;  // balls whose surface is faster than 1e-4 voxels a frame after 2 s
  double largest_force_step = 0;  // N: as the nut's, of a ball that is moved in its hollow
  FrameLengths frames;
};
inline constexpr int kMostHolds = 126;
/// Balls that a hand holds still in close hollows: `count` of kMostHolds fits, turns and pulls.
/// Refined contact.
HoldFigures MeasureHolds(int count);

struct SheetFigures {
  int tries = 0;
  int crossings = 0;            // tries in which the body's middle came beyond the sheet
  double nearest_voxels = 1e9;  // of the body's middle over the sheet
};
/// Boxes of three masses whose hand's goal goes at 5 m/s through a closed sheet of 0.3 voxel, or an
/// open one, and waits beyond it, from `tries` attitudes and along as many ways. Refined contact.
SheetFigures MeasureSheets(int tries);

struct ClearanceFigures {
  // of where force begins, within the fine band, beyond it, and everywhere
  double error_voxels_max = 0;
  double outer_error_voxels_max = 0;
  double late_voxels_max = 0;
  double force_step = 0;  // N, the largest between two frames while the clearance changes
};
/// Bodies over `tilts` tilted planes, and a hand that presses a box onto a plate, with the
/// displacement swept through its range in a scene that has one of 6 voxels. Refined contact.
ClearanceFigures MeasureClearance(int tilts);

/// A number of [low, high), the same with every standard library.
inline double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

}  // namespace tandem
