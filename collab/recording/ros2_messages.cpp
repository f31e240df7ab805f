#include "collab/recording/ros2_messages.h"

#include <cstring>

#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr const char* kFrame = "world";

const std::string kStamped =
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
const std::string kTime = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const std::string kVector3 = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
const std::string kRule = std::string(80, '=') + "\n";

/// Common Data Representation (OMG): numbers at multiples of their size, counted after the four
/// bytes of its header.
class Cdr {
 public:
  template <typename T>
  Cdr& Number(T value) {
    const std::size_t gap = (bytes_.size() - kHead) % sizeof value;
    const std::size_t at = bytes_.size() + (gap == 0 ? 0 : sizeof value - gap);
    bytes_.resize(at + sizeof value);
    std::memcpy(&bytes_[at], &value, sizeof value);
    return *this;
  }
  Cdr& Text(const std::string& text) {
    Number(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
    return *this;
  }
  Cdr& Header(std::int64_t time_ns) {
    return Number(static_cast<std::int32_t>(time_ns / kSecondNs))
        .Number(static_cast<std::uint32_t>(time_ns % kSecondNs))
        .Text(kFrame);
  }
  Cdr& Vector(const Vec3& v) { return Number(v.x()).Number(v.y()).Number(v.z()); }
  const Bytes& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHead = 4;
  Bytes bytes_{0, 1, 0, 0};  // CDR, little-endian
};

}  // namespace

Ros2Type PoseStampedType() {
  return {"geometry_msgs/msg/PoseStamped",
          "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + kRule + kStamped + kRule +
              "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\n"
              "geometry_msgs/Quaternion orientation\n" +
              kRule + "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" + kRule +
              "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n" +
              kRule + kTime};
}

Ros2Type TwistStampedType() {
  return {"geometry_msgs/msg/TwistStamped",
          "std_msgs/Header header\ngeometry_msgs/Twist twist\n" + kRule + kStamped + kRule +
              "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\n"
              "geometry_msgs/Vector3 angular\n" +
              kRule + kVector3 + kRule + kTime};
}

Ros2Type WrenchStampedType() {
  return {"geometry_msgs/msg/WrenchStamped",
          "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n" + kRule + kStamped + kRule +
              "MSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\n"
              "geometry_msgs/Vector3 torque\n" +
              kRule + kVector3 + kRule + kTime};
}

Ros2Type Float64Type() {
  return {"std_msgs/msg/Float64", "float64 data\n"};
}

Ros2Type StringType() {
  return {"std_msgs/msg/String", "string data\n"};
}

Bytes PoseStamped(std::int64_t time_ns, const Pose& X_WB) {
  const Quat& q = X_WB.q;
  return Cdr().Header(time_ns).Vector(X_WB.p).Vector(q.vec()).Number(q.w()).bytes();
}

Bytes TwistStamped(std::int64_t time_ns, const Twist& V_WB) {
  return Cdr().Header(time_ns).Vector(V_WB.v).Vector(V_WB.w).bytes();
}

Bytes WrenchStamped(std::int64_t time_ns, const Wrench& F_B_W) {
  return Cdr().Header(time_ns).Vector(F_B_W.f).Vector(F_B_W.tau).bytes();
}

Bytes Float64(double value) {
  return Cdr().Number(value).bytes();
}

Bytes String(const std::string& text) {
  return Cdr().Text(text).bytes();
}

}  // namespace tandem
