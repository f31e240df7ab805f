#include "tests/soak/soak_judgement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <span>

#include "app/common/exit_codes.h"
#include "app/recording/trace_file.h"
#include "engine/safety/device_limits.h"

namespace tandem::testing {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr double kRounding = 1.000001;  // factor for the rounding of a limit in a report

json ReportOf(const SoakLife& life) {
  std::ifstream stream(life.report);
  return json::parse(stream, nullptr, false);
}

bool IsFinite(const TraceSample& sample) {
  return sample.X_WB.p.allFinite() && sample.X_WB.q.coeffs().allFinite() &&
         sample.V_WB.w.allFinite() && sample.V_WB.v.allFinite() && std::isfinite(sample.hand_force);
}

std::int64_t MeanMemory(std::span<const Footprint> footprints) {
  const std::int64_t sum = std::accumulate(footprints.begin(), footprints.end(), std::int64_t{0},
                                           [](std::int64_t before, const Footprint& one) {
                                             return before + one.memory;
                                           });
  return sum / static_cast<std::int64_t>(footprints.size());
}

void FindEmpty(const json& value, const std::string& place, std::vector<std::string>& found) {
  static constexpr std::array<const char*, 2> kSound{"/device_times", "/safety/passivity"};
  if (value.is_null() && std::ranges::find(kSound, place) == kSound.end()) found.push_back(place);
  if (!value.is_structured()) return;
  for (const auto& [key, inner] : value.items()) FindEmpty(inner, place + "/" + key, found);
}

void JudgeTrace(const SoakLife& life, std::vector<std::string>& faults) {
  const Result<std::vector<TraceSample>> trace = ReadTrace(life.report.string() + ".trace");
  if (!trace) {
    faults.push_back(trace.error().what);
    return;
  }
  if (trace->empty()) faults.emplace_back("its hand never began");
  const auto bad = std::ranges::find_if_not(*trace, IsFinite);
  if (bad != trace->end()) {
    faults.push_back("frame " + std::to_string(bad - trace->begin()) +
                     " of its trace has a number that is none");
  }
}

void JudgePeer(const SoakLife& life, const json& report, const SoakBounds& bounds,
               std::vector<std::string>& faults) {
  const json& felt = report.at("felt");
  const auto beyond = [&felt](const char* key, double limit) {
    return !(felt.at(key).get<double>() <= kRounding * limit);
  };
  if (beyond("peak_N", DeviceLimits{}.force) || beyond("peak_Nm", DeviceLimits{}.moment)) {
    faults.push_back("its hand felt more than the limits: " + felt.dump());
  }
  if (life.ended_s - life.began_s < bounds.contact_after_s) return;
  if (!(report.at("contact_share").get<double>() > 0)) faults.emplace_back("it had no contact");
  if (!(report.at("delay_ms").get<double>() >= bounds.least_delay_ms)) {
    faults.push_back("it measured a delay of " + report.at("delay_ms").dump() + " ms");
  }
}

/// Returns some twenty of the life's footprints, evenly spread.
ordered_json CourseInTime(const std::vector<Footprint>& footprints) {
  constexpr std::size_t kShown = 20;
  ordered_json course = ordered_json::array();
  for (std::size_t i = 0; i < footprints.size(); i += footprints.size() / kShown + 1) {
    course.push_back(footprints[i].memory);
  }
  return course;
}

std::string Text(double value, const char* unit) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.3f %s", value, unit);
  return text.data();
}

}  // namespace

std::optional<MemoryTrend> TrendOf(const SoakLife& life, double settle_s) {
  const double from_s = life.began_s + settle_s;
  std::vector<Footprint> judged;
  std::ranges::copy_if(life.footprints, std::back_inserter(judged), [from_s](const Footprint& one) {
    return one.at_s >= from_s && one.memory > 0;
  });
  if (judged.empty() || judged.back().at_s - judged.front().at_s < 2 * MemoryTrend::kWindow) {
    return std::nullopt;
  }
  const auto window = [&judged](double begin_s, double end_s) {
    const auto first = std::ranges::lower_bound(judged, begin_s, {}, &Footprint::at_s);
    const auto last = std::ranges::upper_bound(judged, end_s, {}, &Footprint::at_s);
    return std::span<const Footprint>(first, last);
  };
  const double begin_s = judged.front().at_s;
  const double end_s = judged.back().at_s;
  return MemoryTrend{.judged_s = end_s - begin_s,
                     .settled = MeanMemory(window(begin_s, begin_s + MemoryTrend::kWindow)),
                     .last = MeanMemory(window(end_s - MemoryTrend::kWindow, end_s)),
                     .most = std::ranges::max(judged, {}, &Footprint::memory).memory,
                     .settled_files = judged.front().files,
                     .last_files = judged.back().files};
}

