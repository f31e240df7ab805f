#include "app/peer/peer_orders.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A fixed plate, an own and a shared box. Anna is here, and Ben, who is a viewer.
struct Room {
  explicit Room(ContactModel contact = ContactModel::kRefined) : directory(1, 42, "me") {
    const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
    auto made = std::make_shared<WorldModel>(*testing::MakeWorldModel(
        {{testing::At(box, Vec3(0, 0, -0.1)), true}, {box}, {testing::At(box, Vec3(0.1, 0, 0))}},
        0.004, contact));
    made->scene.bodies[0].name = "plate";
    made->scene.bodies[1].name = "own";
    made->scene.bodies[2].name = "both";
    made->scene.bodies[2].shared = true;
    model = made;
    PeerInfo info;
    info.scene_hash = 42;
    info.peer = 7;
    info.name = "Anna Maria";
    directory.OnPeerInfo(info);
    info.peer = 8;
    info.name = "Ben";
    info.role = Role::kViewer;
    directory.OnPeerInfo(info);
  }
  Result<Command> Order(const std::string& line, bool own_only = false) {
    return ParseOrder(line, *model, directory, own_only);
  }
  std::shared_ptr<const WorldModel> model;
  PeerDirectory directory;
};

TEST(PeerOrders, AreEachExplainedByHelp) {
  std::string help;
  for (const std::string& line : HelpOnOrders()) help += line + "\n";
  for (const char* order : {"grab BODY ", "release ", "give BODY PEER ", "heal ", "layer N ",
                            "displace MM ", "peers ", "network FILE ", "quit "}) {
    EXPECT_THAT(help, HasSubstr(std::string("\n  ") + order));
  }
  for (const char* column : {"delay", "coupling", "force", "theirs", "differ", "mirror", "age"}) {
    EXPECT_THAT(help, HasSubstr(column));
  }
}

TEST(PeerOrders, ParseActionBodyAndRecipient) {
  Room room;
  const auto grab = room.Order("grab both");
  ASSERT_TRUE(grab);
  EXPECT_EQ(grab->kind, Command::Kind::kGrab);
  EXPECT_EQ(grab->object, 2U);
  const auto release = room.Order("  release ");
  ASSERT_TRUE(release);
  EXPECT_EQ(release->kind, Command::Kind::kRelease);
  const auto give = room.Order("give own Anna Maria");
  ASSERT_TRUE(give);
  EXPECT_EQ(give->kind, Command::Kind::kGive);
  EXPECT_EQ(give->object, 1U);
  EXPECT_EQ(give->to, 7U);
}

TEST(PeerOrders, ReportUnknownOrdersAndBodies) {
  Room room;
  for (const char* line : {"", "grab", "grab own now", "give own", "release own", "throw own"}) {
    const auto order = room.Order(line);
    ASSERT_FALSE(order) << line;
    EXPECT_THAT(order.error().what, HasSubstr(std::string(line) + "' is not a command"));
  }
  EXPECT_THAT(room.Order("grab hose").error().what, HasSubstr("no moving body 'hose'"));
  EXPECT_THAT(room.Order("grab plate").error().what, HasSubstr("no moving body 'plate'"));
  EXPECT_THAT(room.Order("give own Carl").error().what, HasSubstr("called 'Carl'"));
  // a viewer holds nothing
  EXPECT_THAT(room.Order("give own Ben").error().what, HasSubstr("called 'Ben'"));
}

TEST(PeerOrders, TypingErrorsGetAHint) {
  Room room;
  EXPECT_THAT(room.Order("relase").error().what, HasSubstr("did you mean 'release'?"));
  EXPECT_THAT(room.Order("grap own").error().what, HasSubstr("did you mean 'grab'?"));
  EXPECT_THAT(room.Order("grab bot").error().what,
              HasSubstr("no moving body 'bot'; did you mean 'both'?"));
  EXPECT_THAT(room.Order("xyzzy").error().what, Not(HasSubstr("did you mean")));
}

