// Interpolated values and gradients of many places.
#include <array>

#include "engine/field/query/distance_field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/query/field_gradients.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/field/query/field_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

/// The values at the corners of cells, x fastest.
using Cubes = std::array<FieldLanes::Lanes<float>, 8>;
using Square = std::array<Floats, 4>;  // per corner, the first of two axes fastest

template <std::size_t kAxis>
HWY_INLINE auto& Along(auto& axes) {
  if constexpr (kAxis == 0) return axes.x;
  if constexpr (kAxis == 1) return axes.y;
  if constexpr (kAxis == 2) return axes.z;
}

HWY_INLINE Floats OnSquare(const Square& values, Floats along, Floats across) {
  return Lerp(Lerp(values[0], values[1], along), Lerp(values[2], values[3], along), across);
}

/// The node beyond a cell along an axis, on the side that a place is nearer to.
template <std::size_t kAxis>
struct NodeBeyond {
  NodeBeyond(const FieldLanes& lanes, std::size_t at)
      : from(FromCell(lanes, at)), in_brick(InBricks(lanes, at)) {
    const F f;
    const I i;
    upper = hn::Ge(Along<kAxis>(from), hn::Set(f, 0.5F));
    offset = hn::IfThenElse(hn::RebindMask(i, upper), hn::Set(i, 2), hn::Set(i, -1));
    Ints& along = Along<kAxis>(in_brick);
    const Ints node = hn::Add(along, offset);
    elsewhere = hn::Or(hn::Lt(node, hn::Zero(i)), hn::Gt(node, hn::Set(i, kBrickCells)));
    along = hn::IfThenElse(elsewhere, hn::And(node, hn::Set(i, 3)), node);
  }
  Lanes3 from;
  IntLanes3 in_brick;  // its place, from the row of the cell's lowest node
  hn::Mask<F> upper;
  Ints offset;            // offset from the cell
  hn::Mask<I> elsewhere;  // it is in another brick than the cell
};

/// Returns the rows of nodes that a cell has across an axis: the places of their first nodes.
template <std::size_t kAxis>
constexpr std::array<int, 4> RowsAcross() {
  if constexpr (kAxis == 0) return {0, 5, 25, 30};
  if constexpr (kAxis == 1) return {0, 25, 0, 0};
  return {0, 5, 0, 0};
}
template <std::size_t kAxis>
constexpr std::size_t kRows = kAxis == 0 ? 4 : 2;

template <std::size_t kAxis>
HWY_INLINE void FindBeyond(const FieldView& field, const FieldLanes& lanes, std::size_t at,
                           FieldLanes& beyond) {
  const NodeBeyond<kAxis> node(lanes, at);
  IntLanes3 cell = CellsAt(lanes, at);
  Ints& along = Along<kAxis>(cell);
  along = hn::IfThenElse(node.elsewhere, hn::Add(along, node.offset), along);
  StoreTablePlaces(field, cell, at, beyond);
}

template <std::size_t kAxis>
HWY_INLINE void UnpackBeyond(const FieldLanes& lanes, std::size_t at, FieldLanes& beyond) {
  const I i;
  const NodeBeyond<kAxis> node(lanes, at);
  const Bricks brick = LoadBricks(beyond, at);
  const Ints first = hn::Mul(NodeOf(node.in_brick), brick.bits);
  for (std::size_t row = 0; row < kRows<kAxis>; ++row) {
    const Ints bit = hn::Add(first, hn::Mul(brick.bits, hn::Set(i, RowsAcross<kAxis>()[row])));
    hn::StoreU(hn::Add(brick.steps, hn::ShiftRight<3>(bit)), i, &beyond.byte[row][at]);
  }
}

/// Returns the values at the nodes beyond the four corners of a cell across an axis, in a Square of
/// the two axes after it.
template <std::size_t kAxis>
HWY_INLINE Square ValuesBeyond(const NodeBeyond<kAxis>& node, const FieldLanes& beyond,
                               std::size_t at) {
  const F f;
  const I i;
  const Bricks brick = LoadBricks(beyond, at);
  const Floats step = StepOf(brick.bits, brick.flags);
  const Floats along_x = hn::Mul(hn::Set(f, FieldBrick::kSlope), hn::ConvertTo(f, brick.slopes.x));
  const Lanes3 first = ToFloats(node.in_brick);
  const Floats one = hn::Set(f, 1.0F);
  const Ints first_bit = hn::Mul(NodeOf(node.in_brick), brick.bits);
  std::array<Floats, 4> low;
  std::array<Floats, 4> high;
  for (std::size_t row = 0; row < kRows<kAxis>; ++row) {
    const int nodes = RowsAcross<kAxis>()[row];
    const Lanes3 place{first.x, nodes % 25 != 0 ? hn::Add(first.y, one) : first.y,
                       nodes >= 25 ? hn::Add(first.z, one) : first.z};
    const Floats plane = PlaneAt(brick, place);
    const Ints bit = hn::Add(first_bit, hn::Mul(brick.bits, hn::Set(i, nodes)));
    const RowSteps steps = StepsOfRow(brick.bits, bit, hn::LoadU(i, &beyond.word[row][at]));
    low[row] = hn::Add(plane, hn::Mul(step, steps.low));
    high[row] = hn::Add(hn::Add(plane, along_x), hn::Mul(step, steps.high));
  }
  if constexpr (kAxis == 0) return low;
  if constexpr (kAxis == 1) return {low[0], low[1], high[0], high[1]};
  return {low[0], high[0], low[1], high[1]};
}

