#include "diagnosis/resemblance.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "scenarios/learned_entry.h"

namespace lacuna {
namespace {

constexpr double kSimpler = 0.02;     ///< share of the curve for which a law with one number more is not preferred
constexpr double kAlike = 0.8;        ///< share of the curve from which a law is named
constexpr double kParity = 0.9;       ///< share of the curve from which it is called even or odd
constexpr double kFewestKnots = 4.0;  ///< a period must have, to be one
constexpr double kFewestPeriods = 2.0;
constexpr double kVague = 0.25;       ///< of its height: a band so wide asks for another recording
constexpr double kOffMiddle = 0.25;   ///< of its height: by so much its middle is off 0 where that is said
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
    const auto& p = law.curve[k];
    const double width = 0.5 * (p.upper95 - p.lower95);
    out.x(k) = p.at, out.y(k) = p.value;
    out.weight(k) = std::isfinite(width) ? 1.0 / (width * width + 1e-4 * height * height + 1e-300) : 0.0;
  }
  return out;
}

/// What columns leave of the curve, each point counting by its weight.
double left_by(const Points& p, const std::vector<Eigen::ArrayXd>& columns) {
  const Eigen::ArrayXd root = p.weight.sqrt();
  Eigen::MatrixXd A(p.x.size(), static_cast<Eigen::Index>(columns.size()) + 1);
  A.col(0) = root.matrix();
  for (std::size_t k = 0; k < columns.size(); ++k)
    A.col(static_cast<Eigen::Index>(k) + 1) = (root * columns[k]).matrix();
  const Eigen::VectorXd y = (root * p.y).matrix();
  return (y - A * A.colPivHouseholderQr().solve(y)).squaredNorm();
}

/// Share of the curve that columns explain, of what `known` and a constant leave of it.
double share_of(const Points& p, const std::vector<Eigen::ArrayXd>& known, std::vector<Eigen::ArrayXd> columns) {
  const double all = left_by(p, known);
  if (!(all > kRoundings * (p.weight * p.y.square()).sum())) return 0.0;
  columns.insert(columns.end(), known.begin(), known.end());
  return 1.0 - left_by(p, columns) / all;
}

/// What textbooks tell apart.
enum class Over { position, speed, command, reading };
Over kind_of(const LearnedLaw& law) {
  if (law.stage == Stage::command) return Over::command;
  if (law.stage == Stage::reading) return Over::reading;
  return variable_named(law.over.front().name).quantity == "speed" ? Over::speed : Over::position;
}

/// A textbook law: its columns at a shape of its own in (0, 1), and how many numbers it has.
struct Textbook {
  const char* name;
  Over over;
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

/// One place at which the command does more or less; `width` of the range.
Textbook notch(double width) {
  return {"a notch", Over::command, 3, [width](const Eigen::ArrayXd& x, double shape) {
            const double range = x.maxCoeff() - x.minCoeff();
            const Eigen::ArrayXd away = (x - edge_of(x, shape)) / (width * range);
            return std::vector<Eigen::ArrayXd>{(-away.square()).exp()};
          }};
}

const std::vector<Textbook>& textbook() {
  using Columns = std::vector<Eigen::ArrayXd>;
  static const std::vector<Textbook> laws{
      {"a spring", Over::position, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x}; }},
      {"a hardening spring", Over::position, 2,
       [](const Eigen::ArrayXd& x, double) {
         return Columns{x, x.cube()};
       }},
      {"a weight on a lever", Over::position, 2,
       [](const Eigen::ArrayXd& x, double) {
         return Columns{x.sin(), x.cos()};
       }},
      {"a stop or a spring with slack", Over::position, 2,
       [](const Eigen::ArrayXd& x, double shape) { return Columns{(x - edge_of(x, shape)).max(0.0)}; }},
      {"gear ripple", Over::position, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         const Eigen::ArrayXd phase = 2.0 * std::numbers::pi / period_of(x, shape) * x;
         return Columns{phase.sin(), phase.cos()};
       }},
      {"viscous friction", Over::speed, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x}; }},
      {"quadratic damping", Over::speed, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x * x.abs()}; }},
      {"Coulomb friction", Over::speed, 2,
       [](const Eigen::ArrayXd& x, double shape) { return Columns{(x / (0.2 * shape * reach(x) + 1e-12)).tanh()}; }},
      {"Coulomb and viscous friction", Over::speed, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         return Columns{(x / (0.2 * shape * reach(x) + 1e-12)).tanh(), x};
       }},
      {"Stribeck friction", Over::speed, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         const Eigen::ArrayXd way = (x / (0.02 * reach(x) + 1e-12)).tanh(), ratio = x / (shape * reach(x) + 1e-12);
         return Columns{way, way * (-ratio.square()).exp()};
       }},
      {"one direction weaker", Over::command, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x.abs()}; }},
      {"a dead zone", Over::command, 2,
       [](const Eigen::ArrayXd& x, double shape) {
         const double edge = shape * reach(x);
         return Columns{x.max(-edge).min(edge)};
       }},
      {"a saturation", Over::command, 2,
       [](const Eigen::ArrayXd& x, double shape) { return Columns{x.sign() * (x.abs() - shape * reach(x)).max(0.0)}; }},
      {"a gain that grows with the command", Over::command, 2,
       [](const Eigen::ArrayXd& x, double) {
         return Columns{x * x.abs(), x.cube()};
       }},
      notch(0.05),
      notch(0.1),
      notch(0.2),
      {"an error of scale", Over::reading, 1, [](const Eigen::ArrayXd& x, double) { return Columns{x}; }},
      {"an eccentric ring", Over::reading, 2,
       [](const Eigen::ArrayXd& x, double) {
         return Columns{x.sin(), x.cos()};
       }},
      {"an error that repeats itself", Over::reading, 3,
       [](const Eigen::ArrayXd& x, double shape) {
         const Eigen::ArrayXd phase = 2.0 * std::numbers::pi / period_of(x, shape) * x;
         return Columns{phase.sin(), phase.cos()};
       }},
  };
  return laws;
}

