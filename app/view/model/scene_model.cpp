#include "app/view/model/scene_model.h"

#include <utility>

#include "app/reach/scene_search.h"
#include "collab/scene_agreement.h"

namespace tandem {

namespace {

QString FileText(const std::filesystem::path& file) {
  return QString::fromStdString(file.string());
}

/// In what a scene read here differs from the session's; empty: in nothing.
QString DifferenceText(const DrawnScene& scene, const SceneManifest& session) {
  SceneHash hashes = scene.hashes;
  hashes.content = scene.hash;
  Scene source = scene.source;
  source.file = scene.file;
  return QString::fromStdString(ContentDifference(source, hashes, session));
}

}  // namespace

SceneModel::SceneModel(LoadFunction load, FindFunction find, QObject* parent)
    : QObject(parent), load_(std::move(load)), find_(std::move(find)) {
  message_ = tr("Join a session, or open a scene: Session, Open scene (Ctrl+O).");
}

SceneModel::~SceneModel() {
  give_up_ = true;
  if (loader_.joinable()) loader_.join();
}

void SceneModel::OpenNamed(const std::filesystem::path& file) {
  named_ = true;
  Load(FileText(file.filename()), [load = load_, file](const LoadProgress& progress) {
    return Loaded{load(file, progress), {}};
  });
}

void SceneModel::LookAgain() {
  if (state_ == State::kMissing && !named_) manifest_.reset();
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
  Load(tr("Looking for \u201c%1\u201d").arg(QString::fromStdString(manifest_->name)),
       [load = load_, find = find_, manifest = *manifest_](const LoadProgress& progress) {
         const bool offered = MayBeSceneFile(manifest.file);
         const SceneSearchResult search = find ? find(manifest) : SceneSearchResult{};
         // where it is not found, what has its path here tells in what it differs
         if (!search.file && !offered) {
           return Loaded{Error{"it is not on this machine"}, search.searched, false};
         }
         return Loaded{load(search.file.value_or(manifest.file), progress), search.searched};
       });
}

void SceneModel::Load(const QString& what, Loader loader) {
  give_up_ = true;
  if (loader_.joinable()) loader_.join();
  give_up_ = false;
  scene_.reset();
  warning_.clear();
  percent_ = 0;
  SetState(State::kLoading, what);
  const unsigned load = ++loads_;
  loader_ = std::thread([this, load, loader = std::move(loader)] {
    loaded_.emplace(loader([this](std::size_t done, std::size_t total, const std::string& part) {
      const int percent = static_cast<int>(100 * done / std::max<std::size_t>(total, 1));
      QMetaObject::invokeMethod(
          this,
          [this, percent, text = QString::fromStdString(part)] {
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
  Loaded loaded = *std::exchange(loaded_, std::nullopt);
  Result<DrawnScene>& result = loaded.scene;
  if (!result && loaded.found) {
    SetState(
        State::kMissing,
        tr("The scene could not be loaded:\n%1").arg(QString::fromStdString(result.error().what)));
    return;
  }
  if (!result || (!named_ && manifest_ && result->hash != manifest_->content_hash)) {
    ShowMissing(loaded);
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

void SceneModel::ShowMissing(const Loaded& loaded) {
  const QString name = QString::fromStdString(manifest_->name);
  QString text;
  if (loaded.scene) {
    text = tr("The session runs \u201c%1\u201d, but what lies at its path here is another one:\n%2")
               .arg(name, DifferenceText(*loaded.scene, *manifest_));
  } else {
    text = tr("The session runs \u201c%1\u201d, but its scene is not on this machine:\n%2")
               .arg(name, manifest_->file.empty() ? tr("(no file was named)")
                                                  : QString::fromStdString(manifest_->file));
  }
  if (!loaded.searched.empty()) {
    QStringList folders;
    for (const std::filesystem::path& folder : loaded.searched) folders << FileText(folder);
    text += tr("\n\nNo file with its content is in %1.").arg(folders.join(QStringLiteral(", ")));
  }
  text +=
      tr("\n\nGet the same scene, with its meshes, and open it (Ctrl+O), or start with --scene "
         "FILE.");
  SetState(State::kMissing, text);
}

void SceneModel::CheckAgreement() {
  if (state_ != State::kReady || !manifest_) return;
  const QString difference = DifferenceText(*scene_, *manifest_);
  const QString warning =
      difference.isEmpty()
          ? QString()
          : tr("This is not the scene that the session runs; places and shapes may be wrong.\n%1")
                .arg(difference);
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
