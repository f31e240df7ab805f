#include "app/invite/enrolment_listener.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <ctime>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr int kListenerTurnMs = 100;
constexpr int kPortsTried = 20;
constexpr std::size_t kMostReceived = 64 * 1024;      // TLS bytes of a connection
constexpr int kWaiting = 64;                          // connections that wait to be accepted
constexpr int kAcceptedATurn = 2;                     // between two looks at those that are there
constexpr std::int64_t kHandshakeNs = 3'000'000'000;  // longest time until TLS is open
constexpr std::int64_t kAfterUseNs = 2'000'000'000;   // time for the answer to be sent
constexpr const char* kNotInvited = "this line is not the invitation that is open here";

/// A client's connection.
class Connection {
 public:
  Connection(int socket, std::uint32_t address, const TlsIdentity& identity, std::int64_t now_ns)
      : socket_(socket),
        address_(address),
        tls_(TlsEndpoint::Server(identity)),
        since_ns_(now_ns) {}
  ~Connection() { close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket() const { return socket_; }
  std::uint32_t address() const { return address_; }
  bool TooOld(std::int64_t now_ns) const {
    const std::int64_t age_ns = now_ns - since_ns_;
    return age_ns > EnrolmentListener::kConnectionNs || (!tls_.open() && age_ns > kHandshakeNs);
  }
  TlsEndpoint& tls() { return tls_; }
  const TlsEndpoint& tls() const { return tls_; }
  bool answered() const { return answered_; }
  bool gets_keys() const { return gets_keys_; }
  bool over() const { return over_; }
  bool waits_to_send() const { return !to_send_.empty(); }

  /// Receives bytes. Returns the request once it is complete.
  std::optional<std::string> Receive() {
    std::array<char, 4096> buffer;
    const ssize_t size = recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (size < 0) {
      over_ = errno != EAGAIN && errno != EINTR;
      return std::nullopt;
    }
    received_ += static_cast<std::size_t>(size);
    // after its answer, the client's bytes are ignored; only its end counts
    if (size == 0 || received_ > kMostReceived) {
      over_ = true;
      return std::nullopt;
    }
    if (answered_) return std::nullopt;
    tls_.Receive({buffer.data(), static_cast<std::size_t>(size)});
    text_ += tls_.Hear();
    const std::size_t end = text_.find('\n');
    if (end != std::string::npos) return text_.substr(0, end);
    over_ = text_.size() > EnrolmentRequest::kLongest;
    return std::nullopt;
  }
  void Answer(const EnrolmentAnswer& answer) {
    tls_.Say(TextOf(answer));
    tls_.Close();
    answered_ = true;
    gets_keys_ = answer.refused.empty();
  }
  void Send() {
    to_send_ += tls_.TakeToSend();
    while (!to_send_.empty()) {
      const ssize_t sent =
          send(socket_, to_send_.data(), to_send_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent <= 0) {
        over_ = over_ || (errno != EAGAIN && errno != EINTR);
        return;
      }
      to_send_.erase(0, static_cast<std::size_t>(sent));
    }
    over_ = over_ || (tls_.failed() && !answered_);
  }

 private:
  int socket_;
  std::uint32_t address_;  // IPv4 address of the client
  TlsEndpoint tls_;
  std::int64_t since_ns_;
  std::size_t received_ = 0;
  std::string text_;
  std::string to_send_;
  bool answered_ = false;
  bool gets_keys_ = false;
  bool over_ = false;
};

using Connections = std::vector<std::unique_ptr<Connection>>;

std::size_t CountOf(const Connections& all, std::uint32_t address) {
  return static_cast<std::size_t>(std::ranges::count_if(all, [address](const auto& one) {
    return one->address() == address;
  }));
}

using Random = std::minstd_rand;

/// Closes one of an address's connections: any one, but before all one that is refused or whose TLS
/// is not open, and none to which keys go. A client that comes again and again cannot choose which.
/// So a joiner that tries again gets its answer in the end.
void CloseOneOf(Connections& all, std::uint32_t address, Random& random) {
  const auto closable = [&all, address](bool may_be_a_joiner) {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Connection& one = *all[i];
      const bool waits = one.tls().open() && !one.answered();
      if (one.address() != address || one.gets_keys() || waits != may_be_a_joiner) continue;
      places.push_back(i);
    }
    return places;
  };
  std::vector<std::size_t> places = closable(false);
  if (places.empty()) places = closable(true);
  if (places.empty()) return;
  const std::size_t chosen = places[random() % places.size()];
  all.erase(all.begin() + static_cast<std::ptrdiff_t>(chosen));
}

/// Returns the address of the client with the most connections.
std::uint32_t BusiestOf(const Connections& all) {
  const auto busiest = std::ranges::max_element(all, {}, [&all](const auto& one) {
    return CountOf(all, one->address());
  });
  return busiest == all.end() ? 0 : (*busiest)->address();
}

/// Accepts clients that wait. Each takes the place of another of its address where that has
/// many, or of one of the busiest address. So idle clients keep nobody out.
void Accept(int listener, const TlsIdentity& identity, std::int64_t now_ns, Random& random,
            Connections& all) {
  for (int accepted = 0; accepted < kAcceptedATurn; ++accepted) {
    sockaddr_in client{};
    socklen_t size = sizeof client;
    const int socket = accept4(listener, reinterpret_cast<sockaddr*>(&client), &size,
                               SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0) return;
    const std::uint32_t address = client.sin_addr.s_addr;
    if (CountOf(all, address) >= EnrolmentListener::kMostOfAnAddress) {
      CloseOneOf(all, address, random);
    }
    if (all.size() >= EnrolmentListener::kMostConnections) {
      CloseOneOf(all, BusiestOf(all), random);
    }
    if (all.size() >= EnrolmentListener::kMostConnections) {
      close(socket);
      continue;
    }
    all.push_back(std::make_unique<Connection>(socket, address, identity, now_ns));
  }
}

