#include "app/device/fake_driver.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <new>
#include <sstream>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr double kWaySeconds = 0.5;  // to its place
constexpr double kTick = 1e-3;       // s
constexpr int kVendorPriority = 40;  // as the device's loop

void Hang(double ms) noexcept {
  MachineClock().SleepUntil(MonotonicNowNs() + static_cast<std::int64_t>(1e6 * ms));
}

/// Until there is no stack left.
int Recurse(int depth) {
  static volatile int deepest = std::numeric_limits<int>::max();
  if (depth == deepest) return 0;
  volatile char room[4096];
  room[depth % 4096] = static_cast<char>(depth);
  return Recurse(depth + 1) + room[depth % 4096];
}

Result<FakeRecord*> MapRecord(const std::string& file) {
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0 || ftruncate(descriptor, sizeof(FakeRecord)) != 0) {
    if (descriptor >= 0) close(descriptor);
    return Error{file + ": cannot be written"};
  }
  void* data = mmap(nullptr, sizeof(FakeRecord), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE,
                    descriptor, 0);
  close(descriptor);
  if (data == MAP_FAILED) return Error{file + ": cannot be mapped"};
  return static_cast<FakeRecord*>(data);
}

}  // namespace

Result<std::unique_ptr<Device>> FakeDriver::Make(const std::string& options, const Pose& X_WD0) {
  std::unique_ptr<FakeDriver> fake(new FakeDriver(X_WD0));
  double x_mm = 0;
  double y_mm = 0;
  double z_mm = 0;
  double swing_mm = 0;
  double open_hang_ms = 0;
  double vendor = 0;
  const std::map<std::string, double*> numbers{{"x_mm", &x_mm},
                                               {"y_mm", &y_mm},
                                               {"z_mm", &z_mm},
                                               {"swing_mm", &swing_mm},
                                               {"swing_hz", &fake->swing_hz_},
                                               {"peak_N", &fake->can_.peak.force},
                                               {"peak_Nm", &fake->can_.peak.moment},
                                               {"continuous_N", &fake->can_.continuous.force},
                                               {"continuous_Nm", &fake->can_.continuous.moment},
                                               {"stiffness", &fake->can_.stiffness},
                                               {"nan_at", &fake->nan_at_},
                                               {"fail_at", &fake->fail_at_},
                                               {"stop_at", &fake->stop_at_},
                                               {"jump_at", &fake->jump_at_},
                                               {"hang_at", &fake->hang_at_},
                                               {"hang_ms", &fake->hang_ms_},
                                               {"crash_at", &fake->crash_at_},
                                               {"recurse_at", &fake->recurse_at_},
                                               {"rate_hz", &fake->can_.rate_hz},
                                               {"vendor", &vendor},
                                               {"open_hang_ms", &open_hang_ms},
                                               {"clutch_at", &fake->clutch_at_}};
  std::istringstream words(options);
  for (std::string word; std::getline(words, word, ',');) {
    const std::size_t equals = word.find('=');
    const std::string key = word.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
    if (key == "record" && !value.empty()) {
      Result<FakeRecord*> record = MapRecord(value);
      if (!record) return record.error();
      fake->record_ = *record;
      continue;
    }
    const auto number = numbers.find(key);
    if (number == numbers.end()) return Error{"fake: '" + key + "' is none of its options"};
    const auto [end, fault] =
        std::from_chars(value.data(), value.data() + value.size(), *number->second);
    if (fault != std::errc{} || end != value.data() + value.size()) {
      return Error{"fake: " + key + ": a number is wanted, not '" + value + "'"};
    }
  }
  fake->aside_ = 1e-3 * Vec3(x_mm, y_mm, z_mm);
  fake->swing_ = 1e-3 * swing_mm;
  if (open_hang_ms > 0) Hang(open_hang_ms);
  if (vendor != 0) {
    if (!(fake->can_.rate_hz >= 100 && fake->can_.rate_hz <= 10'000)) {
      return Error{"fake: vendor=1 wants a rate_hz from 100 to 10000"};
    }
    fake->can_.asks_us = true;
    fake->mailbox_ = std::make_unique<VendorMailbox>(fake->can_.peak);
    fake->vendor_ = std::make_unique<PeriodicThread>(
        PeriodicThread::Options{
            .period_ns = static_cast<std::int64_t>(1e9 / fake->can_.rate_hz),
            .priority = kVendorPriority,
            .name = "vendor"},
        [driver = fake.get()](std::int64_t, std::int64_t) {
          driver->Write(driver->mailbox_->Take(MonotonicNowNs()));
          return true;
        });
  }
  return std::unique_ptr<Device>(std::move(fake));
}

FakeDriver::~FakeDriver() {
  vendor_.reset();
  if (record_ == nullptr) return;
  Write({});
  munmap(record_, sizeof(FakeRecord));
}

Anchor FakeDriver::Read() noexcept {
  tick_ += started_ ? 1 : 0;
  if (Within(hang_at_, 1)) Hang(hang_ms_);
  if (Within(recurse_at_, 1) && Recurse(1) == 0) std::abort();
  if (Within(crash_at_, 1)) std::abort();
  const double t = kTick * static_cast<double>(tick_);
  const double s = std::clamp(t / kWaySeconds, 0.0, 1.0);
  const double omega = 2 * M_PI * swing_hz_;
  const double swing_t = std::max(0.0, t - kWaySeconds);
  Anchor handle{X_WD0_, {}};
  handle.X_WA.p += s * s * (3 - 2 * s) * aside_;
  handle.V_WA.v = s < 1 ? Vec3((6 * s * (1 - s) / kWaySeconds) * aside_) : Vec3(Vec3::Zero());
  handle.X_WA.p.x() += swing_ * std::sin(omega * swing_t);
  if (swing_t > 0) handle.V_WA.v.x() += swing_ * omega * std::cos(omega * swing_t);
  if (jump_at_ > 0 && static_cast<double>(tick_) >= jump_at_) handle.X_WA.p.x() += 0.05;
  if (Within(nan_at_, 1)) handle.X_WA.p.x() = std::numeric_limits<double>::quiet_NaN();
  return handle;
}

void FakeDriver::Render(const Wrench& F_D_W) noexcept {
  if (mailbox_) {
    mailbox_->Put(F_D_W, MonotonicNowNs());
  } else {
    Write(F_D_W);
  }
}

void FakeDriver::Stop() noexcept {
  if (mailbox_) mailbox_->Cut();
  Write({});
}

void FakeDriver::Write(const Wrench& F_D_W) noexcept {
  if (record_ == nullptr) return;
  const std::uint64_t count = record_->count.load(std::memory_order_relaxed);
  FakeRecord::Write& write = record_->writes[count % FakeRecord::kRoom];
  write.ns = MonotonicNowNs();
  for (int i = 0; i < 3; ++i) {
    write.force_N[static_cast<std::size_t>(i)] = F_D_W.f[i];
    write.moment_Nm[static_cast<std::size_t>(i)] = F_D_W.tau[i];
  }
  record_->count.store(count + 1, std::memory_order_release);
}

}  // namespace tandem
