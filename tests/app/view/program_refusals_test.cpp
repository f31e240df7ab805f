// Tests what the program says and returns when it cannot do what it is asked for.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/controller/controller.h"
#include "tests/app/view/program_fixture.h"

namespace tandem {
namespace {

TEST_F(Program, EndsInOneLineWithoutADisplay) {
  QProcessEnvironment bare = here_;
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) bare.remove(name);
  EXPECT_EQ(Run({}, bare), 4);
  EXPECT_THAT(output_, ::testing::HasSubstr("no display"));
  EXPECT_EQ(std::count(output_.begin(), output_.end(), '\n'), 1);
  bare.insert("DISPLAY", ":4711");  // nobody listens there
  EXPECT_EQ(Run({}, bare), 4);
  EXPECT_THAT(output_, ::testing::HasSubstr(":4711"));
}

// Qt itself would abort, which a shell reports as a crash.
TEST_F(Program, EndsInOneLineWithoutQtsPlatform) {
  QProcessEnvironment other = here_;
  for (const char* platform : {"wayland", "nosuch", "nosuch:size=3"}) {
    other.insert("QT_QPA_PLATFORM", platform);
    EXPECT_EQ(Run({}, other), 4) << platform;
    EXPECT_THAT(output_, ::testing::HasSubstr(platform));
    EXPECT_THAT(output_, ::testing::HasSubstr("unset QT_QPA_PLATFORM"));
    EXPECT_EQ(std::count(output_.begin(), output_.end(), '\n'), 1) << output_;
  }
}

// A display with keys, of which this program has none.
TEST_F(Program, EndsInOneLineWhereTheDisplayRefusesIt) {
  QProcess xauth;
  xauth.start("xauth", {"-f", In("authority"), "add", ":0", ".", QString(32, 'a')});
  QProcess server;
  server.setStandardErrorFile(QProcess::nullDevice());
  server.start("Xvfb", {"-displayfd", "1", "-auth", In("authority"), "-nolisten", "tcp"});
  if (!xauth.waitForFinished(kPatienceMs) || xauth.exitCode() != 0 || !server.waitForStarted()) {
    GTEST_SKIP() << "needs xauth and Xvfb";
  }
  ASSERT_TRUE(server.waitForReadyRead(kPatienceMs));
  QProcessEnvironment refused = here_;
  refused.insert("DISPLAY", ":" + QString::fromLatin1(server.readLine()).trimmed());
  refused.insert("XAUTHORITY", In("nothing"));
  EXPECT_EQ(Run({}, refused), 4);
  EXPECT_THAT(output_, ::testing::HasSubstr("XAUTHORITY"));
  EXPECT_EQ(std::count(output_.begin(), output_.end(), '\n'), 1) << output_;
  server.kill();
  server.waitForFinished(kPatienceMs);
}

// A linker leaves out a file of a library that no other file names, and the functions in it too.
TEST_F(Program, HasEveryFunctionThatReplacesOneOfCyclones) {
  for (const char* program : {TANDEM_VIEW, TANDEM_PROGRAM}) {
    QProcess nm;
    nm.start("nm", {"-D", "--defined-only", program});
    ASSERT_TRUE(nm.waitForFinished(kPatienceMs));
    const std::string symbols = nm.readAllStandardOutput().toStdString();
    for (const char* name :
         {"ddsrt_recvmsg", "ddsrt_sendmsg", "ddsrt_bind", "ddsrt_close", "ddsrt_setsockopt",
          "ddsrt_getifaddrs", "ddsrt_thread_create", "ddsrt_cond_waitfor", "ddsrt_cond_waituntil",
          "ddsi_tkmap_lookup_instance_ref", "ddsi_typeinfo_valid"}) {
      EXPECT_THAT(symbols, ::testing::HasSubstr(std::string(" T ") + name)) << program;
    }
  }
}

// The window never came, so that there is no controller that could go on.
TEST_F(Program, OpenSaysNothingOfAControllerThatWasNotStarted) {
  QProcessEnvironment other = here_;
  other.insert("QT_QPA_PLATFORM", "wayland");
  QProcess open;
  open.setProcessEnvironment(other);
  open.start(TANDEM_PROGRAM, {"open", In("scene.json")});
  ASSERT_TRUE(open.waitForFinished(kPatienceMs));
  EXPECT_EQ(open.exitStatus(), QProcess::NormalExit);
  EXPECT_EQ(open.exitCode(), 4);
  const std::string told = open.readAllStandardError().toStdString();
  EXPECT_THAT(told, ::testing::Not(::testing::HasSubstr("controller")));
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1) << told;
}

