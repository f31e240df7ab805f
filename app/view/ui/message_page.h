#pragma once

#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QWidget>

namespace tandem {

/// Stands where the picture would be and says why there is none.
class MessagePage : public QWidget {
  Q_OBJECT

 public:
  explicit MessagePage(QWidget* parent = nullptr);

  /// `percent` below 0: no progress bar.
  void Show(const QString& title, const QString& text, int percent = -1);
  /// Whether there is a button to open a scene.
  void OfferOpening(bool offered) { open_->setVisible(offered); }
  /// Whether there is a button to load the file that the session names.
  void OfferNamed(bool offered) { load_->setVisible(offered); }
  /// Whether there is a button to fetch the scene from the session.
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
