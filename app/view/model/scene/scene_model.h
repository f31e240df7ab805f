#pragma once

#include <QObject>
#include <QString>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "app/view/model/scene/drawn_scene.h"
#include "collab/session/messages.h"

namespace tandem {

/// The result of a search for a session's scene on this machine.
struct SceneSearchResult {
  std::optional<std::filesystem::path> file;
  std::vector<std::filesystem::path> searched;  // folders
};
using FindFunction = std::function<SceneSearchResult(const SceneManifest&)>;

/// Fetches a session's scene from a peer that has its files. Returns the file on this machine.
using FetchFunction =
    std::function<Result<std::filesystem::path>(const SceneManifest&, const LoadProgress&)>;

/// Decides which scene is shown, and explains why none is. A scene that the user opens is shown,
/// with a warning if the session's scene is another. Otherwise the session's scene is shown if a
/// file with its content is found here.
///
/// The path that the session names is a stranger's word. So it is offered to the user, and opened
/// only on request. A worker thread reads files; nothing waits for it longer than a second. GUI
/// thread only.
class SceneModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kWaiting, kLoading, kReady, kMissing };

  /// Without `find` no scene of a session is found.
  explicit SceneModel(LoadFunction load, FindFunction find = {}, QObject* parent = nullptr);
  ~SceneModel() override;

  /// Sets how to fetch, before a session announces a scene. Without it nothing is fetched.
  void SetFetch(FetchFunction fetch) { fetch_ = std::move(fetch); }
  /// Returns whether the missing scene may be fetched from a peer of the session.
  bool can_fetch() const { return state_ == State::kMissing && fetch_ && manifest_ && !named_; }
  /// Fetches and shows the session's scene. Called on the user's request.
  void Fetch();
  /// Shows this file whatever the session's scene is.
  void OpenNamed(const std::filesystem::path& file);
  /// Sets the session's scene as far as it is known. May be called at any rate.
  void SetSessionScene(const std::optional<SceneManifest>& manifest);
  /// Returns the scene file on this machine that the session names, if no file in a known folder
  /// has its content; empty: none.
  const std::filesystem::path& offered() const { return offered_; }
  /// Shows the offered file if it is the session's scene. Called on the user's request.
  void OpenOffered();
  /// Searches again for a missing scene when the session next announces it.
  void LookAgain();

  State state() const { return state_; }
  const DrawnScene* scene() const { return scene_.get(); }  // null unless ready
  /// Returns the same scene, for a thread that may need it longer.
  const std::shared_ptr<const DrawnScene>& shared_scene() const { return scene_; }
  const QString& message() const {
    return message_;
  }  // loading: the current step; missing: what is missing and what to do
  const QString& warning() const {
    return warning_;
  }                                         // set if the scene shown is not the session's; else
                                            // empty
  int percent() const { return percent_; }  // progress of loading

 Q_SIGNALS:
  void Changed();

 private:
  /// The result of the loading thread.
  struct Loaded {
    Result<DrawnScene> scene;
    std::vector<std::filesystem::path> searched;
    bool found = true;
    std::filesystem::path offered = {};  // file that was found but not opened
  };
  using Loader = std::function<Loaded(const LoadProgress&)>;
  /// The state shared by the loading thread and the GUI thread. The loading thread may outlive the
  /// model.
  struct Job;
  void GiveUp(std::chrono::milliseconds patience);
  void Load(const QString& what, Loader loader);
  void ShowMissing(const Loaded& loaded);
  void OnProgress(int percent, const QString& what);
  void OnLoaded(const std::shared_ptr<Job>& job);
  void CheckAgreement();
  void SetState(State state, const QString& message = {});

  LoadFunction load_;
  FindFunction find_;
  FetchFunction fetch_;
  State state_ = State::kWaiting;
  QString message_;
  QString warning_;
  int percent_ = 0;
  bool named_ = false;
  std::optional<SceneManifest> manifest_;
  std::shared_ptr<const DrawnScene> scene_;
  std::filesystem::path offered_;
  std::shared_ptr<Job> job_;  // load in progress; null: none
  std::thread loader_;        // thread of job_
};

}  // namespace tandem
