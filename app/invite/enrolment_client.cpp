#include "app/invite/enrolment_client.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kConnectNs = 4'000'000'000;
constexpr std::int64_t kTalkNs = 6'000'000'000;
constexpr std::int64_t kTriesNs = 5'000'000'000;  // new tries where the inviter's port is busy
constexpr std::chrono::milliseconds kBetweenTries{20};
constexpr int kTurnMs = 50;

using Kind = EnrolmentFault::Kind;

/// A TCP connection to one host that is being opened.
class Way {
 public:
  Way(std::string host, std::uint16_t port)
      : host_(std::move(host)), at_(host_ + ":" + std::to_string(port)) {
    addrinfo hints{};
    hints.ai_family = AF_INET;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (getaddrinfo(host_.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) {
      fault_ = "no address is known for this name";
      return;
    }
    socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (connect(socket_, found->ai_addr, found->ai_addrlen) != 0 && errno != EINPROGRESS) {
      Fail(errno);
    }
    freeaddrinfo(found);
  }
  ~Way() { Close(); }
  Way(Way&& other) noexcept
      : host_(std::move(other.host_)),
        at_(std::move(other.at_)),
        socket_(std::exchange(other.socket_, -1)),
        fault_(std::move(other.fault_)) {}
  Way& operator=(Way&&) = delete;

  const std::string& host() const { return host_; }
  const std::string& at() const { return at_; }
  int socket_now() const { return socket_; }
  bool dead() const { return socket_ < 0; }
  std::string fault() const { return fault_.empty() ? "no answer" : fault_; }
  /// Returns whether the connection is established. Called once the socket is ready to write.
  bool Connected() {
    int fault = 0;
    socklen_t size = sizeof fault;
    getsockopt(socket_, SOL_SOCKET, SO_ERROR, &fault, &size);
    if (fault != 0) Fail(fault);
    return fault == 0;
  }
  void Close() {
    if (socket_ >= 0) close(std::exchange(socket_, -1));
  }

 private:
  void Fail(int fault) {
    fault_ = std::strerror(fault);
    Close();
  }

  std::string host_;
  std::string at_;
  int socket_ = -1;
  std::string fault_;
};

/// A TLS connection over a socket, with a deadline.
class TlsConnection {
 public:
  TlsConnection(int socket, std::int64_t until_ns, const std::function<bool()>& stopped)
      : socket_(socket), until_ns_(until_ns), stopped_(stopped), tls_(TlsEndpoint::Client()) {}

  TlsEndpoint& tls() { return tls_; }
  /// Returns whether the other end closed the connection.
  bool closed() const { return ended_; }
  /// Sends and receives until `done`. False: the connection or the time has ended, or `stopped`.
  template <typename Done>
  bool Until(Done done) {
    for (;;) {
      if (!Send()) return false;
      if (done()) return true;
      if (tls_.failed() || ended_ || MonotonicNowNs() > until_ns_ || stopped_()) return false;
      pollfd wait{socket_, POLLIN, 0};
      if (poll(&wait, 1, kTurnMs) <= 0) continue;
      std::array<char, 16384> buffer;
      const ssize_t size = recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size > 0) tls_.Receive({buffer.data(), static_cast<std::size_t>(size)});
      ended_ = size == 0 || (size < 0 && errno != EAGAIN && errno != EINTR);
    }
  }
  /// Returns the next line of text.
  std::optional<std::string> Line(std::size_t longest) {
    std::string text;
    const bool whole = Until([&] {
      text += tls_.Hear();
      return text.find('\n') != std::string::npos || text.size() > longest;
    });
    if (!whole || text.find('\n') == std::string::npos) return std::nullopt;
    return text.substr(0, text.find('\n'));
  }

 private:
  bool Send() {
    std::string bytes = tls_.TakeToSend();
    while (!bytes.empty()) {
      const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent > 0) {
        bytes.erase(0, static_cast<std::size_t>(sent));
        continue;
      }
      ended_ = errno != EAGAIN && errno != EINTR;
      if (ended_ || MonotonicNowNs() > until_ns_) return false;
      pollfd wait{socket_, POLLOUT, 0};
      poll(&wait, 1, kTurnMs);
    }
    return true;
  }

  int socket_;
  std::int64_t until_ns_;
  const std::function<bool()>& stopped_;
  TlsEndpoint tls_;
  bool ended_ = false;
};

std::string HostOf(const std::string& host_and_port) {
  return host_and_port.substr(0, host_and_port.find(':'));
}

/// The connections to all hosts of an invitation. Each is handed out once it is established.
class Ways {
 public:
  explicit Ways(const Invitation& invitation) {
    for (const std::string& host : invitation.hosts) {
      ways_.emplace_back(HostOf(host), invitation.enrolment.port);
    }
  }
  /// Returns the next established connection; null: no other one is established in time.
  Way* Next(const std::function<bool()>& stopped) {
    while (MonotonicNowNs() < until_ns_ && !stopped()) {
      std::vector<pollfd> waits;
      std::vector<Way*> whose;
      for (Way& way : ways_) {
        if (way.dead() || std::ranges::find(taken_, &way) != taken_.end()) continue;
        waits.push_back({way.socket_now(), POLLOUT, 0});
        whose.push_back(&way);
      }
      if (waits.empty()) return nullptr;
      poll(waits.data(), waits.size(), kTurnMs);
      for (std::size_t i = 0; i < waits.size(); ++i) {
        if (waits[i].revents == 0 || !whose[i]->Connected()) continue;
        taken_.push_back(whose[i]);
        return whose[i];
      }
    }
    return nullptr;
  }
  /// Lists the hosts that were not reached, with the reason for each.
  std::string Faults() const {
    std::string all;
    for (const Way& way : ways_) {
      if (std::ranges::find(taken_, &way) != taken_.end()) continue;
      all += (all.empty() ? "" : ", ") + way.at() + " (" + way.fault() + ")";
    }
    return all;
  }

