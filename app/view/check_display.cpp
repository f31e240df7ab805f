#include "app/view/check_display.h"

#include <QApplication>
#include <QSurfaceFormat>
#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/view/options.h"
#include "app/view/render/gl_check.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/json_text.h"

namespace tandem {

int CheckDisplayFor(int to, int argc, char** argv) {
  // Qt may end the program, and says why on stderr
  dup2(to, STDERR_FILENO);
  if (const std::string trouble = DisplayTrouble(); !trouble.empty()) {
    dprintf(to, "%s\n", CleanText(trouble).c_str());
    return kExitDisplay;
  }
  QSurfaceFormat::setDefaultFormat(RendererFormat());
  const QApplication app(argc, argv);
  const Result<GlInfo> gl = CheckGl();
  const nlohmann::ordered_json found{{"platform", QGuiApplication::platformName().toStdString()},
                                     {"version", gl ? gl->version : std::string()},
                                     {"renderer", gl ? gl->renderer : std::string()},
                                     {"software", gl && gl->software},
                                     {"fault", gl ? std::string() : gl.error().what}};
  dprintf(to, "%s\n", JsonText(found).c_str());
  return gl ? kExitOk : kExitDisplay;
}

}  // namespace tandem
