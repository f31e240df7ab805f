#pragma once

#include <QPainter>

#include "app/view/model/camera_model.h"
#include "app/view/model/hand_picture.h"

namespace tandem {

/// Paints over the picture the tether with its force (unless `hand` is without figures), the
/// contacts, the locked axis and the triad.
void PaintHand(QPainter& painter, const CameraModel& camera, const HandPicture& hand);

}  // namespace tandem
