#include "app/view/model/scene/scene_model.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "app/connection/scene_search.h"
#include "collab/session/scene_agreement.h"

namespace tandem {

namespace {

QString FileText(const std::filesystem::path& file) {
  return QString::fromStdString(file.string());
}

/// Returns how a scene read here differs from the session's; empty: it does not.
QString DifferenceText(const DrawnScene& scene, const SceneManifest& session) {
  SceneHash hashes = scene.hashes;
  hashes.digest = scene.digest;
  Scene source = scene.source;
  source.file = scene.file;
  return QString::fromStdString(ContentDifference(source, hashes, session));
}

}  // namespace

SceneModel::SceneModel(LoadFunction load, FindFunction find, QObject* parent)
    : QObject(parent), load_(std::move(load)), find_(std::move(find)) {
  message_ = tr("Join a session, or open a scene: Session, Open scene (Ctrl+O).");
}

struct SceneModel::Job {
  std::atomic<bool> give_up = false;
  std::mutex mutex;
  std::condition_variable ending;
  bool done = false;            // guarded by mutex, as the members below
  SceneModel* model = nullptr;  // model to notify; null: it does not wait
  std::optional<Loaded> loaded;

  void Tell(const std::function<void(SceneModel&)>& what) {
    const std::scoped_lock lock(mutex);
    if (model == nullptr) return;
    QMetaObject::invokeMethod(
        model,
        [to = model, what] {
          what(*to);
        },
        Qt::QueuedConnection);
  }
};

SceneModel::~SceneModel() {
  constexpr std::chrono::seconds kPatience{1};
  GiveUp(kPatience);
}

// Gives up the load. A slow disk or mesh does not hold up the caller: after `patience` the thread
// ends by itself, and its result is discarded.
void SceneModel::GiveUp(std::chrono::milliseconds patience) {
  if (!job_) return;
  job_->give_up = true;
  std::unique_lock lock(job_->mutex);
  job_->model = nullptr;
  const bool ended = job_->ending.wait_for(lock, patience, [this] {
    return job_->done;
  });
  lock.unlock();
  if (ended) {
    loader_.join();
  } else {
    loader_.detach();
  }
  job_.reset();
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
  if (manifest_ && manifest_->content_digest == manifest->content_digest &&
      manifest_->file == manifest->file) {
    return;
  }
  if (state_ == State::kLoading && !named_) return;  // the session offers it again after that
  manifest_ = manifest;
  if (named_) {
    CheckAgreement();
    return;
  }
  Load(tr("Looking for \u201c%1\u201d").arg(QString::fromStdString(manifest_->name)),
       [load = load_, find = find_, manifest = *manifest_](const LoadProgress& progress) {
         const SceneSearchResult search = find ? find(manifest) : SceneSearchResult{};
         if (search.file) return Loaded{load(*search.file, progress), search.searched};
         Loaded missing{Error{"it is not on this machine"}, search.searched, false};
         if (MayBeSceneFile(manifest.file)) missing.offered = manifest.file;
         return missing;
       });
}

void SceneModel::OpenOffered() {
  if (offered_.empty() || !manifest_) return;
  Load(FileText(offered_.filename()),
       [load = load_, file = offered_](const LoadProgress& progress) {
         return Loaded{load(file, progress), {}};
       });
}

void SceneModel::Fetch() {
  if (!can_fetch()) return;
  Load(tr("Fetching \u201c%1\u201d").arg(QString::fromStdString(manifest_->name)),
       [load = load_, fetch = fetch_, manifest = *manifest_](const LoadProgress& progress) {
         const Result<std::filesystem::path> file = fetch(manifest, progress);
         return file ? Loaded{load(*file, progress), {}} : Loaded{file.error(), {}};
       });
}

void SceneModel::Load(const QString& what, Loader loader) {
  GiveUp(std::chrono::milliseconds(0));
  scene_.reset();
  offered_.clear();
  warning_.clear();
  percent_ = 0;
  SetState(State::kLoading, what);
  job_ = std::make_shared<Job>();
  job_->model = this;
  loader_ = std::thread([job = job_, loader = std::move(loader)] {
    Loaded loaded = loader([&job](std::size_t done, std::size_t total, const std::string& part) {
      const int percent = static_cast<int>(100 * done / std::max<std::size_t>(total, 1));
      job->Tell([percent, text = QString::fromStdString(part)](SceneModel& model) {
        model.OnProgress(percent, text);
      });
      return !job->give_up;
    });
    {
      const std::scoped_lock lock(job->mutex);
      job->loaded.emplace(std::move(loaded));
      job->done = true;
    }
    job->ending.notify_one();
    job->Tell([job](SceneModel& model) {
      model.OnLoaded(job);
    });
  });
}

void SceneModel::OnProgress(int percent, const QString& what) {
  if (state_ != State::kLoading) return;
  percent_ = percent;
  message_ = what;
  Q_EMIT Changed();
}

void SceneModel::OnLoaded(const std::shared_ptr<Job>& job) {
  if (job != job_) return;  // another load was begun meanwhile
  loader_.join();
  job_.reset();
  Loaded loaded = *std::move(job->loaded);
  offered_ = loaded.offered;
  Result<DrawnScene>& result = loaded.scene;
  if (!result && loaded.found) {
    SetState(
        State::kMissing,
        tr("The scene could not be loaded:\n%1").arg(QString::fromStdString(result.error().what)));
    return;
  }
  if (!result || (!named_ && manifest_ && result->digest != manifest_->content_digest)) {
    ShowMissing(loaded);
    return;
  }
  // uses the session's voxel size, which may differ from the file's
  if (manifest_ && result->digest == manifest_->content_digest) {
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
    text = tr("The session runs \u201c%1\u201d, but the file at its path here is a different "
              "scene:\n%2")
               .arg(name, DifferenceText(*loaded.scene, *manifest_));
  } else {
    text = tr("The session runs \u201c%1\u201d, but its scene is not on this machine:\n%2")
               .arg(name, manifest_->file.empty() ? tr("(the session names no file)")
                                                  : QString::fromStdString(manifest_->file));
  }
  if (!offered_.empty()) {
    text +=
        tr("\n\nA peer in the session names this file on this machine. Load it only if you know "
           "what it is.");
  }
  if (!loaded.searched.empty()) {
    QStringList folders;
    for (const std::filesystem::path& folder : loaded.searched) folders << FileText(folder);
    text += tr("\n\nNo file with the scene\u2019s content is in %1.")
                .arg(folders.join(QStringLiteral(", ")));
  }
  if (fetch_) {
    text += tr("\n\nA peer can send its files, 1 GB at most.");
  }
  text += tr("\n\nGet the same scene, with its meshes, and open it (Ctrl+O).");
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
