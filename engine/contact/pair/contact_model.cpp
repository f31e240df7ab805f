#include "engine/contact/pair/contact_model.h"

#include "engine/contact/pair/tangent_plane.h"

namespace tandem {

std::size_t FindPlainContacts(std::span<const Candidate> candidates, const Voxmap& voxmap,
                              double layers, Contact* out) noexcept {
  const double s = voxmap.voxel_size();
  std::size_t count = 0;
  for (const Candidate& c : candidates) {
    const Vec3 centre = s * (Vec3(c.voxel_V.x, c.voxel_V.y, c.voxel_V.z) + Vec3::Constant(0.5));
    const double depth = TangentPlaneDepth(c.p_V, centre, c.nhat_V, c.mark, layers, s);
    if (depth > 0) out[count++] = {c.p_V, c.nhat_V, depth};
  }
  return count;
}

}  // namespace tandem
