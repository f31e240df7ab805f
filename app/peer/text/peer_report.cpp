#include "app/peer/text/peer_report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <utility>

#include "app/peer/text/peer_table_text.h"

namespace tandem {

namespace {

nlohmann::ordered_json Microseconds(const Histogram& ns) {
  const auto us = [&](double q) {
    return 1e-3 * static_cast<double>(ns.Quantile(q));
  };
  return {{"p50", us(0.5)},
          {"p99", us(0.99)},
          {"p999", us(0.999)},
          {"max", 1e-3 * static_cast<double>(ns.max())}};
}

nlohmann::ordered_json AsJson(const DropCounts& drops) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < drops.size(); ++i) json[NameOf(static_cast<Drop>(i))] = drops[i];
  return json;
}

/// Returns the counts of packets that were refused before DDS.
nlohmann::ordered_json AsJson(const PacketCounts& packets) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 1; i < packets.size(); ++i) {
    json[NameOf(static_cast<PacketDrop>(i))] = packets[i];
  }
  return json;
}

nlohmann::ordered_json AsJson(const std::optional<PassivityAccount>& port) {
  if (!port) return nullptr;
  return {{"control", port->control},
          {"balance_J", port->balance_J},
          {"least_J", port->least_J},
          {"damped_ticks", port->damped}};
}

nlohmann::ordered_json SafetyAsJson(const PeerReport& report) {
  const SafetyCounts& counts = report.safety;
  return {{"state", NameOf(report.safety_state)},
          {"clamped", counts.clamped},
          {"slewed", counts.slewed},
          {"zeroed", counts.zeroed},
          {"expired", counts.expired},
          {"stops", counts.stops},
          {"passivity", AsJson(report.passivity)}};
}

nlohmann::ordered_json TimesAsJson(const PeerReport& report) {
  const std::optional<DeviceTimes>& times = report.device_times;
  if (!times) return nullptr;
  const auto us = [](std::int64_t ns) {
    return 1e-3 * static_cast<double>(ns);
  };
  nlohmann::ordered_json json{{"scheduler", report.device_scheduler},
                              {"ticks", times->ticks},
                              {"answered", times->answered},
                              {"unanswered", times->unanswered},
                              {"unanswered_share", times->unanswered_share()},
                              {"late", times->late},
                              {"missed", times->missed},
                              {"read_to_write_us",
                               {{"p50", us(times->read_to_write_p50_ns)},
                                {"p99", us(times->read_to_write_p99_ns)},
                                {"max", us(times->read_to_write_max_ns)}}}};
  if (times->requested > 0) {
    json["asked_age_us"] = {{"mean", us(times->asked_mean_ns)}, {"max", us(times->asked_max_ns)}};
  }
  return json;
}

nlohmann::ordered_json VoxelMemoryAsJson(const PeerReport& report) {
  return {{"bytes", report.voxel_memory},
          {"locked", report.voxels_locked},
          {"stalls", report.waits.count},
          {"stall_s", 1e-3 * static_cast<double>(report.waits.frames)},
          {"longest_stall_ms", report.waits.longest},
          {"pages_read", report.paged.pages_read},
          {"pages_given_up", report.paged.pages_given_up}};
}

/// Keys that earlier versions wrote, which scripts may read, and the keys that they stand for.
constexpr std::array<std::pair<const char*, const char*>, 4> kEarlierKeys{
    {{"felt", "device_force"},
     {"look_price", "query_price"},
     {"said", "sent_states"},
     {"heard", "received_states"}}};

}  // namespace

void AddDelivery(const DeliveryCount& delivery, PeerReport& report) {
  for (const DeliveryCount::Row& row : delivery.rows()) {
    ++report.peers_heard;
    report.states_sent += row.sent;
    report.states_received += row.received;
    report.least_delivered = std::min(
        report.least_delivered, static_cast<double>(row.received) / static_cast<double>(row.sent));
  }
}

nlohmann::ordered_json AsJson(const PeerReport& report, const FrameStats& all,
                              const JudgedFrames& judged) {
  const HandFigures& hand = report.hand;
  const auto frames = static_cast<double>(std::max<std::int64_t>(1, hand.frames));
  nlohmann::ordered_json json{
      {"name", report.name},
      {"role", "active"},
      {"pid", report.pid},
      {"frames", all.frames()},
      {"missed", all.missed()},
      {"scheduler", report.scheduler},
      {"judged_frames", judged.stats().frames()},
      {"judged_missed", judged.stats().missed()},
      {"frames_over_1ms", judged.over_period()},
      {"frame_cpu_us", Microseconds(judged.stats().cpu())},
      {"frame_wall_us", Microseconds(judged.stats().wall())},
      {"lateness_us", Microseconds(all.lateness())},
      {"contact_points",
       {{"mean", static_cast<double>(hand.contact_points) / frames},
        {"max", hand.most_contact_points}}},
      {"contact_share", static_cast<double>(hand.frames_in_contact) / frames},
      {"peak_force_N", hand.peak_force},
      {"device_force",
       {{"peak_N", report.felt.peak_force},
        {"peak_Nm", report.felt.peak_moment},
        {"peak_step_N", report.felt.peak_step}}},
      {"traced_frames", report.traced_frames},
      {"device", report.device},
      {"safety", SafetyAsJson(report)},
      {"device_times", TimesAsJson(report)},
      {"guarded_share", report.guarded_share},
      {"crowded_frames", report.crowded_frames},
      {"limits", AsJson(hand.limits)},
      {"voxel_memory", VoxelMemoryAsJson(report)},
      {"points", report.points},
      {"capacity", report.capacity},
      {"query_price", report.query_price},
      {"voxels", report.voxels},
      {"delay_ms", 1e3 * report.mean_delay_s},
      {"sent_states", {{"sent", report.own_states.sent()}, {"wanted", report.own_states.wanted()}}},
      {"received_states",
       {{"sent", report.states_sent},
        {"received", report.states_received},
        {"peers", report.peers_heard},
        {"least_delivered", report.least_delivered},
        {"socket_dropped", report.socket_dropped}}},
      {"drops", AsJson(report.drops)},
      {"packets_refused", AsJson(report.packets)},
      {"peers", report.peers},
      {"force_terms", report.force_terms},
      {"start_gaps", report.start_gaps},
      {"verdicts", report.verdicts}};
  for (const auto& [earlier, name] : kEarlierKeys) {
    nlohmann::ordered_json copy = json[name];  // a new key moves the values
    json[earlier] = std::move(copy);
  }
  return json;
}

}  // namespace tandem
