// The table of measured quantities.
#include "physics/quantity.h"

#include <gtest/gtest.h>

#include <set>

namespace lacuna {
namespace {

TEST(QuantityTable, HoldsEveryKindOnceInTheEnumerationsOrder) {
  const auto& table = quantity_table();
  ASSERT_EQ(table.size(), static_cast<std::size_t>(ChannelKind::pressure_b) + 1);
  std::set<std::string> names;
  for (std::size_t k = 0; k < table.size(); ++k) {
    EXPECT_EQ(table[k].kind, static_cast<ChannelKind>(k));
    EXPECT_EQ(&quantity_of(table[k].kind), &table[k]);
    EXPECT_TRUE(names.insert(to_string(table[k].kind)).second) << to_string(table[k].kind);
    EXPECT_STRNE(table[k].meaning, "");
  }
}

TEST(QuantityTable, UnitsAreSiAndThoseOfTheJointsKind) {
  const auto units = [](ChannelKind kind) {
    return std::pair<std::string, std::string>(quantity_of(kind).unit, quantity_of(kind).linear_unit);
  };
  using Units = std::pair<std::string, std::string>;
  EXPECT_EQ(units(ChannelKind::command), Units("", ""));  // the joint's own
  EXPECT_EQ(units(ChannelKind::position), Units("rad", "m"));
  EXPECT_EQ(units(ChannelKind::velocity), Units("rad/s", "m/s"));
  EXPECT_EQ(units(ChannelKind::effort), Units("N m", "N"));
  EXPECT_EQ(units(ChannelKind::motor_position), units(ChannelKind::position));
  EXPECT_EQ(units(ChannelKind::pressure_a), Units("Pa", "Pa"));
  EXPECT_EQ(units(ChannelKind::pressure_b), units(ChannelKind::pressure_a));
}

TEST(QuantityTable, OnlyCommandsAreGivenAndOnlyPressuresNeedChambers) {
  for (const Quantity& q : quantity_table()) {
    EXPECT_EQ(q.predicted_by == PredictedBy::given, q.kind == ChannelKind::command) << q.meaning;
    EXPECT_EQ(q.predicted_by == PredictedBy::chambers,
              q.kind == ChannelKind::pressure_a || q.kind == ChannelKind::pressure_b)
        << q.meaning;
  }
  EXPECT_EQ(quantity_of(ChannelKind::effort).predicted_by, PredictedBy::effort);
  EXPECT_EQ(quantity_of(ChannelKind::motor_position).predicted_by, PredictedBy::drive_side);
}

}  // namespace
}  // namespace lacuna
