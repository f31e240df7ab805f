#include "collab/lab/run/recorded_run.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "collab/lab/case/case_parts.h"
#include "collab/recording/replay.h"

namespace tandem {

namespace {

constexpr std::int64_t kFrameNs = 1'000'000;

/// One user's recording, replayed frame by frame.
class User {
 public:
  static Result<User> Open(const std::filesystem::path& file, const LabScene& scene) {
    Result<RecordingReader> reader = RecordingReader::Open(file);
    if (!reader) return reader.error();
    Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), scene.model);
    if (!replay) return Error{file.string() + ": " + replay.error().what};
    User user(file, *std::move(reader), *std::move(replay));
    user.next_ = user.reader_.Next();
    if (!user.next_) return Error{file.string() + ": holds no frame"};
    return user;
  }

  /// Returns the time of the next frame; nothing: there is none.
  std::optional<std::int64_t> next_ns() const {
    return next_ ? std::optional(next_->now_ns) : std::nullopt;
  }
  const UserFrame& frame() const noexcept { return frame_; }
  bool started() const { return replay_->node().peer().started_ns().has_value(); }

  /// Runs all frames that begin before `end_ns`.
  std::optional<Error> RunUntil(std::int64_t end_ns) {
    while (next_ && next_->now_ns < end_ns) {
      if (replay_->Run(*next_) != next_->state_hash) {
        return Error{file_.string() + ": frame " + std::to_string(number_) +
                     " does not end in what was recorded"};
      }
      Observe(replay_->node().peer(), next_->now_ns, frame_);
      next_ = reader_.Next();
      ++number_;
    }
    return std::nullopt;
  }

 private:
  User(std::filesystem::path file, RecordingReader reader, std::unique_ptr<Replay> replay)
      : file_(std::move(file)), reader_(std::move(reader)), replay_(std::move(replay)) {}

  std::filesystem::path file_;
  RecordingReader reader_;
  std::unique_ptr<Replay> replay_;
  std::optional<RecordedFrame> next_;
  UserFrame frame_;
  std::int64_t number_ = 0;
};

}  // namespace

Result<RecordedRun> MeterRecordings(const std::vector<std::filesystem::path>& recordings,
                                    const LabCase& test, const LabScene& scene,
                                    const SeriesSink& series) {
  std::vector<User> users;
  std::int64_t now_ns = 0;
  for (const std::filesystem::path& file : recordings) {
    Result<User> user = User::Open(file, scene);
    if (!user) return user.error();
    now_ns = std::max(now_ns, *user->next_ns());
    users.push_back(*std::move(user));
  }
  std::vector<UserFrame> frames(users.size());
  const auto closed = [&] {
    return std::ranges::all_of(users, [&](const User& user) {
      return user.frame().present && user.started() &&
             user.frame().coupled + 1 >= recordings.size();
    });
  };

  const double seconds = test.seconds > 0 ? test.seconds : test.DefaultDuration();
  const auto wanted = std::llround(seconds / kFrame);
  Meter meter(scene.inertia(), test.MeanPathLength(), LastInputEnds(test));
  std::int64_t measured = 0;
  for (bool open = true; measured < wanted && !meter.diverged(); now_ns += kFrameNs) {
    for (std::size_t user = 0; user < users.size(); ++user) {
      if (!users[user].next_ns()) {
        return Error{recordings[user].string() + ": ends " +
                     std::to_string(kFrame * static_cast<double>(measured)) +
                     " s after all loops were closed, the case takes " + std::to_string(seconds) +
                     " s"};
      }
      if (const auto fault = users[user].RunUntil(now_ns + kFrameNs / 2)) return *fault;
      frames[user] = users[user].frame();
    }
    open = open && !closed();
    if (open) {
      meter.SeeOpening(frames);
      continue;
    }
    meter.See(frames);
    if (series) series(kFrame * static_cast<double>(measured), frames);
    ++measured;
  }
  RecordedRun run;
  run.metrics = meter.Finish();
  run.verdict = Judge(run.metrics);
  run.seconds = kFrame * static_cast<double>(measured);
  return run;
}

}  // namespace tandem
