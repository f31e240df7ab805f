#pragma once

#include <QByteArray>
#include <QComboBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QProcess>
#include <QPushButton>

#include "app/reach/hand_request.h"

namespace tandem {

/// Invites somebody to the session that one is in, by `tandem invite`: shows its line and copies
/// it. In a secured session the line is good while the dialog is open, until it is used.
class InviteDialog : public QDialog {
  Q_OBJECT

 public:
  /// `session`: how one is in it oneself. `program`: `tandem`.
  InviteDialog(const HandRequest& session, QString program, QWidget* parent = nullptr);
  /// Takes back a line that nobody has used.
  ~InviteDialog() override;

  /// What `tandem` is started with.
  QStringList Words() const;
  /// What is wrong with the fields; empty: nothing.
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
  QProcess* process_ = nullptr;  // that makes the line and waits for its use; null: none does
  QByteArray answer_;
  QString told_;  // the newest line that it has said
};

}  // namespace tandem
