#include "app/view/ui/message_page.h"

#include <QVBoxLayout>

namespace tandem {

MessagePage::MessagePage(QWidget* parent)
    : QWidget(parent),
      title_(new QLabel(this)),
      text_(new QLabel(this)),
      progress_(new QProgressBar(this)),
      open_(new QPushButton(tr("&Open scene\u2026"), this)),
      load_(new QPushButton(tr("&Load the file that the session names"), this)),
      fetch_(new QPushButton(tr("&Fetch it from the session"), this)) {
  setAutoFillBackground(true);
  setBackgroundRole(QPalette::Base);
  QFont font = title_->font();
  font.setPointSizeF(1.5 * font.pointSizeF());
  font.setBold(true);
  title_->setFont(font);
  for (QLabel* label : {title_, text_}) {
    label->setTextFormat(Qt::PlainText);  // names and paths come from other peers
    label->setAlignment(Qt::AlignHCenter);
    label->setWordWrap(true);
    label->setTextInteractionFlags(Qt::TextSelectableByMouse);
    label->setFocusPolicy(Qt::NoFocus);
  }
  progress_->setMaximumWidth(320);
  open_->setObjectName("open_scene_button");
  connect(open_, &QPushButton::clicked, this, &MessagePage::OpenAsked);
  load_->setObjectName("load_named_button");
  load_->setVisible(false);
  connect(load_, &QPushButton::clicked, this, &MessagePage::NamedAsked);
  fetch_->setObjectName("fetch_scene_button");
  fetch_->setVisible(false);
  connect(fetch_, &QPushButton::clicked, this, &MessagePage::FetchingAsked);

  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(48, 32, 48, 32);
  layout->setSpacing(12);
  layout->addStretch(2);
  layout->addWidget(title_);
  layout->addWidget(text_);
  layout->addWidget(progress_, 0, Qt::AlignHCenter);
  layout->addWidget(open_, 0, Qt::AlignHCenter);
  layout->addWidget(load_, 0, Qt::AlignHCenter);
  layout->addWidget(fetch_, 0, Qt::AlignHCenter);
  layout->addStretch(3);
}

void MessagePage::Show(const QString& title, const QString& text, int percent) {
  title_->setText(title);
  text_->setText(text);
  progress_->setVisible(percent >= 0);
  progress_->setValue(std::max(percent, 0));
}

}  // namespace tandem
