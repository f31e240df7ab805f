#pragma once

#include <QPointF>
#include <QRectF>
#include <QSizeF>
#include <vector>

namespace tandem {

/// A label to place in the picture. Lengths are in logical pixels.
struct LabelRequest {
  QPointF anchor;  // point that its line leads to
  double top = 0;  // topmost pixel of the labelled body
  QSizeF size;
};

/// The place of a label. Its line leads from `foot`, on the box's edge, to the anchor.
struct LabelPlace {
  QRectF box;
  QPointF foot;
};

/// Places labels in the order given: above their bodies where there is room, else to the side,
/// below, or at the picture's edge. Labels stay in the picture and apart. No line crosses another
/// box, and no box covers an anchor. Where that is impossible, boxes only stay apart and in the
/// picture.
std::vector<LabelPlace> PlaceLabels(const std::vector<LabelRequest>& wishes, const QSizeF& picture);

}  // namespace tandem
