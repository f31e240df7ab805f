#include "app/view/ui/keys_page.h"

#include <QObject>

namespace tandem {

QString KeysPage(bool with_hand) {
  QString page = QObject::tr(
      "<table cellspacing=4>"
      "<tr><td>Left drag</td><td>orbit</td></tr>"
      "<tr><td>Middle drag, Shift+left drag</td><td>pan</td></tr>"
      "<tr><td>Wheel</td><td>zoom at the cursor</td></tr>"
      "<tr><td>Home, F</td><td>fit the scene</td></tr>"
      "<tr><td>K</td><td>keep bodies in the picture (ended by pan and zoom)</td></tr>"
      "<tr><td>1, 3, 7, 9</td><td>front, right, top, oblique</td></tr>"
      "<tr><td>P</td><td>proximity: colours by distance, near voxels, least distance</td></tr>"
      "<tr><td>Ctrl+O</td><td>open a scene</td></tr>"
      "<tr><td>F12</td><td>save a picture</td></tr>"
      "<tr><td>F1</td><td>this page</td></tr>");
  if (with_hand) {
    page += QObject::tr(
        "<tr><td colspan=2><b>Your hand</b></td></tr><tr><td>Left drag on a part</td><td>take it "
        "and move it in the plane of the picture</td></tr><tr><td>Wheel, button held</td><td>move "
        "it farther or nearer</td></tr><tr><td>Ctrl+left drag on a part</td><td>rotate it about "
        "the grabbed point; wheel: roll</td></tr><tr><td>Shift held</td><td>a tenth as "
        "far</td></tr><tr><td>Alt+left drag on a part</td><td>orbit</td></tr><tr><td>X, Y, "
        "Z</td><td>move along this axis only; again: along the part\u2019s own axis; again: "
        "freely; with Shift: in the plane across it</td></tr><tr><td>Arrows, Page Up and "
        "Down</td><td>move by a voxel; with Ctrl rotate by a degree; with Shift a "
        "tenth</td></tr><tr><td>T</td><td>handles: arrows and squares move, rings "
        "rotate</td></tr><tr><td>G, L</td><td>grab the part under the cursor, let "
        "go</td></tr><tr><td>H, A</td><td>hand over, ask for</td></tr><tr><td>Escape</td><td>move "
        "the part back to where you took it</td></tr><tr><td>Ctrl+Z, Ctrl+Shift+R</td><td>undo, "
        "reset</td></tr><tr><td>C</td><td>with a device: its handle moves alone, or moves the part "
        "again</td></tr><tr><td>Space, Ctrl+Space</td><td>emergency stop, "
        "resume</td></tr><tr><td>Ctrl+J, Ctrl+I</td><td>join a session, invite to it</td></tr>");
  }
  return page + QStringLiteral("</table>");
}

}  // namespace tandem
