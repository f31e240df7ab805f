#pragma once

#include <QString>
#include <QTextDocument>

namespace tandem {

/// Makes a tool tip that shows `text` literally. Qt would read HTML in it, and other peers choose
/// names and paths.
inline QString PlainToolTip(const QString& text) {
  if (!Qt::mightBeRichText(text)) return text;
  return QStringLiteral("<qt>") + text.toHtmlEscaped() + QStringLiteral("</qt>");
}

}  // namespace tandem
