#include "app/view/ui/session_dock.h"

#include <QFormLayout>
#include <QHBoxLayout>
#include <QLocale>
#include <QPalette>
#include <QVBoxLayout>

#include <net/if.h>

#include "app/view/model/session/plain_tool_tip.h"
#include "collab/dds/transport/dds_transport.h"

namespace tandem {

namespace {

QString WithPlural(std::size_t count, const QString& one, const QString& many) {
  return QLocale().toString(static_cast<qulonglong>(count)) + QLatin1Char(' ') +
         (count == 1 ? one : many);
}

/// Returns the numbers of bodies and triangles in the files, and the number of triangles drawn with
/// proximity colours where that is larger.
QString SizeText(const DrawnScene& scene) {
  const std::size_t read = scene.FileTriangleCount();
  const std::size_t drawn = scene.TriangleCount();
  const QString text =
      WithPlural(scene.bodies.size(), SessionDock::tr("body"), SessionDock::tr("bodies")) +
      QStringLiteral(", ") +
      WithPlural(read, SessionDock::tr("triangle"), SessionDock::tr("triangles"));
  if (drawn <= read) return text;
  return text +
         SessionDock::tr(", with proximity drawn as %1").arg(QLocale().toString(qulonglong{drawn}));
}

/// Names of this machine's network interfaces.
QStringList Interfaces() {
  QStringList names;
  struct if_nameindex* all = if_nameindex();
  for (const struct if_nameindex* one = all; one != nullptr && one->if_index != 0; ++one) {
    names << QString::fromLocal8Bit(one->if_name);
  }
  if (all != nullptr) if_freenameindex(all);
  return names;
}

/// Makes the fields legible while disabled: the user must read what was joined.
void MakeLegibleWhenDisabled(QWidget& field) {
  QPalette palette = field.palette();
  for (const QPalette::ColorRole role : {QPalette::Text, QPalette::ButtonText}) {
    palette.setColor(QPalette::Disabled, role, palette.color(QPalette::Active, role));
  }
  field.setPalette(palette);
}

}  // namespace

SessionDock::SessionDock(SessionModel& session, SceneModel& scene, QWidget* parent)
    : QDockWidget(tr("Session"), parent),
      session_model_(session),
      scene_model_(scene),
      session_(new QLineEdit),
      name_(new QLineEdit),
      domain_(new QSpinBox),
      interface_(new QComboBox),
      join_(new QPushButton(tr("&Join"))),
      leave_(new QPushButton(tr("&Leave"))),
      state_(new QLabel),
      scene_name_(new QLabel),
      scene_size_(new QLabel),
      voxel_size_(new QLabel) {
  setObjectName("session_dock");
  setFeatures(DockWidgetMovable | DockWidgetFloatable);
  join_->setObjectName("join");
  leave_->setObjectName("leave");
  session_->setObjectName("session");
  state_->setObjectName("session_state");
  scene_size_->setObjectName("scene_size");
  scene_size_->setToolTip(
      tr("in the mesh files; moving bodies are drawn with smaller triangles, so that their colours "
         "show distances"));
  session_->setPlaceholderText(tr("name that the peers use"));
  domain_->setRange(0, static_cast<int>(kMaxDomain));
  interface_->setEditable(true);
  interface_->addItem(QString());
  interface_->addItems(Interfaces());
  interface_->lineEdit()->setPlaceholderText(tr("automatic"));
  for (QWidget* field : std::initializer_list<QWidget*>{session_, name_, domain_, interface_}) {
    MakeLegibleWhenDisabled(*field);
  }
  for (QLabel* label : {state_, scene_name_, scene_size_, voxel_size_}) {
    label->setTextFormat(Qt::PlainText);  // names and paths come from other peers
    label->setWordWrap(true);
    label->setTextInteractionFlags(Qt::TextSelectableByMouse);
    label->setFocusPolicy(Qt::NoFocus);
  }

  auto* body = new QWidget;
  auto* column = new QVBoxLayout(body);
  auto* form = new QFormLayout;
  form->addRow(tr("Session"), session_);
  form->addRow(tr("Your name"), name_);
  form->addRow(tr("Domain"), domain_);
  form->addRow(tr("Interface"), interface_);
  column->addLayout(form);
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(join_);
  buttons->addWidget(leave_);
  column->addLayout(buttons);
  column->addWidget(state_);
  column->addSpacing(8);
  auto* facts = new QFormLayout;
  facts->addRow(tr("Scene"), scene_name_);
  facts->addRow(tr("Shown"), scene_size_);
  facts->addRow(tr("Voxels"), voxel_size_);
  column->addLayout(facts);
  column->addStretch();
  setWidget(body);

  connect(join_, &QPushButton::clicked, this, &SessionDock::Join);
  connect(session_, &QLineEdit::returnPressed, join_, &QPushButton::click);
  connect(leave_, &QPushButton::clicked, &session_model_, &SessionModel::Leave);
  connect(&session_model_, &SessionModel::StateChanged, this, &SessionDock::ShowSession);
  connect(session_, &QLineEdit::textChanged, this, &SessionDock::ShowSession);
  connect(&scene_model_, &SceneModel::Changed, this, &SessionDock::ShowScene);
  ShowSession();
  ShowScene();
}

void SessionDock::SetRequest(const JoinRequest& request) {
  given_ = request;
  session_->setText(QString::fromStdString(request.session));
  name_->setText(QString::fromStdString(request.name));
  domain_->setValue(static_cast<int>(request.domain));
  interface_->setCurrentText(QString::fromStdString(request.interface));
}

JoinRequest SessionDock::Request() const {
  JoinRequest request = given_;
  request.session = session_->text().trimmed().toStdString();
  request.name = name_->text().trimmed().toStdString();
  request.domain = static_cast<std::uint32_t>(domain_->value());
  request.interface = interface_->currentText().trimmed().toStdString();
  return request;
}

void SessionDock::Join() {
  if (again_) {
    Q_EMIT AgainAsked();
  } else {
    session_model_.Join(Request());
  }
}

void SessionDock::OfferAgain(bool offered) {
  if (again_ == offered) return;
  again_ = offered;
  join_->setText(again_ ? tr("Start &again") : tr("&Join"));
  join_->setToolTip(again_
                        ? tr("Start a new hand in the same scene and session")
                        : tr("Look on at the session; Session > Join (Ctrl+J) gives you a hand"));
  ShowSession();
}

void SessionDock::ShowHand(const QString& text) {
  if (text == hand_text_) return;
  hand_text_ = text;
  ShowSession();
}

void SessionDock::ShowSession() {
  const SessionModel::State state = session_model_.state();
  const bool free = hand_text_.isEmpty() && !again_ && state != SessionModel::State::kJoining &&
                    state != SessionModel::State::kJoined;
  for (QWidget* field : std::initializer_list<QWidget*>{session_, name_, domain_, interface_}) {
    field->setEnabled(free);
  }
  join_->setEnabled(again_ || (free && !session_->text().trimmed().isEmpty()));
  leave_->setEnabled(state == SessionModel::State::kJoined);
  QString text = Describe(session_model_);
  if (state == SessionModel::State::kJoined && session_model_.has_peers()) {
    text += session_model_.request().secured ? tr("; secured: members only")
                                             : tr("; plain: anyone on the network can look on");
  } else if (state == SessionModel::State::kLeft) {
    text += tr(" \u201c%1\u201d: the picture shows the moment you left")
                .arg(QString::fromStdString(session_model_.request().session));
  }
  state_->setText(hand_text_.isEmpty() ? text : hand_text_);
}

void SessionDock::ShowScene() {
  const DrawnScene* scene = scene_model_.scene();
  const QString none = QStringLiteral("\u2013");
  scene_name_->setText(scene == nullptr ? none : QString::fromStdString(scene->name));
  scene_name_->setToolTip(
      scene == nullptr ? QString() : PlainToolTip(QString::fromStdString(scene->file.string())));
  const QLocale locale;
  scene_size_->setText(scene == nullptr ? none : SizeText(*scene));
  voxel_size_->setText(
      scene == nullptr ? none : tr("%1 mm").arg(locale.toString(1000 * scene->voxel_size, 'g', 3)));
}

}  // namespace tandem
