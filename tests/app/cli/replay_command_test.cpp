#include <algorithm>
#include <cstdlib>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/key_scene.h"

// Tests `tandem peer --record` and what `tandem replay` makes of it, as programs.

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

namespace fs = std::filesystem;

std::string NewSession() {
  return "replay-" + std::to_string(std::random_device{}());
}

ChildProcess Start(const std::string& arguments) {
  std::istringstream stream(arguments);
  std::vector<std::string> command{TANDEM_PROGRAM};
  command.insert(command.end(), std::istream_iterator<std::string>(stream), {});
  Result<ChildProcess> started = ChildProcess::Start(command);
  EXPECT_TRUE(started);
  return *std::move(started);
}

const char* const kScenes = TANDEM_SCENES;
const std::string kPegScene =
    std::string("peer --interface lo --capacity 20000 --hold peg --scene ") + kScenes +
    "/peg_in_slot.json --hand " + kScenes + "/peg_in_slot_left.json";

/// Records a session of one peer, in which the peg is worked towards the slot for a second.
class ReplayCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    // CTest runs each test as a program of its own: one recording serves all
    if (const char* const made = std::getenv("TANDEM_REPLAY_RECORDING")) {
      fs::copy_file(made, File("run"));
      return;
    }
    const ProgramOutput output = RunTandem(kPegScene + " --name anna --seconds 1 --session " +
                                           NewSession() + " --record " + File("run"));
    ASSERT_EQ(output.exit_code, 0) << output.err;
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string File(const char* name) { return (folder_->path() / name).string(); }

  /// Returns the result of a replay that must succeed.
  static json Replayed(const std::string& arguments) {
    const ProgramOutput output = RunTandem("replay --json " + arguments, "timeout 60 ");
    EXPECT_EQ(output.exit_code, 0) << output.err;
    json result = json::parse(output.out, nullptr, false);
    EXPECT_TRUE(result.is_object()) << output.out;
    return result;
  }
  static void ExpectRefused(const std::string& arguments, int exit_code, const std::string& words) {
    const ProgramOutput output = RunTandem("replay " + arguments, "timeout 60 ");
    EXPECT_EQ(output.exit_code, exit_code) << output.err;
    EXPECT_THAT(output.err, HasSubstr(words));
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  }

  static std::unique_ptr<ScratchFolder> folder_;
};
std::unique_ptr<ScratchFolder> ReplayCommand::folder_;

TEST_F(ReplayCommand, HashesAreIndependentOfTheThreadCount) {
  const json one = Replayed(File("run"));
  EXPECT_EQ(one.at("identical"), true);
  EXPECT_EQ(one.at("torn"), false);
  const auto frames = one.at("frames").get<std::size_t>();
  ASSERT_GE(frames, 2000U) << "two hashes at least are compared; late frames are left out";
  EXPECT_EQ(one.at("hash_each_second").size(), frames / 1000);
  EXPECT_NE(one.at("hash_each_second")[0], one.at("hash_each_second")[1]) << "the peg moved";
  const json two = Replayed(File("run") + " --threads 2");
  EXPECT_EQ(two.at("hash_each_second"), one.at("hash_each_second"));
}

TEST_F(ReplayCommand, ReportsTheFateOfTheHeldBody) {
  const ProgramOutput output = RunTandem("replay " + File("run"), "timeout 60 ");
  EXPECT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(output.err, HasSubstr("tandem: peg stands "));
  EXPECT_THAT(output.err, HasSubstr(" and is NOT out; it "));
  EXPECT_THAT(output.out, ::testing::Not(HasSubstr("state "))) << "hashes are for --json";
  const json verdicts = Replayed(File("run")).at("verdicts");
  ASSERT_EQ(verdicts.size(), 1U);
  EXPECT_EQ(verdicts[0].at("body"), "peg");
  EXPECT_EQ(verdicts[0].at("out"), false);
  EXPECT_GT(verdicts[0].at("moved_mm").get<double>(), 0.1);
  EXPECT_LT(verdicts[0].at("deepest_mm").get<double>(), 0.5);
}

