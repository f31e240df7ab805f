#include "app/view/ui/dialogs/join_dialog.h"

#include <QDialogButtonBox>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QRegularExpression>
#include <QToolButton>
#include <initializer_list>

#include "app/invite/invitation.h"
#include "collab/dds/transport/dds_transport.h"
#include "engine/realtime/private_process.h"

namespace tandem {

namespace {

constexpr int kSessionsHeight = 70;  // pixels
constexpr int kListGoneWithinMs = 500;
constexpr int kTypedMs = 400;  // pause in typing after which the list is read again
constexpr int kLeastPort = 1024;
constexpr qsizetype kLongestSession = 128;  // bytes; limit of the network protocol

QStringList Hosts(const QString& text) {
  return text.split(QRegularExpression(QStringLiteral("[,;\\s]+")), Qt::SkipEmptyParts);
}

bool IsHost(const QString& text) {
  static const QRegularExpression form(
      QStringLiteral("^[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?(:[0-9]{1,5})?$"));
  if (!form.match(text).hasMatch()) return false;
  const auto colon = text.indexOf(QLatin1Char(':'));
  return colon < 0 || (text.mid(colon + 1).toInt() > 0 && text.mid(colon + 1).toInt() < 65536);
}

bool IsAddress(const QString& text) {
  static const QRegularExpression form(
      QStringLiteral("^(\\d{1,3})\\.(\\d{1,3})\\.(\\d{1,3})\\.(\\d{1,3})$"));
  const QRegularExpressionMatch match = form.match(text);
  if (!match.hasMatch()) return false;
  for (int i = 1; i <= 4; ++i) {
    if (match.captured(i).toInt() > 255) return false;
  }
  return true;
}

}  // namespace

JoinDialog::JoinDialog(QWidget* parent)
    : QDialog(parent),
      invitation_(new QLineEdit),
      sessions_(new QListWidget),
      session_(new QLineEdit),
      name_(new QLineEdit),
      role_(new QComboBox),
      scene_(new QLineEdit),
      peers_(new QLineEdit),
      external_(new QLineEdit),
      port_(new QSpinBox),
      domain_(new QSpinBox),
      interface_(new QLineEdit),
      secure_(new QLineEdit),
      fault_(new QLabel) {
  setWindowTitle(tr("Take part in a session"));
  setObjectName("join_dialog");
  invitation_->setObjectName("join_invitation");
  sessions_->setObjectName("join_sessions");
  session_->setObjectName("join_session");
  name_->setObjectName("join_name");
  role_->setObjectName("join_role");
  scene_->setObjectName("join_scene");
  peers_->setObjectName("join_peers");
  external_->setObjectName("join_external");
  port_->setObjectName("join_port");
  domain_->setObjectName("join_domain");
  interface_->setObjectName("join_interface");
  secure_->setObjectName("join_secure");
  fault_->setObjectName("join_fault");
  fault_->setTextFormat(Qt::PlainText);
  role_->addItem(tr("active: take parts in hand"), true);
  role_->addItem(tr("viewer: look on"), false);
  invitation_->setPlaceholderText(tr("tandem://\u2026 \u2013 the line that you received, if any"));
  sessions_->setMaximumHeight(kSessionsHeight);
  session_->setPlaceholderText(tr("name that the others see"));
  scene_->setPlaceholderText(tr("default: the session\u2019s scene, found on this machine"));
  peers_->setPlaceholderText(tr("HOST[:PORT], \u2026 \u2013 the local network"));
  external_->setPlaceholderText(tr("IPv4 \u2013 only behind a router"));
  interface_->setPlaceholderText(tr("automatic"));
  secure_->setPlaceholderText(tr("folder of keys \u2013 none: a plain session"));
  domain_->setRange(0, static_cast<int>(kMaxDomain));
  port_->setRange(kLeastPort - 1, 65534);
  port_->setSpecialValueText(tr("automatic"));
  fault_->setWordWrap(true);
  fault_->setMinimumWidth(420);

  auto* form = new QFormLayout(this);
  form->addRow(tr("In&vitation"), invitation_);
  form->addRow(tr("&Open here"), sessions_);
  form->addRow(tr("&Session"), session_);
  form->addRow(tr("Your &name"), name_);
  form->addRow(tr("&Role"), role_);
  form->addRow(tr("S&cene"), WithChooser(scene_, tr("Scene"), false));
  form->addRow(tr("&Peers"), peers_);
  form->addRow(tr("External &address"), external_);
  form->addRow(tr("P&ort"), port_);
  form->addRow(tr("&Domain"), domain_);
  form->addRow(tr("&Interface"), interface_);
  form->addRow(tr("&Keys"), WithChooser(secure_, tr("Folder of keys"), true));
  form->addRow(fault_);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Cancel);
  join_ = buttons->addButton(tr("&Take part"), QDialogButtonBox::AcceptRole);
  join_->setObjectName("join_accept");
  form->addRow(buttons);
  join_->setDefault(true);  // now that it is in the dialog: else Return presses Cancel
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  for (QLineEdit* field : {session_, name_, scene_, peers_, external_, interface_, secure_}) {
    connect(field, &QLineEdit::textChanged, this, &JoinDialog::Check);
  }
  connect(invitation_, &QLineEdit::textChanged, this, &JoinDialog::TakeLine);
  const auto choose = [this](const QListWidgetItem* item) {
    invitation_->clear();
    session_->setText(item->data(Qt::UserRole).toString());
  };
  connect(sessions_, &QListWidget::itemClicked, this, choose);
  connect(sessions_, &QListWidget::itemActivated, this, choose);  // by the keyboard
  connect(role_, &QComboBox::currentIndexChanged, this, &JoinDialog::Check);
  changed_.setSingleShot(true);
  changed_.setInterval(kTypedMs);
  connect(&changed_, &QTimer::timeout, this, [this] {
    if (!program_.isEmpty() && SearchWords() != searched_) LookAgain();
  });
  const auto changed = [this] {
    changed_.start();
  };
  connect(domain_, &QSpinBox::valueChanged, this, changed);
  for (QLineEdit* field : {interface_, peers_}) {
    connect(field, &QLineEdit::textChanged, this, changed);
  }
  Check();
}

