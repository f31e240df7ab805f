#pragma once

#include <QFrame>
#include <QPushButton>
#include <QStringList>
#include <functional>
#include <vector>

namespace tandem {

/// Notices at the lower edge of another widget, each with a line or more of text and at most two
/// buttons. A notice stays until its owner takes it away or a button is pressed. No button takes
/// the keys: Space stops the hand at any time.
class NoticeBar : public QFrame {
  Q_OBJECT

 public:
  struct Choice {
    QString text;
    std::function<void()> act;
  };
  /// `over`: the widget at whose lower edge it lies, its parent.
  explicit NoticeBar(QWidget* over);

  /// Shows a notice, in place of an earlier one with this name.
  void Show(const QString& name, const QString& text, const std::vector<Choice>& choices);
  void Hide(const QString& name);
  /// Returns the text of the notice with that name; empty: there is none.
  QString Text(const QString& name) const;

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  struct Row {
    QString name;
    QString text;
    QStringList buttons;
    QWidget* widget = nullptr;
  };
  QWidget* MakeRow(const QString& name, const QString& text, const std::vector<Choice>& choices);
  void Place();

  std::vector<Row> rows_;
};

}  // namespace tandem