TEST_F(ReplayCommand, ExportedPosesServeTheProximityCommand) {
  const std::string poses = File("poses.csv");
  const json run = Replayed(File("run") + " --export " + poses);
  std::ifstream stream(poses);
  std::string line;
  std::getline(stream, line);
  EXPECT_EQ(line, "t_s,moving,tx,ty,tz,ax,ay,az,angle_deg");
  std::size_t rows = 0;
  while (std::getline(stream, line)) ++rows;
  EXPECT_EQ(rows, (run.at("frames").get<std::size_t>() + 9) / 10);  // one body, every tenth frame
  // the first row is where the scene has the peg at first
  const std::string scene = std::string(kScenes) + "/peg_in_slot.json";
  const json along =
      json::parse(RunTandem("proximity " + scene + " --json --poses " + poses, "timeout 60 ").out);
  const json first = json::parse(RunTandem("proximity --json " + scene, "timeout 60 ").out);
  ASSERT_EQ(along.at("rows").size(), rows);
  EXPECT_NEAR(along.at("rows")[0].at("distance_m").get<double>(),
              first.at("rows")[0].at("distance_m").get<double>(), 1e-9);
  EXPECT_NE(along.at("rows")[rows - 1].at("distance_m"), along.at("rows")[0].at("distance_m"));
}

// the contact of the peg with the plate of its slot, at the recorded poses
TEST_F(ReplayCommand, ExportedPosesServeTheContactCommand) {
  const std::string poses = File("poses.csv");
  const json run = Replayed(File("run") + " --export " + poses);
  const std::string scenes = std::string(kScenes) + "/";
  const json scene = json::parse(std::ifstream(scenes + "peg_in_slot.json"));
  std::string fixed;
  std::string moving;
  for (const json& body : scene.at("bodies")) {
    (body.value("fixed", false) ? fixed : moving) = scenes + body.at("mesh").get<std::string>();
  }
  const ProgramOutput output =
      RunTandem("contact --csv --voxel 0.001 --body peg --scale 0.001 --static " + fixed +
                    " --dynamic " + moving + " --poses " + poses,
                "timeout 60 ");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(output.err, HasSubstr("has no column fixed"));
  EXPECT_THAT(output.out, HasSubstr(",nearest_voxels,t_s\n0,"));
  EXPECT_THAT(output.out, HasSubstr(",0.010\n"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(output.out.begin(), output.out.end(), '\n')),
            1 + (run.at("frames").get<std::size_t>() + 9) / 10);
  const ProgramOutput other = RunTandem("contact --voxel 0.001 --body pin --static " + fixed +
                                        " --dynamic " + moving + " --poses " + poses);
  EXPECT_EQ(other.exit_code, kExitFile);
  EXPECT_THAT(other.err, HasSubstr("name the body with --body; it has peg"));
}

TEST_F(ReplayCommand, SinglePeerSessionHasNoNetwork) {
  const std::string network = " --as-network " + File("line.csv");
  ExpectRefused(File("run") + network, kExitFailed, "the recording has no messages of a peer");
  ExpectRefused(File("run") + " --as-network " + File("run"), kExitUsage, "recording itself");
  ExpectRefused(File("none") + network, kExitFile, "none");
  ExpectRefused(File("run") + " --from ben", kExitUsage, "--as-network");
  EXPECT_FALSE(fs::exists(File("line.csv")));
}

TEST_F(ReplayCommand, IsShownToViewersAtItsSpeed) {
  const std::string session = NewSession();
  ChildProcess watch =
      Start("watch --interface lo --session " + session + " --report " + File("watched"));
  const json replayed = Replayed(File("run") + " --speed 2 --interface lo --session " + session);
  EXPECT_EQ(replayed.at("identical"), true);
  const double frames = replayed.at("frames").get<double>();
  EXPECT_GE(replayed.at("wall_s").get<double>(), 1e-3 * frames / 2);
  watch.Signal(SIGTERM);
  EXPECT_EQ(watch.Wait(std::chrono::seconds(20)), 0);
  std::ifstream stream(File("watched"));
  const json watched = json::parse(stream, nullptr, false);
  EXPECT_EQ(watched.at("peers_seen"), 1);
  EXPECT_GT(watched.at("samples").get<int>(), 100);
}

