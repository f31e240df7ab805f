#pragma once

#include <QAbstractTableModel>
#include <map>
#include <string>
#include <vector>

#include "app/view/model/scene/peer_palette.h"
#include "collab/session/viewer.h"

namespace tandem {

/// The peers of a session as a table: name with colour, role, presence, delay, lag of the mirrors,
/// force of the couplings, and what the frames gave up. A header's tooltip explains its column.
/// A person has one row: a program that is gone gives it up to another of the same name, and who
/// looks on and takes part at once is shown as active. Rows have lasting ids, so that a selection
/// survives while peers come and go.
class PeerTableModel : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { kName, kRole, kPresence, kDelay, kLag, kForce, kLimits, kColumnCount };

  using QAbstractTableModel::QAbstractTableModel;

  /// Updates the rows, and notifies the views of differences alone.
  void Update(const std::vector<ViewedPeer>& peers);

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override;
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  struct Row {
    PeerId peer = 0;
    QString name, role, presence, delay, lag, force, limits, limits_mean;
    QString remark;       // remark on the presence
    QString colour_name;  // its colour in a word
    Colour colour{};
    bool here = true;
    bool operator==(const Row& other) const = default;
  };
  const QString& Text(const Row& row, int column) const;

  /// Returns the peers to show, one for each person.
  std::vector<const ViewedPeer*> Persons(const std::vector<ViewedPeer>& peers) const;
  /// Returns the id of a person's row.
  PeerId RowOf(const ViewedPeer& peer);

  std::vector<Row> rows_;
  std::map<std::string, PeerId> rows_of_names_;
};

}  // namespace tandem
