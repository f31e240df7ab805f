#pragma once

#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QWidget>

namespace tandem {

/// A page in place of the picture that says why there is none.
class MessagePage : public QWidget {
  Q_OBJECT

 public:
  explicit MessagePage(QWidget* parent = nullptr);

  /// Shows a title, a text and a progress bar; `percent` below 0: no bar.
  void Show(const QString& title, const QString& text, int percent = -1);
  /// Shows or hides a button that opens a scene.
  void OfferOpening(bool offered) { open_->setVisible(offered); }
  /// Shows or hides a button that loads the file the session names.
  void OfferNamed(bool offered) { load_->setVisible(offered); }
  /// Shows or hides a button that fetches the scene from the session.
  void OfferFetching(bool offered) { fetch_->setVisible(offered); }
  QString text() const { return title_->text() + QStringLiteral("\n") + text_->text(); }

 Q_SIGNALS:
  void OpenAsked();
  void NamedAsked();
  void FetchingAsked();

 private:
  QLabel* title_;
  QLabel* text_;
  QProgressBar* progress_;
  QPushButton* open_;
  QPushButton* load_;
  QPushButton* fetch_;
};

}  // namespace tandem
