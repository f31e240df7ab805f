#pragma once

#include <cstdint>
#include <string>

#include "collab/recording/mcap_writer.h"
#include "engine/base/spatial.h"

namespace tandem {

/// A message type of ROS 2's common interfaces: its name, and its definition with all types in it
/// (MCAP's schema encoding "ros2msg"). Messages are in CDR, little-endian.
struct Ros2Type {
  const char* name;
  std::string definition;
};

Ros2Type PoseStampedType();    // geometry_msgs/msg/PoseStamped
Ros2Type TwistStampedType();   // geometry_msgs/msg/TwistStamped
Ros2Type WrenchStampedType();  // geometry_msgs/msg/WrenchStamped
Ros2Type Float64Type();        // std_msgs/msg/Float64
Ros2Type StringType();         // std_msgs/msg/String

/// Return messages in the world's frame, which is called "world".
Bytes PoseStamped(std::int64_t time_ns, const Pose& X_WB);
Bytes TwistStamped(std::int64_t time_ns, const Twist& V_WB);
Bytes WrenchStamped(std::int64_t time_ns, const Wrench& F_B_W);
Bytes Float64(double value);
Bytes String(const std::string& text);

}  // namespace tandem
