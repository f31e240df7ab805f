#include <QHeaderView>
#include <QMenuBar>
#include <QStatusBar>

#include "app/view/ui/main_window.h"

// Lays out the main window: docks, menus and the status bar.

namespace tandem {

namespace {
constexpr int kSessionHeight = 260;
}  // namespace

void MainWindow::MakeDocks() {
  session_dock_ = new SessionDock(session_, scene_, this);
  addDockWidget(Qt::RightDockWidgetArea, session_dock_);

  peers_view_ = new QTableView;
  peers_view_->setObjectName("peers");
  peers_view_->setModel(&peers_);
  peers_view_->setSelectionBehavior(QAbstractItemView::SelectRows);
  peers_view_->setShowGrid(false);
  peers_view_->setAlternatingRowColors(true);
  peers_view_->setWordWrap(false);
  peers_view_->verticalHeader()->hide();
  peers_view_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  QHeaderView* header = peers_view_->horizontalHeader();
  header->setSectionResizeMode(QHeaderView::Fixed);
  header->setSectionResizeMode(PeerTableModel::kName, QHeaderView::Stretch);
  const auto room_for = [&](const QString& text) {
    return header->fontMetrics().horizontalAdvance(text) + 16;
  };
  header->resizeSection(PeerTableModel::kRole, room_for(tr("viewer")));
  header->resizeSection(PeerTableModel::kPresence, room_for(tr("Presence")));
  header->resizeSection(PeerTableModel::kDelay, room_for(tr("1000 ms")));
  header->resizeSection(PeerTableModel::kLag, room_for(tr("99.9 mm")));
  header->resizeSection(PeerTableModel::kForce, room_for(tr("99.9 N")));
  header->resizeSection(PeerTableModel::kLimits, room_for(tr("slowed 12 %")));
  int width = room_for(tr("A longer name")) + 2 * peers_view_->frameWidth();
  for (int column = 1; column < PeerTableModel::kColumnCount; ++column) {
    width += header->sectionSize(column);
  }
  peers_view_->setMinimumWidth(width);
  header->setHighlightSections(false);
  header->setDefaultAlignment(Qt::AlignLeft | Qt::AlignVCenter);
  auto* dock = new QDockWidget(tr("Peers"), this);
  dock->setObjectName("peers_dock");
  dock->setFeatures(QDockWidget::DockWidgetMovable | QDockWidget::DockWidgetFloatable);
  dock->setWidget(peers_view_);
  addDockWidget(Qt::RightDockWidgetArea, dock);
  resizeDocks({session_dock_, dock}, {kSessionHeight, 2 * kSessionHeight}, Qt::Vertical);
}

void MainWindow::MakeActions(bool with_hand) {
  QMenu* session = menuBar()->addMenu(tr("&Session"));
  QAction* open = session->addAction(tr("&Open scene\u2026"), QKeySequence::Open, this,
                                     &MainWindow::AskForScene);
  open->setObjectName("open_scene");
  recent_menu_ = session->addMenu(tr("Open &recent"));
  recent_menu_->setObjectName("open_recent");
  recent_menu_->setEnabled(false);
  if (with_hand) {
    QAction* join = session->addAction(tr("&Join\u2026"), QKeySequence(Qt::CTRL | Qt::Key_J), this,
                                       &MainWindow::AskToJoin);
    join->setObjectName("join_session_action");
    invite_action_ = session->addAction(tr("&Invite\u2026"), QKeySequence(Qt::CTRL | Qt::Key_I),
                                        this, &MainWindow::InviteSomebody);
    invite_action_->setObjectName("invite_action");
    invite_action_->setEnabled(false);  // until there is a session
    QAction* leave = session->addAction(tr("&Leave"), this, [this] {
      panel_->hand().Leave();
      session_.Leave();
    });
    leave->setObjectName("leave_action");
    session->addSeparator();
  }
  session->addAction(tr("Save &picture"), Qt::Key_F12, this, &MainWindow::SaveScreenshot);
  session->addSeparator();
  session->addAction(tr("&Quit"), QKeySequence::Quit, this, &QWidget::close);

  QMenu* view = menuBar()->addMenu(tr("&View"));
  view->setEnabled(view_ != nullptr);
  if (view_ != nullptr) {
    QAction* fit = view->addAction(tr("&Fit the scene"), view_, &ViewWidget::FitScene);
    fit->setShortcuts({QKeySequence(Qt::Key_F), QKeySequence(Qt::Key_Home)});
    const auto add = [&](const QString& text, Qt::Key key, StandardView from) {
      view->addAction(text, key, view_, [this, from] {
        view_->LookFrom(from);
      });
    };
    add(tr("F&ront"), Qt::Key_1, StandardView::kFront);
    add(tr("R&ight"), Qt::Key_3, StandardView::kRight);
    add(tr("&Top"), Qt::Key_7, StandardView::kTop);
    add(tr("&Oblique"), Qt::Key_9, StandardView::kIso);
    QAction* follow = view->addAction(tr("&Keep bodies in the picture"));
    follow->setObjectName("follow");
    follow->setCheckable(true);
    follow->setChecked(view_->follow());
    follow->setShortcut(Qt::Key_K);
    connect(follow, &QAction::toggled, view_, &ViewWidget::SetFollow);
    connect(view_, &ViewWidget::FollowChanged, follow, &QAction::setChecked);
    view->addSeparator();
    proximity_action_ = view->addAction(tr("&Proximity"));
    proximity_action_->setObjectName("proximity");
    proximity_action_->setCheckable(true);
    proximity_action_->setShortcut(Qt::Key_P);
    connect(proximity_action_, &QAction::toggled, &proximity_, &ProximityModel::SwitchOn);
  }
  QMenu* help = menuBar()->addMenu(tr("&Help"));
  help->addAction(tr("&Mouse and keys"), Qt::Key_F1, this, &MainWindow::ShowKeys);
}

QLabel* MainWindow::AddStatus(const QString& name) {
  auto* label = new QLabel;
  label->setTextFormat(Qt::PlainText);
  label->setObjectName(name);
  label->setMargin(3);
  statusBar()->addPermanentWidget(label);
  return label;
}

void MainWindow::MakeStatusBar() {
  status_session_ = new QLabel;
  status_session_->setTextFormat(Qt::PlainText);  // names come from other peers
  status_session_->setObjectName("status_session");
  status_session_->setMargin(3);
  statusBar()->addWidget(status_session_);
  status_proximity_ = AddStatus("status_proximity");
  status_scene_ = AddStatus("status_scene");
  status_samples_ = AddStatus("status_samples");
  status_fps_ = AddStatus("status_fps");
  RefreshNumbers();
}

}  // namespace tandem
