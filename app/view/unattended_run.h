#pragma once

#include <QObject>
#include <QTimer>

#include "app/view/options.h"
#include "app/view/ui/main_window.h"

namespace tandem {

/// The unattended work of a run: takes a picture, ends after some time or on SIGTERM or SIGINT,
/// writes a report. A program has one.
class UnattendedRun : public QObject {
  Q_OBJECT

 public:
  UnattendedRun(const ViewOptions& options, MainWindow& window, SessionModel& session);

  /// Called after the event loop has ended. Leaves the session, writes the report, returns the exit
  /// code.
  int Finish();

 private:
  void CatchSignals();
  void LookForPicture();
  bool PictureIsComplete() const;
  void TakePicture();
  void OnSessionChanged();
  void End(int exit_code);
  /// Writes the report of a window with a hand: the numbers of pictures and snapshots.
  Result<bool> WriteHandReport() const;

  const ViewOptions& options_;
  MainWindow& window_;
  SessionModel& session_;
  int exit_code_ = 0;
  bool picture_due_;
  std::int64_t joined_ns_ = 0;  // time of joining; 0: not in a session
  double seconds_joined_ = 0;
  QTimer look_;         // tests whether the picture is complete
  QTimer picture_;      // runs from the complete picture for --screenshot-after
  QTimer last_chance_;  // takes the picture as it is
  QTimer end_;
};

}  // namespace tandem