TEST(PeerOrders, SetLayerOrDisplacementOfTheHeldBody) {
  Room room;
  const auto layer = room.Order("layer 2");
  ASSERT_TRUE(layer);
  EXPECT_EQ(layer->kind, Command::Kind::kLayer);
  EXPECT_EQ(layer->layer, 2);
  EXPECT_THAT(AnswerTo(*layer, *room.model), HasSubstr("force layer 2 for the body you hold"));
  EXPECT_THAT(AnswerTo(*layer, *room.model), HasSubstr("force begins 1.45 voxels from surfaces"));
  const auto displace = room.Order("displace -1.5");
  ASSERT_TRUE(displace);
  EXPECT_EQ(displace->kind, Command::Kind::kDisplace);
  EXPECT_DOUBLE_EQ(displace->metres, -0.0015);
  EXPECT_THAT(AnswerTo(*displace, *room.model), HasSubstr("1.5 mm outwards, at this peer alone"));
  EXPECT_EQ(AnswerTo(*room.Order("grab own"), *room.model), "");
  // at a cube's edges displaced neighbours part outwards and come together inwards; refined contact
  // displaces no points
  Room plain(ContactModel::kPlain);
  EXPECT_THAT(AnswerTo(*displace, *plain.model),
              HasSubstr("'own': its displaced points stand up to 1.27 voxels apart"));
  EXPECT_THAT(AnswerTo(*plain.Order("displace 1.5"), *plain.model), Not(HasSubstr("stand up to")));
  EXPECT_THAT(AnswerTo(*displace, *room.model), Not(HasSubstr("stand up to")));
  // refined contact needs the first layer; the fields reach 1.5 voxels, of 4 mm
  for (const char* word : {"0", "3", "-1", "2.5", "2x", "99999999999", "nan"}) {
    EXPECT_EQ(room.Order(std::string("layer ") + word).error().what,
              std::string("layer: expected a whole number from 1 to 2, got '") + word + "'");
  }
  for (const char* word : {"4.1", "-5", "1e400", "nan", "inf", "1mm"}) {
    EXPECT_EQ(room.Order(std::string("displace ") + word).error().what,
              std::string("displace: expected millimetres inwards, from -4.2 to 4 (one voxel), ") +
                  "got '" + word + "'");
  }
  EXPECT_THAT(room.Order("layer").error().what, HasSubstr("is not a command"));
  EXPECT_THAT(room.Order("displace 1 mm").error().what, HasSubstr("is not a command"));
}

TEST(PeerOrders, RefuseSharedBodiesUnderOtherParameters) {
  Room room;
  EXPECT_TRUE(room.Order("grab own", true));
  EXPECT_THAT(room.Order("grab both", true).error().what, HasSubstr("'both' is shared"));
}

/// A pipe with text that somebody wrote into one end.
class Pipe {
 public:
  Pipe() { EXPECT_EQ(pipe2(ends_, O_CLOEXEC | O_NONBLOCK), 0); }
  ~Pipe() {
    close(ends_[0]);
    End();
  }
  int out() const { return ends_[0]; }
  /// Writes as much of the text as there is room for.
  void Write(const std::string& text) const {
    EXPECT_GT(write(ends_[1], text.data(), text.size()), 0);
  }
  void End() {
    if (ends_[1] >= 0) close(std::exchange(ends_[1], -1));
  }

 private:
  int ends_[2] = {-1, -1};
};

/// Returns the lines, with "!" for each that is not taken.
std::vector<std::string> Taken(OrderReader& reader) {
  std::vector<std::string> lines;
  for (const Result<std::string>& line : reader.TakeLines()) {
    lines.push_back(line ? *line : "!");
  }
  return lines;
}

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(OrderReader, YieldsCompleteLinesAndAnUnterminatedLastLine) {
  Pipe pipe;
  OrderReader reader(pipe.out());
  EXPECT_THAT(Taken(reader), IsEmpty());
  pipe.Write("grab a\n\nrele");
  EXPECT_THAT(Taken(reader), ElementsAre("grab a"));
  pipe.Write("ase\nheal");
  EXPECT_THAT(Taken(reader), ElementsAre("release"));
  pipe.End();
  EXPECT_THAT(Taken(reader), ElementsAre("heal"));
  EXPECT_THAT(Taken(reader), IsEmpty());
}

// With the input of `yes
// tandem peer` the control thread goes on, and nothing of the input is lost.
TEST(OrderReader, ReadsABoundedAmountPerTurn) {
  Pipe pipe;
  OrderReader reader(pipe.out());
  std::string text;
  for (int i = 0; i < 8000; ++i) text += "y\n";
  pipe.Write(text);
  std::size_t lines = 0;
  for (std::size_t turn = 0; turn < 8000 / OrderReader::kMostLines; ++turn) {
    const std::vector<std::string> taken = Taken(reader);
    EXPECT_EQ(taken.size(), OrderReader::kMostLines);
    EXPECT_THAT(taken, Each("y"));
    lines += taken.size();
  }
  EXPECT_EQ(lines, 8000U);
  EXPECT_THAT(Taken(reader), IsEmpty());
  // empty lines are no orders, but cost a turn as well
  pipe.Write(std::string(20000, '\n') + "heal\n");
  int turns = 0;
  while (Taken(reader).empty() && turns < 100) ++turns;
  EXPECT_EQ(turns, 20000 / static_cast<int>(OrderReader::kMostBytes));
}

TEST(OrderReader, OverlongLineIsReportedOnceAndSkipped) {
  Pipe pipe;
  OrderReader reader(pipe.out());
  pipe.Write(std::string(OrderReader::kLongest, 'a') + "\n");
  EXPECT_THAT(Taken(reader), ElementsAre(std::string(OrderReader::kLongest, 'a')));
  pipe.Write(std::string(OrderReader::kLongest + 1, 'a') + "\nheal\n");
  EXPECT_THAT(Taken(reader), ElementsAre("!", "heal"));
  std::size_t reported = 0;
  for (int i = 0; i < 10; ++i) {
    pipe.Write(std::string(20000, 'a'));
    for (int turn = 0; turn < 10; ++turn) reported += Taken(reader).size();
  }
  EXPECT_EQ(reported, 1U);
  pipe.Write("grab\nheal\n");
  EXPECT_THAT(Taken(reader), ElementsAre("heal"));
}

}  // namespace
}  // namespace tandem