TEST_F(ReplayCommand, IsDistinguishedFromALivePeer) {
  const std::string session = NewSession();
  ChildProcess replay =
      Start("replay --speed 0.2 " + File("run") + " --interface lo --session " + session);
  const ProgramOutput watched = RunTandem("watch --interface lo --seconds 4 --session " + session);
  EXPECT_THAT(watched.err, HasSubstr("anna (replay) joined"));
  replay.Signal(SIGTERM);
  EXPECT_TRUE(replay.Wait(std::chrono::seconds(20)));
}

// The recorded path is that of another machine, or of another day.
TEST_F(ReplayCommand, FindsItsMovedScene) {
  const ScratchFolder before;
  fs::path scene;
  for (const auto& entry : fs::recursive_directory_iterator(kScenes)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("peg", 0) != 0 && name.rfind("slot", 0) != 0) continue;
    if (!entry.is_regular_file()) continue;
    const fs::path to = before.path() / fs::relative(entry.path(), kScenes);
    fs::create_directories(to.parent_path());
    fs::copy_file(entry.path(), to);
    if (name == "peg_in_slot.json") scene = to;
  }
  const ProgramOutput output =
      RunTandem("peer --interface lo --capacity 20000 --hold peg --scene " + scene.string() +
                " --seconds 0.5 --session " + NewSession() + " --record " + File("elsewhere"));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  fs::remove_all(before.path());
  const ProgramOutput replayed = RunTandem("replay " + File("elsewhere"), "timeout 60 ");
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_THAT(replayed.err, HasSubstr(std::string("scene found in ") + kScenes));
}

TEST_F(ReplayCommand, ReportsWhereItSearchedForAMissingScene) {
  const ScratchFolder before;
  const std::string scene = testing::WriteKeyScene(before, 0.0004, 0.0005);
  const ProgramOutput output =
      RunTandem("peer --interface lo --capacity 20000 --hold key --scene " + scene +
                " --seconds 0.2 --session " + NewSession() + " --record " + File("gone"));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  fs::remove_all(before.path());
  const ProgramOutput replayed = RunTandem("replay " + File("gone"), "timeout 60 ");
  EXPECT_EQ(replayed.exit_code, kExitFile);
  EXPECT_THAT(replayed.err, HasSubstr(scene + ": "));
  EXPECT_THAT(replayed.err, HasSubstr("no file with its content is in "));
  EXPECT_THAT(replayed.err, HasSubstr("give its place with --scene"));
}

/// Returns the bytes of a recording with other words in its header.
std::string WithOtherHeader(const std::string& file,
                            const std::function<void(nlohmann::ordered_json&)>& change) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  constexpr std::size_t kLine = 19;  // "tandem-recording 2\n"
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes[kLine], sizeof length);
  auto header = nlohmann::ordered_json::parse(bytes.substr(kLine + 4, length));
  change(header);
  const std::string text = header.dump();
  const auto new_length = static_cast<std::uint32_t>(text.size());
  std::memcpy(&bytes[kLine], &new_length, sizeof new_length);
  return bytes.replace(kLine + 4, length, text);
}

// A stranger's recording could have voxels that fill the memory.
TEST_F(ReplayCommand, UnusualVoxelSizesNeedTheUsersConsent) {
  const auto changed = [](double factor) {
    std::ofstream(File("voxels"), std::ios::binary)
        << WithOtherHeader(File("run"), [&](nlohmann::ordered_json& header) {
             header["voxel_size"] = factor * header["voxel_size"].get<double>();
           });
    return File("voxels");
  };
  ExpectRefused(changed(0.2), kExitFile, "they differ by more than a factor of 4");
  ExpectRefused(changed(1e-6), kExitFile, "--adopt-any takes the recorded voxel size");
  const std::string coarse = changed(5);
  ExpectRefused(coarse, kExitFile, "they differ by more than a factor of 4");
  const ProgramOutput taken = RunTandem("replay --adopt-any " + coarse, "timeout 60 ");
  EXPECT_THAT(taken.err, HasSubstr("as recorded by version"));
}

// A stranger's recording could name any file of the user's.
TEST_F(ReplayCommand, OpensOnlySceneFilesThatARecordingNames) {
  std::ofstream(File("secret.txt")) << "secret";
  std::ofstream(File("named"), std::ios::binary)
      << WithOtherHeader(File("run"), [](nlohmann::ordered_json& header) {
           header["scene"] = File("secret.txt");
           header["scene_hash"] = 1;
         });
  ExpectRefused(
      File("named"), kExitFile,
      "secret.txt: is not a scene file (.json, at most 4 MB) (no file with its content is in ");
}

