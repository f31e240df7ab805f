#include "app/view/model/session/peer_table_model.h"

#include <QAbstractItemModelTester>
#include <QColor>

#include <gtest/gtest.h>

#include "collab/session/frame_limits.h"

namespace tandem {
namespace {

ViewedPeer Peer(PeerId id, const std::string& name, Role role, double delay_ms) {
  ViewedPeer peer;
  peer.info.peer = id;
  peer.info.name = name;
  peer.info.role = role;
  peer.delay_ms = delay_ms;
  return peer;
}

QString Text(const PeerTableModel& model, int row, int column) {
  return model.data(model.index(row, column), Qt::DisplayRole).toString();
}

class PeerTable : public ::testing::Test {
 protected:
  PeerTableModel model_;
  // checks the signals against the rows at every change, and fails fatally
  QAbstractItemModelTester tester_{&model_, QAbstractItemModelTester::FailureReportingMode::Fatal};
};

TEST_F(PeerTable, ShowsNameRolePresenceAndDelayWithItsUnit) {
  model_.Update({Peer(1, "Anna", Role::kActive, 104.4), Peer(2, "Cleo", Role::kViewer, 0)});
  ASSERT_EQ(model_.rowCount(), 2);
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kName), "Anna");
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kRole), "active");
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kPresence), "here");
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kDelay), "104 ms");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kRole), "viewer");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kDelay), "\u2013");
  EXPECT_TRUE(model_.data(model_.index(0, PeerTableModel::kName), Qt::DecorationRole).isValid());
}

TEST_F(PeerTable, ShowsLagForceAndTrappedPeers) {
  ViewedPeer anna = Peer(1, "Anna", Role::kActive, 20);
  anna.mirror_lag_mm = 12.34;
  anna.link_force = 2.96;
  anna.bodies = {{0, ViewBody::kHeld, {}, Vec3::Zero()}, {1, ViewBody::kTrapped, {}, Vec3::Zero()}};
  model_.Update({anna, Peer(2, "Ben", Role::kActive, 20)});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kPresence), "trapped");
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kLag), "12.3 mm");
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kForce), "3.0 N");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kPresence), "here");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kLag), "\u2013");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kForce), "\u2013");
  anna.presence = ViewedPeer::Presence::kLost;
  model_.Update({anna});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kPresence), "lost");
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kLag), "\u2013");
}

// The table tells what a mark means where the mouse rests on it.
TEST_F(PeerTable, ShowsAPeersFrameLimits) {
  ViewedPeer anna = Peer(1, "Anna", Role::kActive, 20);
  const FrameLimits limits{.travel_limited = 0.12, .over_capacity = 0, .contacts_full = 0.03};
  anna.bodies = {{0, ViewBody::kHeld | AsFlags(limits), {}, Vec3::Zero()}};
  model_.Update({anna, Peer(2, "Ben", Role::kActive, 20)});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kLimits), "slowed 12 %, contacts left out 3 %");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kLimits), "");
  const QString tip =
      model_.data(model_.index(0, PeerTableModel::kLimits), Qt::ToolTipRole).toString();
  EXPECT_TRUE(tip.contains("moved slower than it was pulled")) << tip.toStdString();
  EXPECT_TRUE(tip.contains("the rest did not push")) << tip.toStdString();
  EXPECT_FALSE(tip.contains("point tests"));
  anna.presence = ViewedPeer::Presence::kLeft;
  model_.Update({anna});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kLimits), "");
}

TEST_F(PeerTable, ShowsOtherProtocolsReplaysAndDepartedPeers) {
  ViewedPeer anna = Peer(1, "Anna", Role::kActive, 20);
  anna.info.protocol = kProtocol + 1;
  ViewedPeer ben = Peer(2, ReplayName("Ben"), Role::kActive, 20);
  ViewedPeer cleo = Peer(3, "Cleo", Role::kActive, 20);
  cleo.presence = ViewedPeer::Presence::kUnknown;
  model_.Update({anna, ben, cleo});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kPresence),
            QStringLiteral("protocol %1").arg(kProtocol + 1));
  EXPECT_TRUE(model_.data(model_.index(0, PeerTableModel::kPresence), Qt::ToolTipRole)
                  .toString()
                  .contains("update both to one version"));
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kRole), "replay");
  EXPECT_EQ(Text(model_, 2, PeerTableModel::kPresence), "you left");
  EXPECT_EQ(Text(model_, 2, PeerTableModel::kDelay), "\u2013");
}

TEST_F(PeerTable, ReturningPeerKeepsRowAndColour) {
  model_.Update({Peer(5, "E", Role::kActive, 0), Peer(7, "G", Role::kActive, 0)});
  const QPersistentModelIndex e = model_.index(0, 0);
  const QVariant colour = e.data(Qt::DecorationRole);
  ViewedPeer again = Peer(9, "E", Role::kActive, 0);
  again.first_id = 5;
  model_.Update({Peer(7, "G", Role::kActive, 0), again});
  ASSERT_EQ(model_.rowCount(), 2);
  ASSERT_TRUE(e.isValid());
  EXPECT_EQ(e.row(), 0);
  EXPECT_EQ(e.data(Qt::DecorationRole), colour);
}

