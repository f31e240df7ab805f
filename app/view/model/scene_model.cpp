#include "app/view/model/scene_model.h"

#include <utility>

namespace tandem {

namespace {

QString FileText(const std::filesystem::path& file) {
  return QString::fromStdString(file.string());
}

QString HashText(std::uint64_t hash) {
  return QStringLiteral("%1").arg(hash, 16, 16, QChar('0'));
}

}  // namespace

SceneModel::SceneModel(LoadFunction load, QObject* parent)
    : QObject(parent), load_(std::move(load)) {
  message_ = tr("Join a session, or start with --scene FILE.");
}

SceneModel::~SceneModel() {
  give_up_ = true;
  if (loader_.joinable()) loader_.join();
}

void SceneModel::OpenNamed(const std::filesystem::path& file) {
  named_ = true;
  Load(file);
}

void SceneModel::SetSessionScene(const std::optional<SceneManifest>& manifest) {
  if (!manifest) return;
  if (manifest_ && manifest_->content_hash == manifest->content_hash &&
      manifest_->file == manifest->file) {
    return;
  }
  if (state_ == State::kLoading && !named_) return;  // offered again when that is done
  manifest_ = manifest;
  if (named_) {
    CheckAgreement();
    return;
  }
  std::error_code ignored;
  if (manifest_->file.empty() || !std::filesystem::exists(manifest_->file, ignored)) {
    SetState(State::kMissing,
             tr("The session runs \u201c%1\u201d, but its file is not on this machine:\n%2\n\n"
                "Get the same scene and start with --scene FILE.")
                 .arg(QString::fromStdString(manifest_->name),
                      manifest_->file.empty() ? tr("(no file was named)")
                                              : QString::fromStdString(manifest_->file)));
    return;
  }
  Load(manifest_->file);
}

void SceneModel::Load(const std::filesystem::path& file) {
  give_up_ = true;
  if (loader_.joinable()) loader_.join();
  give_up_ = false;
  scene_.reset();
  warning_.clear();
  percent_ = 0;
  SetState(State::kLoading, FileText(file.filename()));
  const unsigned load = ++loads_;
  loader_ = std::thread([this, file, load] {
    loaded_.emplace(
        load_(file, [this](std::size_t done, std::size_t total, const std::string& what) {
          const int percent = static_cast<int>(100 * done / std::max<std::size_t>(total, 1));
          QMetaObject::invokeMethod(
              this,
              [this, percent, text = QString::fromStdString(what)] {
                OnProgress(percent, text);
              },
              Qt::QueuedConnection);
          return !give_up_;
        }));
    QMetaObject::invokeMethod(
        this,
        [this, load] {
          OnLoaded(load);
        },
        Qt::QueuedConnection);
  });
}

void SceneModel::OnProgress(int percent, const QString& what) {
  if (state_ != State::kLoading) return;
  percent_ = percent;
  message_ = what;
  Q_EMIT Changed();
}

void SceneModel::OnLoaded(unsigned load) {
  if (load != loads_) return;  // another one was begun meanwhile
  loader_.join();
  Result<DrawnScene> result = *std::exchange(loaded_, std::nullopt);
  if (!result) {
    SetState(
        State::kMissing,
        tr("The scene could not be loaded:\n%1").arg(QString::fromStdString(result.error().what)));
    return;
  }
  if (!named_ && manifest_ && result->hash != manifest_->content_hash) {
    SetState(State::kMissing,
             tr("The session runs \u201c%1\u201d, but the file of that name on this machine is "
                "another one:\n"
                "%2\n\nIts hash is %3, the session\u2019s is %4.\n"
                "Get the same scene and start with --scene FILE.")
                 .arg(QString::fromStdString(manifest_->name), FileText(result->file),
                      HashText(result->hash), HashText(manifest_->content_hash)));
    return;
  }
  // the voxels that the session goes by, which may not be the file's
  if (manifest_ && result->hash == manifest_->content_hash) {
    result->voxel_size = manifest_->voxel_size;
  }
  scene_ = std::make_shared<const DrawnScene>(*std::move(result));
  percent_ = 100;
  SetState(State::kReady);
  CheckAgreement();
}

void SceneModel::CheckAgreement() {
  if (state_ != State::kReady || !manifest_) return;
  const QString warning =
      scene_->hash == manifest_->content_hash
          ? QString()
          : tr("This is not the scene that the session runs (\u201c%1\u201d, hash %2; shown: %3). "
               "Places and shapes may be wrong.")
                .arg(QString::fromStdString(manifest_->name), HashText(manifest_->content_hash),
                     HashText(scene_->hash));
  if (warning == warning_) return;
  warning_ = warning;
  Q_EMIT Changed();
}

void SceneModel::SetState(State state, const QString& message) {
  state_ = state;
  message_ = message;
  Q_EMIT Changed();
}

}  // namespace tandem
