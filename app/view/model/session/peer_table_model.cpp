#include "app/view/model/session/peer_table_model.h"

#include <QColor>
#include <algorithm>

#include "app/view/model/scene/picture_composer.h"
#include "app/view/model/session/plain_tool_tip.h"
#include "app/view/model/words/window_words.h"
#include "collab/session/frame_limits.h"

namespace tandem {

namespace {

constexpr std::size_t kMostNames = 256;  // names whose rows are kept in mind

/// Returns whether a person's row shows `a` rather than `b`.
bool ShownBefore(const ViewedPeer& a, const ViewedPeer& b) {
  using Presence = ViewedPeer::Presence;
  const auto rank = [](const ViewedPeer& peer) {
    return (peer.presence == Presence::kHere ? 2 : 0) + (peer.info.role == Role::kActive ? 1 : 0);
  };
  if (a.presence != Presence::kHere && b.presence != Presence::kHere) {
    return a.received_ns > b.received_ns;
  }
  return rank(a) > rank(b);
}

}  // namespace

std::vector<const ViewedPeer*> PeerTableModel::Persons(const std::vector<ViewedPeer>& peers) const {
  std::vector<const ViewedPeer*> persons;
  std::map<std::string, std::size_t> places;
  for (const ViewedPeer& peer : peers) {
    if (peer.info.name.empty()) {
      persons.push_back(&peer);
      continue;
    }
    const auto [place, is_new] = places.try_emplace(peer.info.name, persons.size());
    if (is_new) {
      persons.push_back(&peer);
    } else if (ShownBefore(peer, *persons[place->second])) {
      persons[place->second] = &peer;
    }
  }
  return persons;
}

PeerId PeerTableModel::RowOf(const ViewedPeer& peer) {
  if (peer.info.name.empty()) return LastingId(peer);
  if (rows_of_names_.size() >= kMostNames) rows_of_names_.clear();
  const PeerId row = rows_of_names_.try_emplace(peer.info.name, LastingId(peer)).first->second;
  return row;
}

void PeerTableModel::Update(const std::vector<ViewedPeer>& peers) {
  std::vector<Row> rows;
  for (const ViewedPeer* person : Persons(peers)) {
    const ViewedPeer& peer = *person;
    Row row;
    row.peer = RowOf(peer);
    row.name = QString::fromStdString(DisplayName(peer));
    row.role = IsReplay(peer.info)               ? tr("replay")
               : peer.info.role == Role::kActive ? tr("active")
                                                 : tr("viewer");
    row.here = peer.presence == ViewedPeer::Presence::kHere;
    const bool other_protocol = peer.info.protocol != kProtocol;
    using Presence = ViewedPeer::Presence;
    row.presence = row.here && other_protocol         ? tr("protocol %1").arg(peer.info.protocol)
                   : row.here && peer.info.stopped    ? tr("stopped")
                   : row.here && IsTrapped(peer)      ? tr("trapped")
                   : row.here                         ? tr("here")
                   : peer.presence == Presence::kLost ? tr("lost")
                   : peer.presence == Presence::kLeft ? tr("left")
                                                      : tr("you left");
    row.remark = row.here && other_protocol ? row.name + QLatin1Char(' ') +
                                                  QString::fromStdString(OtherProtocol(peer.info))
                 : row.here && peer.info.stopped
                     ? tr("pressed the emergency stop: its hand holds and takes nothing")
                 : row.here && IsTrapped(peer) ? tr("something fixed stands between its copy of a "
                                                    "part and another user\u2019s copy")
                 : row.here                    ? tr("heard within the last two seconds")
                 : peer.presence == Presence::kLost ? tr("fell silent without a goodbye")
                 : peer.presence == Presence::kLeft ? tr("said goodbye")
                                                    : tr("was here when you left");
    const auto number = [&row](double value, int decimals, const QString& text) {
      return row.here && value > 0 ? text.arg(value, 0, 'f', decimals) : QStringLiteral("\u2013");
    };
    row.delay = number(peer.delay_ms, 0, tr("%1 ms"));
    row.lag = number(peer.mirror_lag_mm, 1, tr("%1 mm"));
    row.force = number(peer.link_force, 1, tr("%1 N"));
    const FrameLimits limits = row.here ? LimitsOf(peer.bodies) : FrameLimits{};
    row.limits = QString::fromStdString(AsText(limits));
    for (const std::string& line : Explain(limits)) {
      row.limits_mean +=
          (row.limits_mean.isEmpty() ? "" : "\n") + WordsForWindow(QString::fromStdString(line));
    }
    row.colour = ColourOfPerson(peer.info);
    row.colour_name = tr(NameOfColour(ColourOf(peer.info)));
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    return a.peer < b.peer;
  });

