#include "app/view/model/words/window_words.h"

#include <QCoreApplication>
#include <QRegularExpression>
#include <QStringList>
#include <array>

namespace tandem {

namespace {

struct Replacement {
  const char* from;
  const char* to;
};

/// Phrases that no field's name alone puts right.
constexpr std::array kPhrases{
    Replacement{"larger voxels or more --threads help", "larger voxels help"},
    Replacement{"a larger --voxel-memory or a faster disk helps", "a faster disk helps"},
    Replacement{"leave --secure out", "leave the field \u201cKeys\u201d empty"},
    Replacement{"domain or --secure another one", "domain or keys another one"},
    Replacement{"name the scene with --scene", "open the scene (Ctrl+O)"},
    Replacement{"; type 'resume' to get it back", "; Resume (Ctrl+Space) brings it back"},
    Replacement{"; type 'resume' to end it", "; Resume (Ctrl+Space) ends it"},
    Replacement{": type 'resume' to get force again", ": Resume (Ctrl+Space) brings force back"},
    Replacement{": type it again", ": try again"}};

/// The options that have a field in the dialog "Take part in a session" or in the window.
constexpr std::array kFields{
    Replacement{"--session", "Session"},     Replacement{"--name", "Your name"},
    Replacement{"--role", "Role"},           Replacement{"--scene", "Scene"},
    Replacement{"--peers", "Peers"},         Replacement{"--external-address", "External address"},
    Replacement{"--port", "Port"},           Replacement{"--domain", "Domain"},
    Replacement{"--interface", "Interface"}, Replacement{"--secure", "Keys"},
    Replacement{"--device", "Device"}};

const QRegularExpression& Option() {
  static const QRegularExpression option(QStringLiteral("--[a-z][a-z-]*"));
  return option;
}

/// Returns whether a part of a line tells what to type.
bool TellsToType(const QString& part) {
  static const QRegularExpression command(QStringLiteral(
      "\\btype '|'(?:tandem(?:-view)? |(?:grab|give|ask|release|heal|stop|resume|clutch)\\b)"
      "[^']*'|`[^`]*`|\\btandem(?:-view)? [a-z]+ |\\btandem [a-z]+$"));
  return part.contains(Option()) || part.contains(command);
}

QString WithFields(QString line) {
  QRegularExpressionMatchIterator found = Option().globalMatch(line);
  QString text;
  qsizetype at = 0;
  while (found.hasNext()) {
    const QRegularExpressionMatch match = found.next();
    text += line.mid(at, match.capturedStart() - at);
    QString word = match.captured();
    for (const Replacement& field : kFields) {
      if (word != QLatin1String(field.from)) continue;
      word = QCoreApplication::translate("Fields", "the field \u201c%1\u201d")
                 .arg(QCoreApplication::translate("Fields", field.to));
      break;
    }
    text += word;
    at = match.capturedEnd();
  }
  return text + line.mid(at);
}

}  // namespace

QString WordsForWindow(const QString& line) {
  QString text = line;
  for (const Replacement& phrase : kPhrases) {
    text.replace(QLatin1String(phrase.from), QString::fromUtf8(phrase.to));
  }
  text = WithFields(text);
  if (!TellsToType(text)) return text;
  // remarks in brackets first, then the parts between colons and semicolons
  static const QRegularExpression bracket(QStringLiteral(" ?\\([^()]*\\)"));
  QRegularExpressionMatchIterator found = bracket.globalMatch(text);
  QStringList remarks;
  while (found.hasNext()) remarks << found.next().captured();
  for (const QString& remark : remarks) {
    if (TellsToType(remark)) text.remove(remark);
  }
  static const QRegularExpression border(QStringLiteral("[:;] "));
  QString kept;
  qsizetype at = 0;
  QString before;  // border before the part
  while (at <= text.size()) {
    const QRegularExpressionMatch next = border.match(text, at);
    const qsizetype end = next.hasMatch() ? next.capturedStart() : text.size();
    const QString part = text.mid(at, end - at);
    if (!TellsToType(part)) kept += (kept.isEmpty() ? QString() : before) + part;
    if (!next.hasMatch()) break;
    before = next.captured();
    at = next.capturedEnd();
  }
  if (!kept.trimmed().isEmpty()) return kept.trimmed();
  return QCoreApplication::translate("Fields", "That is possible at a terminal only");
}

}  // namespace tandem
