#pragma once

#include <QPainter>

#include "app/view/model/hand/hand_picture.h"
#include "app/view/model/scene/camera_model.h"

namespace tandem {

/// Paints over the picture the tether with its force (unless `hand` is without figures), the
/// contacts, the locked axis and the triad.
void PaintHand(QPainter& painter, const CameraModel& camera, const HandPicture& hand);

}  // namespace tandem
