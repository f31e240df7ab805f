#include "collab/dds/control/control_port.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <random>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "collab/dds/control/control_domain.h"
#include "collab/dds/cyclone/take_samples.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/wire/control_wire.h"

namespace tandem {

namespace {

/// The name of a running controller: a locked file, which the kernel unlocks when the process ends
/// for any reason. Its keys for hosts and its scenes are removed with it.
class NameLock {
 public:
  NameLock(NameLock&& other) noexcept
      : file_(std::exchange(other.file_, -1)), path_(std::move(other.path_)) {}
  NameLock& operator=(NameLock&&) = delete;
  ~NameLock() {
    if (file_ < 0) return;
    std::error_code ignored;
    std::filesystem::remove_all(keys(), ignored);
    std::filesystem::remove_all(scenes(), ignored);
    std::filesystem::remove(path_, ignored);  // while it is locked, so that nobody takes it
                                              // meanwhile
    close(file_);
  }

  static Result<NameLock> Take(const std::filesystem::path& path, const std::string& name) {
    for (;;) {
      NameLock lock(open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600), path);
      if (lock.file_ < 0) return Error{path.string() + ": cannot be written"};
      if (flock(lock.file_, LOCK_EX | LOCK_NB) != 0) {
        close(std::exchange(lock.file_, -1));
        return Error{"a controller '" + name + "' already runs on this machine: --control with " +
                     "another name, or attach to that one"};
      }
      // its owner may have removed the file between open and lock
      struct stat ours {};
      struct stat there {};
      if (fstat(lock.file_, &ours) == 0 && stat(path.c_str(), &there) == 0 &&
          ours.st_ino == there.st_ino) {
        return lock;
      }
      close(std::exchange(lock.file_, -1));
    }
  }
  /// Removes what killed controllers left behind.
  static void Sweep(const std::filesystem::path& folder) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
      // whoever has the lock owns the files of its controller; they are removed with the lock
      if (entry.path().extension() == ".lock") static_cast<void>(Take(entry.path(), ""));
    }
  }

  std::filesystem::path keys() const {
    return std::filesystem::path(path_).replace_extension(".keys");
  }
  std::filesystem::path scenes() const {
    return path_.parent_path() / ScenesFolderOf(path_.stem().string());
  }

 private:
  NameLock(int file, std::filesystem::path path) : file_(file), path_(std::move(path)) {}

  int file_;
  std::filesystem::path path_;
};

class DdsControlPort final : public ControlPort {
 public:
  DdsControlPort(NameLock lock, ControlDomain domain)
      : lock_(std::move(lock)), domain_(std::move(domain)) {
    std::random_device random;
    while (id_ == 0) id_ = std::uint64_t{random()} << 32U | random();
  }
  ~DdsControlPort() override {
    domain_.participant.Delete();
    domain_.domain.Delete();
  }
  DdsControlPort(const DdsControlPort&) = delete;
  DdsControlPort& operator=(const DdsControlPort&) = delete;

  bool Open() {
    const dds_entity_t participant = domain_.participant.get();
    const auto count = [this](dds_instance_handle_t, Drop) {
      refused_.fetch_add(1, std::memory_order_relaxed);
    };
    requests_ = ControlReader(participant, ControlTopic::kRequest, count);
    goals_ = ControlReader(participant, ControlTopic::kGoal, count);
    answers_ = ControlWriter(participant, ControlTopic::kAnswer);
    scenes_ = ControlWriter(participant, ControlTopic::kScene);
    snapshots_ = ControlWriter(participant, ControlTopic::kSnapshot);
    wake_ = dds_create_guardcondition(participant);
    waitset_ = dds_create_waitset(participant);
    for (const dds_entity_t reader : {requests_, goals_}) {
      dds_waitset_attach(waitset_, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
    }
    dds_waitset_attach(waitset_, wake_, 0);
    return std::min({requests_, goals_, answers_, scenes_, snapshots_, wake_, waitset_}) > 0;
  }

  void Wait(std::int64_t at_most_ns) override {
    dds_waitset_wait(waitset_, nullptr, 0, at_most_ns);
    bool raised = false;
    dds_take_guardcondition(wake_, &raised);
  }
  void Wake() override { dds_set_guardcondition(wake_, true); }

  void Take(ControlServer& server, std::int64_t now_ns) override {
    TakeData<tandem_control_Goal>(goals_, [&](const tandem_control_Goal& wire) {
      HostGoal goal;
      if (FromWire(wire, goal)) server.OnGoal(wire.host, goal, now_ns);
    });
    TakeData<tandem_control_Request>(requests_, [&](const tandem_control_Request& wire) {
      const std::optional<ControlRequest> request =
          wire.version == kControlVersion ? FromWire(wire) : std::nullopt;
      if (request) {
        server.OnRequest(wire.host, TextFromWire(wire.host_name), wire.number, *request, now_ns);
        return;
      }
      Say({wire.host,
           wire.number,
           {false, wire.version == kControlVersion
                       ? "a request that is none"
                       : "this controller speaks version " + std::to_string(kControlVersion) +
                             " of the command interface, not " + std::to_string(wire.version)}});
    });
  }

  void Say(const HostAnswer& answer) override {
    tandem_control_Answer wire{};
    ToWire(answer, wire);
    dds_write(answers_, &wire);
  }
  void Say(const ControlScene& scene, bool loading) override {
    tandem_control_Scene wire{};
    std::vector<tandem_control_SceneBody> room;
    ToWire(scene, loading, wire, room);
    wire.controller = id_;
    dds_write(scenes_, &wire);
  }
  void Say(const ControllerSnapshot& snapshot) override {
    tandem_control_Snapshot wire{};
    ToWire(snapshot, snapshot.self, wire, room_);
    dds_write(snapshots_, &wire);
  }
  std::uint64_t refused() const noexcept override {
    return refused_.load(std::memory_order_relaxed);
  }

 private:
  NameLock lock_;
  std::atomic<std::uint64_t> refused_ = 0;
  ControlDomain domain_;
  std::uint64_t id_ = 0;
  dds_entity_t requests_ = 0;
  dds_entity_t goals_ = 0;
  dds_entity_t answers_ = 0;
  dds_entity_t scenes_ = 0;
  dds_entity_t snapshots_ = 0;
  dds_entity_t wake_ = 0;
  dds_entity_t waitset_ = 0;
  SnapshotBuffers room_;
};

}  // namespace

Result<std::unique_ptr<ControlPort>> ControlPort::Open(const Options& options) {
  if (!IsMemberName(options.name)) {
    return Error{"'" + options.name + "' is no name for a controller: letters, digits, '.', '_', " +
                 "'-', at most 64"};
  }
  const Result<std::filesystem::path> folder = ControlFolder();
  if (!folder) return folder.error();
  NameLock::Sweep(*folder);
  Result<NameLock> lock = NameLock::Take(*folder / (options.name + ".lock"), options.name);
  if (!lock) return lock.error();
  const std::filesystem::path keys = lock->keys();
  std::error_code failed;
  std::filesystem::remove_all(keys, failed);
  if (options.secured) {
    if (const Result<bool> made = MakeControlKeys(keys); !made) return made.error();
  }
  const std::filesystem::path own = options.secured ? keys / "controller" : "";
  Result<ControlDomain> domain = EnterControlDomain(options.name, options.domain, own);
  if (!domain) return domain.error();
  auto port = std::make_unique<DdsControlPort>(*std::move(lock), *std::move(domain));
  if (!port->Open()) return Error{"the command interface cannot be opened on this machine"};
  return std::unique_ptr<ControlPort>(std::move(port));
}

}  // namespace tandem
