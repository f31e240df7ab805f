#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "engine/base/text/json_text.h"
#include "engine/realtime/periodic_thread.h"
#include "tests/soak/soak_judgement.h"
#include "tests/soak/soak_schedule.h"
#include "tests/soak/soak_session.h"
#include "tests/support/machine/lag_meter.h"
#include "tests/support/tap_hub_here.h"

// The endurance run. Three peers and two viewers of the product live through faults that a seed
// draws, and after each fault the session must come together again. TANDEM_SOAK_SECONDS=3600 makes
// it an hour, TANDEM_SOAK_KINDS=kill,stop draws those kinds alone; the figures come on stdout, and
// into the file that TANDEM_SOAK_RESULT names.

namespace tandem {
namespace {

using nlohmann::ordered_json;
using ::testing::IsEmpty;
using testing::SoakBounds;
using testing::SoakFault;
using testing::SoakLife;
using testing::SoakPlaces;
using testing::SoakSchedule;
using testing::SoakSession;

constexpr double kTogetherWithin = 10;  // s, after a fault's end, a new program's start among them
constexpr double kBeginWithin = 60;     // s
constexpr double kLastChance = 60;  // s, after which a session that is not together ends the run
constexpr double kLongRun = 600;    // s

std::string FromEnvironment(const char* value, const char* otherwise) {
  return value != nullptr ? value : otherwise;
}

double WantedSeconds() {
  return std::stod(FromEnvironment(std::getenv("TANDEM_SOAK_SECONDS"), "60"));
}

std::uint64_t Seed() {
  return std::stoull(FromEnvironment(std::getenv("TANDEM_SOAK_SEED"), "1"));
}

std::vector<SoakFault::Kind> Kinds() {
  return testing::KindsIn(FromEnvironment(std::getenv("TANDEM_SOAK_KINDS"), ""));
}

/// A long run asks for memory that is flat after five minutes. In a shorter one a program settles
/// for a third of the run; the poses of its hand, 11 kB a second, still fill their room then.
SoakBounds BoundsOf(double seconds) {
  return {.settle_s = seconds >= kLongRun ? 300 : seconds / 3};
}

/// Returns the network spaces that the test made and did not take away.
std::vector<std::string> LeftNetworks() {
  const std::string own = "tandem" + std::to_string(getpid()) + "-";
  std::vector<std::string> left;
  std::error_code none;
  for (const auto& one : std::filesystem::directory_iterator("/run/netns", none)) {
    if (one.path().filename().string().starts_with(own)) left.push_back(one.path().string());
  }
  return left;
}

std::vector<std::string> SharedMemory() {
  std::vector<std::string> names;
  for (const auto& one : std::filesystem::directory_iterator("/dev/shm")) {
    if (one.path().filename().string().find("tandem") != std::string::npos) {
      names.push_back(one.path().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

ordered_json AsJson(const FrameStats& empty) {
  const auto us = [](std::int64_t ns) {
    return 1e-3 * static_cast<double>(ns);
  };
  return {{"frames", empty.frames()},
          {"missed", empty.missed()},
          {"lateness_us",
           {{"p50", us(empty.lateness().Quantile(0.5))},
            {"p99", us(empty.lateness().Quantile(0.99))},
            {"max", us(empty.lateness().max())}}}};
}

/// Returns a share of deadlines, as a person compares it.
double MissedPerMillion(const ordered_json& row) {
  const auto missed = row.at("missed").get<double>();
  return 1e6 * missed / std::max(1.0, row.at("frames").get<double>() + missed);
}

/// The run's faults with the time until the session was together again.
class SoakTrend {
 public:
  void Add(const SoakFault& fault, double began_s, std::optional<double> together_s) {
    ordered_json row = testing::AsJson(fault);
    row["at_s"] = began_s;
    row["together_after_s"] = together_s ? ordered_json(*together_s) : ordered_json(nullptr);
    std::printf("%8.1f s: %s\n", began_s, row.dump().c_str());
    std::fflush(stdout);
    rows_.push_back(row);
    Kind& kind = kinds_[NameOf(fault.kind)];
    ++kind.count;
    kind.worst_s = std::max(kind.worst_s, together_s.value_or(1e9));
    kind.best_s = std::min(kind.best_s, together_s.value_or(1e9));
  }
  std::size_t count() const { return rows_.size(); }
  const ordered_json& rows() const { return rows_; }
  ordered_json Kinds() const {
    ordered_json kinds = ordered_json::object();
    for (const auto& [name, kind] : kinds_) {
      kinds[name] = {{"count", kind.count}, {"best_s", kind.best_s}, {"worst_s", kind.worst_s}};
    }
    return kinds;
  }

 private:
  struct Kind {
    int count = 0;
    double best_s = 1e9;
    double worst_s = 0;
  };
  ordered_json rows_ = ordered_json::array();
  std::map<std::string, Kind> kinds_;
};

class Soak : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* lacks = testing::WhyNoTapHub()) {
      GTEST_SKIP() << "over loopback nothing can be cut, and a TAP hub " << lacks;
    }
    ASSERT_FALSE(kinds_.empty()) << "TANDEM_SOAK_KINDS names no kind of fault";
  }

  /// Strikes the session with all faults of the seed until the time is over, but with every kind at
  /// least once.
  void StrikeAll(SoakSession& session, SoakTrend& course) const {
    SoakSchedule schedule(Seed(), kinds_);
    const testing::LagMeter lag;
    while (session.seconds() < wanted_s_ || course.count() < kinds_.size()) {
      const SoakFault fault = schedule.Next();
      session.Watch(fault.after_s);
      const double began_s = session.seconds();
      session.Strike(fault);
      const double within_s = kTogetherWithin + std::chrono::duration<double>(lag.worst()).count();
      std::optional<double> together_s = session.AwaitTogether(within_s);
      course.Add(fault, began_s, together_s);
      if (together_s) continue;
      ADD_FAILURE() << "not together again within " << within_s << " s after "
                    << testing::AsJson(fault) << "\n"
                    << session.LastWords();
      if (!session.AwaitTogether(kLastChance)) return;
    }
  }

  const double wanted_s_ = WantedSeconds();
  const std::vector<SoakFault::Kind> kinds_ = Kinds();
  const SoakBounds bounds_ = BoundsOf(wanted_s_);
};

TEST_F(Soak, ThreePeersAndTwoViewersSurviveRandomFaults) {
  const std::vector<std::string> shared_memory = SharedMemory();
  ordered_json result{{"seed", Seed()},
                      {"wanted_s", wanted_s_},
                      {"delay_ms_each_way", SoakSession::kDelayMs},
                      {"settle_s", bounds_.settle_s},
                      {"growth_allowed_bytes", bounds_.growth},
                      {"cores", std::thread::hardware_concurrency()}};
  SoakTrend course;
  {
    SoakSession session(wanted_s_ + 300);
    // it has the haptic threads' priority and no work: a deadline that it misses, no peer can keep
    PeriodicThread empty({.name = "empty"}, [](std::int64_t, std::int64_t) {
      return true;
    });
    session.Begin();
    const std::optional<double> begun_s = session.AwaitTogether(kBeginWithin);
    ASSERT_TRUE(begun_s) << "the session never came together\n" << session.LastWords();
    result["together_at_first_s"] = *begun_s;
    StrikeAll(session, course);
    session.Watch(1);
    session.End();
    empty.Stop();
    empty.Join();
    for (double waited = 0; waited < 10 && !session.LeftProcesses().empty(); waited += 0.1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    EXPECT_THAT(session.LeftProcesses(), IsEmpty());
    EXPECT_THAT(session.LeftFiles(), IsEmpty());

    result["seconds"] = session.seconds();
    result["empty_loop"] = AsJson(empty.stats());
    result["empty_loop"]["missed_per_million"] = MissedPerMillion(result["empty_loop"]);
    result["frames_carried"] = session.hub().carried();
    result["frames_lost"] = session.hub().lost();
    result["kinds"] = course.Kinds();
    result["faults"] = course.rows();
    result["lives"] = ordered_json::array();
    for (const SoakLife& life : session.lives()) {
      EXPECT_THAT(FaultsOf(life, bounds_), IsEmpty()) << life.name;
      ordered_json row = testing::AsJson(life, bounds_);
      if (row.contains("missed")) row["missed_per_million"] = MissedPerMillion(row);
      result["lives"].push_back(row);
    }
  }
  EXPECT_GE(course.count(), kinds_.size());
  EXPECT_THAT(LeftNetworks(), IsEmpty());
  EXPECT_EQ(SharedMemory(), shared_memory);
  const std::string text = JsonText(result, 1);
  std::printf("%s\n", text.c_str());
  const std::string file = FromEnvironment(std::getenv("TANDEM_SOAK_RESULT"), "");
  if (!file.empty()) std::ofstream(file) << text << "\n";
}

}  // namespace
}  // namespace tandem
