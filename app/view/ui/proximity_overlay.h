#pragma once

#include <QPainter>
#include <QSize>

#include "app/view/model/camera_model.h"
#include "app/view/model/proximity_picture.h"

namespace tandem {

/// The least distance as a line between its two points with its value and error beside it, seen
/// through whatever is in front, and that of the part in hand where that is another; what the
/// colours mean in the lower right corner.
void PaintProximity(QPainter& painter, const QSize& size, const CameraModel& camera,
                    const ProximityPicture& picture);

}  // namespace tandem
