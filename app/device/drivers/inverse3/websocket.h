#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tandem::driver {

/// A WebSocket client for a service on this machine. Every call ends in time: at its limit, or
/// within 20 ms once `ending` is set. After a call that failed the connection is closed, and
/// fault() says why. For one thread. No call throws but for lack of memory.
class WebSocket {
 public:
  static constexpr std::size_t kLongest = 65536;  // bytes of a message; a longer one is a fault

  explicit WebSocket(const std::atomic<bool>& ending);
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Connects to ws://127.0.0.1:port/, or where nobody listens there, to ws://[::1]:port/.
  bool Connect(int port, std::int64_t limit_ns);
  bool Send(std::string_view text, std::int64_t limit_ns);
  /// The next message, whatever it holds.
  bool Receive(std::string& text, std::int64_t limit_ns);
  /// Bytes have come that Receive() has not seen.
  bool pending() const;
  /// Says goodbye where there is a connection, after a last message; `ending` does not matter.
  void Close(std::int64_t limit_ns, std::string_view last = {});
  const std::string& fault() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// What GET http://127.0.0.1:port/target answers with status 200; nothing: no such answer in time.
std::optional<std::string> HttpGet(int port, const std::string& target, std::int64_t limit_ns);

}  // namespace tandem::driver