JoinDialog::~JoinDialog() {
  if (process_ == nullptr) return;
  process_->disconnect(this);
  process_->kill();
  process_->waitForFinished(kListGoneWithinMs);
}

void JoinDialog::Look(const QString& program) {
  program_ = program;
  LookAgain();
}

QStringList JoinDialog::SearchWords() const {
  QStringList words{QStringLiteral("sessions"), QStringLiteral("--json"),
                    QStringLiteral("--domain"), QString::number(domain_->value())};
  const QString interface = interface_->text().trimmed();
  if (!interface.isEmpty()) words << QStringLiteral("--interface") << interface;
  QStringList peers;
  for (const QString& host : Hosts(peers_->text())) {
    if (IsHost(host)) peers << host;
  }
  if (!peers.isEmpty()) words << QStringLiteral("--peers") << peers.join(QLatin1Char(','));
  return words;
}

void JoinDialog::LookAgain() {
  if (process_ != nullptr) {
    process_->disconnect(this);
    process_->kill();
    process_->waitForFinished(kListGoneWithinMs);
    process_->deleteLater();
  }
  sessions_->clear();
  auto* looking = new QListWidgetItem(tr("looking for sessions\u2026"), sessions_);
  looking->setFlags(Qt::NoItemFlags);
  searched_ = SearchWords();
  process_ = new QProcess(this);
  process_->setChildProcessModifier(&CloseOthersOnExec);
  process_->setStandardErrorFile(QProcess::nullDevice());
  connect(process_, &QProcess::finished, this, [this](int, QProcess::ExitStatus) {
    ShowSessions(process_->readAllStandardOutput());
    process_->start();  // asks again, since sessions come and go
  });
  process_->start(program_, searched_);
}

void JoinDialog::ShowSessions(const QByteArray& json) {
  const QListWidgetItem* const current = sessions_->currentItem();
  const QString chosen = current != nullptr ? current->data(Qt::UserRole).toString() : QString();
  sessions_->clear();
  const QJsonArray found =
      QJsonDocument::fromJson(json).object().value(QStringLiteral("sessions")).toArray();
  for (const QJsonValue& value : found) {
    const QJsonObject one = value.toObject();
    const QString name = one.value(QStringLiteral("session")).toString();
    if (one.value(QStringLiteral("relay")).toBool()) continue;
    auto* item =
        new QListWidgetItem(one.value(QStringLiteral("secured")).toBool()
                                ? tr("%1 \u2013 secured: needs keys or an invitation").arg(name)
                                : name,
                            sessions_);
    item->setData(Qt::UserRole, name);
    if (name == chosen) sessions_->setCurrentItem(item);
  }
  if (!found.isEmpty()) return;
  auto* none = new QListWidgetItem(tr("no session is announced on this network"), sessions_);
  none->setFlags(Qt::NoItemFlags);
}

