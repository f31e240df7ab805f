#pragma once

#include <QString>
#include <QTextDocument>

namespace tandem {

/// A tool tip that shows `text` letter by letter: Qt takes what looks like HTML for it, and others
/// choose names and paths.
inline QString PlainToolTip(const QString& text) {
  if (!Qt::mightBeRichText(text)) return text;
  return QStringLiteral("<qt>") + text.toHtmlEscaped() + QStringLiteral("</qt>");
}

}  // namespace tandem
