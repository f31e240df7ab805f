#include <QCoreApplication>
#include <QDir>
#include <QElapsedTimer>
#include <QFile>
#include <QProcess>
#include <QTemporaryDir>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "collab/controller/controller.h"
#include "tests/app/view/x_mouse.h"

// Goes a person's way through the program, by mouse and keys of the X server alone. The tests see
// what happens on the screen and, by an onlooker of the controller, in numbers.

namespace tandem {
namespace {

constexpr int kPatience = 60'000;  // ms
constexpr double kActuatorLength = 0.216;

bool IsOrange(QRgb c) {
  return qRed(c) > 90 && qRed(c) > qGreen(c) + 30 && qGreen(c) > qBlue(c) + 10;
}

/// A window with a controller of its own, and an onlooker.
class OpenWindow {
 public:
  explicit OpenWindow(const QStringList& arguments) {
    process_.setProcessChannelMode(QProcess::ForwardedChannels);
    process_.start(TANDEM_PROGRAM, arguments);
    started_ = process_.waitForStarted();
  }
  ~OpenWindow() { Close(); }
  bool started() const { return started_; }
  QProcess& process() { return process_; }
  // the controller's name begins with it, and digits follow that nobody guesses
  std::string control() const { return "window-" + std::to_string(process_.processId()); }

