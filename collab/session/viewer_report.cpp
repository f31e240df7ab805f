#include "collab/session/viewer_report.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

/// Returns the 99th percentile of the ages, exact to 1/64; nullopt if they cannot be compared.
std::optional<double> P99Ms(const FrameAges& ages) {
  if (ages.others || ages.of_this_machine.count() == 0) return std::nullopt;
  return 1e-6 * static_cast<double>(ages.of_this_machine.Quantile(0.99));
}

}  // namespace

ViewerReport ReportOf(const Viewer* viewer, int pid, double seconds) {
  ViewerReport report;
  report.pid = pid;
  report.seconds = seconds;
  if (viewer == nullptr) return report;
  const ViewerPicture picture = viewer->Picture();
  report.samples = picture.samples;
  const double span_s =
      static_cast<double>(picture.newest_sample_ns - picture.first_sample_ns) * 1e-9;
  if (span_s > 0) report.samples_per_s = static_cast<double>(picture.samples - 1) / span_s;
  report.age_ms_p99 = P99Ms(viewer->Ages());
  report.peers_seen = static_cast<std::size_t>(
      std::count_if(picture.peers.begin(), picture.peers.end(), [](const ViewedPeer& peer) {
        return peer.info.role == Role::kActive;
      }));
  return report;
}

std::string AsJson(const ViewerReport& report) {
  nlohmann::ordered_json json;
  json["pid"] = report.pid;
  json["seconds"] = report.seconds;
  json["samples"] = report.samples;
  json["samples_per_s"] = report.samples_per_s;
  json["age_ms_p99"] = nullptr;
  if (report.age_ms_p99) json["age_ms_p99"] = *report.age_ms_p99;
  json["peers_seen"] = report.peers_seen;
  return JsonText(json, 2);
}

Result<bool> WriteReport(const ViewerReport& report, const std::filesystem::path& file) {
  if (const auto fault = WriteWholeFile(file, AsJson(report) + "\n")) return *fault;
  return true;
}

}  // namespace tandem