struct Match {
  const Textbook* law = nullptr;
  double share = 0.0, shape = 0.5;
};

Match nearest(const Points& p, Over over) {
  Match best;
  // A command's own gain was fitted beside what is added to it.
  const std::vector<Eigen::ArrayXd> known = over == Over::command ? std::vector{p.x} : std::vector<Eigen::ArrayXd>{};
  for (const Textbook& law : textbook()) {
    if (law.over != over) continue;
    Match here{&law, -HUGE_VAL, 0.5};
    for (int k = 0; k < kShapes; ++k) {
      const double shape = (k + 0.5) / kShapes, share = share_of(p, known, law.columns(p.x, shape));
      if (share > here.share) here.share = share, here.shape = shape;
    }
    const double handicap = best.law == nullptr ? 0.0 : kSimpler * (law.numbers - best.law->numbers);
    if (best.law == nullptr || here.share > best.share + handicap) best = here;
  }
  return best;
}

/// Share of the curve that is even (or odd) about zero, where it was seen on both sides; nothing elsewhere.
std::optional<double> parity_share(const LearnedLaw& law, double sign) {
  const double from = law.over.front().from, to = law.over.front().to;
  const auto at = [&](double x) {
    const double k = (x - from) / (to - from) * static_cast<double>(law.curve.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(std::max(k, 0.0)), law.curve.size() - 2);
    const double s = k - static_cast<double>(i);
    return law.curve[i].value + s * (law.curve[i + 1].value - law.curve[i].value);
  };
  const double both = std::min(-from, to);
  if (!(both > 0.3 * std::max(-from, to))) return std::nullopt;
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
  if (law.period > 0.0) add(fmt::format("repeats every {:.3g} {}", law.period, law.over.front().unit));
  const auto even = parity_share(law, 1.0), odd = parity_share(law, -1.0);
  if (even && *even > kParity) add("the same in either direction");
  if (odd && *odd > kParity) add("turns with the sign");
  if (law.period <= 0.0) add(is_monotone(law) ? "rises or falls throughout" : "rises and falls");
  return out;
}

/// "its position", "the speed of elbow".
std::string words_of(const LearnedLaw::Variable& variable) {
  const VariableName name = variable_named(variable.name);
  if (!name.joint.empty()) return fmt::format("the {} of {}", name.quantity, name.joint);
  return name.quantity == "time" ? "the time of the session" : "its " + name.quantity;
}

/// What is there, and what it depends on.
std::string subject(const LearnedLaw& law) {
  std::string on = words_of(law.over.front());
  if (law.over.size() > 1)
    on += law.over[1].knots == 2 ? " and on which way it moves" : " and on " + words_of(law.over[1]);
  switch (law.stage) {
    case Stage::command: return fmt::format("the command of {} arrives changed by what depends on {}", law.place, on);
    case Stage::reading: return fmt::format("the position of {} is read wrong by what depends on {}", law.place, on);
    default:
      return fmt::format("{} lacks {} that depends on {}", law.place, law.unit == "N" ? "a force" : "a torque", on);
  }
}

Eigen::MatrixXd table_of(const LearnedLaw& law) {
  const auto columns = static_cast<Eigen::Index>(law.over[1].knots);
  Eigen::MatrixXd out(static_cast<Eigen::Index>(law.curve.size()) / columns, columns);
  for (Eigen::Index k = 0; k < out.size(); ++k) out(k / columns, k % columns) = law.curve[k].value;
  return out;
}