  // first the rows that went, then those that came, then those that changed
  for (std::size_t i = rows_.size(); i-- > 0;) {
    const bool stays = std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
      return row.peer == rows_[i].peer;
    });
    if (stays) continue;
    beginRemoveRows({}, static_cast<int>(i), static_cast<int>(i));
    rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(i));
    endRemoveRows();
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const int at = static_cast<int>(i);
    if (i == rows_.size() || rows_[i].peer != rows[i].peer) {
      beginInsertRows({}, at, at);
      rows_.insert(rows_.begin() + at, rows[i]);
      endInsertRows();
    } else if (!(rows_[i] == rows[i])) {
      rows_[i] = rows[i];
      Q_EMIT dataChanged(index(at, 0), index(at, kColumnCount - 1));
    }
  }
}

int PeerTableModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(rows_.size());
}

int PeerTableModel::columnCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(kColumnCount);
}

const QString& PeerTableModel::Text(const Row& row, int column) const {
  switch (column) {
    case kRole:
      return row.role;
    case kPresence:
      return row.presence;
    case kDelay:
      return row.delay;
    case kLag:
      return row.lag;
    case kForce:
      return row.force;
    case kLimits:
      return row.limits;
    default:
      return row.name;
  }
}

QVariant PeerTableModel::data(const QModelIndex& index, int role) const {
  if (!checkIndex(index, CheckIndexOption::IndexIsValid)) return {};
  const Row& row = rows_[static_cast<std::size_t>(index.row())];
  switch (role) {
    case Qt::ToolTipRole:
      if (index.column() == kLimits) return row.limits_mean;
      if (index.column() == kName) return PlainToolTip(row.name + ": " + row.colour_name);
      return PlainToolTip(index.column() == kPresence ? row.remark : Text(row, index.column()));
    case Qt::DisplayRole:
      return Text(row, index.column());
    case Qt::DecorationRole:
      if (index.column() != kName) return {};
      return QColor::fromRgbF(row.colour[0], row.colour[1], row.colour[2]);
    case Qt::TextAlignmentRole:
      return QVariant::fromValue(Qt::Alignment(
          Qt::AlignVCenter |
          (index.column() >= kDelay && index.column() <= kForce ? Qt::AlignRight : Qt::AlignLeft)));
    case Qt::ForegroundRole:
      return row.here ? QVariant() : QVariant(QColor(Qt::gray));
    default:
      return {};
  }
}

namespace {

/// Returns a column's explanation for its tooltip.
QString Explanation(int section) {
  switch (section) {
    case PeerTableModel::kName:
      return PeerTableModel::tr("its name, and its colour in the picture");
    case PeerTableModel::kRole:
      return PeerTableModel::tr("active: takes part; viewer: looks on; replay: shows a recording");
    case PeerTableModel::kPresence:
      return PeerTableModel::tr("here, stopped, left, or silent without a goodbye (lost)");
    case PeerTableModel::kDelay:
      return PeerTableModel::tr(
          "half the time that its messages take to the farthest partner and back; \u2013: no "
          "partner");
    case PeerTableModel::kLag:
      return PeerTableModel::tr(
          "largest distance of others\u2019 parts, as this peer shows them, from where it was "
          "told that they are; \u2013: none");
    case PeerTableModel::kForce:
      return PeerTableModel::tr(
          "largest pull of others\u2019 hands on its body; \u2013: nobody else holds it");
    case PeerTableModel::kLimits:
      return PeerTableModel::tr("share of frames in which its simulation hit a limit; empty: none");
    default:
      return {};
  }
}

}  // namespace

QVariant PeerTableModel::headerData(int section, Qt::Orientation orientation, int role) const {
  if (orientation == Qt::Horizontal && role == Qt::ToolTipRole) return Explanation(section);
  if (orientation != Qt::Horizontal || role != Qt::DisplayRole) return {};
  switch (section) {
    case kName:
      return tr("Peer");
    case kRole:
      return tr("Role");
    case kPresence:
      return tr("Presence");
    case kDelay:
      return tr("Delay");
    case kLag:
      return tr("Lag");
    case kForce:
      return tr("Force");
    case kLimits:
      return tr("Limits");
    default:
      return {};
  }
}

}  // namespace tandem
