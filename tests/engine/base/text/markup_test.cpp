#include "engine/base/text/markup.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(Markup, EscapesElementsAndAttributes) {
  EXPECT_EQ(EscapedMarkup("<b a=\"1\" c='2'>&"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;");
}

TEST(Markup, HasNoControlCharacters) {
  EXPECT_EQ(EscapedMarkup(std::string("a\x01z\nb", 5)), "a z\nb");
}

TEST(Markup, AnElementEndsWithItsNameAndNotItsAttributes) {
  EXPECT_EQ(MarkupElement("td class=\"n\"", "a<b"), "<td class=\"n\">a&lt;b</td>");
}

}  // namespace
}  // namespace tandem
