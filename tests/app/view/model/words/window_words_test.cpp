#include "app/view/model/words/window_words.h"

#include <QDirIterator>
#include <QFile>
#include <QRegularExpression>
#include <array>
#include <utility>

#include <gtest/gtest.h>

namespace tandem {
namespace {

/// Tells what a user of a mouse cannot do.
bool NamesACommand(const QString& text) {
  static const QRegularExpression command(
      QStringLiteral("--[a-z]|\\btype '|'(?:give|grab|resume|tandem)\\b[^']*'|`tandem"));
  return text.contains(command);
}

TEST(WindowWords, NameFieldsInPlaceOfOptions) {
  const std::array<std::pair<const char*, const char*>, 10> lines{
      {{"this machine has several networks; --interface chooses one",
        "this machine has several networks; the field \u201cInterface\u201d chooses one"},
       {"no peer answers in session press: it is plain, but you came with keys: leave --secure out",
        "no peer answers in session press: it is plain, but you came with keys: leave the field "
        "\u201cKeys\u201d empty"},
       {"ben asks for p5, which you hold: 'give p5 ben' hands it over",
        "ben asks for p5, which you hold"},
       {"device: no force after a fault; type 'resume' to get it back",
        "device: no force after a fault; Resume (Ctrl+Space) brings it back"},
       {"the session uses voxel 1 mm; this peer adopts them (--insist keeps voxel 2 mm)",
        "the session uses voxel 1 mm; this peer adopts them"},
       {"they differ by more than a factor of 4, which needs much more memory; --adopt-any takes "
        "the session's voxels, --insist keeps yours",
        "they differ by more than a factor of 4, which needs much more memory"},
       {"no controller 'x' on this machine: 'tandem peer --control x …' starts one",
        "no controller 'x' on this machine"},
       {"the host 'tandem-view' ends the controller", "the host 'tandem-view' ends the controller"},
       {"in 3 % of the frames contact took long; larger voxels or more --threads help",
        "in 3 % of the frames contact took long; larger voxels help"},
       {"peg stands 60.0 mm from its first place and is out; it touched nothing",
        "peg stands 60.0 mm from its first place and is out; it touched nothing"}}};
  for (const auto& [line, shown] : lines) {
    EXPECT_EQ(WordsForWindow(QString::fromUtf8(line)).toStdString(), shown);
  }
}

/// Calls use(text, file) for the text of each string literal; neighbours count as one.
template <typename Use>
void ForEachText(const QString& folder, Use use) {
  static const QRegularExpression literal(QStringLiteral("(?:\"(?:[^\"\\\\\n]|\\\\.)*\"\\s*)+"));
  static const QRegularExpression border(QStringLiteral("\"\\s*\""));
  QDirIterator files(folder, {"*.cpp", "*.h"}, QDir::Files, QDirIterator::Subdirectories);
  while (files.hasNext()) {
    QFile file(files.next());
    ASSERT_TRUE(file.open(QIODevice::ReadOnly)) << file.fileName().toStdString();
    QRegularExpressionMatchIterator found = literal.globalMatch(QString::fromUtf8(file.readAll()));
    while (found.hasNext()) {
      QString text = found.next().captured().trimmed();
      text = text.mid(1, text.size() - 2).replace(border, QString());
      use(text, file.fileName());
    }
  }
}

// All that a controller, its files and its network can say passes through here on its way to the
// window. So the texts of their sources are tried, each of them.
TEST(WindowWords, NoTextOfAControllerTellsAMouseUserToType) {
  int tried = 0;
  for (const char* folder : {"app/peer", "app/connection", "app/process", "app/judgement", "collab",
                             "engine/scene", "engine/world", "engine/realtime"}) {
    ForEachText(
        QStringLiteral(TANDEM_SOURCES "/") + folder, [&](const QString& text, const QString& file) {
          if (!NamesACommand(text)) return;
          ++tried;
          const QString shown = WordsForWindow(text);
          EXPECT_FALSE(NamesACommand(shown)) << file.toStdString() << ": " << shown.toStdString();
          EXPECT_FALSE(shown.isEmpty()) << text.toStdString();
        });
  }
  EXPECT_GT(tried, 20);  // the search finds them
}

// The window's own texts pass through nothing.
TEST(WindowWords, TheWindowsOwnTextsNameNoCommand) {
  for (const char* folder : {"app/view/model", "app/view/ui"}) {
    ForEachText(
        QStringLiteral(TANDEM_SOURCES "/") + folder, [&](const QString& text, const QString& file) {
          // words of a command line, and the table of what is replaced
          if (text.startsWith("--") || file.endsWith("window_words.cpp")) return;
          EXPECT_FALSE(NamesACommand(text)) << file.toStdString() << ": " << text.toStdString();
        });
  }
}

}  // namespace
}  // namespace tandem
