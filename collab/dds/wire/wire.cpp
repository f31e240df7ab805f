#include "collab/dds/wire/wire.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {
namespace {

static_assert(std::size(tandem_CouplingLinks{}.entries) == kMaxLinks);
static_assert(std::size(tandem_ViewFrame{}.bodies) == kMaxViewBodies);

constexpr double kUnitTolerance = 1e-3;

// NOLINTBEGIN(modernize-avoid-c-arrays): idlc's arrays are C's
template <typename Scalar>
void Put(const Vec3& v, Scalar (&out)[3]) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<Scalar>(v[i]);
}
template <typename Scalar>
void Put(const Quat& q, Scalar (&out)[4]) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<Scalar>(q.coeffs()[i]);
}
void Put(const Wrench& F, tandem_Wrench& out) {
  Put(F.f, out.f);
  Put(F.tau, out.t);
}

/// Reads numbers, and keeps the first fault that it finds.
class Reader {
 public:
  template <typename Scalar>
  Vec3 Get(const Scalar (&in)[3], double limit) {
    const Vec3 v(in[0], in[1], in[2]);
    for (const double x : v) Check(x, limit);
    return v;
  }
  template <typename Scalar>
  Quat Get(const Scalar (&in)[4]) {
    Quat q;
    q.coeffs() << in[0], in[1], in[2], in[3];
    for (const double x : q.coeffs()) Check(x, std::numeric_limits<double>::max());
    if (std::abs(q.norm() - 1.0) > kUnitTolerance) Note(Drop::kNotUnit);
    if (!fault_) q.normalize();
    return q;
  }
  Wrench Get(const tandem_Wrench& in) {
    return {Get(in.t, kWireBounds.torque), Get(in.f, kWireBounds.force)};
  }
  double GetNotNegative(double x, double limit) {
    Check(x, limit);
    if (x < 0) Note(Drop::kHuge);
    return x;
  }
  void Expect(bool holds, Drop otherwise) {
    if (!holds) Note(otherwise);
  }
  std::optional<Drop> fault() const { return fault_; }

 private:
  void Check(double x, double limit) {
    if (!std::isfinite(x)) {
      Note(Drop::kNotFinite);
    } else if (std::abs(x) > limit) {
      Note(Drop::kHuge);
    }
  }
  void Note(Drop fault) {
    if (!fault_) fault_ = fault;
  }

  std::optional<Drop> fault_;
};

template <typename Scalar>
bool Get(const Scalar (&in)[3], Vec3& v) {
  Reader reader;
  v = reader.Get(in, kWireBounds.position);
  return !reader.fault();
}
template <typename Scalar>
bool Get(const Scalar (&in)[4], Quat& q) {
  Reader reader;
  q = reader.Get(in);
  return !reader.fault();
}

void Put(const CouplingLinks& links, tandem_CouplingLinks& wire) noexcept {
  wire = {};
  wire.object = links.object;
  wire.seq = links.seq;
  wire.sample_ns = links.sample_ns;
  wire.count = std::min<std::uint32_t>(links.count, kMaxLinks);
  for (std::size_t i = 0; i < wire.count; ++i) {
    const LinkEntry& entry = links.entries[i];
    wire.entries[i].to = entry.to;
    wire.entries[i].echo_ns = entry.echo_ns;
    wire.entries[i].stiffness = entry.stiffness;
    wire.entries[i].gate_overflow = entry.gate_overflow;
    Put(entry.applied_B_W, wire.entries[i].applied);
  }
}

std::optional<Drop> Get(const tandem_CouplingLinks& wire, CouplingLinks& links) noexcept {
  if (wire.count > kMaxLinks) return Drop::kBadCount;
  links.object = wire.object;
  links.seq = wire.seq;
  links.sample_ns = wire.sample_ns;
  links.count = wire.count;
  Reader reader;
  for (std::size_t i = 0; i < wire.count; ++i) {
    LinkEntry& entry = links.entries[i];
    entry.to = wire.entries[i].to;
    entry.echo_ns = wire.entries[i].echo_ns;
    reader.Expect(entry.to != 0, Drop::kBadCount);
    entry.stiffness = reader.GetNotNegative(wire.entries[i].stiffness, kWireBounds.stiffness);
    entry.gate_overflow = reader.GetNotNegative(wire.entries[i].gate_overflow, kWireBounds.energy);
    entry.applied_B_W = reader.Get(wire.entries[i].applied);
  }
  return reader.fault();
}

// NOLINTEND(modernize-avoid-c-arrays)

}  // namespace

void ToWire(const ObjectState& state, tandem_ObjectState& wire) noexcept {
  wire.peer = state.peer;
  wire.object = state.object;
  wire.epoch = state.epoch;
  wire.seq = state.seq;
  wire.flags = state.flags;
  wire.sample_ns = state.sample_ns;
  Put(state.X_WB.p, wire.pose.p);
  Put(state.X_WB.q, wire.pose.q);
  Put(state.V_WB.v, wire.twist.v);
  Put(state.V_WB.w, wire.twist.w);
  Put(state.contact_B_W, wire.contact);
}

