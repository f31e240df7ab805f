#include "app/view/ui/dialogs/invite_dialog.h"

#include <QClipboard>
#include <QDialogButtonBox>
#include <QDir>
#include <QFileDialog>
#include <QFormLayout>
#include <QGuiApplication>
#include <QHBoxLayout>
#include <QJsonDocument>
#include <QJsonObject>
#include <QRegularExpression>
#include <QToolButton>
#include <utility>

#include "engine/realtime/private_process.h"

namespace tandem {

namespace {

constexpr int kInviterGoneWithinMs = 1500;
constexpr const char* kAuthority = "identity_ca.key";  // file in the folder that makes members

QString Text(const std::string& text) {
  return QString::fromStdString(text);
}

/// Returns the session's folder if it contains a member's folder; else empty.
QString SessionFolderOf(const std::string& member) {
  if (member.empty()) return {};
  QDir folder(QDir(Text(member)).absolutePath());
  return folder.cdUp() && folder.exists(QLatin1String(kAuthority)) ? folder.path() : QString();
}

}  // namespace

InviteDialog::InviteDialog(const HandRequest& session, QString program, QWidget* parent)
    : QDialog(parent),
      session_(session),
      program_(std::move(program)),
      name_(new QLineEdit),
      role_(new QComboBox),
      keys_(new QLineEdit(SessionFolderOf(session.secure))),
      line_(new QLineEdit),
      state_(new QLabel),
      make_(new QPushButton(tr("&Make the line"))) {
  setObjectName("invite_dialog");
  setWindowTitle(tr("Invite to \u201c%1\u201d").arg(Text(session.session)));
  name_->setObjectName("invite_name");
  role_->setObjectName("invite_role");
  keys_->setObjectName("invite_keys");
  line_->setObjectName("invite_line");
  state_->setObjectName("invite_state");
  make_->setObjectName("invite_make");
  name_->setPlaceholderText(tr("name that the others see"));
  role_->addItem(tr("active: takes parts in hand"), QStringLiteral("active"));
  role_->addItem(tr("viewer: looks on"), QStringLiteral("viewer"));
  keys_->setPlaceholderText(tr("folder that \u2018tandem keys session\u2019 made"));
  line_->setReadOnly(true);
  line_->setMinimumWidth(520);
  line_->setPlaceholderText(tr("the line to send, by mail or chat"));
  state_->setTextFormat(Qt::PlainText);
  state_->setWordWrap(true);

  auto* form = new QFormLayout(this);
  const bool secured = !session.secure.empty();
  if (secured) {
    form->addRow(tr("&Whom"), name_);
    auto* row = new QWidget;
    auto* of_keys = new QHBoxLayout(row);
    of_keys->setContentsMargins(0, 0, 0, 0);
    auto* choose = new QToolButton;
    choose->setText(QStringLiteral("\u2026"));
    choose->setAccessibleName(tr("Folder of the session\u2019s keys"));
    of_keys->addWidget(keys_);
    of_keys->addWidget(choose);
    connect(choose, &QToolButton::clicked, this, [this] {
      const QString chosen = QFileDialog::getExistingDirectory(
          this, tr("Folder of the session\u2019s keys"), keys_->text());
      if (!chosen.isEmpty()) keys_->setText(chosen);
    });
    form->addRow(tr("Session\u2019s &keys"), row);
  }
  form->addRow(tr("&Role"), role_);
  form->addRow(tr("&Line"), line_);
  form->addRow(state_);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
  buttons->addButton(make_, QDialogButtonBox::ActionRole);
  form->addRow(buttons);
  make_->setDefault(true);
  connect(make_, &QPushButton::clicked, this, &InviteDialog::Make);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  for (QLineEdit* field : {name_, keys_}) {
    field->setVisible(secured);
    connect(field, &QLineEdit::textChanged, this, &InviteDialog::Check);
  }
  Check();
}

InviteDialog::~InviteDialog() {
  if (process_ == nullptr) return;
  process_->disconnect(this);
  process_->terminate();
  if (!process_->waitForFinished(kInviterGoneWithinMs)) process_->kill();
}

QStringList InviteDialog::Words() const {
  QStringList words{QStringLiteral("invite"),        Text(session_.session),
                    QStringLiteral("--json"),        QStringLiteral("--role"),
                    role_->currentData().toString(), QStringLiteral("--domain"),
                    QString::number(session_.domain)};
  const auto add = [&words](const char* option, const QString& value) {
    if (!value.isEmpty()) words << QLatin1String(option) << value;
  };
  if (!session_.secure.empty()) {
    add("--name", name_->text().trimmed());
    add("--keys", keys_->text().trimmed());
  }
  QStringList others;
  for (const std::string& peer : session_.peers) others << Text(peer);
  add("--scene", Text(session_.scene));
  add("--interface", Text(session_.interface));
  add("--peers", others.join(QLatin1Char(',')));
  add("--external-address", Text(session_.external_address));
  add("--port", session_.port == 0 ? QString() : QString::number(session_.port));
  return words;
}

QString InviteDialog::Fault() const {
  if (session_.secure.empty()) return {};
  static const QRegularExpression name(QStringLiteral("^[A-Za-z0-9._-]{1,64}$"));
  if (!name.match(name_->text().trimmed()).hasMatch()) {
    return tr(
        "Enter the name of the person you invite: letters, digits, \u2018.\u2019, \u2018_\u2019 "
        "and \u2018-\u2019.");
  }
  if (!QDir(keys_->text().trimmed()).exists(QLatin1String(kAuthority)) ||
      keys_->text().trimmed().isEmpty()) {
    return tr(
        "Enter the folder of the session\u2019s keys that \u2018tandem keys session\u2019 made; "
        "ask the person who made it.");
  }
  return {};
}

void InviteDialog::Check() {
  const QString fault = Fault();
  make_->setEnabled(fault.isEmpty() && process_ == nullptr);
  if (process_ == nullptr) state_->setText(fault);
}

void InviteDialog::Make() {
  answer_.clear();
  reported_.clear();
  line_->clear();
  process_ = new QProcess(this);
  process_->setChildProcessModifier(&CloseOthersOnExec);
  connect(process_, &QProcess::readyReadStandardOutput, this, [this] {
    answer_ += process_->readAllStandardOutput();
    if (answer_.endsWith('\n')) ShowLine(answer_);
  });
  connect(process_, &QProcess::readyReadStandardError, this, &InviteDialog::OnWords);
  connect(process_, &QProcess::finished, this, [this](int exit_code, QProcess::ExitStatus) {
    OnEnd(exit_code);
  });
  connect(process_, &QProcess::errorOccurred, this, [this](QProcess::ProcessError error) {
    if (error != QProcess::FailedToStart) return;
    reported_ = tr("%1 cannot be started: %2").arg(program_, process_->errorString());
    OnEnd(1);
  });
  Check();
  state_->setText(tr("Asking the session\u2026"));
  process_->start(program_, Words());
}

void InviteDialog::ShowLine(const QByteArray& json) {
  const QJsonObject answer = QJsonDocument::fromJson(json).object();
  const QString line = answer.value(QStringLiteral("line")).toString();
  if (line.isEmpty()) return;
  line_->setText(line);
  line_->setCursorPosition(0);
  QGuiApplication::clipboard()->setText(line);
  state_->setText(answer.value(QStringLiteral("secured")).toBool()
                      ? tr("Copied. Send it to %1 and to nobody else. It works once, until %2, "
                           "while this window is open.")
                            .arg(answer.value(QStringLiteral("name")).toString(),
                                 answer.value(QStringLiteral("until")).toString())
                      : tr("Copied. Everybody who has it can join."));
}

void InviteDialog::OnWords() {
  const QStringList lines = QString::fromUtf8(process_->readAllStandardError())
                                .split(QLatin1Char('\n'), Qt::SkipEmptyParts);
  if (!lines.isEmpty()) reported_ = lines.last().section(QStringLiteral("tandem: "), 1);
}

void InviteDialog::OnEnd(int exit_code) {
  const bool secured = !session_.secure.empty();
  process_->deleteLater();
  process_ = nullptr;
  make_->setEnabled(Fault().isEmpty());
  // the line of a plain session stays valid
  if (exit_code != 0 || secured) {
    line_->clear();
    state_->setText(reported_);
  }
}

}  // namespace tandem
