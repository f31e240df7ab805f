#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

/// FCL behind an interface without Eigen (see CMakeLists.txt).
class __attribute__((visibility("default"))) FclPair {
 public:
  struct Mesh {
    std::vector<std::array<double, 3>> vertices;  // m
    std::vector<std::array<std::uint32_t, 3>> triangles;
  };
  /// The moving mesh's frame in the fixed one's.
  struct Placed {
    std::array<double, 4> q_wxyz;
    std::array<double, 3> p;  // m
  };

  FclPair(const Mesh& fixed, const Mesh& moving);
  ~FclPair();

  /// Returns how many contacts there are. FCL finds each with its place and normal.
  std::size_t Contacts(const Placed& at) const;
  bool Touch(const Placed& at) const;
  /// Returns the distance, m; 0 or less when they touch.
  double Distance(const Placed& at) const;

 private:
  struct Models;
  std::unique_ptr<Models> models_;
};
