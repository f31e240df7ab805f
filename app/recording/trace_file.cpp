#include "app/recording/trace_file.h"

#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include <pthread.h>

#include "app/common/output_file.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

// whole seconds stand apart, because a double does not hold all ns of a long uptime
using TraceRow = std::array<double, kTraceColumns>;

TraceRow AsRow(const TraceSample& sample) {
  const Vec3& p = sample.X_WB.p;
  const Quat& q = sample.X_WB.q;
  const Twist& V = sample.V_WB;
  return {ToSeconds(sample.time_ns / 1'000'000'000 * 1'000'000'000),
          ToSeconds(sample.time_ns % 1'000'000'000),
          p.x(),
          p.y(),
          p.z(),
          q.x(),
          q.y(),
          q.z(),
          q.w(),
          V.w.x(),
          V.w.y(),
          V.w.z(),
          V.v.x(),
          V.v.y(),
          V.v.z(),
          static_cast<double>(sample.hand_force),
          sample.contact_points + (sample.pushing ? 0.5 : 0.0)};
}

TraceSample FromRow(const TraceRow& row) {
  TraceSample sample;
  sample.time_ns = std::llround(row[0]) * 1'000'000'000 + std::llround(1e9 * row[1]);
  sample.X_WB.p = Vec3(row[2], row[3], row[4]);
  sample.X_WB.q = Quat(row[8], row[5], row[6], row[7]);
  sample.V_WB = {Vec3(row[9], row[10], row[11]), Vec3(row[12], row[13], row[14])};
  sample.hand_force = static_cast<float>(row[15]);
  sample.contact_points = static_cast<int>(row[16]);
  sample.pushing = row[16] - sample.contact_points > 0.25;
  return sample;
}

}  // namespace

std::string WhyNoTrace(const std::filesystem::path& file) {
  std::error_code not_there;
  if (std::filesystem::is_fifo(file, not_there)) {
    return file.string() + ": is a pipe: name a file for the trace";
  }
  return WhyNotWritable(file);
}

TraceFile::TraceFile(std::filesystem::path file, Traced traced)
    : file_(std::move(file)),
      traced_(std::move(traced)),
      stream_(file_, std::ios::binary),
      thread_([this] {
        Run();
      }) {}

TraceFile::~TraceFile() {
  if (thread_.joinable()) static_cast<void>(Close());
}

void TraceFile::Run() {
  constexpr std::chrono::milliseconds kPeriod(100);
  pthread_setname_np(pthread_self(), "trace");
  std::unique_lock lock(mutex_);
  while (!closed_.wait_for(lock, kPeriod, [this] {
    return is_closed_;
  })) {
    lock.unlock();
    WriteNew();
    lock.lock();
  }
}

void TraceFile::WriteNew() {
  for (const TraceSample& sample : traced_().subspan(written_)) {
    const TraceRow row = AsRow(sample);
    stream_.write(reinterpret_cast<const char*>(row.data()), sizeof row);
    ++written_;
  }
}

Result<bool> TraceFile::Close() {
  EndThread();
  WriteNew();
  stream_.close();
  if (stream_) return true;
  Remove();
  return Error{file_.string() + ": cannot be written, and is removed"};
}

void TraceFile::Discard() {
  EndThread();
  stream_.close();
  Remove();
}

void TraceFile::EndThread() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  closed_.notify_one();
  thread_.join();
}

// a device, such as /dev/null, stays
void TraceFile::Remove() {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(file_, ignored)) std::filesystem::remove(file_, ignored);
}

TraceTail::TraceTail(std::filesystem::path file) : file_(std::move(file)) {}

std::vector<TraceSample> TraceTail::ReadNew() {
  std::vector<TraceSample> fresh;
  if (!stream_.is_open()) stream_.open(file_, std::ios::binary);
  if (!stream_.is_open()) return fresh;
  stream_.clear();  // the file may have grown since its end was met
  stream_.seekg(read_);
  TraceRow row{};
  while (stream_.read(reinterpret_cast<char*>(row.data()), sizeof row)) {
    fresh.push_back(FromRow(row));
    read_ += static_cast<std::streamoff>(sizeof row);
  }
  return fresh;
}

Result<std::vector<TraceSample>> ReadTrace(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return Error{file.string() + ": cannot be read"};
  std::vector<TraceSample> trace;
  TraceRow row{};
  while (stream.read(reinterpret_cast<char*>(row.data()), sizeof row)) {
    trace.push_back(FromRow(row));
  }
  if (stream.gcount() != 0) return Error{file.string() + ": ends within a frame"};
  return trace;
}

}  // namespace tandem