// Nobody would move the hand of such a controller, and its part would stay in a session.
TEST_F(Program, LostDisplayLeavesNoController) {
  QProcess server;
  server.setStandardErrorFile(QProcess::nullDevice());
  server.start("Xvfb", {"-displayfd", "1", "-nolisten", "tcp"});
  if (!server.waitForStarted()) GTEST_SKIP() << "needs Xvfb";
  ASSERT_TRUE(server.waitForReadyRead(kPatienceMs));
  QProcessEnvironment there = here_;
  there.insert("DISPLAY", ":" + QString::fromLatin1(server.readLine()).trimmed());
  QProcess open;
  open.setProcessEnvironment(there);
  open.setStandardErrorFile(QProcess::nullDevice());
  open.start(TANDEM_PROGRAM,
             {"open", In("scene.json"), "--session", session_, "--interface", "lo"});
  ASSERT_TRUE(open.waitForStarted());
  const std::string control = "window-" + std::to_string(open.processId());
  Controller::Options patient;
  patient.timeout_s = 30;
  EXPECT_TRUE(Controller::Attach(control, patient));
  server.kill();
  ASSERT_TRUE(server.waitForFinished(kPatienceMs));
  ASSERT_TRUE(open.waitForFinished(kPatienceMs));
  EXPECT_NE(open.exitCode(), 0);
  Controller::Options brief;
  brief.timeout_s = 0.2;
  bool answers = true;
  for (int i = 0; i < 50 && answers; ++i) {
    answers = static_cast<bool>(Controller::Attach(control, brief));
  }
  EXPECT_FALSE(answers);
}

TEST_F(Program, ReportsPictureErrorsInOneLine) {
  Write(In("pictures.json"), R"({"pictures": [{"name": "a/b"}]})");
  EXPECT_EQ(Run({"--paint", In("pictures.json"), "--into", In("painted")}, here_), 3);
  EXPECT_THAT(output_, ::testing::HasSubstr("pictures[0].name: expected a plain file name"));
}

TEST_F(Program, WithoutOpenGlWritesAnExplanation) {
  QProcessEnvironment offscreen = here_;
  offscreen.insert("QT_QPA_PLATFORM", "offscreen");
  EXPECT_EQ(Run({"--scene", In("scene.json"), "--screenshot", In("page.png")}, offscreen), 4);
  EXPECT_THAT(output_, ::testing::HasSubstr("no OpenGL"));
  EXPECT_EQ(QImage(In("page.png")).size(), QSize(1280, 800));
}

TEST_F(Program, NamesAnUnreadableSceneFile) {
  EXPECT_EQ(Run({"--scene", "/nowhere/scene.json"}, here_), 3);
  EXPECT_THAT(output_, ::testing::HasSubstr("/nowhere/scene.json"));
}

TEST_F(Program, NamesAnUnknownOption) {
  EXPECT_EQ(Run({"--nosuch"}, here_), 2);
  EXPECT_THAT(output_, ::testing::HasSubstr("--nosuch"));
}

TEST_F(Program, UnattendedRunThatCannotJoinExitsWithTheNetworkCode) {
  EXPECT_EQ(Run({"--session", session_, "--interface", "nosuch0", "--seconds", "30"}, here_), 5);
  EXPECT_THAT(output_, ::testing::HasSubstr("nosuch0"));
}

TEST_F(Program, InvalidPeerAddressIsAUsageError) {
  EXPECT_EQ(Run({"--session", session_, "--peers", "a:b", "--seconds", "30"}, here_), 2);
  EXPECT_THAT(output_, ::testing::HasSubstr("HOST:PORT"));
}

TEST_F(Program, DoesNotStartWithoutViewerKeys) {
  EXPECT_EQ(Run({"--session", session_, "--secure", folder_.path()}, here_), 9);
  EXPECT_THAT(output_, ::testing::HasSubstr("is missing"));
  EXPECT_EQ(std::count(output_.begin(), output_.end(), '\n'), 1);
}

}  // namespace
}  // namespace tandem