// Active peers would take the replay for an active peer that answers for bodies and is deaf.
TEST_F(ReplayCommand, IsNotShownBesideActivePeers) {
  const std::string session = NewSession();
  const std::string shown = File("run") + " --interface lo --session " + session;
  const std::string refusal =
      "ben takes part in session " + session + ": a replay is shown in a session of its own";
  ChildProcess replay = Start("replay --speed 0.01 " + shown);
  ChildProcess ben = Start(kPegScene + " --name ben --session " + session);
  EXPECT_EQ(replay.Wait(std::chrono::seconds(20)), kExitNetwork);
  ExpectRefused(shown, kExitNetwork, refusal);
  ben.Signal(SIGTERM);
  EXPECT_EQ(ben.Wait(std::chrono::seconds(20)), 0);
}

TEST_F(ReplayCommand, TruncatedFileReplaysToItsEnd) {
  const auto size = fs::file_size(File("run"));
  fs::copy_file(File("run"), File("torn"));
  fs::resize_file(File("torn"), size - 1);  // half of it may end where a frame does
  const json torn = Replayed(File("torn"));
  EXPECT_EQ(torn.at("torn"), true);
  EXPECT_EQ(torn.at("damaged"), false);
  EXPECT_EQ(torn.at("identical"), true);
  EXPECT_EQ(torn.at("frames").get<int>(), Replayed(File("run")).at("frames").get<int>() - 1);
}

TEST_F(ReplayCommand, DamagedFileIsReported) {
  fs::copy_file(File("run"), File("damaged"));
  const auto size = fs::file_size(File("damaged"));
  std::fstream stream(File("damaged"), std::ios::binary | std::ios::in | std::ios::out);
  stream.seekg(static_cast<std::streamoff>(size / 2));
  const int before = stream.get();
  stream.seekp(static_cast<std::streamoff>(size / 2));
  stream.put(static_cast<char>(before ^ 1));
  stream.close();
  const ProgramOutput output = RunTandem("replay --json " + File("damaged"), "timeout 60 ");
  EXPECT_EQ(output.exit_code, kExitFailed);
  const json result = json::parse(output.out, nullptr, false);
  ASSERT_TRUE(result.is_object()) << output.out;
  EXPECT_EQ(result.at("damaged"), true);
  EXPECT_EQ(result.at("torn"), false);
  const auto unread = result.at("unread_bytes").get<std::uintmax_t>();
  EXPECT_GE(unread, size - size / 2);
  EXPECT_LT(unread, size - size / 2 + 20000) << "one frame's worth beside what is behind";
  EXPECT_THAT(output.err, HasSubstr("damaged at frame " + result.at("frames").dump() + ", " +
                                    std::to_string(unread) + " bytes were not replayed"));
}

TEST_F(ReplayCommand, RecordingOfAKilledPeerReplays) {
  const std::string file = File("killed");
  ChildProcess peer = Start(kPegScene + " --session " + NewSession() + " --record " + file);
  // wait until the file has more than half of the first one's length
  const auto enough = fs::file_size(File("run")) / 2;
  std::error_code none;
  for (int i = 0; i < 4000 && (!fs::exists(file) || fs::file_size(file, none) < enough); ++i) {
    ASSERT_FALSE(peer.Wait(std::chrono::milliseconds(5)));
  }
  peer.Signal(SIGKILL);
  EXPECT_EQ(peer.Wait(std::chrono::seconds(10)), 128 + SIGKILL);
  const json replayed = Replayed(file);
  EXPECT_EQ(replayed.at("identical"), true);
  EXPECT_GT(replayed.at("frames").get<int>(), 1000);
}

