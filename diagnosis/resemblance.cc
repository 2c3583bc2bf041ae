#include "diagnosis/resemblance.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace lacuna {
namespace {

constexpr double kSimpler = 0.02;     ///< share of the curve for which a law with one number more is not preferred
constexpr double kAlike = 0.8;        ///< share of the curve from which a law is named
constexpr double kParity = 0.9;       ///< share of the curve from which it is called even or odd
constexpr double kFewestKnots = 4.0;  ///< a period must have, to be one
constexpr double kFewestPeriods = 2.0;
constexpr double kRoundings = 1e-20;  ///< of what there is: nothing varies
constexpr int kShapes = 360;          ///< values of a law's own shape that are tried

/// The curve's points, each counting by how well it is known.
struct Points {
  Eigen::ArrayXd x, y, weight;
};
Points points_of(const LearnedLaw& law) {
  const auto n = static_cast<Eigen::Index>(law.curve.size());
  Points out{Eigen::ArrayXd(n), Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
  double height = 0.0;
  for (const auto& p : law.curve) height = std::max(height, std::fabs(p.value));
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& p = law.curve[static_cast<std::size_t>(k)];
    const double width = 0.5 * (p.upper95 - p.lower95);
    out.x(k) = p.at, out.y(k) = p.value;
    out.weight(k) = std::isfinite(width) ? 1.0 / (width * width + 1e-4 * height * height + 1e-300) : 0.0;
  }
  return out;
}

/// Share of the curve's variance about its mean that columns explain, a constant beside them.
double share_of(const Points& p, const std::vector<Eigen::ArrayXd>& columns) {
  const Eigen::ArrayXd root = p.weight.sqrt();
  const double mean = (p.weight * p.y).sum() / std::max(p.weight.sum(), 1e-300);
  const double all = (p.weight * (p.y - mean).square()).sum();
  if (!(all > kRoundings * (p.weight * p.y.square()).sum())) return 0.0;
  Eigen::MatrixXd A(p.x.size(), static_cast<Eigen::Index>(columns.size()) + 1);
  A.col(0) = root.matrix();
  for (std::size_t k = 0; k < columns.size(); ++k)
    A.col(static_cast<Eigen::Index>(k) + 1) = (root * columns[k]).matrix();
  const Eigen::VectorXd y = (root * p.y).matrix();
  const Eigen::VectorXd c = A.colPivHouseholderQr().solve(y);
  return 1.0 - (y - A * c).squaredNorm() / all;
}

/// A textbook law: its columns at a shape of its own in (0, 1), and how many numbers it has.
struct Textbook {
  const char* name;
  bool over_speed;
  int numbers;
  std::function<std::vector<Eigen::ArrayXd>(const Eigen::ArrayXd& x, double shape)> columns;
};

double reach(const Eigen::ArrayXd& x) { return x.abs().maxCoeff(); }
/// Evenly in the number of periods over the range, so that neighbours shift by as much all over it.
double period_of(const Eigen::ArrayXd& x, double shape) {
  const double range = x.maxCoeff() - x.minCoeff(), most = static_cast<double>(x.size() - 1) / kFewestKnots;
  return range / (kFewestPeriods + shape * std::max(most - kFewestPeriods, 0.0));
}
double edge_of(const Eigen::ArrayXd& x, double shape) { return x.minCoeff() + shape * (x.maxCoeff() - x.minCoeff()); }

const std::vector<Textbook>& textbook() {
  using Columns = std::vector<Eigen::ArrayXd>;
  static const std::vector<Textbook> laws{
      {"a spring", false, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x}; }},
      {"a hardening spring", false, 2,
       [](const Eigen::ArrayXd& x, double) {
         return Columns{x, x.cube()};
       }},
      {"a weight on a lever", false, 2,
       [](const Eigen::ArrayXd& x, double) {
         return Columns{x.sin(), x.cos()};
       }},
      {"a stop or a spring with slack", false, 2,
       [](const Eigen::ArrayXd& x, double shape) { return Columns{(x - edge_of(x, shape)).max(0.0)}; }},
      {"gear ripple", false, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         const Eigen::ArrayXd phase = 2.0 * std::numbers::pi / period_of(x, shape) * x;
         return Columns{phase.sin(), phase.cos()};
       }},
      {"viscous friction", true, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x}; }},
      {"quadratic damping", true, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x * x.abs()}; }},
      {"Coulomb friction", true, 2,
       [](const Eigen::ArrayXd& x, double shape) { return Columns{(x / (0.2 * shape * reach(x) + 1e-12)).tanh()}; }},
      {"Coulomb and viscous friction", true, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         return Columns{(x / (0.2 * shape * reach(x) + 1e-12)).tanh(), x};
       }},
      {"Stribeck friction", true, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         const Eigen::ArrayXd way = (x / (0.02 * reach(x) + 1e-12)).tanh(), ratio = x / (shape * reach(x) + 1e-12);
         return Columns{way, way * (-ratio.square()).exp()};
       }},
  };
  return laws;
}

