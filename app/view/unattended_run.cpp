#include "app/view/unattended_run.h"

#include <QCoreApplication>
#include <atomic>
#include <sstream>

#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/common/stop_signal.h"
#include "app/view/program_lines.h"
#include "collab/session/viewer_report.h"
#include "engine/base/files/whole_file.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr int kLookMs = 100;
constexpr int kSignalLookMs = 50;
constexpr double kPatience = 30;     // s until a picture is taken though scene or poses are missing
constexpr double kBeforeTheEnd = 1;  // s before the end at which a picture is taken at the latest

int Milliseconds(double seconds) {
  return static_cast<int>(1000 * seconds);
}

std::string OneLine(const QString& text) {
  return text.simplified().toStdString();
}

}  // namespace

UnattendedRun::UnattendedRun(const ViewOptions& options, MainWindow& window, SessionModel& session)
    : options_(options),
      window_(window),
      session_(session),
      picture_due_(!options.screenshot.empty()) {
  CatchSignals();
  connect(&session_, &SessionModel::StateChanged, this, &UnattendedRun::OnSessionChanged);
  for (QTimer* timer : {&picture_, &last_chance_, &end_}) timer->setSingleShot(true);
  connect(&look_, &QTimer::timeout, this, &UnattendedRun::LookForPicture);
  connect(&picture_, &QTimer::timeout, this, &UnattendedRun::TakePicture);
  connect(&last_chance_, &QTimer::timeout, this, &UnattendedRun::TakePicture);
  connect(&end_, &QTimer::timeout, this, [this] {
    End(exit_code_);
  });
  if (options.seconds > 0) end_.start(Milliseconds(options.seconds));
  if (!picture_due_) return;
  look_.start(kLookMs);
  double patience = kPatience + options.screenshot_after;
  if (options.seconds > 0) {
    patience = std::min(patience, std::max(0.0, options.seconds - kBeforeTheEnd));
  }
  last_chance_.start(Milliseconds(patience));
}

void UnattendedRun::CatchSignals() {
  const std::atomic<bool>& stop_asked = StopOnSignals();
  auto* look = new QTimer(this);
  connect(look, &QTimer::timeout, this, [this, look, &stop_asked] {
    if (!stop_asked.load()) return;
    look->stop();
    End(exit_code_);
  });
  look->start(kSignalLookMs);
}

void UnattendedRun::OnSessionChanged() {
  if (session_.state() == SessionModel::State::kJoined) {
    if (joined_ns_ == 0) joined_ns_ = MonotonicNowNs();
    seconds_joined_ = 0;
    return;
  }
  if (joined_ns_ != 0) seconds_joined_ = static_cast<double>(MonotonicNowNs() - joined_ns_) * 1e-9;
  joined_ns_ = 0;
  if (session_.state() != SessionModel::State::kFailed) return;
  SayFromView("could not join: " + session_.error().toStdString());
  // a person can read it in the window and try again; an unattended run ends
  const bool unattended = options_.seconds > 0 || !options_.screenshot.empty();
  if (unattended) End(kExitNetwork);
}

bool UnattendedRun::PictureIsComplete() const {
  if (window_.view() == nullptr) {  // the page with the reason is all that will come
    return true;
  }
  using State = ProximityModel::State;
  const State proximity = window_.proximity().state();
  if (options_.proximity && proximity != State::kOn && proximity != State::kFailed) return false;
  if (options_.join.session.empty()) return window_.page() == nullptr;
  return window_.ShowsPoses();
}

void UnattendedRun::LookForPicture() {
  if (!PictureIsComplete()) return;
  look_.stop();
  picture_.start(Milliseconds(options_.screenshot_after));
}

void UnattendedRun::TakePicture() {
  if (!picture_due_) return;
  picture_due_ = false;
  look_.stop();
  if (!PictureIsComplete()) {
    const MessagePage* page = window_.page();
    SayFromView("the picture is incomplete: " +
                (page != nullptr ? OneLine(page->text()) : "no poses arrived"));
  }
  if (window_.view() != nullptr && !window_.view()->warning().isEmpty()) {
    SayFromView(OneLine(window_.view()->warning()));
  }
  // only for a scene that the command line names: a session's scene is not the caller's fault
  if (!options_.scene.empty()) {
    if (window_.scene().state() == SceneModel::State::kMissing) exit_code_ = kExitFile;
    if (!window_.scene().warning().isEmpty()) exit_code_ = kExitIncompatiblePeer;
  }
  if (options_.fit && window_.view() != nullptr) window_.view()->FitScene();
  if (!window_.Screenshot().save(QString::fromStdString(options_.screenshot), "PNG")) {
    SayFromView(options_.screenshot + ": cannot be written");
    exit_code_ = kExitFile;
  } else if (window_.view() == nullptr) {
    SayFromView("the picture shows no scene: " +
                window_.page()->text().split('\n').last().toStdString());
    exit_code_ = kExitDisplay;
  }
  if (options_.seconds <= 0) End(exit_code_);
}

void UnattendedRun::End(int exit_code) {
  exit_code_ = exit_code;
  QCoreApplication::exit(exit_code);
}

Result<bool> UnattendedRun::WriteHandReport() const {
  std::ostringstream text;
  const std::uint64_t pictures = window_.view() != nullptr ? window_.view()->frames_drawn() : 0;
  text << "{\n  \"pid\": " << getpid() << ",\n  \"pictures\": " << pictures
       << ",\n  \"snapshots\": " << window_.panel()->snapshots() << "\n}\n";
  if (const auto fault = WriteWholeFile(options_.report, text.str())) return *fault;
  return true;
}

int UnattendedRun::Finish() {
  session_.Leave();
  SayStillEnding();
  if (options_.report.empty()) return exit_code_;
  if (options_.attach || options_.take_part || !options_.open.empty()) {
    const Result<bool> reported = WriteHandReport();
    if (reported) return exit_code_;
    SayFromView(reported.error().what);
    return exit_code_ != kExitOk ? exit_code_ : kExitFile;
  }
  const Result<bool> written =
      WriteReport(ReportOf(session_.viewer(), getpid(), seconds_joined_), options_.report);
  if (!written) {
    SayFromView(written.error().what);
    return exit_code_ != kExitOk ? exit_code_ : kExitFile;
  }
  return exit_code_;
}

}  // namespace tandem
