#include "tests/app/device/drivers/inverse3/fake_service.h"

#include <chrono>
#include <list>
#include <mutex>
#include <thread>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

namespace tandem::testing {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;
using Stream = beast::websocket::stream<tcp::socket>;

std::string Xyz(double x, double y, double z) {
  return nlohmann::json{{"x", x}, {"y", y}, {"z", z}}.dump();
}

}  // namespace

struct FakeService::Parts {
  struct Connection {
    std::unique_ptr<Stream> stream;
    bool events = false;
    bool ended = false;
    std::thread thread;
  };

  /// Returns the state of all devices; `full`: with their configuration.
  std::string State(bool full) const {
    std::string text = R"({"session_id":7,"inverse3":[)";
    if (!world.arm.empty()) {
      text += R"({"device_id":")" + world.arm + "\",";
      if (full) text += R"("config":{"type":"inverse3","basis":{"permutation":"XYZ"}},)";
      text += R"("state":{"cursor_position":)" + Xyz(world.x, world.y, world.z) +
              R"(,"cursor_velocity":)" + Xyz(world.vx, world.vy, world.vz) +
              R"(,"body_orientation":{"w":1,"x":0,"y":0,"z":0},"current_cursor_force":)" +
              force.dump() + R"(,"control_mode":"force"},"status":)" +
              nlohmann::json{{"calibrated", world.calibrated},
                             {"ready", world.ready},
                             {"power_supply", world.powered},
                             {"started", true},
                             {"in_use", true}}
                  .dump() +
              "}";
    }
    text += "]";
    if (!world.grip_kind.empty()) {
      text += ",\"" + world.grip_kind + R"(":[{"device_id":"G1","state":{)" + world.grip_state +
              R"(},"status":{)" + world.grip_status + "}}]";
    }
    return text + "}";
  }

  /// Acts as a message says, and answers it.
  std::string Answer(const std::string& message, bool is_first) {
    const std::lock_guard lock(mutex);
    ++messages;
    newest = message;
    if (is_first) first = message;
    force = {{"x", 0}, {"y", 0}, {"z", 0}};
    const auto output = nlohmann::json::parse(message, nullptr, false);
    try {
      force = output.at("inverse3").at(0).at("commands").at("set_cursor_force").at(world.follows);
    } catch (const nlohmann::json::exception&) {
      // the message has no force in the form that the service follows
    }
    if (world.silent) return {};
    return world.instead.empty() ? State(false) : world.instead;
  }

  void Serve(Connection& mine) {
    error_code error;
    beast::flat_buffer buffer;
    http::request<http::string_body> request;
    Stream& stream = *mine.stream;
    http::read(stream.next_layer(), buffer, request, error);
    if (error) return;
    if (!beast::websocket::is_upgrade(request)) {
      http::response<http::string_body> answer(http::status::ok, 11);
      answer.body() = R"({"version":"3.5.1"})";
      answer.prepare_payload();
      http::write(stream.next_layer(), answer, error);
      stream.next_layer().shutdown(tcp::socket::shutdown_both, error);
      return;
    }
    stream.accept(request, error);
    if (error) return;
    {
      const std::lock_guard lock(mutex);
      ++connections;
      if (mine.events) {
        listening = true;
      } else {
        stream.write(asio::buffer(State(true)), error);
      }
    }
    for (bool is_first = true; !error; is_first = false) {
      beast::flat_buffer message;
      stream.read(message, error);
      if (error) break;
      const std::string answer = Answer(beast::buffers_to_string(message.data()), is_first);
      if (!answer.empty()) stream.write(asio::buffer(answer), error);
    }
  }

  void Accept() {
    while (!ending.load()) {
      for (const bool events : {false, true}) {
        error_code error;
        tcp::socket socket(context);
        tcp::acceptor& door = events ? events_door : state_door;
        door.accept(socket, error);
        if (error) continue;
        const std::lock_guard lock(mutex);
        if (shut) continue;
        socket.non_blocking(false, error);
        socket.set_option(tcp::no_delay(true), error);
        Connection& mine = all.emplace_back();
        mine.stream = std::make_unique<Stream>(std::move(socket));
        mine.events = events;
        mine.thread = std::thread([this, &mine] {
          Serve(mine);
          const std::lock_guard served(mutex);
          error_code ignored;
          mine.stream->next_layer().shutdown(tcp::socket::shutdown_both, ignored);
          if (mine.events) listening = false;
          mine.ended = true;
        });
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  static void Open(tcp::acceptor& door, int port) {
    const tcp::endpoint here(asio::ip::address_v4::loopback(), static_cast<unsigned short>(port));
    door.open(here.protocol());
    door.set_option(tcp::acceptor::reuse_address(true));
    door.bind(here);
    door.listen();
    door.non_blocking(true);
  }

  asio::io_context context;
  tcp::acceptor state_door{context};
  tcp::acceptor events_door{context};
  std::atomic<bool> ending{false};
  mutable std::mutex mutex;
  FakeWorld world;
  nlohmann::json force = {{"x", 0}, {"y", 0}, {"z", 0}};
  bool shut = false;
  bool listening = false;
  std::string first, newest;
  long messages = 0;
  long connections = 0;
  std::list<Connection> all;
  std::thread accepter;
};

FakeService::FakeService(int port) : parts_(std::make_unique<Parts>()) {
  Parts::Open(parts_->state_door, port);
  Parts::Open(parts_->events_door, 0);
  parts_->accepter = std::thread([this] {
    parts_->Accept();
  });
}

FakeService::~FakeService() {
  parts_->ending.store(true);
  parts_->accepter.join();
  Kick(true);
  for (Parts::Connection& one : parts_->all) one.thread.join();
}

int FakeService::port() const {
  return parts_->state_door.local_endpoint().port();
}
int FakeService::events_port() const {
  return parts_->events_door.local_endpoint().port();
}
std::string FakeService::ports() const {
  return "port=" + std::to_string(port()) + ",events=" + std::to_string(events_port());
}

void FakeService::Change(const std::function<void(FakeWorld&)>& change) {
  const std::lock_guard lock(parts_->mutex);
  change(parts_->world);
}

void FakeService::Tell(const std::string& event) {
  const std::lock_guard lock(parts_->mutex);
  for (Parts::Connection& one : parts_->all) {
    error_code ignored;
    if (one.events && !one.ended) one.stream->write(asio::buffer(event), ignored);
  }
}

void FakeService::Kick(bool shut) {
  const std::lock_guard lock(parts_->mutex);
  parts_->shut = shut;
  for (Parts::Connection& one : parts_->all) {
    if (!one.ended) shutdown(one.stream->next_layer().native_handle(), SHUT_RDWR);
  }
}

void FakeService::Reopen() {
  const std::lock_guard lock(parts_->mutex);
  parts_->shut = false;
}

std::string FakeService::first() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->first;
}
std::string FakeService::newest() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->newest;
}
long FakeService::messages() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->messages;
}
long FakeService::connections() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->connections;
}
bool FakeService::Listens() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->listening;
}

}  // namespace tandem::testing
