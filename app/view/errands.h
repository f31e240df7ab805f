#pragma once

#include <QObject>
#include <QTimer>

#include "app/view/options.h"
#include "app/view/ui/main_window.h"

namespace tandem {

/// What a run does by itself: takes a picture, ends after some time or on SIGTERM or SIGINT, tells
/// how it went. One in a program.
class Errands : public QObject {
  Q_OBJECT

 public:
  Errands(const ViewOptions& options, MainWindow& window, SessionModel& session);

  /// After the event loop ended: leaves the session, writes the report.
  int Finish();

 private:
  void CatchSignals();
  void LookForPicture();
  bool PictureIsComplete() const;
  void TakePicture();
  void OnSessionChanged();
  void End(int exit_code);
  /// Of a window with a hand: what it has drawn, of how many snapshots.
  Result<bool> WriteHandReport() const;

  const ViewOptions& options_;
  MainWindow& window_;
  SessionModel& session_;
  int exit_code_ = 0;
  bool picture_due_;
  std::int64_t joined_ns_ = 0;  // 0: not in a session
  double seconds_joined_ = 0;
  QTimer look_;         // whether the picture is complete
  QTimer picture_;      // it is, and --screenshot-after runs
  QTimer last_chance_;  // for the picture, as it is
  QTimer end_;
};

}  // namespace tandem
