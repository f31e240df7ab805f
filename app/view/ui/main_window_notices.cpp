#include <algorithm>

#include "app/view/ui/main_window.h"

// Shows the window's notices: messages with buttons, which stay until they are answered.

namespace tandem {

namespace {

constexpr std::size_t kMostOffered = 2;  // sessions that a notice has buttons for

/// Returns the announced sessions that the user could mean and can join.
std::vector<AnnouncedSession> Joinable(const SessionModel& session) {
  std::vector<AnnouncedSession> some;
  for (const AnnouncedSession& other : session.others()) {
    const bool behind_relay = other.name.ends_with(kBehindRelay);
    if (behind_relay || other.secured != session.request().secured) continue;
    if (other.name != session.request().session) some.push_back(other);
  }
  return some;
}

}  // namespace

void MainWindow::UpdateNotices() {
  OfferOtherSessions();
  if (panel_ == nullptr) return;
  const HandModel& hand = panel_->hand();
  session_dock_->OfferAgain(hand.can_start_again());
  if (hand.can_start_again()) {
    QString text = hand.trouble();
    if (!text.isEmpty()) text[0] = text[0].toUpper();
    notices_->Show("again", text, {{tr("Start again"), [this] {
                                      panel_->hand().StartAgain();
                                    }}});
  } else {
    notices_->Hide("again");
  }
  if (scene_alone_) return;
  OfferHandOver();
  WarnOfScene();
}

void MainWindow::OfferOtherSessions() {
  const bool alone = session_.state() == SessionModel::State::kJoined && !session_.has_peers();
  const std::vector<AnnouncedSession> others =
      alone ? Joinable(session_) : std::vector<AnnouncedSession>{};
  if (others.empty() || scene_alone_) return notices_->Hide("others");
  QStringList names;
  std::vector<NoticeBar::Choice> choices;
  for (const AnnouncedSession& other : others) {
    const QString name = QString::fromStdString(other.name);
    names << QStringLiteral("\u201c%1\u201d").arg(name);
    if (choices.size() == kMostOffered) continue;
    choices.push_back({name, [this, session = other.name] {
                         GoTo(session);
                       }});
  }
  notices_->Show("others",
                 tr("No session \u201c%1\u201d answers here. Announced: %2.")
                     .arg(QString::fromStdString(session_.request().session),
                          names.join(QStringLiteral(", "))),
                 choices);
}

void MainWindow::GoTo(const std::string& session) {
  if (panel_ != nullptr && panel_->waits()) {
    HandRequest request = panel_->defaults();
    request.session = session;
    panel_->TakePart(request);
    return;
  }
  JoinRequest request = session_.request();
  session_.Leave();
  request.session = session;
  session_dock_->SetRequest(request);
  session_.Join(request);
}

void MainWindow::OfferHandOver() {
  const HandModel& hand = panel_->hand();
  if (!hand.asked() || hand.asked()->body >= hand.snapshot().bodies.size()) {
    return notices_->Hide("asked");
  }
  const HandModel::Asked& asked = *hand.asked();
  const QString body = QString::fromStdString(hand.snapshot().bodies[asked.body].name);
  notices_->Show("asked", tr("%1 asks for %2, which you hold.").arg(asked.name, body),
                 {{tr("Hand over"),
                   [this] {
                     panel_->hand().HandOverAsked();
                   }},
                  {tr("Keep"), [this] {
                     panel_->hand().KeepPart();
                   }}});
}

void MainWindow::WarnOfScene() {
  const HandModel& hand = panel_->hand();
  if (!hand.ready()) return;
  QStringList lines;
  for (const std::string& line : hand.snapshot().warnings) {
    lines << WordsForWindow(QString::fromStdString(line));
  }
  const QString text = lines.join(QLatin1Char('\n'));
  if (text == warned_) return;
  warned_ = text;
  if (text.isEmpty()) return notices_->Hide("scene");
  notices_->Show("scene", text, {{tr("OK"), {}}});
}

void MainWindow::ShowVerdicts(const QStringList& lines) {
  warned_.clear();
  notices_->Hide("scene");
  if (!scene_alone_) notices_->Show("verdict", lines.join(QLatin1Char('\n')), {{tr("OK"), {}}});
}

}  // namespace tandem
