#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>

#include "app/process/child_processes.h"
#include "collab/controller/controller.h"
#include "engine/base/units.h"
#include "tests/support/machine/lag_meter.h"
#include "tests/support/machine/processor_wait.h"

// Real processes: two controllers in one session, each with the peg in its hand. A host moves the
// first one's hand and is killed; this program is a host of the second, and sees what its user
// feels.

namespace tandem {
namespace {

using std::chrono::milliseconds;

struct ForceThen {
  double t = 0;  // s
  std::array<double, 3> force{};
};

double Difference(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

/// Returns the largest change of force within 100 ms.
double LargestChange(const std::vector<ForceThen>& course) {
  double largest = 0;
  for (std::size_t i = 0; i < course.size(); ++i) {
    for (std::size_t k = i + 1; k < course.size() && course[k].t - course[i].t <= 0.1; ++k) {
      largest = std::max(largest, Difference(course[k].force, course[i].force));
    }
  }
  return largest;
}

Result<ChildProcess> StartController(const std::string& session, const std::string& name,
                                     bool holds) {
  std::vector<std::string> words{
      TANDEM_PROGRAM, "peer",      "--session",
      session,        "--scene",   std::string(TANDEM_SCENES) + "/peg_in_slot.json",
      "--interface",  "lo",        "--name",
      name,           "--control", name,
      "--capacity",   "20000",     "--brief"};
  if (holds) words.insert(words.end(), {"--hold", "peg"});
  return ChildProcess::Start(words);
}

/// The host of a controller that looks on, and keeps what its user feels.
class Partner {
 public:
  explicit Partner(const std::string& controller) {
    Controller::Options options;
    options.timeout_s = 60;
    Result<Controller> attached = Controller::Attach(controller, options);
    EXPECT_TRUE(attached) << attached.error().what;
    host_.emplace(*std::move(attached));
    EXPECT_TRUE(host_->Ask(SnapshotRateRequest{200}).ok);
    while (host_->snapshot().hand.body < 0) host_->Wait(milliseconds(100));
    host_->OnSnapshot([this](const ControllerSnapshot& now) {
      course_.push_back({ToSeconds(now.time_ns), now.hand.force_N});
    });
  }
  Partner(const Partner&) = delete;

  void Look(int ms) {
    const auto until = std::chrono::steady_clock::now() + milliseconds(ms);
    while (std::chrono::steady_clock::now() < until) host_->Wait(milliseconds(2));
  }
  /// Looks on until the condition holds, or for a minute. Returns whether it holds.
  template <class Condition>
  bool LookUntil(const Condition& condition) {
    for (int waited = 0; waited < 6000 && !condition(); ++waited) Look(10);
    return condition();
  }
  bool SeesBothHold() const {
    const auto body = static_cast<std::size_t>(host_->snapshot().hand.body);
    return host_->snapshot().bodies[body].holders.size() == 2;
  }
  std::vector<ForceThen>& course() noexcept { return course_; }

 private:
  std::optional<Controller> host_;
  std::vector<ForceThen> course_;
};

TEST(HostKilled, PartnersFeelLittleAndTheNextHostFindsEverything) {
  // nothing of ours sets the environment
  const char* requested = std::getenv("TANDEM_HOST_KILLS");  // NOLINT(concurrency-mt-unsafe)
  const int kills = requested != nullptr ? std::atoi(requested) : 3;
  std::mt19937_64 random(17);
  const std::string id = std::to_string(getpid());
  TemporaryFolder folder;
  Result<ChildProcess> first = StartController("kill-" + id, "first-" + id, false);
  Result<ChildProcess> second = StartController("kill-" + id, "second-" + id, true);
  ASSERT_TRUE(first && second);
  Partner partner("second-" + id);
  std::vector<ForceThen>& course = partner.course();
  double least_pull = 99;  // N; least pull of the partner's hand against the other's
  double worst_change = 0;
  double longest_attach_s = 0;
  for (int kill = 0; kill < kills; ++kill) {
    const std::filesystem::path output = folder.path() / ("host-" + std::to_string(kill));
    Result<ChildProcess> host =
        ChildProcess::Start({TANDEM_HOST_FOR_TESTS, "first-" + id, "peg", "0.02", output.string()});
    ASSERT_TRUE(host);
    testing::ProcessorWait of_host(host->pid());
    testing::ProcessorWait of_controller(first->pid());
    const testing::LagMeter lag;
    ASSERT_TRUE(partner.LookUntil([&output, &of_host] {
      of_host.Look();
      return std::filesystem::exists(output);
    }));
    // without the time in which others had the processors
    const double waited_s =
        of_host.Look() + of_controller.Look() + std::chrono::duration<double>(lag.worst()).count();
    double took_s = 99;
    std::size_t bodies = 0;
    std::ifstream(output) >> took_s >> bodies;
    EXPECT_EQ(bodies, 2U) << "the peg and the block with its slot";
    longest_attach_s = std::max(longest_attach_s, took_s - waited_s);
    const auto held_by_both = [&partner] {
      return partner.SeesBothHold();
    };
    ASSERT_TRUE(partner.LookUntil(held_by_both)) << "the host's hand holds the peg";
    partner.Look(static_cast<int>(random() % 500));
    ASSERT_FALSE(course.empty());
    const double pulled = Difference(course.back().force, {});
    least_pull = std::min(least_pull, pulled);
    ASSERT_TRUE(held_by_both()) << "the killed host's hand holds the peg";
    course.clear();
    host->Signal(SIGKILL);
    EXPECT_TRUE(partner.LookUntil(std::not_fn(held_by_both))) << "it has let go";
    partner.Look(700);  // until its pull has faded
    worst_change = std::max(worst_change, LargestChange(course));
    ASSERT_GT(course.size(), 50U) << "snapshots of the partner";
  }
  RecordProperty("kills", kills);
  RecordProperty("least_pull_N", std::to_string(least_pull));
  RecordProperty("worst_change_N", std::to_string(worst_change));
  RecordProperty("longest_attach_s", std::to_string(longest_attach_s));
  EXPECT_GT(least_pull, 0.5) << "a pull that nobody feels proves nothing";
  EXPECT_LE(worst_change, 1.0);
  EXPECT_LE(longest_attach_s, 2.0);
  EXPECT_FALSE(first->Poll()) << "the controller has ended";
}

}  // namespace
}  // namespace tandem