// Each time that ben comes, his program has another id. He looked on before he took part.
TEST_F(PeerTable, PersonWhoComesAndGoesHasOneRow) {
  const ViewedPeer anna = Peer(1, "anna", Role::kActive, 0);
  std::vector<ViewedPeer> peers{anna, Peer(20, "ben", Role::kViewer, 0)};
  model_.Update(peers);
  const QPersistentModelIndex ben = model_.index(1, 0);
  const QVariant colour = ben.data(Qt::DecorationRole);
  for (PeerId id : {9, 40, 8}) {
    peers.back().presence = ViewedPeer::Presence::kLeft;
    peers.push_back(Peer(id, "ben", Role::kActive, 0));
    model_.Update(peers);
    ASSERT_EQ(model_.rowCount(), 2);
    ASSERT_TRUE(ben.isValid());
    EXPECT_EQ(ben.row(), 1);
    EXPECT_EQ(Text(model_, 1, PeerTableModel::kRole), "active");
    EXPECT_EQ(Text(model_, 1, PeerTableModel::kPresence), "here");
    EXPECT_EQ(ben.data(Qt::DecorationRole), colour);
  }
  peers.back().presence = ViewedPeer::Presence::kLost;
  peers.back().received_ns = 5;
  model_.Update(peers);
  ASSERT_EQ(model_.rowCount(), 2);
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kPresence), "lost");
}

TEST_F(PeerTable, NamesakesOfDifferentPersonsHaveRowsOfTheirOwn) {
  model_.Update({Peer(1, "anna", Role::kActive, 0), Peer(2, "anna (2)", Role::kActive, 0)});
  EXPECT_EQ(model_.rowCount(), 2);
}

TEST_F(PeerTable, ShowsWhoStopped) {
  ViewedPeer ben = Peer(2, "ben", Role::kActive, 0);
  ben.info.stopped = true;
  model_.Update({ben});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kPresence), "stopped");
  ben.info.stopped = false;
  model_.Update({ben});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kPresence), "here");
}

TEST_F(PeerTable, ShowsTheColourThatThePersonSays) {
  ViewedPeer ben = Peer(2, "ben", Role::kActive, 0);
  ben.info.colour = 3;
  model_.Update({ben});
  const auto colour = model_.index(0, 0).data(Qt::DecorationRole).value<QColor>();
  EXPECT_EQ(colour, QColor::fromRgbF(0.00F, 0.62F, 0.45F));
  EXPECT_TRUE(model_.index(0, 0).data(Qt::ToolTipRole).toString().contains("green"));
}

TEST_F(PeerTable, ExplainsEachColumn) {
  for (int column = 0; column < PeerTableModel::kColumnCount; ++column) {
    EXPECT_GT(model_.headerData(column, Qt::Horizontal, Qt::ToolTipRole).toString().size(), 20)
        << column;
  }
}

TEST_F(PeerTable, KeepsItsRowsInOrderWhilePeersComeAndGo) {
  model_.Update({Peer(5, "E", Role::kActive, 0)});
  const QPersistentModelIndex e = model_.index(0, 0);
  model_.Update({Peer(2, "B", Role::kActive, 0), Peer(5, "E", Role::kActive, 0),
                 Peer(9, "I", Role::kActive, 0)});
  ASSERT_EQ(model_.rowCount(), 3);
  EXPECT_EQ(e.row(), 1);
  model_.Update({Peer(5, "E", Role::kActive, 0), Peer(9, "I", Role::kActive, 0)});
  EXPECT_EQ(e.row(), 0);
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kName), "I");
  model_.Update({});
  EXPECT_EQ(model_.rowCount(), 0);
}

TEST_F(PeerTable, ReportsOnlyChangedRows) {
  std::vector<ViewedPeer> peers{Peer(1, "Anna", Role::kActive, 100),
                                Peer(2, "Ben", Role::kActive, 100)};
  model_.Update(peers);
  std::vector<int> changed;
  QObject::connect(&model_, &QAbstractItemModel::dataChanged,
                   [&](const QModelIndex& from, const QModelIndex&) {
                     changed.push_back(from.row());
                   });
  peers[0].delay_ms = 100.3;  // the same text
  model_.Update(peers);
  EXPECT_TRUE(changed.empty());
  peers[1].presence = ViewedPeer::Presence::kLost;
  model_.Update(peers);
  EXPECT_EQ(changed, std::vector<int>{1});
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kPresence), "lost");
  EXPECT_EQ(Text(model_, 1, PeerTableModel::kDelay), "\u2013");
}

TEST_F(PeerTable, UnnamedPeerIsShownByNumber) {
  model_.Update({Peer(0x12ab34, "", Role::kActive, 0)});
  EXPECT_EQ(Text(model_, 0, PeerTableModel::kName), "peer ab34");
}

}  // namespace
}  // namespace tandem
