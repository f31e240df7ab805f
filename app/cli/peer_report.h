#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/cli/judged_frames.h"
#include "collab/dds/packet_filter.h"
#include "collab/delivery_count.h"
#include "collab/drop_counts.h"
#include "collab/peer.h"
#include "collab/sent_states.h"
#include "engine/base/result.h"
#include "engine/haptics/device_memory.h"
#include "engine/realtime/frame_stats.h"

namespace tandem {

/// What a peer says of itself at the end of a run.
struct PeerReport {
  std::string name;
  int pid = 0;
  std::string scheduler;
  std::size_t points = 0;   // that contact tests: TestedPoints()
  std::size_t voxels = 0;   // that contact reads: ReadVoxels()
  double capacity = 0;      // point tests that fit into a frame
  double look_price = 0;    // of an exact look, in point tests
  double mean_delay_s = 0;  // half the loop age
  HandFigures hand;
  std::size_t traced_frames = 0;                 // of the hand's, the first ones
  std::string device;                            // as it was asked for
  std::optional<DeviceTimes> device_times;       // of a device process
  std::string device_scheduler;                  // of its loop
  std::optional<PassivityAccount> passivity;     // of its port
  SafetyState safety_state = SafetyState::kOff;  // at the end
  SafetyCounts safety;                           // of all guards before the hand
  double guarded_share = 0;  // of frames, in which the hand got something else than was wanted
  Felt felt;                 // by the hand, at the most
  std::uint64_t crowded_frames = 0;  // with more contacts than there is room for
  VoxelWaits waits;                  // for voxels that were not in memory
  std::uint64_t voxel_memory = 0;    // bytes, of the fixed bodies' voxels
  bool voxels_locked = false;
  ResidentCounts paged;
  SentStates own_states;
  DropCounts drops{};  // of samples heard, by reason
  // states heard of all others, and of the one of whom the largest share is missing
  std::uint64_t states_sent = 0;
  std::uint64_t states_received = 0;
  std::size_t peers_heard = 0;  // of whom at least one state came
  double least_delivered = 1;
  nlohmann::ordered_json peers = nlohmann::ordered_json::array();  // AsJson() of the last table
  nlohmann::ordered_json force_terms = nlohmann::ordered_json::array();  // of each: law, gains …
  nlohmann::ordered_json start_gaps = nlohmann::ordered_json::array();   // AsJson() of them
  nlohmann::ordered_json verdicts = nlohmann::ordered_json::array();
  std::uint64_t socket_dropped = 0;  // packets of any kind, since the receive thread was late
  PacketCounts packets{};            // by what became of them before DDS
};

/// Of what came from all others.
void AddDelivery(const DeliveryCount& delivery, PeerReport& report);

/// One JSON object: frames, missed and lateness_us {p50, p99, p999, max} of `all` frames;
/// judged_frames, judged_missed, frames_over_1ms, frame_cpu_us and frame_wall_us of those in
/// `judged`, in which the hand moves: frames of waiting and of the last second have less to do; of
/// the hand contact_points {mean, max}, contact_share, peak_force_N (of its spring), traced_frames;
/// felt {peak_N, peak_Nm, peak_step_N} by the hand, device, safety {state, clamped, slewed,
/// zeroed, expired, stops, passivity {control, balance_J, least_J, damped_ticks}}, of a device
/// process device_times, guarded_share, crowded_frames, limits
/// {travel_limited_share, over_capacity_share, contacts_full_share, waited_share},
/// voxel_memory {bytes, locked, stalls, stall_s, longest_stall_ms, pages_read, pages_given_up},
/// of the fixed bodies' voxels; said {sent, wanted}; heard {sent, received,
/// peers, least_delivered, socket_dropped}, drops by reason, packets_refused by reason, peers,
/// start_gaps, verdicts.
nlohmann::ordered_json AsJson(const PeerReport& report, const FrameStats& all,
                              const JudgedFrames& judged);

}  // namespace tandem
