#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

#include "app/bench/fidelity/push_judge.h"
#include "engine/base/result.h"
#include "engine/contact/pair/contact_kind.h"
#include "engine/realtime/frame_stats.h"
#include "engine/world/world.h"

namespace tandem {

/// `tandem bench fidelity` measures how close the contact models come to exact surfaces. Random
/// numbers come from fixed seeds. So all figures but times repeat, except those of MeasureBall(),
/// where the capacity follows the machine.
struct Spread {
  double min = 0;
  double mean = 0;
  double max = 0;
};

/// A convex body that comes down on a plane.
enum class Approaching : std::uint8_t { kSphere, kBox, kCylinder };

/// Returns the gap between exact surfaces at which the first force is felt, voxels. `approaches`
/// bodies at random attitudes come down on planes of `tilts` random tilts. The force layer is the
/// default one.
Spread MeasureFirstForce(ContactModel contact, Approaching body, int tilts, int approaches);

struct PressedFigures {
  double direction_error_mean = 0;  // degrees, between the summed force and the plane's normal
  double direction_error_max = 0;
  /// RMS variation over mean of the force in a slide of 100 voxels at fixed height.
  double ripple = 0;
  double ripple_max = 0;  // largest ripple of a slide
};
/// Measures bodies that rest on planes of random tilts. Each is pressed to half a voxel of mean
/// depth, and slid.
PressedFigures MeasurePressed(ContactModel contact, int tilts);

/// Counts the times of frames that run back to back, at no fixed rate.
struct TimesOfFrames {
  FrameStats stats;
  std::uint64_t over_1ms = 0;
  std::uint64_t dropped = 0;  // frames that left contacts out for want of room
};
/// Summarizes TimesOfFrames.
struct FrameLengths {
  double cpu_p50_us = 0;
  double cpu_p99_us = 0;
  double wall_p999_us = 0;
  std::uint64_t frames = 0;
  std::uint64_t over_1ms = 0;
  /// Deadlines that pass within these frames; a loop at 1 kHz leaves out that many.
  std::uint64_t missed = 0;
  std::uint64_t dropped = 0;
};
FrameLengths LengthsOf(const TimesOfFrames& times);

/// The report of a frame, and the processor time that was counted for it.
struct TimedFrame {
  const StepReport& report;
  std::int64_t cpu_ns = 0;
};
TimedFrame TimedStep(World& world, const StepInputs& inputs, TimesOfFrames& times);

/// The errors of contact as found by judges that share no code with it (CheckedSteps).
struct ContactChecks {
  FalsePushes pushes;
  /// N; largest difference in a frame between the reported contact force and the one that the
  /// momentum shows: its change less hand and gravity. Frames in which the travel limit holds the
  /// body back count in `wrench_error_held_back` instead, because that limit takes momentum too.
  double wrench_error = 0;
  double wrench_error_held_back = 0;
  ContactChecks& operator+=(const ContactChecks& other);
};

struct NutFigures {
  double voxel = 0;           // m
  double turned = 0;          // rad; turn of the nut, of the full turn that the hand makes
  double helix_error_mm = 0;  // largest distance of the nut's height from the helix
  double push_mm = 0;         // largest displacement by a push along the axis
  bool axial_blocked = false;
  /// N; largest jump of the contact force that remains when the steps between the turn's poses
  /// shrink to nothing
  double largest_force_step = 0;
  ContactChecks checks;
  FrameLengths frames;  // frames without a budget: they test and look at everything
};
/// Measures an M16 nut on its bolt, turned by a hand and pushed. `models`: folder that has
/// `factory`. `contacts`: number of pushes that are judged, about.
Result<NutFigures> MeasureNut(ContactModel contact, const std::filesystem::path& models,
                              double voxel, std::size_t contacts);

struct TightNutFigures {
  double voxel = 0;           // m
  double turned = 0;          // rad; as the loose nut's
  double helix_error_mm = 0;  // as the loose nut's
  double crossing_mm = 0;     // largest depth of nut and bolt in one another, over sampled frames
  FrameLengths frames;        // as the loose nut's
};
/// Measures the tight M16 nut on its bolt, turned by the hand that turns the loose one.
Result<TightNutFigures> MeasureTightNut(ContactModel contact, const std::filesystem::path& models,
                                        double voxel);

struct PegFigures {
  double voxel = 0;  // m
  int trials = 0;
  double inserted_share = 0;
  double buzz = 0;  // largest of all trials: force RMS from 20 to 500 Hz over the mean force
  ContactChecks checks;
  FrameLengths frames;  // as the nut's
};
/// Measures round and rectangular pegs that a hand puts into their holes. The hand aims wrong by
/// half a degree and 0.2 mm and gives way. `seeds`: number of all trials. `contacts`: as for the
/// nut.
Result<PegFigures> MeasurePegs(ContactModel contact, const std::filesystem::path& models,
                               double voxel, int seeds, std::size_t contacts);

struct BallFigures {
  std::size_t points = 0;
  double turn_s = 0;       // simulated time, whatever the frames take
  double turn_1khz_s = 0;  // time at 1 kHz: with the deadlines that pass within frames
  FrameLengths frames;
  double contacts_mean = 0;
};
/// Measures a full turn of the ball. `scene_file`: the scene ball_and_socket. `voxel` in metres.
Result<BallFigures> MeasureBall(ContactModel contact, const std::filesystem::path& scene_file,
                                double voxel);

/// Returns the number of the ball's points at that voxel size.
Result<std::size_t> CountBallPoints(ContactModel contact, const std::filesystem::path& scene_file,
                                    double voxel);

struct HoldFigures {
  int count = 0;
  int moving = 0;  // balls whose surface is faster than 1e-4 voxels a frame after 2 s
  double largest_force_step = 0;  // N; as the nut's, for a ball that is moved in its hollow
  FrameLengths frames;
};
inline constexpr int kMostHolds = 126;
/// Measures balls that a hand holds still in close hollows, for `count` of kMostHolds combinations
/// of fit, turn and pull. Contact is refined.
HoldFigures MeasureHolds(int count);

struct SheetFigures {
  int tries = 0;
  int crossings = 0;            // tries in which the body's centre came beyond the sheet
  double nearest_voxels = 1e9;  // least height of the body's centre over the sheet
};
/// Measures boxes of three masses whose hand pulls them at a sheet, from `tries` attitudes and in
/// as many directions. The sheet is closed and 0.3 voxel thick, or open. The hand's goal goes
/// through it at 5 m/s and waits beyond it. Contact is refined.
SheetFigures MeasureSheets(int tries);

struct ClearanceFigures {
  // errors of the gap at which force begins: within the fine band, beyond it, and too small
  // anywhere
  double error_voxels_max = 0;
  double outer_error_voxels_max = 0;
  double late_voxels_max = 0;
  double force_step = 0;  // N; largest step between two frames while the clearance changes
};
/// Measures bodies over `tilts` tilted planes, and a hand that presses a box onto a plate. The
/// displacement sweeps through its range, in a scene with a clearance range of 6 voxels. Contact is
/// refined.
ClearanceFigures MeasureClearance(int tilts);

/// Returns a number in [low, high), the same with every standard library.
inline double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

}  // namespace tandem
