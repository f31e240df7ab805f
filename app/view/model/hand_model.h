#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <QString>
#include <QTimer>
#include <memory>
#include <optional>
#include <thread>

#include "app/view/model/controller_link.h"
#include "app/view/model/hand_picture.h"

namespace tandem {

/// The user's hand: starts a controller or takes up one that runs, takes and moves bodies through
/// it, tells what came of it. A controller that is lost is waited for; one that ended is said to
/// have. GUI thread only.
class HandModel : public QObject {
  Q_OBJECT

 public:
  /// kLost: the controller was there and is not heard; kEnded: see trouble().
  enum class State { kNone, kStarting, kReady, kLost, kEnded };

  HandModel(AttachFunction attach, LaunchFunction launch, QObject* parent = nullptr);
  ~HandModel() override;  // ends what it started

  /// Starts a controller, in place of the one before. One of that name that runs is taken up.
  void Start(const HandRequest& request);
  /// Takes up a controller that runs already. `own`: an earlier window of this user has started it,
  /// and it ends with this one. `secure`: the folder of keys that it has for its session; empty:
  /// none.
  void TakeUp(const std::string& control, const std::string& name, bool own = false,
              const std::string& secure = {});
  /// Leaves the session; ends the controller, if it is this user's own.
  void Leave();

  State state() const { return state_; }
  bool ready() const { return state_ == State::kReady; }
  /// A controller is there or was just now: what is shown is its picture.
  bool shows() const { return link_ != nullptr; }
  /// In states kStarting, kLost and kEnded: what is going on, in a line.
  const QString& trouble() const { return trouble_; }
  /// Newest word to the user: why something was refused, what the controller says.
  const QString& word() const { return word_; }
  const HandRequest& request() const { return request_; }

  const ControllerSnapshot& snapshot() const;
  /// The body in hand, or nothing.
  std::optional<std::size_t> held() const;
  bool stopped() const;
  /// Whether a device at the controller moves the hand, so that the mouse has the view alone.
  bool by_device() const;
  /// Why the device in the hand has no force now, or less; empty: it has all.
  QString DeviceTrouble() const;
  /// Whether Resume() would do something: after a stop, after a fault of the device.
  bool resumable() const;
  /// Newest goal of the grasp frame: what this hand has asked for, else what the controller knows.
  Pose goal() const;
  /// Whether the controller drives the part by itself, so that the goal is the controller's.
  bool retracing() const;

  /// Asks for a body at a point of it. What is in hand is let go of first.
  void Grab(std::size_t body, const Vec3& p_W);
  void SetGoal(const Pose& X_WG);
  void Release();
  void Give(const QString& peer);
  void AskFor(std::size_t body);
  void Retrace(RetraceRequest::To to);
  /// Where the controller is not heard, too: it may hear.
  void Stop();
  void Resume();
  /// Tells how the user looks at the scene, for a device's sake; once for each view.
  void SetView(const Mat3& R_WV);
  /// Any request; a refusal becomes the newest word, after `what`.
  void Ask(const QString& what, const ControlRequest& request);
  /// Puts a word for the user there itself.
  void Tell(const QString& word);

 Q_SIGNALS:
  void StateChanged();
  void SnapshotCame();
  void Told(const QString& word);

 private:
  void Poll();
  void TryToAttach();
  void OnAttachEnded();
  void SetState(State state, const QString& trouble = {});
  void TakeNews();
  /// From here on the goal is the controller's, and a grab that is on its way counts no more.
  void ForgetGoal();

  AttachFunction attach_;
  LaunchFunction launch_;
  HandRequest request_;
  State state_ = State::kNone;
  QString trouble_;
  QString word_;
  std::unique_ptr<ControllerProcess> process_;
  std::unique_ptr<ControllerLink> link_;
  std::thread attaching_;
  std::optional<Result<std::unique_ptr<ControllerLink>>> attach_result_;  // by attaching_
  bool own_ = false;            // the controller ends with this window
  bool drop_attached_ = false;  // what is being attached is not wanted any more
  QTimer poll_;
  QElapsedTimer since_start_;
  std::optional<Pose> goal_;
  std::uint64_t grabs_asked_ = 0;
  bool grab_pending_ = false;
  bool grab_answered_ = false;
  std::uint64_t news_seen_ = 0;
  std::uint64_t frame_seen_ = 0;
  std::optional<Mat3> view_told_;
  bool stop_asked_ = false;  // before there was a controller to hear it
};

/// "anna holds it, ben holds it" in short words for lists: whether another user has it alone.
std::optional<QString> HeldByOther(const ControllerSnapshot& snapshot, std::size_t body);

}  // namespace tandem
