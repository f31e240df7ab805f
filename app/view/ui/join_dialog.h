#pragma once

#include <QComboBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSpinBox>
#include <functional>

#include "app/view/model/controller_link.h"

namespace tandem {

/// Asks how a session is joined: as an active user or a viewer, and all that the command line says
/// by --peers, --external-address, --port and --secure. Wrong fields are said beside the buttons,
/// and the button that joins is grey meanwhile.
class JoinDialog : public QDialog {
  Q_OBJECT

 public:
  explicit JoinDialog(QWidget* parent = nullptr);

  void SetRequest(const HandRequest& request, bool active);
  HandRequest Request() const;
  bool active() const;
  /// What is wrong with the fields; empty: nothing.
  QString Fault() const;

 private:
  void Check();
  QWidget* WithChooser(QLineEdit* field, const QString& title, bool folder);

  HandRequest given_;
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