/// Listens at a port. A negative result is a failure, as errno says.
int ListenAt(std::uint16_t port, const EnrolmentListener::BindFunction& bind) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener < 0) return listener;
  const int yes = 1;
  setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (bind(listener, port) && listen(listener, kWaiting) == 0) {
    return listener;
  }
  const int fault = errno;
  close(listener);
  errno = fault;
  return -1;
}

/// The open invitation: answers requests and counts wrong proofs.
class Desk {
 public:
  Desk(const Invitation& invitation, const std::string& name, const SignFunction& sign,
       const std::function<void(const std::string&)>& tell)
      : invitation_(invitation), name_(name), sign_(sign), tell_(tell) {}

  bool used() const { return used_; }
  int wrong() const { return wrong_; }

  EnrolmentAnswer Answer(const std::string& text, const Digest256& binding) {
    const Result<EnrolmentRequest> request = ReadEnrolmentRequest(text);
    // a scanner's request is no guess at the secret
    if (!request) {
      if (std::exchange(strangers_told_, true)) return Refused(kNotInvited);
      tell_("a program that is not Tandem's called at the port of this invitation: refused");
      return Refused(kNotInvited);
    }
    if (!AreSame(request->proof, ProofOf(invitation_, binding))) {
      if (wrong_++ == 0) {
        tell_("somebody came without the secret of this invitation: refused");
      }
      return Refused(kNotInvited);
    }
    if (used_) {
      tell_("somebody used the line a second time: refused");
      return Refused("somebody has used the invitation already: ask for one of your own");
    }
    Result<MemberFiles> files = sign_(request->certificate_request);
    if (!files) {
      tell_("the request is invalid and refused: " + files.error().what);
      return Refused("the request is invalid and refused: " + files.error().what);
    }
    used_ = true;
    EnrolmentAnswer answer;
    answer.session = invitation_.session;
    answer.role = invitation_.role;
    answer.name = name_;
    answer.files = *std::move(files);
    return answer;
  }

 private:
  static EnrolmentAnswer Refused(const std::string& why) {
    EnrolmentAnswer answer;
    answer.refused = why;
    return answer;
  }

  const Invitation& invitation_;
  const std::string& name_;
  const SignFunction& sign_;
  const std::function<void(const std::string&)>& tell_;
  bool used_ = false;
  bool strangers_told_ = false;
  int wrong_ = 0;
};

}  // namespace

Result<EnrolmentListener> EnrolmentListener::Open(std::uint16_t port, bool or_next,
                                                  const BindFunction& bind) {
  Result<TlsIdentity> identity = TlsIdentity::Make();
  if (!identity) return identity.error();
  int listener = -1;
  int fault = 0;
  for (int i = 0; i < (or_next ? kPortsTried : 1) && listener < 0 && port + i <= 65535; ++i) {
    listener = ListenAt(static_cast<std::uint16_t>(port + i), bind);
    fault = errno;
  }
  if (listener < 0) {
    return Error{"TCP port " + std::to_string(port) + ": " + std::strerror(fault) +
                 ": give a free one with --enrol-port"};
  }
  sockaddr_in bound{};
  socklen_t size = sizeof bound;
  getsockname(listener, reinterpret_cast<sockaddr*>(&bound), &size);
  return EnrolmentListener(listener, ntohs(bound.sin_port), *std::move(identity));
}

EnrolmentListener::EnrolmentListener(EnrolmentListener&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      port_(other.port_),
      identity_(std::move(other.identity_)) {}

EnrolmentListener::~EnrolmentListener() {
  if (socket_ >= 0) close(socket_);
}

EnrolmentListener::End EnrolmentListener::Serve(const Invitation& invitation,
                                                const std::string& name, const SignFunction& sign,
                                                const std::function<void(const std::string&)>& tell,
                                                const std::atomic<bool>& stop) {
  Desk panel(invitation, name, sign, tell);
  Connections all;
  Random random(std::random_device{}());
  std::int64_t used_ns = 0;
  while (!stop.load()) {
    if (!panel.used() && std::time(nullptr) >= invitation.enrolment.until) return End::kExpired;
    std::vector<pollfd> waits{{socket_, POLLIN, 0}};
    for (const auto& one : all) {
      const int events = one->waits_to_send() ? POLLIN | POLLOUT : POLLIN;
      waits.push_back({one->socket(), static_cast<short>(events), 0});
    }
    poll(waits.data(), waits.size(), kListenerTurnMs);
    const std::int64_t now_ns = MonotonicNowNs();
    for (std::size_t i = 0; i < all.size(); ++i) {
      Connection& one = *all[i];
      if (waits[i + 1].revents == 0) continue;
      if ((waits[i + 1].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
        const std::optional<std::string> request = one.Receive();
        if (request) one.Answer(panel.Answer(*request, one.tls().Binding()));
      }
      one.Send();
    }
    std::erase_if(all, [now_ns](const auto& one) {
      return one->over() || one->TooOld(now_ns);
    });
    if ((waits[0].revents & POLLIN) != 0) Accept(socket_, identity_, now_ns, random, all);
    if (panel.wrong() >= kMostWrong && !panel.used()) return End::kGuessed;
    if (!panel.used()) continue;
    if (used_ns == 0) used_ns = now_ns;
    // the joiner closes the connection when it has its answer
    if (all.empty() || now_ns - used_ns > kAfterUseNs) return End::kUsed;
  }
  return panel.used() ? End::kUsed : End::kStopped;
}

}  // namespace tandem
