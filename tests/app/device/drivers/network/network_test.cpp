// The driver `network` against a device program on this machine, by UDP. What a session refuses,
// and why, is in session_test.cpp.
//
// | fault | test |
// |---|---|
// | no device; wrong key, address, option | OpenReportsWhatIsMissing |
// | loss, reordering, duplicates | SurvivesLossReorderingAndDuplicates |
// | a loop that hangs | HungLoopInvalidatesTheForce |
// | a device that is silent, and goes on | SilentDeviceIsUnpluggedAndCanReturn |
// | a device that says goodbye; that begins anew | DeviceMayLeaveAndRestart |
// | replays and forgeries while it works | ForgeriesAndReplaysChangeNothing |
// | another port | KeyedDeviceMayChangeItsAddress |
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/network/far_end.h"
#include "tests/support/scratch_folder.h"

extern char** environ;

namespace tandem::testing {
namespace {

int FreePort() {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof here;
  EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&here), length), 0);
  EXPECT_EQ(getsockname(socket, reinterpret_cast<sockaddr*>(&here), &length), 0);
  close(socket);
  return ntohs(here.sin_port);
}

std::string KeyFile(const std::filesystem::path& folder, const std::string& text, mode_t mode) {
  const std::string file = folder / "device.key";
  std::ofstream(file) << text;
  EXPECT_EQ(chmod(file.c_str(), mode), 0);
  return file;
}

net::Key KeyOf(const std::string& text) {
  return net::Key(std::vector<std::uint8_t>(text.begin(), text.end()));
}

const std::string kSecret = "0123456789abcdef0123456789abcdef";

struct NetworkTrial {
  explicit NetworkTrial(bool keyed = false) : port(FreePort()) {
    options = "listen=127.0.0.1:" + std::to_string(port);
    if (keyed) {
      key = KeyOf(kSecret);
      options += ",key=" + KeyFile(folder.path(), kSecret + "\n", 0600);
    }
    far = std::make_unique<FarEnd>(port, key, 7, 0.1);
    trial.SetTake([this](TandemDeviceForce& force) {
      force.force[0] = fx.load();
      force.force[1] = 2;
      force.moment[2] = 0.5;
    });
    EXPECT_EQ(trial.Open(options), TANDEM_OK) << trial.Error();
    if (trial.device() != nullptr) {
      EXPECT_EQ(trial.Start(), TANDEM_OK);
    }
  }
  bool Reads(std::int32_t code) {
    trial.Ticks(1);
    return trial.TicksUntil([&] {
      return trial.read() == code;
    });
  }
  bool IsAt(double x) {
    return trial.TicksUntil([&] {
      return trial.read() >= 0 && trial.position().x() == x;
    });
  }
  bool FeelsX(double x) {
    return trial.TicksUntil([&] {
      return far->force().force[0] == x;
    });
  }

  ScratchFolder folder;
  int port;
  std::string options;
  net::Key key;
  std::atomic<double> fx{1};
  std::unique_ptr<FarEnd> far;
  DriverTrial trial{"network"};  // goes first
};

TEST(Network, StartsMovesAndGivesForce) {
  for (const bool keyed : {false, true}) {
    NetworkTrial it(keyed);
    ASSERT_TRUE(it.IsAt(0.1));
    EXPECT_EQ(it.trial.position(), Vec3(0.1, 0.2, 0.3));
    const TandemDeviceCapabilities can = it.trial.Capabilities();
    EXPECT_EQ(can.freedoms_in, 6U);
    EXPECT_EQ(can.freedoms_out, 3U);
    EXPECT_EQ(can.peak_force, 8);
    EXPECT_NE(can.asks, 0U);
    it.far->SetX(0.4);
    EXPECT_TRUE(it.IsAt(0.4));
    ASSERT_TRUE(it.FeelsX(1));
    EXPECT_EQ(it.far->force().force[1], 2);
    EXPECT_EQ(it.far->force().moment[2], 0.5);
    it.fx = -3;
    ASSERT_TRUE(it.FeelsX(-3));
    it.trial.Ticks(500);
    const Histogram ages = it.far->ages();
    const std::string key = keyed ? "keyed" : "open";
    RecordProperty(key + "_forces", static_cast<int>(ages.count()));
    RecordProperty(key + "_age_p50_us", static_cast<int>(ages.Quantile(0.5) / 1000));
    RecordProperty(key + "_age_p99_us", static_cast<int>(ages.Quantile(0.99) / 1000));
    it.trial.ExpectRealtime();
    it.trial.Close();
    ASSERT_EQ(it.trial.output().size(), 1U);
  }
}

