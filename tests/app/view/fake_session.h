#pragma once

#include <QCoreApplication>
#include <QDeadlineTimer>
#include <QEventLoop>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/view/model/session/session_model.h"

namespace tandem {

/// Runs the event loop until `done` holds. Returns false when it does not in time.
inline bool ProcessEventsUntil(const std::function<bool()>& done, int patience_ms = 10'000) {
  const QDeadlineTimer deadline(patience_ms);
  while (!done()) {
    if (deadline.hasExpired()) return false;
    QCoreApplication::processEvents(QEventLoop::WaitForMoreEvents | QEventLoop::AllEvents, 20);
  }
  return true;
}

/// A session without a network. It writes down what the viewer says, and a test calls `inbox` with
/// what the viewer hears.
struct FakeSession {
  std::string refuse;  // when not empty, joining fails with these words
  Inbox* inbox = nullptr;
  JoinRequest request;
  PeerId peer = 0;
  std::vector<PeerInfo> output;
  std::string keys_end;  // words on keys that have ended
  int left = 0;
  int destroyed = 0;

  JoinFunction Join() {
    return
        [this](const JoinRequest& r, PeerId id, Inbox& in) -> Result<std::unique_ptr<Transport>> {
          if (!refuse.empty()) return Error{refuse};
          request = r;
          peer = id;
          inbox = &in;
          return std::unique_ptr<Transport>(std::make_unique<FakeTransport>(*this));
        };
  }

  /// Returns a frame of a peer that holds one body.
  static ViewFrame Frame(PeerId from, ObjectId object, const Vec3& displacement, float delay_ms) {
    ViewFrame frame;
    frame.peer = from;
    frame.delay_ms = delay_ms;
    frame.count = 1;
    frame.bodies[0].object = object;
    frame.bodies[0].flags = ViewBody::kHeld;
    frame.bodies[0].X_W.p = displacement;
    return frame;
  }
  static PeerInfo Info(PeerId peer, const std::string& name, Role role) {
    PeerInfo info;
    info.peer = peer;
    info.name = name;
    info.role = role;
    return info;
  }

 private:
  struct FakeTransport : Transport {
    explicit FakeTransport(FakeSession& s) : session(s) {}
    ~FakeTransport() override { ++session.destroyed; }
    void Publish(const ObjectState&) override { FAIL() << "a viewer says nothing of poses"; }
    void Publish(const ObjectState&, const CouplingLinks&) override {
      FAIL() << "a viewer says nothing of poses";
    }
    void Publish(const ViewFrame&) override { FAIL() << "a viewer says nothing of poses"; }
    void Publish(const PeerInfo& info) override { session.output.push_back(info); }
    void Publish(const Event&) override { FAIL() << "a viewer says nothing of bodies"; }
    void Publish(const SceneManifest&) override { FAIL() << "a viewer offers no scene"; }
    void Leave() override { ++session.left; }
    std::string KeysEnd() const override { return session.keys_end; }
    FakeSession& session;
  };
};

}  // namespace tandem