/// "4.2 N to either side of its middle", and where that lies: a constant part may be an offset of its own.
std::string size_words(const LearnedLaw& law) {
  const auto [low, high] = std::ranges::minmax(law.curve, {}, &LearnedLaw::Point::value);
  const double middle = 0.5 * (low.value + high.value);
  std::string out = fmt::format("{:.3g} {} to either side of its middle", law.height, law.unit);
  if (std::fabs(middle) > kOffMiddle * law.height) out += fmt::format(" at {:.3g} {}", middle, law.unit);
  return out;
}

/// Of a law whose two branches are the two ways in which the joint moves: what turns with the way is friction, the
/// rest a curve over the position.
void describe_branches(LearnedLaw& law) {
  const Eigen::MatrixXd table = table_of(law);
  const Eigen::ArrayXd friction = 0.5 * (table.col(0) - table.col(1)).array(),
                       both = 0.5 * table.rowwise().sum().array();
  const double turns = friction.square().sum(), stays = (both - both.mean()).square().sum();
  law.share = turns + stays > 0.0 ? turns / (turns + stays) : 0.0;
  law.resembles = "friction that depends on the position";
  const char* loop = law.share > 1.0 - kParity ? "a loop, so dry friction or a memory" : "all but alike either way";
  law.description = fmt::format("{}: {}, {}; {} {} ({:.0f} % of it), from {:.3g} to {:.3g} {}", subject(law),
                                size_words(law), loop, law.share > kAlike ? "like" : "no textbook law, nearest is",
                                law.resembles, 100.0 * law.share, friction.minCoeff(), friction.maxCoeff(), law.unit);
}

/// Of a map: whether it is one law of either variable side by side, or one times the other.
void describe_map(LearnedLaw& law) {
  const Eigen::MatrixXd table = table_of(law);
  const Eigen::MatrixXd centred = table.array() - table.mean();
  const double all = centred.squaredNorm();
  const Eigen::VectorXd rows = centred.rowwise().mean();
  const Eigen::RowVectorXd columns = centred.colwise().mean();
  const double apart = (centred.colwise() - rows).rowwise().operator-(columns).squaredNorm();
  const Eigen::VectorXd sizes = table.jacobiSvd().singularValues();
  const double product = 1.0 - sizes.tail(sizes.size() - 1).squaredNorm() / std::max(sizes.squaredNorm(), 1e-300);
  const double sum = all > 0.0 ? 1.0 - apart / all : 0.0;
  law.share = std::max(sum, product);
  law.resembles = product > sum + kSimpler ? "the product of a law of either" : "two laws side by side, one of either";
  law.description =
      fmt::format("{}: {}; {} {} ({:.0f} % of it)", subject(law), size_words(law),
                  law.share > kAlike ? "like" : "no textbook law, nearest is", law.resembles, 100.0 * law.share);
}

void describe_one(LearnedLaw& law) {
  const Match match = nearest(points_of(law), kind_of(law));
  law.resembles = match.law->name, law.share = std::clamp(match.share, 0.0, 1.0);
  law.description =
      fmt::format("{}: {}, {}; {} {} ({:.0f} % of the curve)", subject(law), size_words(law), shape_words(law),
                  law.share > kAlike ? "like" : "no textbook law, nearest is", law.resembles, 100.0 * law.share);
}

/// Where least is known of the law, beside its height.
std::string more_to_measure(const LearnedLaw& law) {
  const auto widest = std::ranges::max_element(
      law.curve, {}, [](const LearnedLaw::Point& p) { return std::isfinite(p.upper95) ? p.upper95 - p.lower95 : 0.0; });
  const double band = 0.5 * (widest->upper95 - widest->lower95);
  if (!(band > kVague * law.height)) return {};
  const LearnedLaw::Variable& over = law.over.front();
  std::string out = fmt::format("Least is known of it where {} is {:.3g} {}", words_of(over), widest->at, over.unit);
  if (law.over.size() > 1 && law.over[1].knots > 2)
    out += fmt::format(" and {} {:.3g} {}", words_of(law.over[1]), widest->beside, law.over[1].unit);
  return out + fmt::format(" (within {:.2g} {}): a recording that goes there slowly, both ways, would tell more", band,
                           law.unit);
}

}  // namespace

void describe_curve(LearnedLaw& law) {
  law.resembles.clear(), law.description.clear(), law.tells_more.clear();
  law.share = law.height = 0.0;
  if (law.curve.size() < 4) return;
  const auto [least, most] = std::ranges::minmax_element(law.curve, {}, &LearnedLaw::Point::value);
  law.height = 0.5 * (most->value - least->value);
  if (law.over.size() < 2)
    describe_one(law);
  else if (law.over[1].knots == 2)
    describe_branches(law);
  else
    describe_map(law);
  law.tells_more = more_to_measure(law);
}

}  // namespace lacuna
