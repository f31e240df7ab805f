#pragma once

#include <QByteArray>
#include <QComboBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QProcess>
#include <QPushButton>

#include "app/connection/hand_request.h"

namespace tandem {

/// Invites a person to the session in use by `tandem invite`: shows the line and copies it. In a
/// secured session the line is valid while the dialog is open, until it is used.
class InviteDialog : public QDialog {
  Q_OBJECT

 public:
  /// `session`: how the user takes part in it. `program`: `tandem`.
  InviteDialog(const HandRequest& session, QString program, QWidget* parent = nullptr);
  /// Withdraws an unused line.
  ~InviteDialog() override;

  /// Returns the arguments for `tandem`.
  QStringList Words() const;
  /// Returns what is wrong with the fields; empty: nothing.
  QString Fault() const;
  /// Shows the answer of `tandem invite --json` and copies its line.
  void ShowLine(const QByteArray& json);

 private:
  void Check();
  void Make();
  void OnWords();
  void OnEnd(int exit_code);

  HandRequest session_;
  QString program_;
  QLineEdit* name_;
  QComboBox* role_;
  QLineEdit* keys_;
  QLineEdit* line_;
  QLabel* state_;
  QPushButton* make_;
  QProcess* process_ = nullptr;  // process that makes the line and waits for its use; null: none
  QByteArray answer_;
  QString reported_;  // newest line that the process has said
};

}  // namespace tandem
