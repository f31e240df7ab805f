#pragma once

#include <QObject>
#include <QString>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "app/view/model/proximity/proximity_picture.h"

namespace tandem {

/// The state of proximity, and its newest picture. A thread voxelizes the scene when proximity is
/// first switched on, with half of the processors. Then it computes pictures for the newest poses,
/// so that the window never waits. GUI thread only.
class ProximityModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kOff, kNoScene, kVoxelizing, kOn, kFailed };

  explicit ProximityModel(QObject* parent = nullptr);
  ~ProximityModel() override;  // waits for the part that is being voxelized

  void SwitchOn(bool on);
  /// Sets the scene; null: none. Forgets the voxels of another scene.
  void SetScene(std::shared_ptr<const DrawnScene> scene);
  /// Sets the displacements of the scene's bodies, and which are in hand. May be called at any
  /// rate.
  void SetPoses(const std::vector<Pose>& X_W, const std::vector<std::size_t>& held = {});

  State state() const { return state_; }
  /// Returns the newest picture; null unless on.
  const std::shared_ptr<const ProximityPicture>& picture() const { return picture_; }
  /// Returns a line for the status bar: the nearest bodies and their distance, the part being
  /// voxelized, or the fault.
  QString message() const;

 Q_SIGNALS:
  void Changed();

 private:
  /// The task of the worker; guarded by mutex_.
  struct Wish {
    bool quit = false;
    bool on = false;
    std::shared_ptr<const DrawnScene> scene;
    std::optional<std::vector<Pose>> X_W;  // poses that are not answered yet
    std::vector<std::size_t> held;
  };

  void Work();
  /// Makes the composer of a scene; null: it cannot be made, or is not wanted.
  std::unique_ptr<ProximityComposer> Voxelize(const std::shared_ptr<const DrawnScene>& scene);
  /// Runs `then` in the GUI thread if the scene is still shown and proximity is on.
  template <typename Then>
  void Tell(const std::shared_ptr<const DrawnScene>& scene, Then then);
  void Begin();
  void SetState(State state, const QString& detail = {});

  State state_ = State::kOff;
  QString detail_;  // part being voxelized, or reason of a failure
  std::shared_ptr<const DrawnScene> scene_;
  std::vector<Pose> X_W_;
  std::vector<std::size_t> held_;
  std::shared_ptr<const ProximityPicture> picture_;

  std::mutex mutex_;
  std::condition_variable wished_;
  Wish wish_;
  std::thread worker_;  // runs from the first time that proximity is on
};

}  // namespace tandem
