#include "app/view/ui/dialogs/device_dialog.h"

#include <QDialogButtonBox>
#include <QHeaderView>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include "engine/realtime/private_process.h"

namespace tandem {

namespace {

enum Column : int { kDevice, kState, kWhat };
enum ItemData : int { kName = Qt::UserRole, kMend };

}  // namespace

DeviceDialog::DeviceDialog(const QString& device, QWidget* parent)
    : QDialog(parent), list_(new QTreeWidget), device_(new QLineEdit(device)), mend_(new QLabel) {
  setWindowTitle(tr("Device"));
  resize(720, 420);
  list_->setObjectName(QStringLiteral("devices"));
  list_->setHeaderLabels({tr("Device"), tr("State"), tr("What it is")});
  list_->setRootIsDecorated(false);
  list_->setUniformRowHeights(true);
  list_->header()->setSectionResizeMode(kDevice, QHeaderView::ResizeToContents);
  list_->header()->setSectionResizeMode(kState, QHeaderView::ResizeToContents);
  device_->setObjectName(QStringLiteral("device"));
  device_->setPlaceholderText(tr("the mouse of this window; or NAME:OPTIONS"));
  mend_->setObjectName(QStringLiteral("mend"));
  mend_->setTextFormat(Qt::PlainText);  // drivers wrote the text
  mend_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  mend_->setWordWrap(true);
  mend_->setMinimumHeight(3 * fontMetrics().lineSpacing());
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
  buttons->button(QDialogButtonBox::Ok)->setText(tr("&Use"));
  look_ = buttons->addButton(tr("&Look again"), QDialogButtonBox::ActionRole);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(list_);
  layout->addWidget(mend_);
  layout->addWidget(device_);
  layout->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(look_, &QPushButton::clicked, this, [this] {
    Look(program_);
  });
  connect(list_, &QTreeWidget::currentItemChanged, this, &DeviceDialog::ShowChosen);
  connect(list_, &QTreeWidget::itemDoubleClicked, this, &QDialog::accept);
  ShowDevices({});
}

DeviceDialog::~DeviceDialog() {
  if (process_ == nullptr) return;
  process_->disconnect(this);
  process_->kill();
  process_->waitForFinished(1000);
}

void DeviceDialog::Look(const QString& program) {
  program_ = program;
  if (process_ != nullptr) return;
  look_->setEnabled(false);
  mend_->setText(tr("Looking for devices\u2026"));
  process_ = new QProcess(this);
  process_->setChildProcessModifier(&CloseOthersOnExec);
  const auto ended = [this](const QString& fault) {
    const QByteArray output = process_->readAllStandardOutput();
    process_->deleteLater();
    process_ = nullptr;
    look_->setEnabled(true);
    ShowDevices(output);
    if (!fault.isEmpty()) mend_->setText(fault);
  };
  connect(process_, &QProcess::finished, this, [ended](int, QProcess::ExitStatus) {
    ended({});
  });
  connect(process_, &QProcess::errorOccurred, this, [this, ended](QProcess::ProcessError error) {
    if (error == QProcess::FailedToStart) {
      ended(tr("%1 cannot be started: %2").arg(program_, process_->errorString()));
    }
  });
  process_->setStandardErrorFile(QProcess::nullDevice());
  process_->start(program, {QStringLiteral("devices"), QStringLiteral("--json")});
}

void DeviceDialog::ShowDevices(const QByteArray& json) {
  const QString wanted = device_->text();
  list_->clear();
  const auto add = [this](const QString& name, const QString& state, const QString& what) {
    auto* item = new QTreeWidgetItem(list_);
    item->setText(kDevice, name.isEmpty() ? tr("mouse of this window") : name);
    item->setText(kState, state);
    item->setText(kWhat, what);
    item->setData(kDevice, kName, name);
    return item;
  };
  QTreeWidgetItem* current = add({}, tr("there"), tr("drags parts in the picture"));
  const QJsonArray devices =
      QJsonDocument::fromJson(json).object().value(QStringLiteral("devices")).toArray();
  for (const QJsonValue& value : devices) {
    const QJsonObject one = value.toObject();
    const auto text = [&one](const char* key) {
      return one.value(QLatin1String(key)).toString();
    };
    const bool is_present = one.value(QStringLiteral("present")).toBool();
    QTreeWidgetItem* item =
        add(text("name"), is_present ? tr("there") : tr("missing"), text("kind"));
    const QString mend = text("missing").isEmpty()
                             ? QString()
                             : tr("Missing: %1\nTo fix it: %2").arg(text("missing"), text("mend"));
    item->setData(kDevice, kMend, mend);
    if (!wanted.isEmpty() &&
        wanted.section(QLatin1Char(':'), 0, 0) == text("name").section(QLatin1Char(':'), 0, 0)) {
      current = item;
    }
  }
  const QSignalBlocker quiet(list_);  // keeps what was typed
  list_->setCurrentItem(current);
  mend_->setText(current->data(kDevice, kMend).toString());
}

void DeviceDialog::ShowChosen() {
  const QTreeWidgetItem* item = list_->currentItem();
  if (item == nullptr) return;
  mend_->setText(item->data(kDevice, kMend).toString());
  device_->setText(item->data(kDevice, kName).toString());
}

QString DeviceDialog::device() const {
  return device_->text().trimmed();
}

}  // namespace tandem
