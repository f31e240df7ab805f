#include "collab/session/person_colour.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

// By hand: FNV-1a of "anna" and of "dave" leave the same remainder, so that both want blue.
TEST(PersonColour, NewcomerTakesAnotherColourThanAPersonWhoIsHere) {
  ASSERT_EQ(ColourOfName("anna"), ColourOfName("dave"));
  const PersonColour anna = ChooseColour("anna", Role::kActive, 0, {});
  EXPECT_EQ(anna, ColourOfName("anna"));
  const std::vector<ColouredPerson> here{
      {.name = "anna", .role = Role::kActive, .colour = anna, .before = true}};
  const PersonColour dave = ChooseColour("dave", Role::kActive, 0, here);
  EXPECT_NE(dave, anna);
  // she leaves, and his colour stays
  EXPECT_EQ(ChooseColour("dave", Role::kActive, dave, {}), dave);
}

TEST(PersonColour, OfTwoWhoChoseAtOnceTheLaterOneYields) {
  const PersonColour both = ColourOfName("anna");
  const std::vector<ColouredPerson> anna{
      {.name = "anna", .role = Role::kActive, .colour = both, .before = true}};
  const std::vector<ColouredPerson> dave{
      {.name = "dave", .role = Role::kActive, .colour = both, .before = false}};
  EXPECT_EQ(ChooseColour("anna", Role::kActive, both, dave), both);
  EXPECT_NE(ChooseColour("dave", Role::kActive, both, anna), both);
}

TEST(PersonColour, WhoLooksOnAndTakesPartHasOneColour) {
  const std::vector<ColouredPerson> here{
      {.name = "anna", .role = Role::kViewer, .colour = 7, .before = true}};
  EXPECT_EQ(ChooseColour("anna", Role::kActive, 0, here), 7);
  // another person of that name who takes part is another person
  const std::vector<ColouredPerson> namesake{
      {.name = "anna", .role = Role::kActive, .colour = ColourOfName("anna"), .before = true}};
  EXPECT_NE(ChooseColour("anna", Role::kActive, 0, namesake), ColourOfName("anna"));
}

TEST(PersonColour, EightPersonsHaveEightColours) {
  std::vector<ColouredPerson> here;
  std::set<PersonColour> colours;
  for (const char* name : {"anna", "dave", "ben", "cleo", "eva", "hans", "bob", "carl"}) {
    const PersonColour colour = ChooseColour(name, Role::kActive, 0, here);
    here.push_back({.name = name, .role = Role::kActive, .colour = colour, .before = true});
    colours.insert(colour);
  }
  EXPECT_EQ(colours.size(), kPersonColours);
  // a ninth shares one
  EXPECT_EQ(ChooseColour("dora", Role::kActive, 0, here), ColourOfName("dora"));
}

TEST(PersonColour, BothSidesAgreeWhoCameFirst) {
  PeerInfo anna;
  anna.peer = 9;
  anna.beat = 40;
  PeerInfo ben;
  ben.peer = 4;
  ben.beat = 3;
  EXPECT_TRUE(CameBefore(anna, ben.peer, ben.beat));
  EXPECT_FALSE(CameBefore(ben, anna.peer, anna.beat));
  anna.beat = 3;  // they came together: the lower id counts
  EXPECT_FALSE(CameBefore(anna, ben.peer, ben.beat));
  EXPECT_TRUE(CameBefore(ben, anna.peer, anna.beat));
}

TEST(PersonColour, EachHasAName) {
  std::set<std::string> names;
  for (PersonColour colour = 1; colour <= kPersonColours; ++colour) {
    names.insert(NameOfColour(colour));
  }
  EXPECT_EQ(names.size(), kPersonColours);
  EXPECT_EQ(names.count(""), 0U);
}

}  // namespace
}  // namespace tandem
