#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

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
Spread MeasureFirstForce(ContactModel contact, Approaching body, int tilts,
                         int approaches);

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
};
FrameLengths LengthsOf(const TimesOfFrames& times);

/// A frame, whose times are counted.
struct TimedFrame {
  const StepReport& report;
  std::int64_t cpu_ns = 0;
};
TimedFrame TimedStep(World& world, const StepInputs& inputs, TimesOfFrames& times);

struct NutFigures {
  double voxel = 0;           // m
  double turned = 0;          // rad, by the nut, of the full turn
  double helix_error_mm = 0;  // the most that the nut's height is off the helix
  double push_mm = 0;         // how far a push along the axis moved it
  bool axial_blocked = false;
  FrameLengths frames;  // that test and look at all there is: no budget
};
/// An M16 nut on its bolt (models/factory of that folder), turned by a hand and pushed.
Result<NutFigures> MeasureNut(ContactModel contact, const std::filesystem::path& models,
                              double voxel);

struct PegFigures {
  double voxel = 0;  // m
  int trials = 0;
  double inserted_share = 0;
  double buzz = 0;      // the most of a peg: force RMS of 20 to 500 Hz over the mean force
  FrameLengths frames;  // as the nut's
};
/// Round and rectangular pegs put into their holes by a hand that aims wrong by half a degree and
/// 0.2 mm and gives way; `seeds` trials in all.
Result<PegFigures> MeasurePegs(ContactModel contact, const std::filesystem::path& models,
                               double voxel, int seeds);

struct BallFigures {
  std::size_t points_035 = 0;
  std::size_t points_015 = 0;
  double turn_s = 0;       // simulated: frames, whatever they take
  double turn_1khz_s = 0;  // the same in real time: with the deadlines that pass within frames
  FrameLengths frames;
  double contacts_mean = 0;
  double depth_max_voxels = 0;  // of the ball's centre off the socket's, beyond the free play
};
/// The scene ball_and_socket in that file.
Result<BallFigures> MeasureBall(ContactModel contact,
                                const std::filesystem::path& scene_file);

/// A number of [low, high), the same with every standard library.
inline double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

}  // namespace tandem
