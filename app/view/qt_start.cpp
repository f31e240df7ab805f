#include "app/view/qt_start.h"

#include <QString>
#include <QtGlobal>
#include <cstdio>
#include <cstdlib>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "app/common/exit_codes.h"

namespace tandem {

namespace {

/// The state of a start for the message handler of Qt, which is a plain function.
struct State {
  int held_back = -1;  // file that takes the place of stderr
  int error = -1;      // stderr
  std::string words;   // Qt's own
  QtMessageHandler before = nullptr;
};
State g_state;

std::string Environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr ? value : "";
}

std::string HeldBack() {
  std::string text;
  char bytes[4096];
  off_t at = 0;
  for (ssize_t count = 0; (count = pread(g_state.held_back, bytes, sizeof bytes, at)) > 0;) {
    text.append(bytes, static_cast<std::size_t>(count));
    at += count;
  }
  return text;
}

void WriteAll(int file, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = write(file, text.data() + at, text.size() - at);
    if (count <= 0) return;
    at += static_cast<std::size_t>(count);
  }
}

void OnMessage(QtMsgType type, const QMessageLogContext& context, const QString& message) {
  if (type != QtFatalMsg) {
    g_state.words += message.toStdString() + "\n";
    if (type != QtDebugMsg && g_state.before != nullptr) g_state.before(type, context, message);
    return;
  }
  const std::string line =
      WhyQtCannotStart(Environment("QT_QPA_PLATFORM"), Environment("DISPLAY"),
                       g_state.words + message.toStdString() + "\n" + HeldBack());
  WriteAll(g_state.error, "tandem-view: " + line + "\n");
  _exit(kExitDisplay);
}

bool Has(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

/// Returns the list that Qt ends its complaint with: "eglfs, offscreen, xcb"; empty: none.
std::string AvailableIn(const std::string& words) {
  const std::string begin = "Available platform plugins are: ";
  const std::size_t at = words.find(begin);
  if (at == std::string::npos) return {};
  const std::size_t from = at + begin.size();
  return words.substr(from, words.find_first_of(".\n", from) - from);
}

}  // namespace

QtStart::QtStart() {
  g_state.held_back = memfd_create("tandem-view-start", MFD_CLOEXEC);
  g_state.error = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (g_state.error < 0) g_state.error = STDERR_FILENO;
  if (g_state.held_back >= 0) dup2(g_state.held_back, STDERR_FILENO);
  g_state.before = qInstallMessageHandler(OnMessage);
}

void QtStart::Succeeded() {
  if (!under_way_) return;
  under_way_ = false;
  qInstallMessageHandler(nullptr);
  if (g_state.held_back < 0) return;
  dup2(g_state.error, STDERR_FILENO);
  WriteAll(STDERR_FILENO, HeldBack());
  close(g_state.held_back);
  close(g_state.error);
  g_state = {};
}

std::string WhyQtCannotStart(const std::string& platform, const std::string& display,
                             const std::string& words) {
  const std::string remedy =
      " (xvfb-run gives a display without a screen, `tandem watch` needs none)";
  if (Has(words, "Could not find the Qt platform plugin")) {
    const std::string available = AvailableIn(words);
    return "no display: Qt's platform \"" + platform + "\", which QT_QPA_PLATFORM asks for, is " +
           (platform == "wayland" || platform.rfind("wayland", 0) == 0
                ? "not installed: install the package qt6-wayland, or unset QT_QPA_PLATFORM"
                : "not installed: unset QT_QPA_PLATFORM") +
           (available.empty() ? "" : "; there are " + available);
  }
  if (Has(words, "uthorization") || Has(words, "Maximum number of clients")) {
    return "no display: the program at DISPLAY " + display +
           " refuses this one: let XAUTHORITY name the file of the display's user, or start the "
           "program as that user" +
           remedy;
  }
  if (Has(words, "could not connect to display")) {
    return "no display: no program answers at DISPLAY " + display + remedy;
  }
  const std::string which =
      platform.empty() ? "Qt's platform" : "Qt's platform \"" + platform + "\"";
  return "no display: " + which +
         " does not start: check DISPLAY, WAYLAND_DISPLAY and QT_QPA_PLATFORM" + remedy;
}

}  // namespace tandem
