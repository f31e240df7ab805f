#pragma once

#include <QByteArray>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QProcess>
#include <QPushButton>
#include <QTreeWidget>

namespace tandem {

/// Asks which device moves the hand. It lists what `tandem devices` finds, with what is missing and
/// the line that mends it, beneath the mouse of the window itself; a line takes a device's options.
class DeviceDialog : public QDialog {
  Q_OBJECT

 public:
  /// `device`: NAME[:OPTIONS] that is in use; empty: the mouse.
  explicit DeviceDialog(const QString& device, QWidget* parent = nullptr);
  ~DeviceDialog() override;

  /// Runs `tandem devices --json` by that program and shows its answer once it comes.
  void Look(const QString& program);
  /// Shows the answer of `tandem devices --json`.
  void ShowDevices(const QByteArray& json);
  /// NAME[:OPTIONS] that was chosen; empty: the mouse.
  QString device() const;

 private:
  void ShowChosen();

  QString program_;
  QTreeWidget* list_;
  QLineEdit* device_;
  QLabel* mend_;
  QPushButton* look_;
  QProcess* process_ = nullptr;  // that looks for devices; null: none does
};

}  // namespace tandem
