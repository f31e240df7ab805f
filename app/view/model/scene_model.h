#pragma once

#include <QObject>
#include <QString>
#include <atomic>
#include <memory>
#include <optional>
#include <thread>

#include "app/view/model/drawn_scene.h"
#include "collab/messages.h"

namespace tandem {

/// Which scene is shown, and why none is. A scene that the user names is shown whatever the session
/// runs, with a warning when that is another one; else the session's own is, if its file is here
/// and its hash is the session's. Files are read in a worker thread. GUI thread only.
class SceneModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kWaiting, kLoading, kReady, kMissing };

  explicit SceneModel(LoadFunction load, QObject* parent = nullptr);
  ~SceneModel() override;

  /// Shows this file, and keeps to it.
  void OpenNamed(const std::filesystem::path& file);
  /// What the session runs, as far as it is known. May be called as often as one likes.
  void SetSessionScene(const std::optional<SceneManifest>& manifest);

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
  void Load(const std::filesystem::path& file);
  void OnProgress(int percent, const QString& what);
  void OnLoaded(unsigned load);
  void CheckAgreement();
  void SetState(State state, const QString& message = {});

  LoadFunction load_;
  State state_ = State::kWaiting;
  QString message_;
  QString warning_;
  int percent_ = 0;
  bool named_ = false;
  std::optional<SceneManifest> manifest_;
  std::shared_ptr<const DrawnScene> scene_;
  unsigned loads_ = 0;
  std::thread loader_;
  std::atomic<bool> give_up_ = false;
  std::optional<Result<DrawnScene>> loaded_;  // by loader_, read after it ended
};

}  // namespace tandem