TEST_F(ReplayCommand, OtherSceneOrFileIsRefused) {
  ExpectRefused(File("run") + " --scene " + kScenes + "/ball_and_socket.json", kExitFile,
                "is not the recorded scene");
  ExpectRefused(File("run") + " --scene /nowhere.json", kExitFile, "/nowhere.json");
  ExpectRefused("/nowhere", kExitFile, "/nowhere: there is no such file");
  ExpectRefused(std::string(kScenes) + "/peg_in_slot.json", kExitFile, "is not a recording");
  ExpectRefused(File("run") + " --export /nowhere/out.mcap", kExitFile, "/nowhere/out.mcap");
  ExpectRefused(File("run") + " --session s --interface nosuch0", kExitNetwork, "nosuch0");
  ExpectRefused(File("run") + " --session s --secure " + folder_->path().string(), kExitSecurity,
                "is missing");
  EXPECT_EQ(RunTandem("replay").exit_code, kExitUsage);
  EXPECT_EQ(RunTandem("replay " + File("run") + " --speed -1").exit_code, kExitUsage);
  EXPECT_EQ(RunTandem("replay " + File("run") + " --threads 0").exit_code, kExitUsage);
}

// A byte in the middle is changed and its frame's checksum set right again. The replay names the
// frame.
TEST_F(ReplayCommand, ChangedInputIsNamedByItsFrame) {
  std::ifstream stream(File("run"), std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const auto number = [&bytes](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes[at], sizeof value);
    return value;
  };
  constexpr std::size_t kLine = 19;  // "tandem-recording 1\n"
  std::size_t at = kLine + 4 + number(kLine);
  for (int frame = 0; frame < 1765; ++frame) {
    at += 8 + number(at);
    ASSERT_LT(at + 8, bytes.size()) << "only " << frame << " frames were recorded";
  }
  const std::uint32_t length = number(at);
  // from the end: the hash, 8, its mark, 1, then the device's twist, its last number's sign
  bytes[at + 8 + length - 10] = static_cast<char>(bytes[at + 8 + length - 10] ^ 0x80);
  std::uint32_t crc = ~0U;
  for (std::size_t i = at + 8; i < at + 8 + length; ++i) {
    crc ^= static_cast<unsigned char>(bytes[i]);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xEDB88320U : crc >> 1U;
  }
  crc = ~crc;
  std::memcpy(&bytes[at + 4], &crc, sizeof crc);
  std::ofstream(File("changed"), std::ios::binary) << bytes;
  const ProgramOutput output = RunTandem("replay --json " + File("changed"), "timeout 60 ");
  EXPECT_EQ(output.exit_code, kExitFailed);
  EXPECT_THAT(output.err, HasSubstr("frame 1765 is the first that differs"));
  EXPECT_EQ(json::parse(output.out).at("first_different"), 1765);
}

TEST_F(ReplayCommand, ExportsAnMcapFile) {
  const ProgramOutput output = RunTandem("replay " + File("run") + " --export " + File("out.mcap"));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(output.err, HasSubstr("out.mcap: "));
  std::ifstream stream(File("out.mcap"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x89MCAP0\r\n", 8));
  EXPECT_THAT(bytes, HasSubstr("/bodies/peg/pose"));
}

TEST_F(ReplayCommand, ExportOfAnUnknownKindIsRefused) {
  for (const char* name : {"out.xlsx", "out.csv.gz", "out.txt"}) {
    ExpectRefused(File("run") + " --export " + File(name), kExitUsage,
                  "expected the name of a file that ends in .csv or .mcap");
    EXPECT_FALSE(fs::exists(File(name)));
  }
  ExpectRefused(File("run") + " --as-network " + File("out.json"), kExitUsage, "ends in .csv");
}

TEST_F(ReplayCommand, RecordingIsNeverOverwritten) {
  const auto size = fs::file_size(File("run"));
  const ProgramOutput output =
      RunTandem(kPegScene + " --seconds 1 --session " + NewSession() + " --record " + File("run"));
  EXPECT_EQ(output.exit_code, kExitFile);
  EXPECT_EQ(output.err,
            "tandem: " + File("run") + " exists already: recordings are never overwritten\n");
  EXPECT_EQ(fs::file_size(File("run")), size);
}

TEST_F(ReplayCommand, DoesNotOverwriteTheRecordingByAnExport) {
  fs::copy_file(File("run"), File("kept"));
  fs::create_symlink(File("kept"), File("link"));
  const auto size = fs::file_size(File("kept"));
  for (const char* name : {"kept", "link"}) {
    ExpectRefused(File("kept") + " --export " + File(name), kExitUsage, "is the recording itself");
    ASSERT_EQ(fs::file_size(File("kept")), size);
  }
}

}  // namespace
}  // namespace tandem