TEST(Network, SurvivesLossReorderingAndDuplicates) {
  NetworkTrial it;
  ASSERT_TRUE(it.IsAt(0.1));
  it.far->SetNetwork({.loss = 0.3, .twice = 0.3, .swapped = 0.3});
  // x rises: a packet in a wrong order must not take it back
  double highest = 0.1;
  int unplugged = 0;
  for (int i = 0; i < 1000; ++i) {
    it.far->SetX(0.1 + 0.001 * i);
    it.trial.Ticks(1);
    unplugged += it.trial.read() < 0 ? 1 : 0;
    EXPECT_GE(it.trial.position().x(), highest);
    highest = std::max(highest, it.trial.position().x());
  }
  EXPECT_GT(highest, 0.9);
  EXPECT_LT(unplugged, 300);  // only where this machine stood still
  EXPECT_TRUE(it.FeelsX(1));
  it.trial.ExpectRealtime();
}

TEST(Network, HungLoopInvalidatesTheForce) {
  NetworkTrial it;
  ASSERT_TRUE(it.FeelsX(1));
  // the loop stands; the driver's thread goes on, but no force follows from a new state
  const std::uint64_t forces = it.far->forces();
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_EQ(it.far->force().force[0], 0);
  EXPECT_GT(it.far->forces(), forces + 10);
  EXPECT_TRUE(it.FeelsX(1));
}

TEST(Network, SilentDeviceIsUnpluggedAndCanReturn) {
  NetworkTrial it;
  ASSERT_TRUE(it.FeelsX(1));
  it.far->SetSilent(true);
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  EXPECT_TRUE(it.trial.TicksUntil([&] {
    return it.trial.Error().find("silent") != std::string::npos;
  })) << it.trial.Error();
  EXPECT_TRUE(it.FeelsX(0));
  EXPECT_EQ(it.trial.position().x(), 0.1);
  it.far->SetX(0.7);
  it.far->SetSilent(false);
  EXPECT_TRUE(it.IsAt(0.7));
  EXPECT_TRUE(it.FeelsX(1));
}

TEST(Network, DeviceMayLeaveAndRestart) {
  NetworkTrial it(true);
  ASSERT_TRUE(it.FeelsX(1));
  it.far->End();
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  EXPECT_NE(it.trial.Error().find("has ended"), std::string::npos) << it.trial.Error();
  it.far.reset();
  it.far = std::make_unique<FarEnd>(it.port, it.key, 8, -0.2);
  EXPECT_TRUE(it.IsAt(-0.2));
  EXPECT_TRUE(it.FeelsX(1));
  // killed, without goodbye
  it.far.reset();
  ASSERT_TRUE(it.Reads(TANDEM_UNPLUGGED));
  it.far = std::make_unique<FarEnd>(it.port, it.key, 9, -0.3);
  EXPECT_TRUE(it.IsAt(-0.3));
  it.trial.ExpectRealtime();
}

TEST(Network, ForgeriesAndReplaysChangeNothing) {
  NetworkTrial it(true);
  ASSERT_TRUE(it.IsAt(0.1));
  it.far->SetX(0.2);
  ASSERT_TRUE(it.IsAt(0.2));
  it.trial.Ticks(20);
  const std::deque<Bytes> received = it.far->sent();  // hello and all
  DeviceEnd forger({}, 7);
  for (const bool own : {false, true}) {
    for (const Bytes& packet : received) {
      it.far->Inject(packet, own);
      Bytes forged = packet;
      forged[60] ^= 0x10U;
      it.far->Inject(forged, own);
      it.far->Inject(Bytes(300, 7), own);
      it.far->Inject(forger.Hello(1), own);
      it.trial.Ticks(1);
      EXPECT_GE(it.trial.read(), 0);
      EXPECT_EQ(it.trial.position().x(), 0.2);
    }
  }
  EXPECT_TRUE(it.FeelsX(1));
  it.trial.Close();
  ASSERT_EQ(it.trial.output().size(), 1U);
  EXPECT_NE(it.trial.output()[0].find("packets were refused"), std::string::npos);
}

TEST(Network, KeyedDeviceMayChangeItsAddress) {
  NetworkTrial keyed(true);
  ASSERT_TRUE(keyed.IsAt(0.1));
  keyed.far->Move();
  keyed.far->SetX(0.3);
  EXPECT_TRUE(keyed.IsAt(0.3));
  EXPECT_TRUE(keyed.FeelsX(1));
  NetworkTrial open;
  ASSERT_TRUE(open.IsAt(0.1));
  open.far->Move();
  open.far->SetX(0.3);
  EXPECT_TRUE(open.Reads(TANDEM_UNPLUGGED));
  EXPECT_NE(open.trial.position().x(), 0.3);
}

