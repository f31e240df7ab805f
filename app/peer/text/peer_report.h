#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/judgement/judged_frames.h"
#include "collab/dds/transport/packet_filter.h"
#include "collab/peer/peer.h"
#include "collab/receive/delivery_count.h"
#include "collab/receive/sent_states.h"
#include "collab/session/drop_counts.h"
#include "engine/base/result.h"
#include "engine/haptics/device_memory.h"
#include "engine/realtime/frame_stats.h"

namespace tandem {

/// A peer's report on itself at the end of a run.
struct PeerReport {
  std::string name;
  int pid = 0;
  std::string scheduler;
  std::size_t points = 0;   // points that contact tests: TestedPoints()
  std::size_t voxels = 0;   // voxels that contact reads: FixtureVoxels() or ReadVoxels()
  double capacity = 0;      // point tests that fit into a frame
  double query_price = 0;   // price of an exact query, in point tests
  double mean_delay_s = 0;  // half the loop age
  HandFigures hand;
  std::size_t traced_frames = 0;  // number of the hand's first frames that are in the trace
  std::string device;             // device as the options name it
  std::optional<DeviceTimes> device_times;       // times of a device process
  std::string device_scheduler;                  // scheduler of the device's loop
  std::optional<PassivityAccount> passivity;     // account of the device's port
  SafetyState safety_state = SafetyState::kOff;  // state at the end
  SafetyCounts safety;                           // counts of all guards before the hand
  double guarded_share = 0;          // share of frames in which the guard changed what the hand got
  RenderedForces felt;               // largest force, moment and step that the hand felt
  std::uint64_t crowded_frames = 0;  // frames with more contacts than there is room for
  VoxelWaits waits;                  // waits for voxels that were not in memory
  std::uint64_t voxel_memory = 0;    // bytes, of the fixed bodies' voxels
  bool voxels_locked = false;
  ResidentCounts paged;
  SentStates own_states;
  DropCounts drops{};  // dropped samples, by reason
  // states of all other peers, and the share that arrived of the peer of whom most is missing
  std::uint64_t states_sent = 0;
  std::uint64_t states_received = 0;
  std::size_t peers_heard = 0;  // peers from whom at least one state came
  double least_delivered = 1;
  nlohmann::ordered_json peers = nlohmann::ordered_json::array();  // AsJson() of the last table
  nlohmann::ordered_json force_terms = nlohmann::ordered_json::array();  // each peer's law, gains …
  nlohmann::ordered_json start_gaps = nlohmann::ordered_json::array();  // AsJson() of the gaps
  nlohmann::ordered_json verdicts = nlohmann::ordered_json::array();
  std::uint64_t socket_dropped = 0;  // packets of any kind, when the receive thread was late
  PacketCounts packets{};            // packets by what became of them before DDS
};

/// Adds what arrived of all other peers' states to the report.
void AddDelivery(const DeliveryCount& delivery, PeerReport& report);

/// Returns one JSON object:
///
/// - name, role, pid, scheduler, device;
/// - of `all` frames: frames, missed, lateness_us {p50, p99, p999, max};
/// - of the frames in `judged`, in which the hand moves: judged_frames, judged_missed,
///   frames_over_1ms, frame_cpu_us, frame_wall_us. Frames of waiting and of the last second have
///   less to do;
/// - of the hand: contact_points {mean, max}, contact_share, peak_force_N (of its spring),
///   device_force {peak_N, peak_Nm, peak_step_N}, traced_frames;
/// - safety {state, clamped, slewed, zeroed, expired, stops, passivity {control, balance_J,
///   least_J, damped_ticks}}, device_times of a device process, guarded_share;
/// - crowded_frames, limits {travel_limited_share, over_capacity_share, contacts_full_share,
///   waited_share};
/// - voxel_memory {bytes, locked, stalls, stall_s, longest_stall_ms, pages_read, pages_given_up} of
///   the fixed bodies' voxels;
/// - points, capacity, query_price, voxels, delay_ms;
/// - sent_states {sent, wanted}, received_states {sent, received, peers, least_delivered,
///   socket_dropped};
/// - drops by reason, packets_refused by reason, peers, force_terms, start_gaps, verdicts;
/// - earlier names of four of them: felt, look_price, said, heard.
nlohmann::ordered_json AsJson(const PeerReport& report, const FrameStats& all,
                              const JudgedFrames& judged);

}  // namespace tandem
