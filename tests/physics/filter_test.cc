#include "physics/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace lacuna {
namespace {

constexpr double kRate = 1000.0, kCutoff = 40.0;  // Hz

/// Amplitude and phase of a filtered sine, read off the middle of a long signal by projection.
std::pair<double, double> response(double frequency) {
  const std::size_t n = 20000;
  std::vector<double> x(n);
  auto phase = [&](std::size_t k) { return 2.0 * std::numbers::pi * frequency * static_cast<double>(k) / kRate; };
  for (std::size_t k = 0; k < n; ++k) x[k] = std::sin(phase(k));
  ZeroPhaseLowPass(kCutoff, kRate).apply(x);
  double s = 0.0, c = 0.0;
  for (std::size_t k = 5000; k < 15000; ++k)
    s += x[k] * std::sin(phase(k)) / 5000.0, c += x[k] * std::cos(phase(k)) / 5000.0;
  return {std::hypot(s, c), std::atan2(c, s)};
}

TEST(ZeroPhaseLowPass, LeavesAConstantAndAStraightLineAlone) {
  std::vector<double> constant(500, 3.7), line(500);
  for (std::size_t k = 0; k < line.size(); ++k) line[k] = 0.2 * static_cast<double>(k) - 5.0;
  const std::vector<double> straight = line;
  const ZeroPhaseLowPass filter(kCutoff, kRate);
  filter.apply(constant);
  filter.apply(line);
  for (const double x : constant) EXPECT_NEAR(x, 3.7, 1e-12);
  // Ends are extended by point reflection, which continues a line; the transient of its outer end is left.
  for (std::size_t k = 0; k < line.size(); ++k) EXPECT_NEAR(line[k], straight[k], 2e-2) << k;
}

TEST(ZeroPhaseLowPass, HasHalfPowerAtTheCutoffInEachDirection) {
  // 1/sqrt(2) forwards and again backwards: one half.
  EXPECT_NEAR(response(kCutoff).first, 0.5, 1e-3);
}

TEST(ZeroPhaseLowPass, HasButterworthsMagnitudeSquared) {
  for (const double f : {5.0, 20.0, 60.0, 100.0}) {
    const double ratio = std::tan(std::numbers::pi * f / kRate) / std::tan(std::numbers::pi * kCutoff / kRate);
    EXPECT_NEAR(response(f).first, 1.0 / (1.0 + std::pow(ratio, 8)), 1e-3) << f << " Hz";
  }
}

TEST(ZeroPhaseLowPass, HasNoPhase) {
  for (const double f : {5.0, 20.0, 40.0, 60.0}) EXPECT_NEAR(response(f).second, 0.0, 1e-3) << f << " Hz";
}

TEST(ZeroPhaseLowPass, IsSymmetricInTime) {
  std::vector<double> a(400), b;
  for (std::size_t k = 0; k < a.size(); ++k) a[k] = std::sin(0.05 * static_cast<double>(k * k % 97));
  b.assign(a.rbegin(), a.rend());
  const ZeroPhaseLowPass filter(kCutoff, kRate);
  filter.apply(a);
  filter.apply(b);
  for (std::size_t k = 100; k + 100 < a.size(); ++k) EXPECT_NEAR(a[k], b[a.size() - 1 - k], 1e-6);
}

TEST(ZeroPhaseLowPass, FiltersAStridedSignalLikeAPlainOne) {
  std::vector<double> plain(300), mixed(900, -1.0);
  for (std::size_t k = 0; k < plain.size(); ++k) mixed[3 * k + 1] = plain[k] = std::cos(0.3 * static_cast<double>(k));
  const ZeroPhaseLowPass filter(kCutoff, kRate);
  filter.apply(plain);
  filter.apply(mixed, 1, 3);
  for (std::size_t k = 0; k < plain.size(); ++k) {
    EXPECT_EQ(mixed[3 * k + 1], plain[k]);
    EXPECT_EQ(mixed[3 * k], -1.0);
  }
}

TEST(ZeroPhaseLowPass, RefusesACutoffOutsideItsRange) {
  for (const double cutoff : {0.0, -1.0, 500.0, 600.0, std::nan("")}) {
    EXPECT_THROW(ZeroPhaseLowPass(cutoff, kRate), std::invalid_argument) << cutoff;
  }
}

}  // namespace
}  // namespace lacuna