/// Returns the gradient along an axis. Each of the cell's four lines along the axis has slopes; the
/// place lies between the middles of two.
template <std::size_t kAxis>
HWY_INLINE Floats GradientAlong(const Cubes& nodes, const FieldLanes& lanes,
                                const FieldLanes& beyond, std::size_t at) {
  const F f;
  const I i;
  constexpr std::size_t kU = (kAxis + 1) % 3;
  constexpr std::size_t kV = (kAxis + 2) % 3;
  const NodeBeyond<kAxis> node(lanes, at);
  const Square values = ValuesBeyond<kAxis>(node, beyond, at);
  const auto has_brick = hn::RebindMask(f, hn::Gt(hn::LoadU(i, &beyond.entry[at]), hn::Set(i, -1)));
  const Floats from = Along<kAxis>(node.from);
  const Floats half = hn::Set(f, 0.5F);
  // share of the slope beyond
  const Floats share = hn::IfThenElse(node.upper, hn::Sub(from, half), hn::Sub(half, from));
  Square slopes;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const std::size_t lower = (corner & 1) << kU | (corner >> 1) << kV;
    const std::size_t upper = lower | std::size_t{1} << kAxis;
    const Floats low = hn::LoadU(f, &nodes[lower][at]);
    const Floats high = hn::LoadU(f, &nodes[upper][at]);
    const Floats own = hn::Sub(high, low);
    const Floats to =
        hn::IfThenElse(node.upper, hn::Sub(values[corner], high), hn::Sub(low, values[corner]));
    // one side of the outermost node is enough where the band ends
    slopes[corner] = Lerp(own, hn::IfThenElse(has_brick, to, own), share);
  }
  return OnSquare(slopes, Along<kU>(node.from), Along<kV>(node.from));
}

template <std::size_t kAxis>
HWY_INLINE void TellGradients(const FieldView& field, std::size_t count, const Cubes& nodes,
                              const FieldLanes& lanes, FieldLanes& beyond, float* gradients) {
  const F f;
  for (std::size_t at = 0; at < count; at += kWidth) FindBeyond<kAxis>(field, lanes, at, beyond);
  ReadBricks(field, count, beyond);
  beyond.near.fill(true);
  for (std::size_t at = 0; at < count; at += kWidth) UnpackBeyond<kAxis>(lanes, at, beyond);
  ReadWords(field, count, kRows<kAxis>, beyond);
  for (std::size_t at = 0; at < count; at += kWidth) {
    hn::StoreU(GradientAlong<kAxis>(nodes, lanes, beyond, at), f, gradients + at);
  }
}

void LookUpGradients(const FieldView& field, std::size_t count, FieldLanes& lanes,
                     FieldGradients& gradients) {
  const F f;
  for (std::size_t at = 0; at < count; at += kWidth) {
    StoreTablePlaces(field, CellsAt(lanes, at), at, lanes);
  }
  ReadBricks(field, count, lanes);
  lanes.near.fill(true);
  for (std::size_t at = 0; at < count; at += kWidth) Unpack(at, lanes);
  ReadWords(field, count, FieldLanes::kWords, lanes);
  Cubes nodes;
  for (std::size_t at = 0; at < count; at += kWidth) {
    const std::array<Floats, 8> corners =
        NodesOf(lanes, LoadBricks(lanes, at), InBricks(lanes, at), at);
    for (std::size_t corner = 0; corner < 8; ++corner) {
      hn::StoreU(corners[corner], f, &nodes[corner][at]);
    }
    const Lanes3 from = FromCell(lanes, at);
    const Floats low = OnSquare({corners[0], corners[1], corners[2], corners[3]}, from.x, from.y);
    const Floats high = OnSquare({corners[4], corners[5], corners[6], corners[7]}, from.x, from.y);
    hn::StoreU(Lerp(low, high, from.z), f, &lanes.value[at]);
  }
  FieldLanes beyond;
  TellGradients<0>(field, count, nodes, lanes, beyond, gradients[0].data());
  TellGradients<1>(field, count, nodes, lanes, beyond, gradients[1].data());
  TellGradients<2>(field, count, nodes, lanes, beyond, gradients[2].data());
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

namespace {
HWY_EXPORT(LookUpGradients);
}  // namespace

void DistanceField::InterpolateGradients(std::size_t count, FieldLanes& lanes,
                                         FieldGradients& gradients) const noexcept {
  HWY_DYNAMIC_DISPATCH(LookUpGradients)(View(), count, lanes, gradients);
}

}  // namespace tandem
#endif
