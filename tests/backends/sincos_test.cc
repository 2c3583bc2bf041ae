// Sine and cosine of the kernels against long double, for one number and for packs.
#include "backends/featherstone/sincos.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "physics/lanes.h"

namespace lacuna {
namespace {

using Pack = xsimd::batch<double, xsimd::sse2>;

/// Distance in units of the last place of the exact value.
double ulps(double found, long double exact) {
  const double nearest = static_cast<double>(exact);
  const double spacing = std::nextafter(std::fabs(nearest), HUGE_VAL) - std::fabs(nearest);
  return static_cast<double>(std::fabs(static_cast<long double>(found) - exact)) / spacing;
}

/// All round, and as close to the multiples of pi/4 as a double comes.
std::vector<double> arguments() {
  std::vector<double> out{0.0, -0.0, 1e-300, 1e-9, 1e-4};
  double phase = 0.0;
  for (int k = 0; k < 200'000; ++k) {
    phase += std::numbers::phi - 1.0;
    phase -= std::floor(phase);
    out.push_back((2.0 * phase - 1.0) * (k % 2 == 0 ? 1e4 : 7.0));
  }
  for (int k = -12'800; k <= 12'800; ++k) {
    const double near = k * (std::numbers::pi / 4.0);
    out.insert(out.end(), {near, std::nextafter(near, HUGE_VAL), std::nextafter(near, -HUGE_VAL)});
  }
  return out;
}

TEST(SinCos, IsAccurateToTwoUlpWithinTenThousandRadians) {
  constexpr double kUlps = 2.0;
  for (const double x : arguments()) {
    double s, c;
    sincos(x, s, c);
    ASSERT_LE(ulps(s, std::sin(static_cast<long double>(x))), kUlps) << x;
    ASSERT_LE(ulps(c, std::cos(static_cast<long double>(x))), kUlps) << x;
    Pack ps, pc;
    sincos(Pack(x), ps, pc);
    ASSERT_LE(ulps(lane(ps, 1), std::sin(static_cast<long double>(x))), kUlps) << x;
    ASSERT_LE(ulps(lane(pc, 0), std::cos(static_cast<long double>(x))), kUlps) << x;
  }
}

TEST(SinCos, OfHugeNumbersAreTheLibrarysAndOfNoNumberNone) {
  double s, c;
  sincos(1e12, s, c);
  EXPECT_EQ(s, std::sin(1e12));
  EXPECT_EQ(c, std::cos(1e12));
  for (const double x : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    Pack ps, pc;
    sincos(Pack(x), ps, pc);
    EXPECT_TRUE(std::isnan(lane(ps, 0)) && std::isnan(lane(pc, 0))) << x;
  }
}

}  // namespace
}  // namespace lacuna
