#include "app/view/model/scene/label_layout.h"

#include <QLineF>
#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

constexpr double kRise = 34;       // px from a body to its label
constexpr double kGap = 4;         // distance between boxes
constexpr double kRim = 8;         // margin of the picture
constexpr double kAnchorRoom = 6;  // room round an anchor's dot
constexpr double kCorner = 8;      // corner of a box, where no line begins

bool Crosses(const QRectF& box, const QLineF& line) {
  if (box.contains(line.p1()) || box.contains(line.p2())) return true;
  const QLineF sides[] = {{box.topLeft(), box.topRight()},
                          {box.topRight(), box.bottomRight()},
                          {box.bottomRight(), box.bottomLeft()},
                          {box.bottomLeft(), box.topLeft()}};
  return std::any_of(std::begin(sides), std::end(sides), [&](const QLineF& side) {
    return side.intersects(line) == QLineF::BoundedIntersection;
  });
}

LabelPlace At(QRectF box, const QPointF& anchor, const QSizeF& picture) {
  const auto within = [](double at, double size, double room) {
    return std::clamp(at, kRim, std::max(kRim, room - size - kRim));
  };
  box.moveLeft(within(box.left(), box.width(), picture.width()));
  box.moveTop(within(box.top(), box.height(), picture.height()));
  // the nearest point of the box's edge, off its rounded corners
  QPointF foot(std::clamp(anchor.x(), box.left() + kCorner, box.right() - kCorner),
               anchor.y() < box.top() ? box.top() : box.bottom());
  const bool beside = anchor.y() >= box.top() && anchor.y() <= box.bottom();
  if (beside) {
    foot = {anchor.x() < box.left() ? box.left() : box.right(), box.center().y()};
  }
  return {box, foot};
}

/// Returns the places to try, the best first.
std::vector<QRectF> Candidates(const LabelRequest& wish) {
  const double width = wish.size.width();
  const double height = wish.size.height();
  const double step = height + kGap;
  const QRectF above(wish.anchor.x() - width / 2, wish.top - kRise - height, width, height);
  std::vector<QRectF> boxes{above};
  for (int ring = 0; ring < 6; ++ring) {
    const double x = (0.5 + 0.5 * ring) * (width + kGap) + kAnchorRoom;
    // right and left at the same height, then above and below it; then under the body
    for (const double y : {0.0, -step, step, -2 * step, 2 * step, 3 * step}) {
      boxes.push_back(above.translated(x, y));
      boxes.push_back(above.translated(-x, y));
    }
    boxes.push_back(above.translated(0, -(1 + ring) * step));
    const double below = wish.anchor.y() + kRise + ring * step;
    boxes.emplace_back(above.left(), below, width, height);
    boxes.emplace_back(above.left() + x, below, width, height);
    boxes.emplace_back(above.left() - x, below, width, height);
  }
  return boxes;
}

}  // namespace

std::vector<LabelPlace> PlaceLabels(const std::vector<LabelRequest>& wishes,
                                    const QSizeF& picture) {
  std::vector<LabelPlace> placed;
  const auto off_boxes = [&](const LabelPlace& place) {
    const QRectF room = place.box.adjusted(-kGap, -kGap, kGap, kGap);
    return std::none_of(placed.begin(), placed.end(), [&](const LabelPlace& other) {
      return other.box.intersects(room);
    });
  };
  const auto off_all = [&](const LabelPlace& place, const QPointF& anchor) {
    const QRectF room = place.box.adjusted(-kAnchorRoom, -kAnchorRoom, kAnchorRoom, kAnchorRoom);
    const bool on_anchor = std::any_of(wishes.begin(), wishes.end(), [&](const LabelRequest& wish) {
      return room.contains(wish.anchor);
    });
    if (on_anchor) return false;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      if (Crosses(placed[i].box, {place.foot, anchor})) return false;
      if (Crosses(place.box, {placed[i].foot, wishes[i].anchor})) return false;
    }
    return true;
  };
  for (const LabelRequest& wish : wishes) {
    const std::vector<QRectF> boxes = Candidates(wish);
    const LabelPlace* second_best = nullptr;
    std::vector<LabelPlace> tried;
    tried.reserve(boxes.size());
    const LabelPlace* best = nullptr;
    for (const QRectF& box : boxes) {
      const LabelPlace& place = tried.emplace_back(At(box, wish.anchor, picture));
      if (!off_boxes(place)) continue;
      if (second_best == nullptr) second_best = &place;
      if (!off_all(place, wish.anchor)) continue;
      best = &place;
      break;
    }
    if (best == nullptr) best = second_best != nullptr ? second_best : &tried.front();
    placed.push_back(*best);
  }
  return placed;
}

}  // namespace tandem
