#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <QString>
#include <QStringList>
#include <QTimer>
#include <memory>
#include <optional>
#include <thread>

#include "app/view/model/hand/controller_link.h"
#include "app/view/model/hand/hand_picture.h"

namespace tandem {

/// The user's hand. Starts a controller or attaches to a running one, takes and moves bodies
/// through it, and reports the results. Waits for a controller that is lost; reports one that has
/// ended. GUI thread only.
class HandModel : public QObject {
  Q_OBJECT

 public:
  /// kLost: the controller was there and is not heard. kEnded: trouble() says why.
  enum class State { kNone, kStarting, kReady, kLost, kEnded };

  HandModel(AttachFunction attach, LaunchFunction launch, QObject* parent = nullptr);
  ~HandModel() override;  // ends a controller of its own

  /// Leaves the present controller and starts a new one.
  void Start(const HandRequest& request);
  /// Attaches to a running controller. `own`: an earlier window of this user has started it, and it
  /// ends with this window. `secure`: the folder of the controller's keys for its session; empty:
  /// none.
  void TakeUp(const std::string& control, const std::string& name, bool own = false,
              const std::string& secure = {});
  /// Starts a new controller by the last request, where the one before has ended. Until it answers,
  /// the picture stays as it is.
  void StartAgain();
  bool can_start_again() const { return state_ == State::kEnded && !request_.scene.empty(); }
  /// Leaves the session, and ends the controller if it is this user's own.
  void Leave();

  State state() const { return state_; }
  bool ready() const { return state_ == State::kReady; }
  /// Returns whether a controller is or was there, so that the picture shows its state.
  bool shows() const { return link_ != nullptr || last_.frame > 0; }
  /// Returns whether the controller answers; else the picture shows where it left the bodies.
  bool alive() const { return ready(); }
  /// Describes in a line what is going on in states kStarting, kLost and kEnded.
  const QString& trouble() const { return trouble_; }
  /// Returns the newest message to the user: why a request was refused, or what the controller
  /// says.
  const QString& word() const { return word_; }
  const HandRequest& request() const { return request_; }

  /// Returns the newest snapshot; after the controller's end the last one, without a hand.
  const ControllerSnapshot& snapshot() const;
  /// Another user who asks for the part in hand.
  struct Asked {
    std::uint64_t peer = 0;
    QString name;
    std::size_t body = 0;
  };
  /// Returns who asks for the part in hand, until the hand lets go or KeepPart() is called.
  const std::optional<Asked>& asked() const { return asked_; }
  void HandOverAsked();
  void KeepPart();
  /// Returns the body in hand, or nothing.
  std::optional<std::size_t> held() const;
  bool stopped() const;
  /// Returns whether a device at the controller moves the hand. Then the mouse moves the camera
  /// alone.
  bool by_device() const;
  /// Says why a fault or a stop took the force from the device in use; empty: none did.
  QString DeviceTrouble() const;
  /// Returns whether Resume() has an effect: after a stop, or after a fault of the device.
  bool resumable() const;
  /// Returns the newest goal of the grasp frame: the goal that this hand set, else the
  /// controller's.
  Pose goal() const;
  /// Returns whether the controller drives the part by itself, so that the goal is the
  /// controller's.
  bool retracing() const;

  /// Asks for a body at a point of it. First lets go of the body in hand.
  void Grab(std::size_t body, const Vec3& p_W);
  void SetGoal(const Pose& X_WG);
  void Release();
  void Give(const QString& peer);
  void AskFor(std::size_t body);
  void Retrace(RetraceRequest::To to);
  /// Stops the hand, even while the controller is not heard: it may hear.
  void Stop();
  void Resume();
  /// Reports the user's view of the scene to the controller, for its device; once for each view.
  void SetView(const Mat3& R_WV);
  /// Sends any request. A refusal becomes the newest message, after `what`.
  void Ask(const QString& what, const ControlRequest& request);
  /// Sets a message for the user.
  void Tell(const QString& word);

 Q_SIGNALS:
  void StateChanged();
  void SnapshotCame();
  void Notified(const QString& word);
  /// The lines that the controller said as the session ended: verdicts on the parts that were held.
  void SessionEnded(const QStringList& lines);

 private:
  void Poll();
  void TryToAttach();
  void OnAttachEnded();
  void SetState(State state, const QString& trouble = {});
  void TakeNotifications();
  /// Ends a controller of this user's own, and returns what it said meanwhile.
  QStringList EndController();
  /// Makes the goal the controller's, and ignores the answer to a pending grab.
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
  std::optional<Result<std::unique_ptr<ControllerLink>>> attach_result_;  // result of the thread
                                                                          // attaching_
  bool own_ = false;            // true: the controller ends with this window
  bool drop_attached_ = false;  // true: the attachment in progress is unwanted
  ControllerSnapshot last_;     // last state of a controller that does not answer, without a hand
  std::optional<Asked> asked_;
  QTimer poll_;
  QElapsedTimer since_start_;
  std::optional<Pose> goal_;
  std::uint64_t grabs_asked_ = 0;
  bool grab_pending_ = false;
  bool grab_answered_ = false;
  std::uint64_t news_seen_ = 0;
  std::uint64_t frame_seen_ = 0;
  std::optional<Mat3> view_told_;
  bool stop_asked_ = false;  // stop asked for before the controller was there
};

/// Returns the name of another user who alone holds the body; nothing: none.
std::optional<QString> HeldByOther(const ControllerSnapshot& snapshot, std::size_t body);

}  // namespace tandem