 private:
  std::vector<Way> ways_;
  std::vector<Way*> taken_;
  std::int64_t until_ns_ = MonotonicNowNs() + kConnectNs;
};

/// Explains why no inviter answers, by this machine's clock.
std::string WhyNobody(const Invitation& invitation) {
  const std::time_t now = std::time(nullptr);
  const std::string end = TimeForAPerson(invitation.enrolment.until, now);
  if (now >= invitation.enrolment.until) {
    return "the invitation expired at " + end + ": ask for a new one";
  }
  return "the invitation (until " + end +
         ") was used or withdrawn, or its port is closed: ask for a new one, or check with: tandem "
         "doctor --invitation '" +
         PublicLineOf(invitation) + "'";
}

EnrolmentOutcome Faulty(Kind kind, const std::string& what) {
  return {.answer = {}, .fault = EnrolmentFault{kind, what}};
}

/// Shakes hands and checks the certificate. Returns why this is not the inviter; nothing: it is.
std::optional<std::string> WhyNotTheInviter(const Invitation& invitation, const Way& way,
                                            TlsConnection& talk) {
  const bool open = talk.Until([&talk] {
    return talk.tls().open();
  });
  if (!open && talk.closed()) {
    return way.at() +
           " closes the connection before it answers: many programs call there, or it is no "
           "program of Tandem's: try again";
  }
  if (!open) return way.at() + " does not listen for invitations";
  if (AreSame(talk.tls().others_digest(), invitation.enrolment.certificate)) return std::nullopt;
  return way.at() +
         " is not the program of this line: another invitation is open there, or somebody changed "
         "the line: ask for a new one";
}

EnrolmentOutcome Ask(const Invitation& invitation, const std::string& certificate_request,
                     TlsConnection& talk) {
  EnrolmentRequest request;
  request.proof = ProofOf(invitation, talk.tls().Binding());
  request.certificate_request = certificate_request;
  talk.tls().Say(TextOf(request));
  const std::optional<std::string> line = talk.Line(EnrolmentAnswer::kLongest);
  if (!line) {
    return Faulty(Kind::kUnreachable,
                  "the inviter's program ended: ask whether it still runs, and for a new line");
  }
  Result<EnrolmentAnswer> answer = ReadEnrolmentAnswer(*line);
  if (!answer) return Faulty(Kind::kStranger, answer.error().what);
  if (!answer->refused.empty()) {
    return Faulty(Kind::kRefused, "the inviter refuses: " + answer->refused);
  }
  if (answer->session != invitation.session || answer->role != invitation.role) {
    return Faulty(Kind::kStranger,
                  "the inviter sent keys of another session or role than the line's, and this "
                  "program discards them: ask for a new line");
  }
  return {.answer = *std::move(answer), .fault = std::nullopt};
}

/// Asks the hosts of the line once. `closed`: the host that answered closed the connection.
EnrolmentOutcome AskOnce(const Invitation& invitation, const std::string& certificate_request,
                         const std::function<bool()>& stopped, bool& closed) {
  Ways ways(invitation);
  std::optional<std::string> stranger;
  closed = false;
  while (Way* const way = ways.Next(stopped)) {
    TlsConnection talk(way->socket_now(), MonotonicNowNs() + kTalkNs, stopped);
    const std::optional<std::string> why_not = WhyNotTheInviter(invitation, *way, talk);
    if (!why_not) {
      EnrolmentOutcome outcome = Ask(invitation, certificate_request, talk);
      closed = outcome.fault && outcome.fault->kind == Kind::kUnreachable && talk.closed();
      return outcome;
    }
    closed = closed || talk.closed();
    stranger = why_not;
  }
  if (stopped()) return Faulty(Kind::kUnreachable, "ended before the inviter answered");
  if (stranger) return Faulty(Kind::kStranger, *stranger);
  return Faulty(Kind::kUnreachable,
                "no program answers at " + ways.Faults() + ": " + WhyNobody(invitation));
}

}  // namespace

EnrolmentOutcome Enrol(const Invitation& invitation, const std::string& certificate_request,
                       const std::function<bool()>& stopped) {
  const std::int64_t until_ns = MonotonicNowNs() + kTriesNs;
  for (;;) {
    bool closed = false;
    EnrolmentOutcome outcome = AskOnce(invitation, certificate_request, stopped, closed);
    // the inviter closes connections where too many come, and has used nothing up then
    if (!closed || stopped() || MonotonicNowNs() > until_ns) return outcome;
    std::this_thread::sleep_for(kBetweenTries);
  }
}

InviterFacts ProbeInviter(const Invitation& invitation) {
  const std::function<bool()> stopped = [] {
    return false;
  };
  Ways ways(invitation);
  InviterFacts facts;
  while (Way* const way = ways.Next(stopped)) {
    TlsConnection talk(way->socket_now(), MonotonicNowNs() + kTalkNs, stopped);
    const std::optional<std::string> why_not = WhyNotTheInviter(invitation, *way, talk);
    facts.host = way->host();
    facts.is_the_inviter = !why_not;
    facts.what = why_not.value_or(way->at() + " answers, and is the inviter's program");
    if (facts.is_the_inviter) return facts;
  }
  if (facts.host.empty()) {
    facts.what = "no program answers at " + ways.Faults() + ": " + WhyNobody(invitation);
  }
  return facts;
}

}  // namespace tandem