std::optional<Drop> FromWire(const tandem_ObjectState& wire, ObjectState& state) noexcept {
  state.peer = wire.peer;
  state.object = wire.object;
  state.epoch = wire.epoch;
  state.seq = wire.seq;
  state.flags = wire.flags;
  state.sample_ns = wire.sample_ns;
  Reader reader;
  reader.Expect(wire.peer != 0, Drop::kNoOwner);
  state.X_WB.p = reader.Get(wire.pose.p, kWireBounds.position);
  state.X_WB.q = reader.Get(wire.pose.q);
  state.V_WB.v = reader.Get(wire.twist.v, kWireBounds.speed);
  state.V_WB.w = reader.Get(wire.twist.w, kWireBounds.spin);
  state.contact_B_W = reader.Get(wire.contact);
  return reader.fault();
}

void ToWire(const LinkedState& linked, tandem_LinkedState& wire) noexcept {
  wire.peer = linked.state.peer;
  ToWire(linked.state, wire.state);
  Put(linked.links, wire.links);
}

std::optional<Drop> FromWire(const tandem_LinkedState& wire, LinkedState& linked) noexcept {
  if (wire.state.peer != wire.peer) return Drop::kWrongOwner;
  linked.links.from = wire.peer;
  if (const std::optional<Drop> fault = FromWire(wire.state, linked.state)) return fault;
  return Get(wire.links, linked.links);
}

void ToWire(const ViewFrame& frame, tandem_ViewFrame& wire) noexcept {
  wire = {};
  wire.peer = frame.peer;
  wire.seq = frame.seq;
  wire.sample_ns = frame.sample_ns;
  wire.delay_ms = frame.delay_ms;
  wire.mirror_lag_mm = frame.mirror_lag_mm;
  wire.link_force = frame.link_force;
  Put(frame.V_W.v, wire.v);
  Put(frame.V_W.w, wire.w);
  wire.count = std::min<std::uint32_t>(frame.count, kMaxViewBodies);
  for (std::size_t i = 0; i < wire.count; ++i) {
    const ViewBody& body = frame.bodies[i];
    wire.bodies[i].object = body.object;
    wire.bodies[i].flags = body.flags;
    Put(body.X_W.p, wire.bodies[i].p);
    Put(body.X_W.q, wire.bodies[i].q);
    Put(body.hand_force_W, wire.bodies[i].hand_force);
  }
}

std::optional<Drop> FromWire(const tandem_ViewFrame& wire, ViewFrame& frame) noexcept {
  if (wire.peer == 0) return Drop::kNoOwner;
  if (wire.count > kMaxViewBodies) return Drop::kBadCount;
  Reader reader;
  frame.peer = wire.peer;
  frame.seq = wire.seq;
  frame.sample_ns = wire.sample_ns;
  frame.delay_ms = wire.delay_ms;
  reader.GetNotNegative(static_cast<double>(wire.delay_ms), kWireBounds.delay_ms);
  frame.mirror_lag_mm = wire.mirror_lag_mm;
  reader.GetNotNegative(static_cast<double>(wire.mirror_lag_mm), 1e3 * kWireBounds.position);
  frame.link_force = wire.link_force;
  reader.GetNotNegative(static_cast<double>(wire.link_force), kWireBounds.force);
  frame.V_W.v = reader.Get(wire.v, kWireBounds.speed);
  frame.V_W.w = reader.Get(wire.w, kWireBounds.spin);
  frame.count = wire.count;
  for (std::size_t i = 0; i < wire.count; ++i) {
    ViewBody& body = frame.bodies[i];
    body.object = wire.bodies[i].object;
    body.flags = wire.bodies[i].flags;
    body.X_W.p = reader.Get(wire.bodies[i].p, kWireBounds.position);
    body.X_W.q = reader.Get(wire.bodies[i].q);  // single precision on the wire
    body.hand_force_W = reader.Get(wire.bodies[i].hand_force, kWireBounds.force);
  }
  return reader.fault();
}

void ToWire(const Event& event, tandem_Event& wire) noexcept {
  wire.peer = event.peer;
  wire.seq = event.seq;
  wire.kind = static_cast<tandem_EventKind>(event.kind);
  wire.object = event.object;
  wire.epoch = event.epoch;
  wire.to = event.to;
  Put(event.X_WB.p, wire.pose.p);
  Put(event.X_WB.q, wire.pose.q);
}

bool FromWire(const tandem_Event& wire, Event& event) noexcept {
  static_assert(static_cast<int>(EventKind::kTouch) == static_cast<int>(tandem_TOUCH));
  const auto kind = static_cast<std::uint32_t>(wire.kind);
  if (wire.peer == 0 || kind > static_cast<std::uint32_t>(tandem_TOUCH)) return false;
  event.peer = wire.peer;
  event.seq = wire.seq;
  event.kind = static_cast<EventKind>(kind);
  event.object = wire.object;
  event.epoch = wire.epoch;
  event.to = wire.to;
  return Get(wire.pose.p, event.X_WB.p) && Get(wire.pose.q, event.X_WB.q);
}

}  // namespace tandem
