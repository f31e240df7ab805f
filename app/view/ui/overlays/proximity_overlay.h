#pragma once

#include <QPainter>
#include <QSize>

#include "app/view/model/proximity/proximity_picture.h"
#include "app/view/model/scene/camera_model.h"

namespace tandem {

/// Paints the least distance as a line between its two points, with value and error beside it,
/// visible through bodies in front. Paints the distance of the part in hand too, where it is
/// another. The lower right corner explains the colours.
void PaintProximity(QPainter& painter, const QSize& size, const CameraModel& camera,
                    const ProximityPicture& picture);

}  // namespace tandem
