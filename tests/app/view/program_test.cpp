#include <QDeadlineTimer>
#include <QFile>
#include <QImage>
#include <QProcess>
#include <QTemporaryDir>
#include <algorithm>
#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "collab/dds/security/keys.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/session/viewer.h"
#include "tests/app/view/fake_session.h"
#include "tests/app/view/program_fixture.h"

// Runs the program as people start it, under an X server, in sessions of its own on the loopback
// interface.

namespace tandem {
namespace {

TEST_F(Program, WritesAPictureWithSolidAndGhostAndAReport) {
  work_folder_ = folder_.path();  // the program finds the scene there by its content
  StartScriptedPeer("Anna", "0.05");
  StartScriptedPeer("Ben", "-0.05");
  const int exit_code =
      Run(JoinArguments() + QStringList{"--screenshot", In("window.png"), "--report",
                                        In("report.json"), "--screenshot-after", "2"},
          here_);
  EXPECT_EQ(exit_code, 0) << output_;
  const QImage image(In("window.png"));
  ASSERT_EQ(image.size(), QSize(1280, 800));
  const int solid = Count(image, [](const QColor& c) {
    return c.green() > 110 && c.red() < 60 && c.blue() < 90;
  });
  EXPECT_GT(solid, 1000);  // a part of 4 cm in a picture of about 25 cm
  // Ben's colour, whichever it is, drawn at 45 % over light or grey beside the panel
  const QImage picture = image.copy(0, 60, 700, 640);
  const int ghost = Count(picture, [](const QColor& c) {
    const auto [least, most] = std::minmax({c.red(), c.green(), c.blue()});
    const bool part = c.green() > c.red() + 40 && c.green() > c.blue() + 40;
    return most - least > 25 && !part;
  });
  EXPECT_GT(ghost, 1000);
  const nlohmann::json report = Report();
  EXPECT_EQ(report.at("peers_seen"), 2);
  EXPECT_GT(report.at("samples").get<int>(), 50);
  EXPECT_GT(report.at("samples_per_s").get<double>(), 50.0);  // 120 are sent
  EXPECT_GT(report.at("age_ms_p99").get<double>(), 0.0);
}

TEST_F(Program, MeasuresTheFramesOfAScene) {
  const QStringList arguments{"--scene",         In("scene.json"), "--time-pictures",
                              In("report.json"), "--rounds",       "2"};
  EXPECT_EQ(Run(arguments, here_), 0) << output_;
  const nlohmann::json times = Report();
  const nlohmann::json& pictures = times.at("pictures");
  ASSERT_EQ(pictures.size(), 2U);
  EXPECT_EQ(pictures[0].at("samples"), 1);
  EXPECT_EQ(pictures[1].at("samples"), 4);
  for (const nlohmann::json& one : pictures) {
    EXPECT_EQ(one.at("static_triangles"), 12);  // the plate, a box
    EXPECT_EQ(one.at("moving_triangles"), 12);  // the part, a box
    const double full_ms = one.at("full_redraw_ms").at("median");
    const double fixed_ms = one.at("fixed_eye_ms").at("median");
    EXPECT_GT(full_ms, 0);
    EXPECT_GT(fixed_ms, 0);
    EXPECT_EQ(one.at("frames_until_whole").at("most"), 1);
  }
}

TEST_F(Program, FindsTheSessionsSceneOnThisMachine) {
  StartScriptedPeerFromElsewhere("Anna");
  QTemporaryDir state;
  here_.insert("XDG_STATE_HOME", state.path());
  const QStringList arguments =
      JoinArguments() + QStringList{"--screenshot", In("found.png"), "--screenshot-after", "0.2"};
  const auto green = [&] {
    return Count(QImage(In("found.png")), [](const QColor& c) {
      return c.green() > 110 && c.red() < 60 && c.blue() < 90;
    });
  };
  // the scene is nowhere: the program says so, and where it looked
  EXPECT_EQ(Run(arguments + QStringList{"--seconds", "12"}, here_), 0) << output_;
  EXPECT_THAT(output_, ::testing::HasSubstr("The scene is missing"));
  EXPECT_LT(green(), 150);
  // the scene is in the current folder
  work_folder_ = folder_.path();
  EXPECT_EQ(Run(arguments, here_), 0) << output_;
  EXPECT_GT(green(), 1000);
  // the scene is where a scene was named the last time
  work_folder_ = state.path();
  EXPECT_EQ(Run({"--scene", In("scene.json"), "--fit", "--screenshot", In("named.png")}, here_), 0);
  QFile::remove(In("found.png"));
  EXPECT_EQ(Run(arguments, here_), 0) << output_;
  EXPECT_GT(green(), 1000);
}

TEST_F(Program, ReportsADifferentOrUnloadableScene) {
  StartScriptedPeer("Anna", "0.05");
  Write(In("bare.json"), R"({"name": "bare", "voxel_m": 0.001, "bodies": [
      {"name": "part", "mesh": "part.obj", "mass_kg": 0.2}]})");
  EXPECT_EQ(Run(JoinArguments() +
                    QStringList{"--scene", In("bare.json"), "--screenshot", In("other.png")},
                here_),
            8);
  EXPECT_THAT(output_, ::testing::HasSubstr("This is not the scene that the session runs"));
  Write(In("broken.json"), R"({"name": "broken", "voxel_m": 0.001, "bodies": [
      {"name": "part", "mesh": "gone.obj", "mass_kg": 0.2}]})");
  EXPECT_EQ(Run({"--scene", In("broken.json"), "--screenshot", In("broken.png"), "--seconds", "30"},
                here_),
            3);
  EXPECT_THAT(output_, ::testing::HasSubstr("gone.obj"));
}

