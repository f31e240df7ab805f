#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// An affine map: the columns of its linear part, then the place of the origin.
using Affine34 = Eigen::Matrix<double, 3, 4>;

/// Returns the map that does `b`, then `a`.
inline Affine34 ProductOf(const Affine34& a, const Affine34& b) {
  Affine34 product;
  product << a.leftCols<3>() * b.leftCols<3>(), a.leftCols<3>() * b.col(3) + a.col(3);
  return product;
}

/// Returns a point as a map places it.
inline Vec3 Placed(const Affine34& X, const Vec3& p) {
  return X.leftCols<3>() * p + X.col(3);
}

}  // namespace tandem
