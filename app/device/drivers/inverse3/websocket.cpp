#include "app/device/drivers/inverse3/websocket.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::int64_t kSliceNs = 20'000'000;  // time between looks at `ending`
// Time for an operation that `ending` finds under way. Without it the connection is gone, and no
// message can take the force away any more.
constexpr std::int64_t kGraceNs = 100'000'000;

/// Runs an operation to its end or to the limit. At the limit `abandon` closes the socket, which
/// ends the operation with an error. Returns whether the operation ended by itself.
template <typename Abandon>
bool RunToEnd(asio::io_context& context, const bool& done, std::int64_t limit_ns,
              const std::atomic<bool>& ending, const Abandon& abandon) {
  std::int64_t until_ns = MonotonicNowNs() + limit_ns;
  bool hurries = false;
  context.restart();
  while (!done) {
    const std::int64_t now_ns = MonotonicNowNs();
    if (!hurries && ending.load(std::memory_order_relaxed)) {
      hurries = true;
      until_ns = std::min(until_ns, now_ns + kGraceNs);
    }
    const std::int64_t left_ns = until_ns - now_ns;
    if (left_ns <= 0) {
      abandon();
      while (!done && context.run_one() != 0) {
      }
      return false;
    }
    context.run_one_for(std::chrono::nanoseconds(std::min(left_ns, kSliceNs)));
  }
  return true;
}

/// Connects to this machine. Returns the error of the last address.
error_code ConnectHere(asio::io_context& context, tcp::socket& socket, int port,
                       std::int64_t limit_ns, const std::atomic<bool>& ending) {
  error_code error;
  const std::array<asio::ip::address, 2> addresses{asio::ip::address_v4::loopback(),
                                                   asio::ip::address_v6::loopback()};
  for (const asio::ip::address& address : addresses) {
    bool done = false;
    error_code ignored;
    socket.close(ignored);
    socket.async_connect(tcp::endpoint(address, static_cast<unsigned short>(port)),
                         [&](error_code outcome) {
                           error = outcome;
                           done = true;
                         });
    const bool ended = RunToEnd(context, done, limit_ns, ending, [&] {
      socket.close(ignored);
    });
    if (ended && !error) {
      socket.set_option(tcp::no_delay(true), ignored);
      return {};
    }
  }
  return error ? error : asio::error::timed_out;
}

}  // namespace

struct WebSocket::Parts {
  explicit Parts(const std::atomic<bool>& is_ending) : ending(&is_ending) {}
  void Drop() {
    error_code ignored;
    if (stream) stream->next_layer().close(ignored);
  }
  /// Runs an operation that `begin` starts with its handler.
  template <typename Begin>
  bool Do(const char* what, std::int64_t limit_ns, const Begin& begin) {
    if (!stream || !stream->next_layer().is_open()) return false;
    bool done = false;
    error_code error;
    begin([&](error_code outcome, std::size_t = 0) {
      error = outcome;
      done = true;
    });
    const bool in_time = RunToEnd(context, done, limit_ns, *ending, [this] {
      Drop();
    });
    if (in_time && !error) return true;
    fault = std::string(what) + ": " + (in_time ? error.message() : "no answer in time");
    Drop();
    return false;
  }

  const std::atomic<bool>* ending;
  asio::io_context context{1};
  std::optional<beast::websocket::stream<tcp::socket>> stream;
  beast::flat_buffer buffer{2 * kLongest};
  std::string fault;
};

WebSocket::WebSocket(const std::atomic<bool>& ending) : parts_(std::make_unique<Parts>(ending)) {}

WebSocket::~WebSocket() {
  parts_->Drop();
}

const std::string& WebSocket::fault() const {
  return parts_->fault;
}

bool WebSocket::Connect(int port, std::int64_t limit_ns) {
  Parts& my = *parts_;
  my.Drop();
  my.buffer.consume(my.buffer.size());
  tcp::socket socket(my.context);
  if (const error_code error = ConnectHere(my.context, socket, port, limit_ns, *my.ending)) {
    my.fault = "connecting: " + error.message();
    return false;
  }
  my.stream.emplace(std::move(socket));
  my.stream->read_message_max(kLongest);
  my.stream->text(true);
  return my.Do("greeting", limit_ns, [&](auto handler) {
    my.stream->async_handshake("localhost:" + std::to_string(port), "/", handler);
  });
}

bool WebSocket::Send(std::string_view text, std::int64_t limit_ns) {
  return parts_->Do("sending", limit_ns, [&](auto handler) {
    parts_->stream->async_write(asio::buffer(text.data(), text.size()), handler);
  });
}

bool WebSocket::Receive(std::string& text, std::int64_t limit_ns) {
  Parts& my = *parts_;
  my.buffer.consume(my.buffer.size());
  if (!my.Do("receiving", limit_ns, [&](auto handler) {
        my.stream->async_read(my.buffer, handler);
      })) {
    return false;
  }
  const auto data = my.buffer.data();
  text.assign(static_cast<const char*>(data.data()), data.size());
  return true;
}

bool WebSocket::pending() const {
  error_code error;
  return parts_->stream && parts_->stream->next_layer().available(error) > 0 && !error;
}

void WebSocket::Close(std::int64_t limit_ns, std::string_view last) {
  static const std::atomic<bool> to_the_limit{false};
  const std::atomic<bool>* ending = std::exchange(parts_->ending, &to_the_limit);
  if (!last.empty()) Send(last, limit_ns);
  parts_->Do("closing", limit_ns, [&](auto handler) {
    parts_->stream->async_close(beast::websocket::close_code::normal, handler);
  });
  parts_->ending = ending;
  parts_->Drop();
}

std::optional<std::string> HttpGet(int port, const std::string& target, std::int64_t limit_ns) {
  static const std::atomic<bool> never{false};
  asio::io_context context(1);
  tcp::socket socket(context);
  if (ConnectHere(context, socket, port, limit_ns, never)) return {};
  http::request<http::empty_body> request(http::verb::get, target, 11);
  request.set(http::field::host, "localhost:" + std::to_string(port));
  request.set(http::field::connection, "close");
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> answer;
  answer.body_limit(WebSocket::kLongest);
  bool done = false;
  error_code error;
  const auto handler = [&](error_code outcome, std::size_t) {
    error = outcome;
    done = true;
  };
  const auto abandon = [&] {
    error_code ignored;
    socket.close(ignored);
  };
  http::async_write(socket, request, handler);
  if (!RunToEnd(context, done, limit_ns, never, abandon) || error) return {};
  done = false;
  http::async_read(socket, buffer, answer, handler);
  if (!RunToEnd(context, done, limit_ns, never, abandon) || error) return {};
  if (answer.get().result() != http::status::ok) return {};
  return answer.get().body();
}

}  // namespace tandem::driver
