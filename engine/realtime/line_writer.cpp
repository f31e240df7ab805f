#include "engine/realtime/line_writer.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <utility>

#include <poll.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "engine/base/text/clean_text.h"

namespace tandem {
namespace {

// locked memory would hold the whole of an ordinary stack
constexpr std::size_t kStackBytes = 128 * 1024;

// Returns whether all of it went out; false: the reader has gone, or nothing can be written.
bool WriteOut(int fd, const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t wrote = write(fd, text.data() + done, text.size() - done);
    if (wrote >= 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (errno == EAGAIN) {
      pollfd wait{fd, POLLOUT, 0};
      poll(&wait, 1, -1);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace

LineWriter::LineWriter(int fd) : fd_(fd) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  // an ordinary thread, whatever thread makes it
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_t thread{};
  pthread_create(&thread, &attributes, &LineWriter::Run, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
}

void LineWriter::WriteLine(std::string_view line) {
  Write(CleanText(line) + '\n');
}

void LineWriter::Write(std::string text) {
  const std::scoped_lock lock(mutex_);
  if (waiting_.size() >= kMostTexts) {
    ++dropped_;
    return;
  }
  waiting_.push_back(std::move(text));
  work_.notify_one();
}

bool LineWriter::Flush(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return idle_.wait_for(lock, patience, [this] {
    return waiting_.empty() && !writing_;
  });
}

std::uint64_t LineWriter::dropped() const {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

void* LineWriter::Run(void* self) {
  prctl(PR_SET_NAME, "lines");
  static_cast<LineWriter*>(self)->WriteAll();
  return nullptr;
}

void LineWriter::WriteAll() {
  std::unique_lock lock(mutex_);
  for (;;) {
    work_.wait(lock, [this] {
      return !waiting_.empty();
    });
    std::string text = std::move(waiting_.front());
    waiting_.pop_front();
    // lines that were dropped meanwhile came after all that wait
    if (waiting_.empty() && dropped_ != dropped_told_) {
      text += "(" + std::to_string(dropped_ - dropped_told_) + " more lines found no room)\n";
      dropped_told_ = dropped_;
    }
    writing_ = true;
    lock.unlock();
    const bool written = WriteOut(fd_, text);
    lock.lock();
    writing_ = false;
    if (!written) dropped_told_ = ++dropped_;  // no reader is left to tell
    if (waiting_.empty()) idle_.notify_all();
  }
}

LineWriter& StandardError() {
  // never destroyed: other libraries' threads outlive main()
  static LineWriter& writer = *[] {
    std::atexit([] {
      StandardError().Flush(kLastWordsPatience);
    });
    return new LineWriter(STDERR_FILENO);
  }();
  return writer;
}

}  // namespace tandem
