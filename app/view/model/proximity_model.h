#pragma once

#include <QObject>
#include <QString>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "app/view/model/proximity_picture.h"

namespace tandem {

/// Whether proximity is shown, and the newest picture of it. A thread of its own voxelizes the
/// scene when that is first asked for, with half of the processors, and then answers the newest
/// poses, so that the window never waits. GUI thread only.
class ProximityModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kOff, kNoScene, kVoxelizing, kOn, kFailed };

  explicit ProximityModel(QObject* parent = nullptr);
  ~ProximityModel() override;  // waits for the part that is being voxelized

  void SwitchOn(bool on);
  /// Null: none. What was voxelized of another scene is forgotten.
  void SetScene(std::shared_ptr<const DrawnScene> scene);
  /// The displacements of the scene's bodies, and which are in hand; may be called as often as one
  /// likes.
  void SetPoses(const std::vector<Pose>& X_W, const std::vector<std::size_t>& held = {});

  State state() const { return state_; }
  /// The newest; null unless on.
  const std::shared_ptr<const ProximityPicture>& picture() const { return picture_; }
  /// One line for the status bar: what is near and how much, what is being voxelized, or why not.
  QString message() const;

 Q_SIGNALS:
  void Changed();

 private:
  /// What the worker is to do; guarded by mutex_.
  struct Wish {
    bool quit = false;
    bool on = false;
    std::shared_ptr<const DrawnScene> scene;
    std::optional<std::vector<Pose>> X_W;  // those that are not answered yet
    std::vector<std::size_t> held;
  };

  void Work();
  /// Null: it cannot be, or is not wanted any more.
  std::unique_ptr<ProximityComposer> Voxelize(const std::shared_ptr<const DrawnScene>& scene);
  /// Runs `then` in the GUI thread if the scene is still the one shown, and it is still wanted.
  template <typename Then>
  void Tell(const std::shared_ptr<const DrawnScene>& scene, Then then);
  void Begin();
  void SetState(State state, const QString& detail = {});

  State state_ = State::kOff;
  QString detail_;  // voxelizing: which part; failed: why
  std::shared_ptr<const DrawnScene> scene_;
  std::vector<Pose> X_W_;
  std::vector<std::size_t> held_;
  std::shared_ptr<const ProximityPicture> picture_;

  std::mutex mutex_;
  std::condition_variable wished_;
  Wish wish_;
  std::thread worker_;  // since it was first switched on
};

}  // namespace tandem