TEST_F(Program, TakesAPictureWithProximityOnceItIsVoxelized) {
  // 3 mm above the plate, at most
  Write(In("scene.json"), R"({"name": "plate and part", "voxel_m": 0.001, "bodies": [
      {"name": "plate", "mesh": "plate.obj", "fixed": true, "colour": "#8f9aa6"},
      {"name": "part", "mesh": "part.obj", "mass_kg": 0.2, "colour": "#00c020",
       "pose": {"p_W": [0, 0, 0.027]}}]})");
  EXPECT_EQ(Run({"--scene", In("scene.json"), "--proximity", "--screenshot", In("near.png"),
                 "--screenshot-after", "0.2"},
                here_),
            0)
      << output_;
  const QImage image(In("near.png"));
  ASSERT_EQ(image.size(), QSize(1280, 800));
  const auto count = [&](const auto& like) {
    return Count(image, like);
  };
  // the part's lower rim is warm and its sides are blue; only the Y axis is green
  EXPECT_LT(count([](const QColor& c) {
              return c.green() > 110 && c.red() < 60 && c.blue() < 90;
            }),
            150);
  EXPECT_GT(count([](const QColor& c) {
              return c.blue() > c.red() + 50 && c.blue() > c.green() + 20;
            }),
            1000);
  EXPECT_GT(count([](const QColor& c) {
              return c.red() > c.blue() + 40 && c.red() > c.green() + 5;
            }),
            300);
}

TEST_F(Program, LeavesWithAGoodbyeAndReportsWhenItIsTerminated) {
  Viewer other;
  DdsOptions options;
  options.session = session_.toStdString();
  options.peer = 77;
  options.role = Role::kViewer;
  options.interface = "lo";
  const Result<std::unique_ptr<Transport>> joined = JoinOverDds(options, other);
  ASSERT_TRUE(joined) << joined.error().what;
  const auto dora_is = [&](ViewedPeer::Presence presence) {
    const ViewerPicture picture = other.Picture();
    return std::any_of(picture.peers.begin(), picture.peers.end(), [&](const ViewedPeer& peer) {
      return peer.info.name == "Dora" && peer.presence == presence;
    });
  };
  QProcess view;
  view.start(TANDEM_VIEW, JoinArguments() + QStringList{"--report", In("report.json")});
  ASSERT_TRUE(ProcessEventsUntil(
      [&] {
        return dora_is(ViewedPeer::Presence::kHere);
      },
      kPatienceMs));
  const qint64 pid = view.processId();
  view.terminate();
  ASSERT_TRUE(view.waitForFinished(kPatienceMs));
  EXPECT_EQ(view.exitStatus(), QProcess::NormalExit);
  EXPECT_EQ(view.exitCode(), 0);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return dora_is(ViewedPeer::Presence::kLeft);
  }));
  EXPECT_EQ(Report().at("pid").get<qint64>(), pid);
  (*joined)->Leave();
}

