#include "app/view/ui/notice_bar.h"

#include <QEvent>
#include <QHBoxLayout>
#include <QLabel>
#include <QVBoxLayout>
#include <algorithm>

namespace tandem {

namespace {
constexpr int kMargin = 12;      // pixels
constexpr int kMostWidth = 720;  // pixels
}  // namespace

NoticeBar::NoticeBar(QWidget* over) : QFrame(over) {
  setObjectName("notice_bar");
  setFrameShape(QFrame::StyledPanel);
  setAutoFillBackground(true);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(kMargin, 6, kMargin, 6);
  over->installEventFilter(this);
  hide();
}

void NoticeBar::Show(const QString& name, const QString& text, const std::vector<Choice>& choices) {
  QStringList buttons;
  for (const Choice& choice : choices) buttons << choice.text;
  const auto known = std::ranges::find(rows_, name, &Row::name);
  if (known != rows_.end() && known->text == text && known->buttons == buttons) return;
  Hide(name);
  rows_.push_back({name, text, buttons, MakeRow(name, text, choices)});
  layout()->addWidget(rows_.back().widget);
  Place();
}

QWidget* NoticeBar::MakeRow(const QString& name, const QString& text,
                            const std::vector<Choice>& choices) {
  auto* row = new QWidget(this);
  row->setObjectName("notice_" + name);
  auto* line = new QHBoxLayout(row);
  line->setContentsMargins(0, 0, 0, 0);
  auto* label = new QLabel(text);
  label->setTextFormat(Qt::PlainText);  // names come from other peers
  label->setWordWrap(true);
  line->addWidget(label, 1);
  for (std::size_t i = 0; i < choices.size(); ++i) {
    QString shown = choices[i].text;  // an ampersand marks a key
    auto* button = new QPushButton(shown.replace(QLatin1Char('&'), QStringLiteral("&&")));
    button->setObjectName(QStringLiteral("notice_%1_%2").arg(name).arg(i));
    button->setFocusPolicy(Qt::NoFocus);
    // queued, since the choice may take the notice and its buttons away
    connect(
        button, &QPushButton::clicked, this,
        [this, name, act = choices[i].act] {
          Hide(name);
          if (act) act();
        },
        Qt::QueuedConnection);
    line->addWidget(button);
  }
  return row;
}

void NoticeBar::Hide(const QString& name) {
  const auto known = std::ranges::find(rows_, name, &Row::name);
  if (known == rows_.end()) return;
  known->widget->hide();
  known->widget->deleteLater();
  rows_.erase(known);
  Place();
}

QString NoticeBar::Text(const QString& name) const {
  const auto known = std::ranges::find(rows_, name, &Row::name);
  return known == rows_.end() ? QString() : known->text;
}

bool NoticeBar::eventFilter(QObject* watched, QEvent* event) {
  if (watched == parentWidget() && event->type() == QEvent::Resize) Place();
  return QFrame::eventFilter(watched, event);
}

void NoticeBar::Place() {
  setVisible(!rows_.empty());
  if (rows_.empty()) return;
  const QSize over = parentWidget()->size();
  const int width = std::min(kMostWidth, over.width() - 2 * kMargin);
  layout()->activate();
  const int height = layout()->hasHeightForWidth() ? layout()->totalHeightForWidth(width)
                                                   : layout()->totalSizeHint().height();
  setGeometry((over.width() - width) / 2, over.height() - height - kMargin, width, height);
  raise();
}

}  // namespace tandem