std::vector<std::string> EmptyNumbers(const json& report) {
  std::vector<std::string> found;
  FindEmpty(report, "", found);
  return found;
}

std::vector<std::string> FaultsOf(const SoakLife& life, const SoakBounds& bounds) {
  std::vector<std::string> faults;
  if (!life.not_finite.empty()) faults.push_back("it said: " + life.not_finite);
  if (life.most_lines_per_s > bounds.lines_per_s) {
    faults.push_back("it said " + Text(life.most_lines_per_s, "lines a second"));
  }
  if (const std::optional<MemoryTrend> course = TrendOf(life, bounds.settle_s)) {
    if (course->growth() > bounds.growth) {
      faults.push_back("it grew by " + std::to_string(course->growth()) + " bytes in " +
                       Text(course->judged_s, "s"));
    }
    if (course->last_files > course->settled_files + bounds.files) {
      faults.push_back("it had " + std::to_string(course->settled_files) +
                       " files open, and at its end " + std::to_string(course->last_files));
    }
  }
  if (life.killed) return faults;
  const int expected = life.disk_full ? kExitFile : kExitOk;
  if (life.exit_code != expected) {
    faults.push_back("it ended with " + std::to_string(life.exit_code.value_or(-1)) + " for " +
                     std::to_string(expected));
  }
  if (life.took_to_end_s > bounds.end_s) {
    faults.push_back("it took " + Text(life.took_to_end_s, "s") + " to end");
  }
  if (life.said_goodbye == false) faults.emplace_back("nobody heard its goodbye");
  const json report = ReportOf(life);
  if (!report.is_object()) {
    faults.emplace_back("it left no report that can be read");
    return faults;
  }
  if (!life.is_peer()) {
    if (!(report.at("samples").get<double>() > 0)) faults.emplace_back("it received nothing");
    return faults;
  }
  const std::vector<std::string> empty = EmptyNumbers(report);
  for (const std::string& place : empty) faults.push_back("no number in its report: " + place);
  if (empty.empty()) JudgePeer(life, report, bounds, faults);
  JudgeTrace(life, faults);
  return faults;
}

ordered_json AsJson(const SoakLife& life, const SoakBounds& bounds) {
  ordered_json row{{"name", life.name},
                   {"seconds", life.ended_s - life.began_s},
                   {"killed", life.killed},
                   {"stopped_s", life.stopped_s},
                   {"lines", life.lines},
                   {"most_lines_per_s", life.most_lines_per_s},
                   {"losses_of_others", life.losses}};
  if (const std::optional<MemoryTrend> course = TrendOf(life, bounds.settle_s)) {
    row["memory"] = {{"judged_s", course->judged_s},
                     {"settled_bytes", course->settled},
                     {"last_bytes", course->last},
                     {"most_bytes", course->most},
                     {"growth_bytes", course->growth()},
                     {"files", course->settled_files},
                     {"files_at_the_end", course->last_files}};
  }
  row["course_bytes"] = CourseInTime(life.footprints);
  if (life.killed) return row;
  row["exit_code"] = life.exit_code.value_or(-1);
  row["disk_full"] = life.disk_full;
  row["took_to_end_s"] = life.took_to_end_s;
  const json report = ReportOf(life);
  if (!report.is_object()) return row;
  const auto take = [&](std::initializer_list<const char*> keys) {
    for (const char* key : keys) {
      if (report.contains(key)) row[key] = report.at(key);
    }
  };
  take({"frames", "missed", "frames_over_1ms", "scheduler", "lateness_us", "frame_wall_us",
        "contact_share", "peak_force_N", "felt", "delay_ms", "guarded_share", "heard", "drops",
        "samples", "samples_per_s"});
  if (life.is_peer()) {
    // a stopped program runs no frame: each millisecond of that is a deadline missed
    const double missed = report.at("missed").get<double>() - 1e3 * life.stopped_s;
    row["missed_beside_stops"] = std::max(0.0, missed);
  }
  return row;
}

}  // namespace tandem::testing
