#pragma once

#include <QByteArray>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QProcess>
#include <QPushButton>
#include <QTreeWidget>

namespace tandem {

/// Asks which device moves the hand. Lists the window's own mouse and what `tandem devices` finds,
/// with what is missing and the line that mends it. A text line takes a device's options.
class DeviceDialog : public QDialog {
  Q_OBJECT

 public:
  /// `device`: NAME[:OPTIONS] in use; empty: the mouse.
  explicit DeviceDialog(const QString& device, QWidget* parent = nullptr);
  ~DeviceDialog() override;

  /// Runs that program's `tandem devices --json` and shows its answer when it comes.
  void Look(const QString& program);
  /// Shows the answer of `tandem devices --json`.
  void ShowDevices(const QByteArray& json);
  /// Returns the chosen NAME[:OPTIONS]; empty: the mouse.
  QString device() const;

 private:
  void ShowChosen();

  QString program_;
  QTreeWidget* list_;
  QLineEdit* device_;
  QLabel* mend_;
  QPushButton* look_;
  QProcess* process_ = nullptr;  // process that looks for devices; null: none
};

}  // namespace tandem
