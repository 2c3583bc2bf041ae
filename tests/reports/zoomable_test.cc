#include "reports/zoomable.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/marks.h"
#include "reports/packed.h"
#include "tests/reports/sample.h"

namespace lacuna {
namespace {

using Record = nlohmann::ordered_json;
using sample::kInf;
using sample::kNan;

/// As reports/page/data.js does it.
std::vector<double> unpacked(const Record& packed) {
  std::vector<double> out;
  double sum = 0.0;
  for (const Record& v : packed.is_array() ? packed : packed["d"]) {
    if (v.is_null())
      out.push_back(kNan);
    else
      out.push_back(packed.is_array()
                        ? v.get<double>()
                        : packed["from"].get<double>() + packed["step"].get<double>() * (sum += v.get<double>()));
  }
  return out;
}

Record data_in(const Html& html, const std::string& style = "plot-data") {
  const std::string open = "<script type=\"application/json\" class=\"" + style + "\">";
  const std::size_t at = html.markup.find(open);
  if (at == std::string::npos) return nullptr;
  const std::size_t begin = at + open.size();
  return Record::parse(html.markup.substr(begin, html.markup.find('<', begin) - begin));
}

LinePlot one_curve(std::span<const double> x, std::span<const double> y) {
  LinePlot plot;
  plot.curves = {{"label", x, y}};
  return plot;
}

TEST(Packed, ComesBackToAHundredThousandthOfItsRange) {
  std::vector<double> values;
  for (int i = 0; i < 3000; ++i) values.push_back(i % 100 == 7 ? kNan : 1e4 + 0.3 * std::sin(0.01 * i));
  const std::vector<double> back = unpacked(packed(values));
  ASSERT_EQ(back.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]))
      EXPECT_TRUE(std::isnan(back[i])) << i;
    else
      EXPECT_NEAR(back[i], values[i], 0.6e-5 * 0.6) << i;
  }
}

TEST(Packed, IsShort) {
  std::vector<double> values;
  for (int i = 0; i < 3000; ++i) values.push_back(std::sin(0.01 * i));
  EXPECT_LT(packed(values).dump().size(), 5u * values.size());
}

TEST(Packed, TakesAnyNumbers) {
  for (const double extreme : {1.7e308, 1e-320, kInf, kNan, 0.0}) {
    std::vector<double> values(300, extreme);
    values[7] = -extreme;
    const std::string text = packed(values).dump();
    EXPECT_EQ(text.find("inf"), std::string::npos);
    EXPECT_EQ(unpacked(Record::parse(text)).size(), values.size());
  }
  EXPECT_TRUE(packed({}).empty());
}

TEST(Zoomable, KeepsTheDrawingAndEveryPeak) {
  std::vector<double> x(100'000), y(x.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1e-3 * static_cast<double>(i);
  y[54'321] = 1.0;
  const Html html = zoomable(one_curve(x, y));
  EXPECT_NE(html.markup.find("<svg"), std::string::npos);
  const Record data = data_in(html);
  const std::vector<double> kept = unpacked(data["blocks"][0]["curves"][0]["y"]);
  EXPECT_LE(kept.size(), kMostRows);
  EXPECT_NEAR(*std::max_element(kept.begin(), kept.end()), 1.0, 1e-5);
}

TEST(Zoomable, CurvesOfOneTimeBaseShareItsInstants) {
  std::vector<double> x(10'000), y(x.size()), z(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = 1e-3 * static_cast<double>(i), y[i] = std::sin(x[i]), z[i] = std::cos(9.0 * x[i]);
  LinePlot plot = one_curve(x, y);
  plot.curves.push_back({"other", x, z});
  const Record data = data_in(zoomable(plot));
  ASSERT_EQ(data["blocks"].size(), 1u);
  const Record& block = data["blocks"][0];
  EXPECT_EQ(unpacked(block["x"]).size(), unpacked(block["curves"][1]["y"]).size());
  EXPECT_LE(unpacked(block["x"]).size(), kMostRows);
}

TEST(Zoomable, ALineThatTurnsBackStaysADrawing) {
  const std::vector<double> x{0.0, 1.0, 0.5}, y{0.0, 1.0, 2.0};
  const std::string markup = zoomable(one_curve(x, y)).markup;
  EXPECT_EQ(markup.find("<script"), std::string::npos);
  EXPECT_NE(markup.find("<svg"), std::string::npos);
}

TEST(Zoomable, NothingToDrawStaysADrawing) {
  const std::vector<double> x{1.0, 2.0, 3.0}, zero(3, 0.0), none(3, kNan);
  LinePlot logarithmic = one_curve(x, zero);
  EXPECT_NE(zoomable(logarithmic).markup.find("<script"), std::string::npos);
  logarithmic.log_y = true;
  EXPECT_EQ(zoomable(logarithmic).markup.find("<script"), std::string::npos);
  EXPECT_EQ(zoomable(one_curve(x, none)).markup.find("<script"), std::string::npos);
}

TEST(Zoomable, LogarithmicValuesKeepTheirSixDigits) {
  std::vector<double> x(500), y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i), y[i] = std::pow(10.0, -0.02 * x[i]);
  LinePlot plot = one_curve(x, y);
  plot.log_y = true;
  const std::vector<double> back = unpacked(data_in(zoomable(plot))["blocks"][0]["curves"][0]["y"]);
  for (std::size_t i = 0; i < y.size(); ++i) EXPECT_NEAR(back[i] / y[i], 1.0, 1e-5) << i;
}

TEST(Zoomable, NamesCannotEndTheDatasElement) {
  const std::vector<double> x{0.0, 1.0}, y{0.0, 1.0};
  const std::string attack = "</script><!--<script>&\xff";
  LinePlot plot = one_curve(x, y);
  plot.curves.front().label = plot.y_label = plot.joint = plot.recording = plot.title = attack;
  const Html html = zoomable(plot);
  const Record data = data_in(html);
  EXPECT_EQ(data["joint"], "</script><!--<script>&\ufffd");
  EXPECT_EQ(html.markup.find("<!--"), std::string::npos);
}

TEST(Marks, SayWhereAndWhen) {
  Marks marks;
  EXPECT_TRUE(marks.data().markup.empty());
  EXPECT_EQ(marks.add("joint_1", {{"a.csv", 1.0, 2.0}}), "mark mark-0");
  EXPECT_EQ(marks.add("</script>", {}), "mark mark-1");
  const Record data = data_in(marks.data(), "marks-data");
  EXPECT_EQ(data[0]["times"][0], Record::parse(R"(["a.csv", 1.0, 2.0])"));
  EXPECT_EQ(data[1]["joint"], "</script>");
}

}  // namespace
}  // namespace lacuna
