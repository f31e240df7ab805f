#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <vector>

#include "engine/base/result.h"
#include "engine/contact/contact_kind.h"

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
Spread MeasureFirstForce(ContactModel model, Approaching body, int tilts, int approaches);

struct PressedFigures {
  double direction_error_mean = 0;  // degrees, of the summed force from the plane's normal
  double direction_error_max = 0;
  double ripple = 0;      // RMS over mean of the force while sliding 100 voxels at fixed height
  double ripple_max = 0;  // of one slide
};
/// Bodies that rest on planes of random tilts, pressed to half a voxel of mean depth, and slid.
PressedFigures MeasurePressed(ContactModel model, int tilts);

struct NutFigures {
  double voxel = 0;           // m
  double turned = 0;          // rad, by the nut, of the full turn
  double helix_error_mm = 0;  // the most that the nut's height is off the helix
  double push_mm = 0;         // how far a push along the axis moved it
  bool axial_blocked = false;
  double frame_cpu_p50_us = 0;  // of frames that test and look at all there is: no budget
  double frame_cpu_p99_us = 0;
};
/// An M16 nut on its bolt (models/factory of that folder), turned by a hand and pushed.
Result<NutFigures> MeasureNut(ContactModel model, const std::filesystem::path& models,
                              double voxel);

struct PegFigures {
  double voxel = 0;  // m
  int trials = 0;
  double inserted_share = 0;
  double buzz = 0;              // the most of a peg: force RMS of 20 to 500 Hz over the mean force
  double frame_cpu_p50_us = 0;  // as the nut's
  double frame_cpu_p99_us = 0;
};
/// Round and rectangular pegs put into their holes by a hand that aims wrong by half a degree and
/// 0.2 mm and gives way; `seeds` trials in all.
Result<PegFigures> MeasurePegs(ContactModel model, const std::filesystem::path& models,
                               double voxel, int seeds);

struct BallFigures {
  std::size_t points_035 = 0;
  std::size_t points_015 = 0;
  double turn_s = 0;            // simulated: frames, whatever they take;
  double frame_cpu_p50_us = 0;  // what they take
  double frame_cpu_p99_us = 0;
  double contacts_mean = 0;
  double depth_max_voxels = 0;  // of the ball's centre off the socket's, beyond the free play
};
/// The scene ball_and_socket in that file.
Result<BallFigures> MeasureBall(ContactModel model, const std::filesystem::path& scene_file);

/// A number of [low, high), the same with every standard library.
inline double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

}  // namespace tandem