  bool Attach() {
    Controller::Options options;
    options.host = "test";
    options.timeout_s = 0.2;
    QElapsedTimer waited;
    waited.start();
    while (waited.elapsed() < 20'000) {
      Result<Controller> found = Controller::Attach(control(), options);
      if (found) {
        controller_.emplace(*std::move(found));
        return true;
      }
      why_ = found.error().what;
    }
    return false;
  }
  /// Ends looking on: a program looks on at one controller at a time.
  void Detach() { controller_.reset(); }
  /// Returns why it could not attach.
  const std::string& why() const { return why_; }
  const ControllerSnapshot& now() {
    controller_->Poll();
    return controller_->snapshot();
  }
  bool Until(const std::function<bool(const ControllerSnapshot&)>& done, int ms = 10'000) {
    QElapsedTimer clock;
    clock.start();
    if (!controller_ && !Attach()) return false;
    while (!done(now())) {
      if (clock.elapsed() > ms) return false;
      controller_->Wait(std::chrono::milliseconds(5));
    }
    return true;
  }
  const SnapshotBody& Body(const char* name) {
    const auto& bodies = now().bodies;
    return *std::find_if(bodies.begin(), bodies.end(), [name](const SnapshotBody& body) {
      return body.name == name;
    });
  }
  bool AskControllerToQuit() { return controller_ && controller_->Ask(QuitRequest{}, 5).ok; }
  void Close() {
    controller_.reset();
    if (process_.state() == QProcess::NotRunning) return;
    process_.terminate();
    if (!process_.waitForFinished(15'000)) process_.kill();
  }

 private:
  QProcess process_;
  bool started_ = false;
  std::string why_;
  std::optional<Controller> controller_;
};

class Person : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(mouse_.ready()) << "no X server with XTEST: run under xvfb-run";
    ASSERT_TRUE(folder_.isValid());
  }
  /// Waits until that many windows are there.
  bool WindowsAre(std::size_t count) {
    QElapsedTimer clock;
    clock.start();
    while (mouse_.Windows().size() != count) {
      if (clock.elapsed() > kPatience) return false;
      QThreadSleep();
    }
    return true;
  }
  static void QThreadSleep() { usleep(20'000); }
  /// Saves a picture for a person who wants to see how far a test has come.
  void TearDown() override {
    if (HasFailure()) Keep("failed.png");
  }
  /// Returns a place a few pixels below the highest of the actuator within a part of the screen,
  /// where one can take hold of it. Returns nothing if none is seen.
  std::optional<QPoint> ActuatorsTop(const QRect& within) {
    const QImage screen = mouse_.Screen();
    for (int y = within.top(); y <= within.bottom(); ++y) {
      int first = -1;
      int last = -1;
      int count = 0;
      for (int x = within.left(); x <= within.right(); ++x) {
        if (!IsOrange(screen.pixel(x, y))) continue;
        if (first < 0) first = x;
        last = x;
        ++count;
      }
      if (count < 4) continue;
      // the eye is a ring: its rim, below the very top
      const QPoint at((first + last) / 2, y + 3);
      if (IsOrange(screen.pixel(at))) return at;
    }
    return std::nullopt;
  }
  std::optional<QPoint> WaitForActuator(const QRect& within) {
    QElapsedTimer clock;
    clock.start();
    while (clock.elapsed() < kPatience) {
      if (const auto at = ActuatorsTop(within)) return at;
      QThreadSleep();
    }
    return std::nullopt;
  }
  /// Presses on the actuator until it is held, and returns where, or nothing. The picture may still
  /// be on its way to its new size, or the window may not have heard of its controller yet.
  std::optional<QPoint> TakeActuator(OpenWindow& window, const QRect& within) {
    QElapsedTimer clock;
    clock.start();
    while (clock.elapsed() < kPatience) {
      const auto top = ActuatorsTop(within);
      if (!top) {
        QThreadSleep();
        continue;
      }
      mouse_.MoveTo(*top);
      mouse_.Press();
      const bool held = window.Until(
          [](const ControllerSnapshot& now) {
            return now.hand.state == SnapshotHand::State::kHolding;
          },
          500);
      if (held) return top;
      mouse_.Release();
    }
    return std::nullopt;
  }
  void Keep(const char* name) {
    const QString folder = qEnvironmentVariable("TANDEM_KEEP_PICTURES");
    if (!folder.isEmpty()) mouse_.Screen().save(folder + "/" + name);
  }
  QString In(const char* file) const { return folder_.filePath(file); }

  XMouse mouse_;
  QTemporaryDir folder_;
  const QRect picture_{0, 60, 900, 660};  // picture of a window alone: without menu, docks, status
};

TEST_F(Person, FeelsContactOfALiftedPart) {
  OpenWindow window({"open", "bracket_actuator", "--name", "anna"});
  ASSERT_TRUE(window.started());
  ASSERT_TRUE(WaitForActuator(picture_).has_value());
  ASSERT_TRUE(window.Attach()) << window.why();
  const auto top = TakeActuator(window, picture_);
  ASSERT_TRUE(top.has_value());
  mouse_.DragTo(*top + QPoint(0, -60), 6, 5);
  ASSERT_TRUE(window.Until([](const ControllerSnapshot& now) {
    const auto& f = now.hand.force_N;
    return now.contact_points > 0 && std::abs(f[2]) > 0.5;
  }));
  usleep(500'000);
  Keep("drag-contact.png");
  mouse_.Release();
}

TEST_F(Person, RemovesTheActuatorInContact) {
  const QString report = In("report.json");
  {
    OpenWindow window(
        {"open", "bracket_actuator", "--name", "anna", "--peer-options", "--report " + report});
    ASSERT_TRUE(WindowsAre(1));
    ASSERT_TRUE(window.Attach()) << window.why();
    mouse_.Focus(mouse_.Windows().back());
    ASSERT_TRUE(WaitForActuator(picture_));
    usleep(500'000);
    mouse_.MoveTo({400, 200});
    mouse_.Key("1");  // from the front
    usleep(700'000);
    const auto top = TakeActuator(window, picture_);
    ASSERT_TRUE(top.has_value());
    // up against the web, then a quarter turn along it, half a degree a pixel
    mouse_.DragTo(*top + QPoint(0, -22), 1, 30);
    EXPECT_TRUE(window.Until([](const ControllerSnapshot& now) {
      return now.contact_points > 0;
    }));
    Keep("pressed.png");
    mouse_.KeyDown("Control_L");
    mouse_.DragTo(*top + QPoint(180, -22), 2, 25);
    mouse_.KeyUp("Control_L");
    EXPECT_TRUE(window.Until([](const ControllerSnapshot& now) {
      return std::abs(now.hand.X_WG.q_W[2]) > 0.69;
    }));
    Keep("turned.png");
    // up and out
    while (window.Body("actuator").X_W.p_W[2] < kActuatorLength && mouse_.at().y() > 70) {
      mouse_.DragTo(mouse_.at() - QPoint(0, 10), 2, 25);
    }
    EXPECT_TRUE(window.Until([&](const ControllerSnapshot&) {
      return window.Body("actuator").X_W.p_W[2] > 0.14;
    }));
    usleep(500'000);
    Keep("out.png");
    mouse_.Release();
    // a signal would leave its controller a second or three, too few for a verdict on a busy
    // machine
    EXPECT_TRUE(window.AskControllerToQuit());
    for (int i = 0; i < 3000 && !QFile::exists(report); ++i) usleep(10'000);
    window.Close();
  }
  QFile file(report);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  const nlohmann::json output = nlohmann::json::parse(file.readAll().toStdString());
  const nlohmann::json& verdict = output.at("verdicts").at(0);
  SCOPED_TRACE(verdict.dump());
  EXPECT_EQ(verdict.at("body"), "actuator");
  EXPECT_TRUE(verdict.at("out").get<bool>());
  EXPECT_TRUE(verdict.at("met").get<bool>());
  EXPECT_GT(verdict.at("poses_judged").get<int>(), 100);
  EXPECT_LE(verdict.at("deepest_mm").get<double>(), 0.5);  // half a voxel of 1 mm
}

/// Returns the process that runs with these words in a row among its arguments; 0: there is none.
pid_t ProcessWith(const std::string& words) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ostringstream line;
    line << std::ifstream(entry.path() / "cmdline").rdbuf();
    if (line.str().find(words) != std::string::npos) return static_cast<pid_t>(std::stol(name));
  }
  return 0;
}

TEST_F(Person, KilledWindowLeavesNoTemporaryFiles) {
  const QByteArray before = qgetenv("TMPDIR");
  qputenv("TMPDIR", folder_.path().toUtf8());
  OpenWindow window({"open", "bracket_actuator", "--name", "anna"});
  before.isNull() ? qunsetenv("TMPDIR") : qputenv("TMPDIR", before);
  ASSERT_TRUE(window.started());
  ASSERT_TRUE(window.Attach()) << window.why();
  using namespace std::string_literals;
  const pid_t view = ProcessWith("bracket_actuator.json\0--control\0"s + window.control() + "-");
  ASSERT_GT(view, 0);
  // a program that watches the window would start another view
  window.process().kill();
  ASSERT_TRUE(window.process().waitForFinished(15'000));
  ASSERT_EQ(kill(view, SIGKILL), 0);
  ASSERT_TRUE(WindowsAre(0));
  // a folder of Qt's own is no fault of ours
  EXPECT_EQ(QDir(folder_.path()).entryList({"tandem*"}).join(' ').toStdString(), "");
  EXPECT_TRUE(window.AskControllerToQuit());  // it goes on without its window
}

// A stopped process hears no request and no signal but SIGKILL.
TEST_F(Person, SignalEndsAWindowAndItsSuspendedController) {
  OpenWindow window({"open", "bracket_actuator", "--name", "anna"});
  ASSERT_TRUE(window.started());
  ASSERT_TRUE(window.Attach()) << window.why();
  window.Detach();
  using namespace std::string_literals;
  const std::string words = "\0peer\0--control\0"s + window.control() + "-";
  const pid_t controller = ProcessWith(words);
  ASSERT_GT(controller, 0);
  ASSERT_EQ(kill(controller, SIGSTOP), 0);
  usleep(700'000);  // the window has missed it
  window.process().terminate();
  EXPECT_TRUE(window.process().waitForFinished(15'000));
  QElapsedTimer clock;
  clock.start();
  while (ProcessWith(words) != 0 && clock.elapsed() < 5000) QThreadSleep();
  EXPECT_EQ(ProcessWith(words), 0) << "the controller is left behind";
  kill(controller, SIGKILL);
}

TEST_F(Person, TwoWindowsHoldThePartAt100MillisecondsDelay) {
  const QString session = QStringLiteral("two-%1").arg(getpid());
  const auto arguments = [&](const char* name) {
    return QStringList{"open", "bracket_actuator", "--session", session,          "--interface",
                       "lo",   "--name",           name,        "--peer-options", "--delay-ms 100"};
  };
  OpenWindow anna(arguments("anna"));
  ASSERT_TRUE(WindowsAre(1));
  const unsigned long left = mouse_.Windows().back();
  ASSERT_TRUE(anna.Attach()) << anna.why();
  anna.Detach();
  OpenWindow ben(arguments("ben"));
  ASSERT_TRUE(WindowsAre(2));
  auto windows = mouse_.Windows();
  const unsigned long right = windows[0] == left ? windows[1] : windows[0];
  ASSERT_TRUE(ben.Attach()) << ben.why();
  ben.Detach();
  // the windows lie one below the other, so that each picture is free
  mouse_.Place(left, {0, 0, 1400, 490});
  mouse_.Place(right, {0, 500, 1400, 490});
  const QRect upper(0, 60, 1000, 400);
  const QRect lower(0, 560, 1000, 400);
  usleep(1'500'000);
  const auto take = [&](OpenWindow& window, const QRect& within, int by_y) {
    const auto at = TakeActuator(window, within);
    if (!at) return false;
    mouse_.DragTo(*at + QPoint(0, by_y), 2, 20);
    mouse_.Release();  // the part stays in hand
    window.Detach();
    return true;
  };
  ASSERT_TRUE(take(anna, upper, -6));
  ASSERT_TRUE(take(ben, lower, 4));
  // each sees the other's instance, and the two pull on one another
  for (OpenWindow* window : {&anna, &ben}) {
    EXPECT_TRUE(window->Until([](const ControllerSnapshot& now) {
      const bool coupled = std::any_of(now.peers.begin(), now.peers.end(), [](const auto& peer) {
        return peer.link_force_N > 0.05 && peer.delay_s > 0.09;
      });
      return coupled && !now.instances.empty();
    }));
    window->Detach();
  }
  usleep(500'000);
  Keep("two-windows.png");
}

}  // namespace
}  // namespace tandem
