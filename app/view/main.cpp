#include <QApplication>
#include <QSurfaceFormat>
#include <algorithm>
#include <memory>
#include <stop_token>

#include "app/common/exit_codes.h"
#include "app/common/output_file.h"
#include "app/common/stop_signal.h"
#include "app/connection/fetch_consent.h"
#include "app/connection/recent_scenes.h"
#include "app/connection/scene_search.h"
#include "app/connection/session_scene.h"
#include "app/view/check_display.h"
#include "app/view/controller_process.h"
#include "app/view/options.h"
#include "app/view/paint_pictures.h"
#include "app/view/program_lines.h"
#include "app/view/qt_start.h"
#include "app/view/render/gl_check.h"
#include "app/view/time_pictures.h"
#include "app/view/ui/main_window.h"
#include "app/view/unattended_run.h"
#include "collab/dds/transport/announcements.h"
#include "collab/dds/transport/relay.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/realtime/line_writer.h"
#include "engine/scene/scene.h"

namespace {

using namespace tandem;

/// Loads a scene to draw, and says on stderr what its mesh files say and their readers do not
/// honour.
Result<DrawnScene> LoadAndSay(const std::filesystem::path& file, const LoadProgress& progress) {
  Result<DrawnScene> drawn = LoadDrawnScene(file, progress);
  if (!drawn) return drawn;
  for (const std::string& remark : drawn->remarks) {
    SayFromView(remark);
  }
  return drawn;
}

/// Returns the options of the command line, or those of the window's fields.
ConnectionOptions ReachBy(ConnectionOptions connection, const JoinRequest& request) {
  connection.domain = request.domain;
  connection.interface = request.interface;
  if (!request.chosen_here) return connection;
  connection.peers = request.peers;
  connection.external_address = request.external_address;
  connection.port = request.port;
  connection.secure = request.secure;
  return connection;
}

/// Joins over DDS by the options of the command line, with the domain and interface of the form.
JoinFunction JoinBy(const ConnectionOptions& connection, SceneFetcher& fetcher) {
  return [connection, &fetcher](const JoinRequest& request, PeerId peer,
                                Inbox& inbox) -> Result<std::unique_ptr<Transport>> {
    DdsOptions options;
    options.session = request.session;
    options.peer = peer;
    if (request.chosen_here && request.secured) {
      std::string name = request.name;
      const Result<PeerId> id = Identify(ReachBy(connection, request), Role::kViewer, name);
      if (!id) return id.error();
      options.peer = *id;
    }
    options.role = Role::kViewer;
    options.files = fetcher.PartyOf(options.peer, ReachBy(connection, request).secure);
    ApplyConnection(ReachBy(connection, request), options);
    if (request.from_relay) GoToRelay(options);
    return JoinOverDds(options, inbox);
  };
}

/// Listens for other sessions on the same network.
ListenFunction ListenBy(const ConnectionOptions& connection) {
  return [connection](const JoinRequest& request) {
    DdsOptions options;
    options.session = request.session;
    ApplyConnection(ReachBy(connection, request), options);
    if (request.from_relay) GoToRelay(options);
    return ListenForSessions(options);
  };
}

FindFunction FindBy(const std::shared_ptr<SceneFetcher>& fetcher) {
  return [fetcher](const SceneManifest& manifest) -> SceneSearchResult {
    const std::vector<std::filesystem::path> folders = FoldersWithScenes();
    return {FindScene(WantedFrom(manifest, fetcher->keys()), folders), folders};
  };
}

/// Fetches scenes from the window's session. A press of the button consents to small files, a
/// second press to large ones.
FetchFunction FetchBy(const std::shared_ptr<SceneFetcher>& fetcher) {
  const auto consent = std::make_shared<FetchConsent>();
  return [fetcher, consent](const SceneManifest& manifest,
                            const LoadProgress& progress) -> Result<std::filesystem::path> {
    std::stop_source stop;
    std::string what = "requesting its files";
    SessionSceneOptions options;
    options.say = [&what](const std::string& line) {
      what = line;
    };
    options.refuses = [&](const OfferedScene& offered) {
      return consent->Refuses(manifest.content_digest, offered);
    };
    options.progress = [&](std::uint64_t bytes, std::uint64_t of) {
      if (!progress(bytes, of, what)) stop.request_stop();
    };
    options.stop = stop.get_token();
    const SessionScene scene = fetcher->Fetch(manifest, options);
    if (!scene.file.empty()) return scene.file;
    return Error{scene.fault.empty() ? "the fetch did not finish" : scene.fault};
  };
}

/// Does in the window what the command line asks for.
void Begin(const ViewOptions& options, MainWindow& window, SessionModel& session,
           SceneModel& scene) {
  if (options.attach) {
    window.panel()->hand().TakeUp(options.hand.control, options.hand.name, options.own,
                                  options.hand.secure);
  } else if (!options.open.empty() || options.take_part) {
    window.panel()->TakePart(options.hand);
  } else {
    if (!options.scene.empty()) scene.OpenNamed(options.scene);
    if (!options.join.session.empty()) session.Join(options.join);
  }
}

/// Prints the verdicts of a session that has ended, for a user who started the window at a
/// terminal.
void SayVerdicts(const QStringList& lines) {
  for (const QString& line : lines) {
    SayFromView(line.toStdString());
  }
}

}  // namespace

