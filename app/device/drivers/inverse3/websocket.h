#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tandem::driver {

/// A WebSocket client for a service on this machine. Each call ends at its limit, or within 120 ms
/// once `ending` is set. After a failed call the connection is closed, and fault() says why. Used
/// by one thread. Throws only for lack of memory.
class WebSocket {
 public:
  static constexpr std::size_t kLongest = 65536;  // bytes of a message; a longer one is a fault

  explicit WebSocket(const std::atomic<bool>& ending);
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Connects to ws://127.0.0.1:port/; where nothing listens there, to ws://[::1]:port/.
  bool Connect(int port, std::int64_t limit_ns);
  bool Send(std::string_view text, std::int64_t limit_ns);
  /// Receives the next message, whatever it contains.
  bool Receive(std::string& text, std::int64_t limit_ns);
  /// Returns whether bytes have come that Receive() has not read.
  bool pending() const;
  /// Sends a last message and a goodbye where there is a connection, even while `ending` is set.
  void Close(std::int64_t limit_ns, std::string_view last = {});
  const std::string& fault() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Returns the answer to GET http://127.0.0.1:port/target with status 200; nothing: none came in
/// time.
std::optional<std::string> HttpGet(int port, const std::string& target, std::int64_t limit_ns);

}  // namespace tandem::driver
