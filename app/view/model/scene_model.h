#pragma once

#include <QObject>
#include <QString>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "app/view/model/drawn_scene.h"
#include "collab/messages.h"

namespace tandem {

/// Where on this machine a session's scene was looked for, and where it lies.
struct SceneSearchResult {
  std::optional<std::filesystem::path> file;
  std::vector<std::filesystem::path> searched;  // folders
};
using FindFunction = std::function<SceneSearchResult(const SceneManifest&)>;

/// Fetches a session's scene from a peer that has its files; gives the file here.
using FetchFunction =
    std::function<Result<std::filesystem::path>(const SceneManifest&, const LoadProgress&)>;

/// Which scene is shown, and why none is. A scene that the user names is shown whatever the session
/// runs, with a warning when that is another one; else the session's own is, if a file with its
/// content is found here. The path that the session names is any stranger's word: it is offered to
/// the user, and not opened before they say so. Files are read in a worker thread, which nobody
/// waits for longer than a second. GUI thread only.
class SceneModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kWaiting, kLoading, kReady, kMissing };

  /// Without `find` nothing is found here.
  explicit SceneModel(LoadFunction load, FindFunction find = {}, QObject* parent = nullptr);
  ~SceneModel() override;

  /// Before a session tells of a scene. Without it nothing is fetched.
  void SetFetch(FetchFunction fetch) { fetch_ = std::move(fetch); }
  /// Whether what is missing may be had from a peer of the session.
  bool can_fetch() const { return state_ == State::kMissing && fetch_ && manifest_ && !named_; }
  /// Fetches it and shows it: the user has said so.
  void Fetch();
  /// Shows this file, and keeps to it.
  void OpenNamed(const std::filesystem::path& file);
  /// What the session runs, as far as it is known. May be called as often as one likes.
  void SetSessionScene(const std::optional<SceneManifest>& manifest);
  /// The scene file that the session names and that lies here, where none of a known folder has its
  /// content; empty: there is no such.
  const std::filesystem::path& offered() const { return offered_; }
  /// Shows that one if it is the session's scene: the user has said so.
  void OpenOffered();
  /// What was missing is looked for again when the session tells its scene.
  void LookAgain();

  State state() const { return state_; }
  const DrawnScene* scene() const { return scene_.get(); }  // null unless ready
  /// The same, for a thread that may need it longer.
  const std::shared_ptr<const DrawnScene>& shared_scene() const { return scene_; }
  const QString& message() const {
    return message_;
  }  // loading: what; missing: what is missing and what to do
  const QString& warning() const {
    return warning_;
  }                                         // the scene shown is not the session's; else empty
  int percent() const { return percent_; }  // of loading

 Q_SIGNALS:
  void Changed();

 private:
  /// What the loading thread has to tell at its end.
  struct Loaded {
    Result<DrawnScene> scene;
    std::vector<std::filesystem::path> searched;
    bool found = true;
    std::filesystem::path offered = {};  // that was not opened
  };
  using Loader = std::function<Loaded(const LoadProgress&)>;
  /// What the loading thread and this one share; the thread may outlive the model.
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
  std::shared_ptr<Job> job_;  // under way; null: none is
  std::thread loader_;        // its thread
};

}  // namespace tandem
