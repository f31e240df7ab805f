#include "app/view/model/proximity/proximity_model.h"

#include <algorithm>
#include <utility>

#include <tbb/task_arena.h>

namespace tandem {

namespace {

bool SamePoses(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Pose& x, const Pose& y) {
    return x.p == y.p && x.q.coeffs() == y.q.coeffs();
  });
}

}  // namespace

ProximityModel::ProximityModel(QObject* parent) : QObject(parent) {}

ProximityModel::~ProximityModel() {
  {
    const std::lock_guard lock(mutex_);
    wish_.quit = true;
  }
  wished_.notify_one();
  if (worker_.joinable()) worker_.join();
}

void ProximityModel::SwitchOn(bool on) {
  if (on == (state_ != State::kOff)) return;
  if (on) {
    Begin();
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    wish_.on = false;
  }
  picture_.reset();
  SetState(State::kOff);
}

void ProximityModel::SetScene(std::shared_ptr<const DrawnScene> scene) {
  if (scene == scene_) return;
  scene_ = std::move(scene);
  X_W_.clear();
  held_.clear();
  if (state_ != State::kOff) Begin();
}

void ProximityModel::SetPoses(const std::vector<Pose>& X_W, const std::vector<std::size_t>& held) {
  if (SamePoses(X_W, X_W_) && held == held_) return;
  X_W_ = X_W;
  held_ = held;
  if (state_ != State::kVoxelizing && state_ != State::kOn) return;
  {
    const std::lock_guard lock(mutex_);
    wish_.X_W = X_W_;
    wish_.held = held_;
  }
  wished_.notify_one();
}

void ProximityModel::Begin() {
  picture_.reset();
  {
    const std::lock_guard lock(mutex_);
    wish_.on = scene_ != nullptr;
    wish_.scene = scene_;
    wish_.X_W = X_W_;
    wish_.held = held_;
  }
  wished_.notify_one();
  if (scene_ != nullptr && !worker_.joinable()) {
    worker_ = std::thread([this] {
      Work();
    });
  }
  SetState(scene_ != nullptr ? State::kVoxelizing : State::kNoScene);
}

QString ProximityModel::message() const {
  switch (state_) {
    case State::kOff:
      return {};
    case State::kNoScene:
      return tr("Proximity: no scene");
    case State::kVoxelizing:
      return detail_.isEmpty() ? tr("Voxelizing") : tr("Voxelizing %1").arg(detail_);
    case State::kFailed:
      return tr("No proximity: %1").arg(detail_);
    case State::kOn:
      break;
  }
  if (picture_->nearest.other == SceneNearness::kNone)
    return tr("Proximity: the scene has only one body");
  QString text =
      tr("%1 \u2013 %2: %3")
          .arg(QString::fromStdString(picture_->part), QString::fromStdString(picture_->other),
               QString::fromStdString(DistanceText(picture_->nearest, picture_->yield)));
  if (picture_->of_held.other != SceneNearness::kNone) {
    text += tr("; in hand: %1 \u2013 %2: %3")
                .arg(QString::fromStdString(picture_->held_part),
                     QString::fromStdString(picture_->held_other),
                     QString::fromStdString(DistanceText(picture_->of_held, picture_->held_yield)));
  }
  if (picture_->shadow_found > picture_->shadow_W.size()) {
    text += tr("; %1 of %2 near voxels shown")
                .arg(picture_->shadow_W.size())
                .arg(picture_->shadow_found);
  }
  return text;
}

void ProximityModel::SetState(State state, const QString& detail) {
  state_ = state;
  detail_ = detail;
  Q_EMIT Changed();
}

template <typename Then>
void ProximityModel::Tell(const std::shared_ptr<const DrawnScene>& scene, Then then) {
  QMetaObject::invokeMethod(
      this,
      [this, scene, then = std::move(then)] {
        if (scene == scene_ && state_ != State::kOff) then();
      },
      Qt::QueuedConnection);
}

std::unique_ptr<ProximityComposer> ProximityModel::Voxelize(
    const std::shared_ptr<const DrawnScene>& scene) {
  const auto wanted = [&] {
    const std::lock_guard lock(mutex_);
    return !wish_.quit && wish_.scene == scene;
  };
  // half, since a peer on this machine needs the others
  tbb::task_arena half(std::max(1, tbb::this_task_arena::max_concurrency() / 2));
  Result<std::vector<ProximityPart>> parts = half.execute([&] {
    return MakeProximityParts(ProximityBodiesOf(*scene), scene->voxel_size, scene->range_voxels,
                              [&](std::size_t done, std::size_t total, const std::string& part) {
                                const QString text = QStringLiteral("%1 (%2 of %3)")
                                                         .arg(QString::fromStdString(part))
                                                         .arg(done + 1)
                                                         .arg(total);
                                Tell(scene, [this, text] {
                                  SetState(State::kVoxelizing, text);
                                });
                                return wanted();
                              });
  });
  if (parts) return std::make_unique<ProximityComposer>(scene, std::move(*parts));
  Tell(scene, [this, why = QString::fromStdString(parts.error().what)] {
    SetState(State::kFailed, why);
  });
  return nullptr;
}

void ProximityModel::Work() {
  std::shared_ptr<const DrawnScene> scene;
  std::unique_ptr<ProximityComposer> composer;
  while (true) {
    std::shared_ptr<const DrawnScene> wished;
    std::vector<Pose> X_W;
    std::vector<std::size_t> held;
    {
      std::unique_lock lock(mutex_);
      wished_.wait(lock, [this] {
        return wish_.quit || (wish_.on && wish_.X_W.has_value());
      });
      if (wish_.quit) return;
      wished = wish_.scene;
      X_W = *std::exchange(wish_.X_W, std::nullopt);
      held = wish_.held;
    }
    if (wished != scene) composer.reset();
    scene = wished;
    if (composer == nullptr) composer = Voxelize(scene);
    if (composer == nullptr) continue;
    auto picture = std::make_shared<const ProximityPicture>(composer->Compose(X_W, held));
    Tell(scene, [this, picture = std::move(picture)] {
      picture_ = picture;
      SetState(State::kOn);
    });
  }
}

}  // namespace tandem
