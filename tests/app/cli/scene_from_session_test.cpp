#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/common/exit_codes.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/session/early_inbox.h"
#include "collab/transfer/file_messages.h"
#include "engine/scene/scene_hash.h"
#include "tests/app/cli/peer_program.h"

// Tests `tandem peer --scene-from-session`: a joiner who names no scene goes by the session's.

namespace tandem {
namespace {

using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::Running;
using testing::RunTandem;

/// Programs of two people on one machine, each with folders of its own.
class SceneFromSession : public testing::PeerCommand {
 protected:
  /// Starts programs as that person from here on.
  void As(const std::string& person) const {
    setenv("XDG_STATE_HOME", In(person + ".state").c_str(), 1);
    setenv("TANDEM_CACHE", In(person + ".cache").c_str(), 1);
  }
  std::string SessionSetup(const std::string& more) const {
    return "--interface lo --capacity 20000 --session " + session_ + " --scene-from-session " +
           more;
  }
};

TEST_F(SceneFromSession, FindsALocalSceneByContent) {
  As("anna");
  Running anna = Start("one", "--name anna --hold left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  As("ben");
  // ben opened a scene in that folder before
  const ProgramOutput once =
      RunTandem("peer --interface lo --capacity 20000 --session " + session_ +
                    "-before --seconds 0.1 --hold left --scene " + In("one.json"),
                "timeout 40 ");
  ASSERT_EQ(once.exit_code, kExitOk) << once.err;
  const ProgramOutput ben =
      RunTandem("peer " + SessionSetup("--name ben --hold right --seconds 0.2"), "timeout 40 ");
  EXPECT_EQ(ben.exit_code, kExitOk) << ben.err;
  EXPECT_THAT(ben.err,
              HasSubstr("the session's scene boxes is on this machine: " + In("one.json")));
  EXPECT_THAT(ben.err, HasSubstr("you hold right"));
  EXPECT_EQ(anna.End(), kExitOk);
}

// ben's machine has no such file: anna's scene stays in her folder, which he never opened.
TEST_F(SceneFromSession, FetchesFromAPeerAfterConsent) {
  As("anna");
  Running anna = Start("one", "--name anna --hold left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  As("ben");
  const ProgramOutput requested = RunTandem("peer " + SessionSetup("--name ben"), "timeout 40 ");
  ExpectRefused(requested, kExitFile,
                "it can be fetched (scene boxes, 2 files, 1 kB, from anna), but there is no "
                "terminal to ask at: give --accept-scene to fetch it");
  EXPECT_FALSE(std::filesystem::exists(In("ben.cache/fetched")));
  const ProgramOutput small = RunTandem(
      "peer " +
          SessionSetup("--name ben --accept-scene --scene-limit-mb 1 --hold right --seconds 0.2"),
      "timeout 40 ");
  EXPECT_EQ(small.exit_code, kExitOk) << small.err;
  EXPECT_THAT(small.err, HasSubstr("fetching scene boxes, 2 files, 1 kB, from anna"));
  EXPECT_THAT(small.err, HasSubstr("you hold right"));
  EXPECT_TRUE(anna.WaitFor("a joiner fetches the scene's files from here"));
  // the next time it is here, whoever looks for it
  const ProgramOutput again =
      RunTandem("watch --interface lo --scene-from-session --seconds 1.5 --session " + session_,
                "timeout 40 ");
  EXPECT_EQ(again.exit_code, kExitOk) << again.err;
  EXPECT_THAT(again.err, HasSubstr("is on this machine: " + In("ben.cache/fetched/")));
  EXPECT_THAT(again.err, HasSubstr("it is the scene given with --scene"));
  const ProgramOutput listed = RunTandem("cache list");
  EXPECT_THAT(listed.out, HasSubstr("scene boxes in " + In("ben.cache/fetched/")));
  EXPECT_EQ(nlohmann::json::parse(RunTandem("cache list --json").out)["fetched_scenes"].size(), 1U);
  EXPECT_THAT(RunTandem("cache clear").out, HasSubstr("and 1 fetched scene removed"));
  EXPECT_TRUE(std::filesystem::is_empty(In("ben.cache/fetched")));
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(SceneFromSession, PeerWithoutSharingServesNothing) {
  As("anna");
  Running anna = Start("one", "--name anna --no-share-scene");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  As("ben");
  ExpectRefused(RunTandem("peer " + SessionSetup("--accept-scene"), "timeout 40 "), kExitFile,
                "nobody here hands out the scene's files");
  EXPECT_EQ(anna.End(), kExitOk);
}

// The scene has 4 MB that no compression makes fewer, and a peer sends 1 MB a second.
TEST_F(SceneFromSession, ResumesAfterAKillAndSwitchesPeersAfterALeave) {
  std::string box = testing::BoxObjText(0.02, 0.02, 0.02);
  std::mt19937_64 random(5);
  while (box.size() < 4'000'000) {
    box += "#";
    for (int i = 0; i < 6; ++i) box += std::to_string(random());
    box += "\n";
  }
  folder_.Write("left.obj", box);
  As("anna");
  Running anna = Start("one", "--name anna --share-rate-mb 0.8");
  Running carl = Start("one", "--name carl --share-rate-mb 0.8");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  ASSERT_TRUE(carl.WaitFor("is in session"));
  As("ben");
  Running first(SessionSetup("--accept-scene --name ben"), In("first"));
  ASSERT_TRUE(first.WaitFor("fetching scene boxes, 3 files, 4 MB"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  first.Kill();
  first.Wait();
  EXPECT_THAT(RunTandem("cache list").out, HasSubstr("a part of a scene in "));
  Running second(SessionSetup("--accept-scene --name ben --hold right --seconds 0.2"),
                 In("second"));
  ASSERT_TRUE(second.WaitFor("fetching scene boxes"));
  EXPECT_THAT(second.output(), HasSubstr(" are here already"));
  const std::string from = second.output().find("from anna") != std::string::npos ? "anna" : "carl";
  (from == "anna" ? anna : carl).Kill();
  EXPECT_EQ(second.Wait(), kExitOk) << second.output();
  EXPECT_THAT(second.output(), HasSubstr("you hold right"));
  EXPECT_EQ((from == "anna" ? carl : anna).End(), kExitOk);
}

/// A stranger that asks a peer for pieces as fast as it can, under DDS.
class Greedy final : public TransferEndpoint {
 public:
  explicit Greedy(std::uint64_t content_hash) : content_(content_hash) {}
  bool serves() const override { return false; }
  void OnPiece(const FilePiece& piece, std::int64_t) override {
    if (piece.kind == FileAsk::Kind::kOffer) list_ = piece.list;
    bytes += piece.bytes.size();
  }
  std::int64_t Tick(std::int64_t now_ns, const Out& out) override {
    FileAsk ask;
    ask.from = 5;
    ask.content_hash = content_;
    ask.kind = turns_ < 100 ? FileAsk::Kind::kOffer : FileAsk::Kind::kFiles;
    ask.list = list_;
    ask.first = (turns_ % 7) * 17;
    ask.wanted.set();
    ask.rate = UINT32_MAX;
    out.ask(ask);
    // paced until a scene is offered: beyond the rate nobody hears this program
    return ++turns_ < 100 ? now_ns + 30'000'000 : now_ns + 100'000;
  }
  std::atomic<std::uint64_t> bytes{0};

 private:
  const std::uint64_t content_;
  Sha256 list_{};
  std::uint32_t turns_ = 0;
};

TEST_F(SceneFromSession, RequestFloodMutesItsSenderAndTakesNoMemory) {
  As("anna");
  Running anna = Start("one", "--name anna --hold left --report " + In("report"));
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  const Result<Scene> scene = LoadScene(In("one.json"));
  ASSERT_TRUE(scene);
  const Result<SceneHash> hash = HashScene(*scene);
  ASSERT_TRUE(hash);
  Greedy greedy(hash->content);
  EarlyInbox active_peers;
  DdsOptions options;
  options.session = session_;
  options.peer = 5;
  options.interface = "lo";
  options.files = &greedy;
  auto joined = JoinOverDds(options, active_peers);
  ASSERT_TRUE(joined) << joined.error().what;
  ASSERT_TRUE(anna.WaitFor("a joiner fetches the scene's files from here"));
  const long before_kb = std::stol(anna.Memory("VmRSS"));
  std::this_thread::sleep_for(std::chrono::seconds(3));
  // 512 kB: the heap of one thread grows by so much at a time
  EXPECT_LT(std::stol(anna.Memory("VmRSS")), before_kb + 512);
  EXPECT_GT(greedy.bytes, 0U);
  (*joined)->Leave();
  EXPECT_EQ(anna.End(), kExitOk);
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(In("report")), nullptr, false);
  EXPECT_GT(report.at("drops").at("flood").get<int>(), 1000);
}

// A viewer's keys allow no topic of files, and the viewer asks by another topic.
TEST_F(SceneFromSession, SecuredMembersAndViewersFetch) {
  As("anna");
  for (const std::string words : {"session ", "peer ", "viewer "}) {
    const std::string name = words == "peer " ? " anna" : words == "viewer " ? " vera" : "";
    const ProgramOutput made = RunTandem("keys " + words + In("keys") + name);
    ASSERT_EQ(made.exit_code, kExitOk) << made.err;
  }
  Running anna = Start("one", "--hold left --secure " + In("keys/anna"));
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  As("vera");
  const ProgramOutput vera =
      RunTandem("watch --interface lo --scene-from-session --accept-scene --seconds 0.5 --secure " +
                    In("keys/vera") + " --session " + session_,
                "timeout 40 ");
  EXPECT_EQ(vera.exit_code, kExitOk) << vera.err;
  EXPECT_THAT(vera.err, HasSubstr("fetched scene boxes in "));
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(SceneFromSession, ReportsInOneLineWhyTheSceneIsMissing) {
  As("ben");
  ExpectRefused(RunTandem("peer --interface lo --session " + session_), kExitUsage,
                "--scene is required, or --scene-from-session");
  ExpectRefused(RunTandem("peer " + SessionSetup("--scene " + In("one.json"))), kExitUsage,
                "--scene excludes --scene-from-session");
  ExpectRefused(RunTandem("peer --interface lo --accept-scene --session " + session_ + " --scene " +
                          In("one.json")),
                kExitUsage, "--scene-from-session");
  // a person who waits is told before that
  const ProgramOutput alone = RunTandem("peer " + SessionSetup(""), "timeout 40 ");
  EXPECT_EQ(alone.exit_code, kExitNetwork);
  EXPECT_THAT(alone.err, HasSubstr("no peer of session " + session_ +
                                   " answered yet: listening for another 11 s\n"));
  EXPECT_THAT(alone.err, HasSubstr("no peer of session " + session_ + " offers a scene"));
  EXPECT_EQ(std::count(alone.err.begin(), alone.err.end(), '\n'), 2) << alone.err;
}

}  // namespace
}  // namespace tandem
