#pragma once

#include <QComboBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QProcess>
#include <QPushButton>
#include <QSpinBox>
#include <QTimer>
#include <functional>

#include "app/view/model/hand/controller_link.h"

namespace tandem {

/// Asks how to join a session: as an active user or a viewer, and with the settings of --peers,
/// --external-address, --port and --secure. An invitation's line fills most fields. Lists the
/// sessions that are open on this network. Faults of fields are shown beside the buttons, and the
/// button that joins is grey meanwhile.
class JoinDialog : public QDialog {
  Q_OBJECT

 public:
  explicit JoinDialog(QWidget* parent = nullptr);
  ~JoinDialog() override;

  void SetRequest(const HandRequest& request, bool active);
  HandRequest Request() const;
  bool active() const;
  /// Returns the invitation's line; empty: none.
  QString invitation() const;
  /// Returns what is wrong with the fields; empty: nothing.
  QString Fault() const;
  /// Looks for open sessions with that program's `tandem sessions` while the dialog is open, by the
  /// domain, interface and peers in its fields.
  void Look(const QString& program);
  /// Shows the answer of `tandem sessions --json`.
  void ShowSessions(const QByteArray& json);

 private:
  void Check();
  void TakeLine();
  /// Returns the arguments of the search, by the fields.
  QStringList SearchWords() const;
  /// Ends the search under way and begins another one.
  void LookAgain();
  QWidget* WithChooser(QLineEdit* field, const QString& title, bool folder);

  HandRequest given_;
  QLineEdit* invitation_;
  QListWidget* sessions_;
  QProcess* process_ = nullptr;  // process that looks for sessions; null: none
  QString program_;              // program that looks; empty: nobody looks
  QStringList searched_;         // arguments of the search under way
  QTimer changed_;               // until the fields have been left alone for a moment
  QLineEdit* session_;
  QLineEdit* name_;
  QComboBox* role_;
  QLineEdit* scene_;
  QLineEdit* peers_;
  QLineEdit* external_;
  QSpinBox* port_;
  QSpinBox* domain_;
  QLineEdit* interface_;
  QLineEdit* secure_;
  QLabel* fault_;
  QPushButton* join_;
};

}  // namespace tandem
