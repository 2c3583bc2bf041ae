// Meetings of ranks: who is told what, when they part, and that nobody waits for ever.
#include "physics/ranks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/physics/rank_threads.h"

namespace lacuna {
namespace {

using namespace test;
using testing::HasSubstr;

std::vector<std::size_t> one_each(const Ranks& ranks) {
  return std::vector<std::size_t>(static_cast<std::size_t>(ranks.size()), 1);
}

void meet(Ranks& ranks, std::uint64_t key) {
  const std::byte mine{static_cast<unsigned char>(10 + ranks.rank())};
  const auto all = ranks.share(key, nullptr, std::span(&mine, 1), one_each(ranks));
  ASSERT_EQ(all.size(), static_cast<std::size_t>(ranks.size()));
  for (std::size_t r = 0; r < all.size(); ++r) EXPECT_EQ(all[r].front(), std::byte(10 + r));
}

/// The message with which the ranks part.
std::string parting(const std::function<void()>& work, int code) {
  try {
    work();
  } catch (const RanksParted& error) {
    EXPECT_EQ(error.code, code);
    return error.what();
  }
  return "did not part";
}

TEST(Ranks, HandEachOtherWhatTheyBring) {
  on_ranks(3, [](Ranks& ranks, StopFlag&) {
    meet(ranks, 1);
    EXPECT_TRUE(ranks.as_first(ranks.first()));
    EXPECT_FALSE(ranks.as_first(!ranks.first()));
    EXPECT_NO_THROW(ranks.agree_on("alike"));
    EXPECT_EQ(ranks.part({}).code, 0);
    EXPECT_TRUE(ranks.leave());
  });
}

TEST(Ranks, PartWhereTheyWereAskedForDifferentWork) {
  on_ranks(3, [](Ranks& ranks, StopFlag&) {
    const auto work = [&] { meet(ranks, ranks.rank() == 2 ? 5 : 4); };
    EXPECT_THAT(parting(work, 3), HasSubstr("rank 2 on here was asked for other work than rank 0 on here"));
    EXPECT_THAT(parting(work, 3), HasSubstr("parted"));  // not once more
    EXPECT_EQ(ranks.part({3, "mine"}).message, "mine");
  });
}

TEST(Ranks, RefuseProgramsThatMightComputeOtherBits) {
  on_ranks(2, [](Ranks& ranks, StopFlag&) {
    const std::string lanes = ranks.first() ? "lanes avx512 x 8" : "lanes avx2 x 4";
    const std::string message = parting([&] { ranks.agree_on(lanes); }, 2);
    EXPECT_THAT(message, HasSubstr("rank 0 on here is lanes avx512 x 8"));
    EXPECT_THAT(message, HasSubstr("rank 1 on here is lanes avx2 x 4"));
  });
}

TEST(Ranks, OneThatLeavesAtOnceIsNotMistakenForAnother) {
  on_ranks(2, [](Ranks& ranks, StopFlag&) {
    if (ranks.first()) {
      EXPECT_EQ(parting([&] { ranks.agree_on("lanes avx2 x 4"); }, 2), "rank 1 on here: no such option");
    } else {
      EXPECT_EQ(ranks.part({2, "no such option"}).code, 2);
    }
  });
}

TEST(Ranks, TheOthersLearnWhyOneLeaves) {
  on_ranks(3, [](Ranks& ranks, StopFlag&) {
    if (ranks.rank() == 1) {
      const Ending own = ranks.part({2, "no such file"});
      EXPECT_EQ(own.code, 2);
      EXPECT_EQ(own.message, "no such file");
      return;
    }
    EXPECT_EQ(parting([&] { meet(ranks, 1); }, 2), "rank 1 on here: no such file");
  });
}

TEST(Ranks, OneThatFinishesEarlyEndsAll) {
  on_ranks(2, [](Ranks& ranks, StopFlag&) {
    if (ranks.first()) {
      EXPECT_EQ(ranks.part({}).code, 3);
    } else {
      EXPECT_THAT(parting([&] { meet(ranks, 1); }, 3), HasSubstr("rank 0 on here: finished before the others"));
    }
  });
}

TEST(Ranks, AllEndWithTheFirstFailure) {
  on_ranks(3, [](Ranks& ranks, StopFlag&) {
    const Ending ending = ranks.part(ranks.rank() == 2 ? Ending{3, "disk full"} : Ending{});
    EXPECT_EQ(ending.code, 3);
    if (ranks.first()) {
      EXPECT_EQ(ending.message, "rank 2 on here: disk full");
    }
  });
}

/// A rank that was killed answers nobody; those that are told to stop do not wait for it.
TEST(Ranks, NobodyWaitsForTheDeadOnceAskedToStop) {
  on_ranks(3, [](Ranks& ranks, StopFlag& asked) {
    meet(ranks, 1);
    if (ranks.rank() == 1) return;
    asked = true;
    EXPECT_THROW(meet(ranks, 2), Interrupted);
    EXPECT_EQ(ranks.part({130, "interrupted"}).code, 130);
    EXPECT_FALSE(ranks.leave());
  });
}

}  // namespace
}  // namespace lacuna
