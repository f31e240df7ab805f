#include "engine/geometry/formats/gltf/gltf_placing.h"

#include <cstddef>
#include <string>
#include <vector>

#include "engine/geometry/formats/gltf/gltf_numbers.h"

namespace tandem {

Mat3 TurnBy(double x, double y, double z, double w) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (!(q.norm() > 0)) return Mat3::Identity();
  return q.normalized().toRotationMatrix();
}

Result<Affine34> LocalPlacing(const JsonNode& node) {
  Affine34 X = Affine34::Identity();
  std::string fault;
  const auto array = [&](const char* key, std::size_t count) {
    std::vector<double> numbers;
    for (const JsonNode& number : ItemsOf(node, key)) numbers.push_back(number.Number());
    if (!numbers.empty() && numbers.size() != count) {
      fault = "a node's " + std::string(key) + " has " + std::to_string(numbers.size()) +
              " numbers in place of " + std::to_string(count);
      numbers.clear();
    }
    return numbers;
  };
  const std::vector<double> m = array("matrix", 16);
  const std::vector<double> r = array("rotation", 4);
  const std::vector<double> s = array("scale", 3);
  const std::vector<double> t = array("translation", 3);
  if (!fault.empty()) return Error{fault};
  if (!m.empty() && !(r.empty() && s.empty() && t.empty())) {
    return Error{
        "a node has a matrix and a translation, rotation or scale besides, of which the format "
        "allows one only: export it again"};
  }
  if (!m.empty()) {
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row) {
        X(row, column) = m[static_cast<std::size_t>(4 * column + row)];
      }
    }
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) {
      return Error{"a node's matrix has another last row than 0 0 0 1, which no placing has"};
    }
    return X;
  }
  if (!r.empty()) X.leftCols<3>() = TurnBy(r[0], r[1], r[2], r[3]);
  if (!s.empty()) X.leftCols<3>() = X.leftCols<3>() * Vec3(s[0], s[1], s[2]).asDiagonal();
  if (!t.empty()) X.col(3) = Vec3(t[0], t[1], t[2]);
  return X;
}

}  // namespace tandem
