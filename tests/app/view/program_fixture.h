#pragma once

#include <QFile>
#include <QImage>
#include <QProcess>
#include <QTemporaryDir>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/support/obj_text.h"

namespace tandem {

/// Runs the program beside peers that a test starts.
class Program : public ::testing::Test {
 protected:
  static constexpr int kPatienceMs = 60'000;

  static void Write(const QString& file, const std::string& text) {
    QFile out(file);
    ASSERT_TRUE(out.open(QIODevice::WriteOnly)) << file.toStdString();
    out.write(text.data(), static_cast<qint64>(text.size()));
  }

  void SetUp() override {
    ASSERT_TRUE(folder_.isValid());
    Write(In("plate.obj"), testing::BoxObjText(0.10, 0.08, 0.005));
    Write(In("part.obj"), testing::BoxObjText(0.02, 0.02, 0.02));
    Write(In("scene.json"), R"({"name": "plate and part", "voxel_m": 0.001, "bodies": [
      {"name": "plate", "mesh": "plate.obj", "fixed": true, "colour": "#8f9aa6"},
      {"name": "part", "mesh": "part.obj", "mass_kg": 0.2, "sharing": "shared", "colour": "#00c020"}]})");
  }
  void TearDown() override {
    for (const auto& scripted : scripted_peers_) {
      scripted->closeWriteChannel();
      if (!scripted->waitForFinished(kPatienceMs)) scripted->kill();
    }
  }
  QString In(const char* file) const { return folder_.filePath(file); }

  void StartScriptedPeer(const char* name, const char* dx) {
    auto scripted = std::make_unique<QProcess>();
    scripted->setProcessChannelMode(QProcess::ForwardedErrorChannel);
    scripted->start(SCRIPTED_PEER, {session_, name, In("scene.json"), "1", dx, "0", "0.04", "104"});
    ASSERT_TRUE(scripted->waitForStarted());
    scripted_peers_.push_back(std::move(scripted));
  }
  /// Starts a peer that says over DDS that its scene lies where it does not lie on this machine.
  void StartScriptedPeerFromElsewhere(const char* name,
                                      const QString& file = "/home/anna/scenes/scene.json") {
    auto scripted = std::make_unique<QProcess>();
    scripted->setProcessChannelMode(QProcess::ForwardedErrorChannel);
    scripted->start(SCRIPTED_PEER,
                    {session_, name, In("scene.json"), "1", "0.05", "0", "0.04", "104", "-", file});
    ASSERT_TRUE(scripted->waitForStarted());
    scripted_peers_.push_back(std::move(scripted));
  }
  QStringList JoinArguments() const {
    return {"--session", session_, "--name", "Dora", "--interface", "lo"};
  }
  /// Runs the program and returns its exit code. Its stderr is then in said_.
  int Run(const QStringList& arguments, const QProcessEnvironment& environment) {
    QProcess view;
    view.setProcessEnvironment(environment);
    view.setWorkingDirectory(work_folder_);
    view.start(TANDEM_VIEW, arguments);
    EXPECT_TRUE(view.waitForFinished(kPatienceMs));
    output_ = view.readAllStandardError().toStdString();
    EXPECT_EQ(view.exitStatus(), QProcess::NormalExit) << output_;
    return view.exitCode();
  }
  nlohmann::json Report() const {
    QFile file(In("report.json"));
    EXPECT_TRUE(file.open(QIODevice::ReadOnly));
    return nlohmann::json::parse(file.readAll().toStdString());
  }
  template <typename Like>
  static int Count(const QImage& image, Like like) {
    int count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) count += like(image.pixelColor(x, y)) ? 1 : 0;
    }
    return count;
  }

  QTemporaryDir folder_;
  QString session_ = QStringLiteral("view-test-%1").arg(getpid());
  QString work_folder_;  // folder of the program; empty: the test's own
  QProcessEnvironment here_ = QProcessEnvironment::systemEnvironment();
  std::vector<std::unique_ptr<QProcess>> scripted_peers_;
  std::string output_;
};

}  // namespace tandem