void JoinDialog::TakeLine() {
  const bool by_line = !invitation().isEmpty();
  // the line decides these fields
  for (QWidget* field :
       std::initializer_list<QWidget*>{session_, role_, domain_, peers_, secure_}) {
    field->setEnabled(!by_line);
  }
  if (const Result<Invitation> read = ReadInvitation(invitation().toStdString()); read) {
    session_->setText(QString::fromStdString(read->session));
    role_->setCurrentIndex(read->role == Role::kViewer ? 1 : 0);
    domain_->setValue(static_cast<int>(read->domain));
    peers_->clear();
    secure_->clear();
    secure_->setPlaceholderText(read->secured ? tr("the invitation supplies them")
                                              : tr("none: a plain session"));
  }
  Check();
}

QString JoinDialog::invitation() const {
  return invitation_->text().trimmed();
}

QWidget* JoinDialog::WithChooser(QLineEdit* field, const QString& title, bool folder) {
  auto* row = new QWidget;
  auto* line = new QHBoxLayout(row);
  line->setContentsMargins(0, 0, 0, 0);
  auto* choose = new QToolButton;
  choose->setText(QStringLiteral("\u2026"));
  choose->setAccessibleName(title);
  line->addWidget(field);
  line->addWidget(choose);
  connect(choose, &QToolButton::clicked, this, [this, field, title, folder] {
    const QString chosen =
        folder ? QFileDialog::getExistingDirectory(this, title, field->text())
               : QFileDialog::getOpenFileName(this, title, field->text(), tr("Scenes (*.json)"));
    if (!chosen.isEmpty()) field->setText(chosen);
  });
  return row;
}

void JoinDialog::SetRequest(const HandRequest& request, bool active) {
  given_ = request;
  session_->setText(QString::fromStdString(request.session));
  name_->setText(QString::fromStdString(request.name));
  role_->setCurrentIndex(active ? 0 : 1);
  scene_->setText(QString::fromStdString(request.scene));
  QStringList peers;
  for (const std::string& peer : request.peers) peers << QString::fromStdString(peer);
  peers_->setText(peers.join(QStringLiteral(", ")));
  external_->setText(QString::fromStdString(request.external_address));
  port_->setValue(request.port == 0 ? kLeastPort - 1 : request.port);
  domain_->setValue(static_cast<int>(request.domain));
  interface_->setText(QString::fromStdString(request.interface));
  secure_->setText(QString::fromStdString(request.secure));
  Check();
}

HandRequest JoinDialog::Request() const {
  HandRequest request = given_;
  request.session = session_->text().trimmed().toStdString();
  request.name = name_->text().trimmed().toStdString();
  request.scene = scene_->text().trimmed().toStdString();
  request.peers.clear();
  for (const QString& host : Hosts(peers_->text())) request.peers.push_back(host.toStdString());
  request.external_address = external_->text().trimmed().toStdString();
  request.port =
      port_->value() < kLeastPort ? std::uint16_t{0} : static_cast<std::uint16_t>(port_->value());
  request.domain = static_cast<std::uint32_t>(domain_->value());
  request.interface = interface_->text().trimmed().toStdString();
  request.secure = secure_->text().trimmed().toStdString();
  return request;
}

bool JoinDialog::active() const {
  return role_->currentData().toBool();
}

QString JoinDialog::Fault() const {
  if (!invitation().isEmpty()) {
    const Result<Invitation> read = ReadInvitation(invitation().toStdString());
    if (!read) return QString::fromStdString(read.error().what);
  }
  const QString session = session_->text().trimmed();
  if (session.isEmpty()) return tr("Enter the name of the session.");
  if (session.toUtf8().size() > kLongestSession) {
    return tr("The session\u2019s name is longer than %1 bytes: shorten it.").arg(kLongestSession);
  }
  if (name_->text().trimmed().isEmpty()) return tr("Enter your name.");
  for (const QString& host : Hosts(peers_->text())) {
    if (!IsHost(host))
      return tr("\u201c%1\u201d is not HOST or HOST:PORT: correct the peers.").arg(host);
  }
  const QString external = external_->text().trimmed();
  if (!external.isEmpty() && !IsAddress(external)) {
    return tr("\u201c%1\u201d is not an IPv4 address: correct the external address.").arg(external);
  }
  const QString scene = scene_->text().trimmed();
  if (!scene.isEmpty() && !QFileInfo(scene).isFile()) {
    return tr("There is no scene file \u201c%1\u201d.").arg(scene);
  }
  const QString keys = secure_->text().trimmed();
  if (!keys.isEmpty() && !QDir(keys).exists()) {
    return tr("There is no folder \u201c%1\u201d.").arg(keys);
  }
  return {};
}

void JoinDialog::Check() {
  const QString fault = Fault();
  fault_->setText(fault);
  join_->setEnabled(fault.isEmpty());
  join_->setText(active() ? tr("&Take part") : tr("&Look on"));
}

}  // namespace tandem
