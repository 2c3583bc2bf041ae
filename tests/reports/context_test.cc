#include "reports/context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lacuna {
namespace {

TEST(MakeContext, KnowsWhenAndWhere) {
  const Context c = make_context(7, 2, "lacuna diagnose x");
  EXPECT_EQ(c.seed, 7u);
  EXPECT_EQ(c.threads, 2);
  EXPECT_EQ(c.command_line, "lacuna diagnose x");
  // 2025-01-02T03:04:05Z
  ASSERT_EQ(c.date.size(), 20u);
  EXPECT_EQ(c.date[4], '-');
  EXPECT_EQ(c.date[10], 'T');
  EXPECT_EQ(c.date[19], 'Z');
  for (const std::string& field : {c.host, c.cpu, c.compiler, c.commit, c.version, c.lanes})
    EXPECT_THAT(field, testing::Not(testing::IsEmpty()));
  EXPECT_EQ(c.version, version());
}

}  // namespace
}  // namespace lacuna