TEST(Network, StopRemovesTheForceUntilTheNextWrite) {
  NetworkTrial it;
  ASSERT_TRUE(it.FeelsX(1));
  const std::uint64_t before = it.far->forces();
  it.trial.Stop();
  for (int i = 0; i < 200 && it.far->forces() < before + 2; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(it.far->force().force[0], 0);
  EXPECT_TRUE(it.FeelsX(1));
  it.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(it.FeelsX(0));  // a force that is no number is none
  it.fx = 1;
  EXPECT_TRUE(it.FeelsX(1));
  it.trial.Close();
  for (int i = 0; i < 500 && !it.far->host_ended(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(it.far->host_ended());
  EXPECT_EQ(it.far->force().force[0], 0);
}

TEST(Network, OpenReportsWhatIsMissing) {
  const ScratchFolder folder;
  const auto refused = [](const std::string& options) {
    DriverTrial trial("network");
    EXPECT_EQ(trial.Open(options), TANDEM_FAILED) << options;
    return trial.Error();
  };
  const auto has = [](const std::string& text, const char* word) {
    return text.find(word) != std::string::npos ? ::testing::AssertionSuccess()
                                                : ::testing::AssertionFailure() << text;
  };
  const std::string listen = "listen=127.0.0.1:" + std::to_string(FreePort());
  EXPECT_TRUE(has(refused(listen + ",wait=0.05"), "no device has connected"));
  EXPECT_TRUE(has(refused("listen=here"), "ADDRESS:PORT"));
  EXPECT_TRUE(has(refused("listen=::1:47111"), "ADDRESS:PORT"));
  EXPECT_TRUE(has(refused("listen=0.0.0.0:47111"), "the driver needs a key"));
  EXPECT_TRUE(has(refused("listen=[::]:47111"), "the driver needs a key"));
  EXPECT_TRUE(has(refused("listen=203.0.113.7:47111"), "the driver needs a key"));
  EXPECT_TRUE(has(refused(listen + ",wait=forever"), "a number from 0"));
  EXPECT_TRUE(has(refused(listen + ",key=/nowhere/key"), "make a key"));
  EXPECT_TRUE(has(refused(listen + ",key=/dev/null"), "is not a file"));
  EXPECT_TRUE(has(refused(listen + ",key=" + KeyFile(folder.path(), kSecret, 0640)), "chmod 600"));
  EXPECT_TRUE(
      has(refused(listen + ",key=" + KeyFile(folder.path(), "short\n", 0600)), "16 to 4096"));
  const std::string key = KeyFile(folder.path(), kSecret, 0600);
  EXPECT_TRUE(has(refused("listen=203.0.113.7:47111,key=" + key), "address of this machine"));
  const int port = FreePort();
  FarEnd wrong(port, KeyOf("another secret of the far end"), 7, 0);
  EXPECT_TRUE(has(refused("listen=127.0.0.1:" + std::to_string(port) + ",wait=0.3,key=" + key),
                  "give both ends the same key"));
}

TEST(Network, ListShowsACallingDevice) {
  const DriverTrial trial("network");
  const std::vector<TandemDeviceFound> found = trial.List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_NE(std::string(found[0].mend).find("network_device.py"), std::string::npos);
}

// The examples in Python are written from the document alone.
TEST(Network, PythonExamplesWorkAsDevices) {
  if (!std::filesystem::exists("/usr/bin/python3")) GTEST_SKIP() << "no python3";
  for (const auto& [example, keyed] :
       {std::pair("smallest_device.py", false), std::pair("network_device.py", false),
        std::pair("network_device.py", true)}) {
    const ScratchFolder folder;
    const std::string port = std::to_string(FreePort());
    const std::string key = KeyFile(folder.path(), kSecret + "\n", 0600);
    std::vector<std::string> words{"python3", std::string(TANDEM_EXAMPLES "/device/") + example,
                                   "127.0.0.1:" + port};
    if (keyed) words.push_back(key);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const std::string output = folder.path() / "said";
    posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_CREAT | O_WRONLY, 0600);
    pid_t python = -1;
    ASSERT_EQ(
        posix_spawn(&python, "/usr/bin/python3", &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    const std::unique_ptr<pid_t, void (*)(pid_t*)> ends(&python, [](pid_t* process) {
      if (*process > 0) kill(*process, SIGKILL);
    });
    {
      DriverTrial trial("network");
      trial.SetTake([](TandemDeviceForce& force) {
        force.force[0] = 1.25;
      });
      ASSERT_EQ(trial.Open("listen=127.0.0.1:" + port + (keyed ? ",key=" + key : "")), TANDEM_OK)
          << trial.Error();
      ASSERT_EQ(trial.Start(), TANDEM_OK);
      ASSERT_TRUE(trial.TicksUntil([&] {
        return trial.position().norm() > 0.01;
      }));
      const Vec3 before = trial.position();
      EXPECT_TRUE(trial.TicksUntil([&] {
        return (trial.position() - before).norm() > 0.005;
      }));
      trial.Ticks(300);
    }
    int status = -1;
    ASSERT_EQ(waitpid(python, &status, 0), python);  // it ends when Tandem does
    python = -1;
    EXPECT_EQ(status, 0);
    std::ifstream file(output);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(text.find("1.25"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace tandem::testing