struct Match {
  const Textbook* law = nullptr;
  double share = 0.0, shape = 0.5;
};

Match nearest(const Points& p, bool over_speed) {
  Match best;
  for (const Textbook& law : textbook()) {
    if (law.over_speed != over_speed) continue;
    Match here{&law, -HUGE_VAL, 0.5};
    for (int k = 0; k < kShapes; ++k) {
      const double shape = (k + 0.5) / kShapes, share = share_of(p, law.columns(p.x, shape));
      if (share > here.share) here.share = share, here.shape = shape;
    }
    const double handicap = best.law == nullptr ? 0.0 : kSimpler * (law.numbers - best.law->numbers);
    if (best.law == nullptr || here.share > best.share + handicap) best = here;
  }
  return best;
}

/// Share of the curve that is even (or odd) about zero, where it was seen on both sides; nothing elsewhere.
std::optional<double> parity_share(const LearnedLaw& law, double sign) {
  const auto at = [&](double x) {
    const double k = (x - law.from) / (law.to - law.from) * static_cast<double>(law.curve.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(std::max(k, 0.0)), law.curve.size() - 2);
    const double s = k - static_cast<double>(i);
    return law.curve[i].value + s * (law.curve[i + 1].value - law.curve[i].value);
  };
  const double both = std::min(-law.from, law.to);
  if (!(both > 0.3 * std::max(-law.from, law.to))) return std::nullopt;
  double part = 0.0, all = 0.0;
  for (int k = 0; k < kShapes; ++k) {
    const double x = both * (k + 0.5) / kShapes, up = at(x), down = at(-x);
    part += std::pow(0.5 * (up + sign * down), 2);
    all += 0.5 * (up * up + down * down);
  }
  return all > 0.0 ? part / all : 0.0;
}

bool is_monotone(const LearnedLaw& law) {
  bool up = true, down = true;
  for (std::size_t k = 0; k + 1 < law.curve.size(); ++k) {
    up = up && law.curve[k + 1].upper95 >= law.curve[k].lower95;
    down = down && law.curve[k + 1].lower95 <= law.curve[k].upper95;
  }
  return up || down;
}

std::string shape_words(const LearnedLaw& law) {
  std::string out;
  const auto add = [&](const std::string& words) { out += (out.empty() ? "" : ", ") + words; };
  if (law.period > 0.0) add(fmt::format("repeats every {:.3g} {}", law.period, law.way_unit));
  const auto even = parity_share(law, 1.0), odd = parity_share(law, -1.0);
  if (even && *even > kParity) add("the same in either direction");
  if (odd && *odd > kParity) add("turns with the sign");
  if (law.period <= 0.0) add(is_monotone(law) ? "rises or falls throughout" : "rises and falls");
  return out;
}

}  // namespace

void describe_curve(LearnedLaw& law) {
  law.resembles.clear(), law.share = law.height = 0.0;
  if (law.curve.size() < 4) return;
  const Points p = points_of(law);
  const auto [least, most] = std::minmax_element(law.curve.begin(), law.curve.end(),
                                                 [](const auto& a, const auto& b) { return a.value < b.value; });
  law.height = 0.5 * (most->value - least->value);
  const bool over_speed = law.over == "v";
  const Match match = nearest(p, over_speed);
  law.resembles = match.law->name, law.share = std::clamp(match.share, 0.0, 1.0);
  law.description = fmt::format(
      "{} lacks {} that depends on its {}: {:.3g} {} to either side of its middle, {}; {} {} ({:.0f} % of the curve)",
      law.place, law.unit == "N" ? "a force" : "a torque", over_speed ? "speed" : "position", law.height, law.unit,
      shape_words(law), law.share > kAlike ? "like" : "no textbook law, nearest is", law.resembles, 100.0 * law.share);
}

}  // namespace lacuna