// A pipe that nobody writes to must neither hold the window for ever nor keep SIGTERM from ending
// it.
TEST_F(Program, EndsInTimeForAnyNamedFile) {
  const QString pipe = In("pipe.json");
  ASSERT_EQ(mkfifo(pipe.toLocal8Bit().constData(), 0600), 0);
  QTemporaryDir state;
  here_.insert("XDG_STATE_HOME", state.path());
  StartScriptedPeerFromElsewhere("Mallory", pipe);
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(Run(JoinArguments() + QStringList{"--seconds", "3"}, here_), 0) << output_;
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(20));
}

TEST_F(Program, DrawsReportPicturesWithoutADisplay) {
  Write(In("pictures.json"), R"({"pictures": [
    {"name": "one", "title": "a box and a word", "width": 100, "height": 60, "shapes": [
      {"rectangle": {"box": [10, 10, 20, 15], "fill": "#ff0000"}},
      {"label": {"at": [90, 50], "text": "HHHH", "size": 12, "anchor": "end", "colour": "#000000",
                 "bold": false, "upwards": false}}]},
    {"name": "two", "title": "a line", "width": 30, "height": 30, "shapes": [
      {"polyline": {"points": [[0, 10], [30, 10]],
                    "stroke": {"colour": "#0000ff", "width": 2, "dashes": [10, 5]}}}]}]})");
  QProcessEnvironment nowhere = here_;
  nowhere.remove(QStringLiteral("DISPLAY"));
  EXPECT_EQ(Run({"--paint", In("pictures.json"), "--into", In("painted")}, nowhere), 0) << output_;
  // twice its size
  const QImage one(In("painted/one.png"));
  ASSERT_EQ(one.size(), QSize(200, 120));
  EXPECT_EQ(one.pixelColor(22, 22), QColor(255, 0, 0));
  EXPECT_EQ(one.pixelColor(18, 22), QColor(255, 255, 255));
  // the word ends at x = 90, and there is some of it
  const auto is_dark = [](const QColor& c) {
    return c.lightness() < 100 && c.red() < 200;
  };
  EXPECT_GT(Count(one.copy(100, 78, 80, 24), is_dark), 50);
  EXPECT_EQ(Count(one.copy(182, 0, 18, 120), is_dark), 0);
  // a dash of 10, a gap of 5: 20 of 30 pixels, 2 wide, at twice the size
  const QImage two(In("painted/two.png"));
  const int blue = Count(two, [](const QColor& c) {
    return c.blue() > 200 && c.red() < 60;
  });
  EXPECT_NEAR(blue, 2 * 20 * 2 * 2, 16);
}

TEST_F(Program, WatchesASecuredSessionWithItsKeys) {
  const std::filesystem::path keys = folder_.filePath("keys").toStdString();
  ASSERT_TRUE(MakeSessionKeys(keys));
  const Result<PeerId> anna = MakeMemberKeys(keys, "anna", Role::kActive, keys / "anna");
  ASSERT_TRUE(anna && MakeMemberKeys(keys, "vera", Role::kViewer, keys / "vera"));
  Viewer received;
  DdsOptions options;
  options.session = session_.toStdString();
  options.peer = *anna;
  options.interface = "lo";
  options.secure = (keys / "anna").string();
  const Result<std::unique_ptr<Transport>> joined = JoinOverDds(options, received);
  ASSERT_TRUE(joined) << joined.error().what;
  QProcess view;
  view.start(TANDEM_VIEW,
             {"--session", session_, "--interface", "lo", "--report", In("report.json"), "--secure",
              QString::fromStdString((keys / "vera").string())});
  ViewFrame frame;
  frame.peer = *anna;
  PeerInfo info;
  info.peer = *anna;
  info.name = "anna";
  const auto publish_for = [&](int patience_ms, const auto& until) {
    const QDeadlineTimer deadline(patience_ms);
    while (!deadline.hasExpired() && !until() && !view.waitForFinished(20)) {
      ++info.beat;
      (*joined)->Publish(info);
      (*joined)->Publish(frame);
    }
    return until();
  };
  // each has heard the other once both have shaken hands
  ASSERT_TRUE(publish_for(kPatienceMs, [&] {
    return !received.Picture().peers.empty();
  })) << view.readAllStandardError().toStdString();
  publish_for(3000, [] {
    return false;
  });
  view.terminate();
  ASSERT_TRUE(view.waitForFinished(kPatienceMs));
  EXPECT_EQ(view.exitCode(), 0) << view.readAllStandardError().toStdString();
  EXPECT_EQ(Report().at("peers_seen"), 1);
  EXPECT_GT(Report().at("samples").get<int>(), 10);
  (*joined)->Leave();
}

}  // namespace
}  // namespace tandem
