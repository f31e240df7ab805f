#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "app/capacity/capacity.h"
#include "engine/haptics/device.h"
#include "engine/realtime/histogram.h"
#include "engine/realtime/worker_pool.h"
#include "engine/world/world.h"

namespace tandem {

inline constexpr int kFramePriority = 30;  // priority of the thread that runs frames
inline constexpr int kWarmUp = 500;        // frames before anything counts

/// The times of frames, and the work done in them.
struct FrameFigures {
  Histogram cpu, wall, noise;
  Histogram workers_cpu;  // processor time of all workers together
  Histogram owed;         // point tests that a frame leaves to the next one
  double contacts = 0, exact_queries = 0, pushing_points = 0;  // sums over frames
  double tests = 0, drifted = 0, chunks = 0;
  std::int64_t frames = 0;
  std::int64_t at_bound = 0;
  std::int64_t held_back = 0;  // frames in which the hand felt MaxTravel
  std::int64_t over_1ms = 0;   // frames of more than a millisecond by the wall's clock
  std::int64_t missed = 0;     // deadlines that passed from a frame's own to its end
  std::size_t violations = 0;
  double point_frames = 0;  // points looked at for violations, summed over frames
  long page_faults = 0;
  VoxelWaits waits;
  double capacity = 0;  // sum over frames
  std::int64_t worst_ns = 0;
  StepReport worst;  // report of the frame that took longest
};

/// A function that gives the goal of the hand that holds the body, frame by frame.
using FrameHand = std::function<Anchor(std::int64_t frame, const StepReport& report)>;

/// Runs frames back to back, at no fixed rate and with one capacity. Keeps the least processor time
/// of each frame on this thread, ns. Over several runs these are times with warm caches and without
/// interruption. It waits for voxels that are not in memory. It calls `after`, if any, after each
/// frame.
void RunBackToBack(World& world, const FrameHand& hand, const Pose& X_BD,
                   const FrameCapacity& capacity, std::vector<std::int64_t>& least_ns,
                   const std::function<void()>& after = {});

/// Runs frames at 1 kHz on a real-time thread until `frames` are counted, each with empty work of
/// its length beside it. `budget_s`: time that a frame's tests may take, which capacity then
/// follows; 0: capacity stays as given. Every `check_every` frames all points are looked at. In
/// frames that wait for voxels the hand stands still, and they count as waits alone. After
/// kLongestVoxelWait such frames in a row the run ends.
void RunFrames(World& world, const FrameHand& hand, const Pose& X_BD, const FrameCapacity& capacity,
               double budget_s, int frames, int check_every, const WorkerPool& workers,
               FrameFigures& figures);

}  // namespace tandem