int main(int argc, char** argv) {
  RunImportHelperIfAsked(argc, argv);
  HandleSignals();
  int exit_code = kExitOk;
  const std::optional<ViewOptions> options = ReadOptions(argc, argv, exit_code);
  if (!options) return exit_code;
  if (options->check_display >= 0) {
    int none = 1;  // Qt gets none of the arguments
    return CheckDisplayFor(options->check_display, none, argv);
  }
  if (!options->paint.empty()) return PaintPictures(options->paint, options->paint_into);
  for (const std::string& file : {options->report, options->screenshot, options->time_pictures}) {
    const std::string fault = file.empty() ? "" : WhyNotWritable(file);
    if (!fault.empty()) return FailFromView(kExitFile, fault);
  }
  for (const std::string& file : {options->scene, options->open}) {
    if (file.empty()) continue;
    const Result<Scene> scene = LoadScene(file);
    if (!scene) return FailFromView(kExitFile, scene.error().what);
    RememberSceneFolder(file);
  }
  if (!options->open.empty()) RememberScene(options->open);
  if (const std::string trouble = DisplayTrouble(); !trouble.empty()) {
    return FailFromView(kExitDisplay, trouble);
  }
  // Without a GPU Mesa would draw with all cores. They belong to a peer's 1 kHz thread if there is
  // one.
  if (!qEnvironmentVariableIsSet("LP_NUM_THREADS")) qputenv("LP_NUM_THREADS", "1");
  QSurfaceFormat::setDefaultFormat(RendererFormat());
  int qt_argc = 1;  // Qt gets none of the arguments
  QtStart start;
  QApplication app(qt_argc, argv);
  start.Succeeded();
  QApplication::setApplicationName(QStringLiteral("tandem-view"));
  if (!options->time_pictures.empty()) {
    return TimePictures(options->scene, options->rounds, options->time_pictures);
  }

  const auto fetcher = std::make_shared<SceneFetcher>();  // outlives the session's transport
  SessionModel session(JoinBy(options->connection, *fetcher), ListenBy(options->connection));
  SceneModel scene(LoadAndSay, FindBy(fetcher));
  scene.SetFetch(FetchBy(fetcher));
  const Result<GlInfo> gl = CheckGl();
  if (!gl) FailFromView(kExitDisplay, gl.error().what);
  HandModel hand(AttachController, LaunchController);
  QObject::connect(&hand, &HandModel::SessionEnded, &SayVerdicts);
  MainWindow window(session, scene, gl, &hand);
  window.panel()->SetDefaults(options->hand);
  UnattendedRun unattended(*options, window, session);
  std::vector<std::filesystem::path> folders = FoldersWithScenes();
  if (folders.size() > 1) std::rotate(folders.begin(), folders.begin() + 1, folders.end());
  window.SetSceneFolders(folders);  // the folder used last first, or that of the scenes that come
                                    // with the program
  QObject::connect(&window, &MainWindow::SceneChosen, [&window](const QString& file) {
    RememberSceneFolder(file.toStdString());
    RememberScene(file.toStdString());
    window.SetRecentScenes(RecentScenes());
  });
  window.SetRecentScenes(RecentScenes());
  window.session_dock().SetRequest(options->join);
  window.ShowProximity(options->proximity);
  if (options->blind) window.ShowSceneAlone();
  window.show();
  Begin(*options, window, session, scene);
  QApplication::exec();
  hand.Leave();  // while its verdicts can be told
  return unattended.Finish();
}
