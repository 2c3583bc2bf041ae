#include "reports/svg.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/property_tree/xml_parser.hpp>
#include <cmath>
#include <numeric>
#include <sstream>

#include "tests/reports/sample.h"

namespace lacuna {
namespace {

using sample::kInf;
using sample::kNan;

/// Parses as XML and holds no number that a browser would refuse.
void expect_well_formed(const Html& svg) {
  std::istringstream in(svg.markup);
  boost::property_tree::ptree tree;
  EXPECT_NO_THROW(boost::property_tree::read_xml(in, tree)) << svg.markup.substr(0, 400);
  for (const char* word : {"=\"nan", "=\"inf", "=\"-inf", "=\"-nan", ",nan", ",inf"})
    EXPECT_EQ(svg.markup.find(word), std::string::npos) << word;
}

LinePlot plot_of(std::span<const double> x, std::span<const double> y) {
  LinePlot plot;
  plot.title = "a < b & \"c\"";
  plot.curves = {{"<label>", x, y}};
  plot.zero_line = true;
  return plot;
}

TEST(LinePlot, AnyDataGivesWellFormedMarkup) {
  const std::vector<double> x{0.0, 1.0, 2.0};
  const std::vector<std::vector<double>> signals{{},
                                                 {1.0},
                                                 {0.0, 0.0, 0.0},
                                                 {5.0, 5.0, 5.0},
                                                 {kNan, kNan, kNan},
                                                 {kInf, -kInf, 1.0},
                                                 {-1.7e308, 1.7e308, 0.0},
                                                 {1e-320, 2e-320, 0.0},
                                                 {1.0, 1.0 + 1e-15, 1.0}};
  for (const std::vector<double>& y : signals) {
    for (const bool log_y : {false, true}) {
      LinePlot plot = plot_of(x, y);
      plot.log_y = log_y;
      plot.band = {-kInf, kNan};
      plot.shaded = {{kNan, 1.0}, {0.5, 0.6}, {-9.0, 99.0}};
      expect_well_formed(to_svg(plot));
    }
  }
  expect_well_formed(to_svg(LinePlot{}));
}

TEST(LinePlot, TimeThatIsNotFiniteIsLeftOut) {
  const std::vector<double> x{kNan, kInf, 1.0}, y{1.0, 2.0, 3.0};
  expect_well_formed(to_svg(plot_of(x, y)));
}

TEST(LinePlot, HasTitleAndDescription) {
  const std::string markup = to_svg(plot_of({}, {})).markup;
  EXPECT_NE(markup.find("role=\"img\""), std::string::npos);
  EXPECT_NE(markup.find("<title>a &lt; b &amp; &quot;c&quot;</title>"), std::string::npos);
}

TEST(LinePlot, LongSignalsStaySmall) {
  std::vector<double> x(1'000'000), y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1e-3 * static_cast<double>(i), y[i] = std::sin(17.0 * x[i]);
  EXPECT_LT(to_svg(plot_of(x, y)).markup.size(), 40'000u);
}

TEST(LinePlot, MissingSamplesBreakTheLine) {
  const std::vector<double> x{0.0, 1.0, 2.0, 3.0, 4.0}, y{1.0, 2.0, kNan, 2.0, 1.0};
  const std::string markup = to_svg(plot_of(x, y)).markup;
  const std::string path = markup.substr(markup.find("<path d=\""), 200);
  EXPECT_EQ(std::count(path.begin(), path.begin() + static_cast<long>(path.find("fill")), 'M'), 2);
}

TEST(Decimate, KeepsEveryPeak) {
  std::vector<double> y(100'000, 0.0);
  y[54'321] = 1.0;
  y[77'777] = -1.0;
  const std::vector<std::size_t> kept = decimate(y);
  EXPECT_LE(kept.size(), kMostPoints);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  EXPECT_NE(std::find(kept.begin(), kept.end(), 54'321u), kept.end());
  EXPECT_NE(std::find(kept.begin(), kept.end(), 77'777u), kept.end());
}

TEST(Decimate, ShortSignalsAreKeptWhole) {
  const std::vector<double> y(kMostPoints, 1.0);
  EXPECT_EQ(decimate(y).size(), y.size());
}

TEST(MakeAxis, TicksAreNiceNumbers) {
  const Axis1d axis = make_axis(0.03, 0.97, 5, false);
  EXPECT_DOUBLE_EQ(axis.low, 0.0);
  EXPECT_DOUBLE_EQ(axis.high, 1.0);
  EXPECT_EQ(axis.labels, (std::vector<std::string>{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"}));
}

TEST(MakeAxis, SmallNumbersShareAnExponent) {
  const Axis1d axis = make_axis(-0.004, 0.004, 4, false);
  EXPECT_EQ(axis.exponent, -3);
  EXPECT_EQ(axis.labels, (std::vector<std::string>{"-4", "-2", "0", "2", "4"}));
}

TEST(MakeAxis, AnyRangeGivesAnAxis) {
  const double sizes[] = {0.0, 1.0, -1.0, 1e-310, 1e300, -1.7e308, 1.7e308, kNan, kInf, -kInf};
  for (const double low : sizes) {
    for (const double high : sizes) {
      for (const bool tight : {false, true}) {
        const Axis1d axis = make_axis(low, high, 5, tight);
        EXPECT_TRUE(std::isfinite(axis.low) && std::isfinite(axis.high) && axis.low < axis.high) << low << " " << high;
        EXPECT_LT(axis.ticks.size(), 65u);
        EXPECT_EQ(axis.ticks.size(), axis.labels.size());
      }
    }
  }
}

TEST(BarChart, AnyDataGivesWellFormedMarkup) {
  BarChart chart;
  expect_well_formed(to_svg(chart));
  chart.bars = {{"<a>", kNan, kNan, "", true}, {"b", kInf, 1.0, "", false}, {"c", 0.0, kInf, "", false}};
  expect_well_formed(to_svg(chart));
  chart.bars = {{std::string(300, 'x'), 12.0, 3.0, "12 \u00b1 3", true}, {"b", -4.0, 1.0, "-4 \u00b1 1", false}};
  expect_well_formed(to_svg(chart));
}

}  // namespace
}  // namespace lacuna
