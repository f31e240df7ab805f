#pragma once

#include <QPointF>
#include <QRectF>
#include <QSizeF>
#include <vector>

namespace tandem {

/// A label to be placed in the picture; px, logical.
struct LabelWish {
  QPointF anchor;  // what its line leads to
  double top = 0;  // the highest pixel of what it names
  QSizeF size;
};

/// Where a label stands. Its line leads from `foot`, on the box's rim, to the anchor.
struct LabelPlace {
  QRectF box;
  QPointF foot;
};

/// Places labels in the order given, above what they name where there is room, else to the side,
/// below or at the picture's rim: within the picture, off one another, no line through another's
/// box and no anchor under any. Where no place is left that keeps all of it, boxes keep off one
/// another and out of the picture's rim.
std::vector<LabelPlace> PlaceLabels(const std::vector<LabelWish>& wishes, const QSizeF& picture);

}  // namespace tandem
