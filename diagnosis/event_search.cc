#include "diagnosis/event_search.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include "diagnosis/baseline.h"
#include "diagnosis/colour.h"
#include "diagnosis/evidence.h"
#include "diagnosis/linear_look.h"
#include "diagnosis/projector.h"

namespace lacuna {
namespace {

constexpr std::size_t kMostEdges = 250;  ///< instants at which a rectangle may begin or end, at first
constexpr std::size_t kFewestEdges = 30;
constexpr std::size_t kMostNumbers = 32u << 20;  ///< in what the rectangles of one segment change, at once
constexpr double kLongest = 0.25;                ///< of the recording: what lasts longer is no event
constexpr std::size_t kMost = 8;                 ///< in one segment
constexpr double kMostOfIt = 0.5;        ///< of what a segment leaves beyond the noise, that its events take away
constexpr int kEdgeSteps = 2;            ///< either way that an edge is moved at a time
constexpr double kFewestInPiece = 16.0;  ///< samples
constexpr double kFinest = 0.25;         ///< samples, to which an effort's edges are found

Eigen::MatrixXd row_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::RowVectorXd>(values.data(), values.size());
}

/// All rectangles of one kind at one joint of a segment: columns `steps` are what there is from the start to each edge,
/// on the segment's own rows; `gram` of what the parameters leave of them.
struct Offer {
  EventSpec::Kind kind = EventSpec::Kind::effort;
  int joint = 0;
  std::vector<double> edges;  ///< s
  Eigen::MatrixXd steps, gram;

  /// A slip of a transducer may last to the end.
  bool is_short(Eigen::Index from, Eigen::Index to) const {
    if (static_cast<double>(to - from) <= kLongest * static_cast<double>(edges.size() - 1)) return true;
    return kind == EventSpec::Kind::reading && from > 0;
  }
};

/// One segment's share of the rows.
struct EventPart {
  int segment = 0;
  Eigen::Index first = 0, count = 0;
  int look = -1;  ///< among the segments that are linearised; -1: it leaves no more than usual
};

/// Pieces of a second or so.
std::vector<ResidualBlock> pieces_of(const std::vector<ResidualBlock>& blocks, double sample_period) {
  const auto length = static_cast<Eigen::Index>(std::max(kFewestInPiece, 1.0 / sample_period));
  std::vector<ResidualBlock> out;
  for (const ResidualBlock& b : blocks) {
    const Eigen::Index many = std::max<Eigen::Index>(1, b.count / length);
    for (Eigen::Index k = 0; k < many; ++k) {
      const Eigen::Index first = k * b.count / many, end = (k + 1) * b.count / many;
      out.push_back({b.segment, b.channel, b.first + first, end - first});
    }
  }
  return out;
}

/// What a channel usually leaves: rms, and the samples over which that forgets itself.
struct Usual {
  double level = 0.0, memory = 1.0;
};
/// From the quieter half of each channel's pieces, so that what happens now and then has no share in it, but not below
/// the noise. [channel]
std::vector<Usual> usual_rest(const Eigen::VectorXd& rest, const std::vector<ResidualBlock>& blocks,
                              const std::vector<double>& noise, double sample_period) {
  const std::vector<ResidualBlock> pieces = pieces_of(blocks, sample_period);
  const auto power = [&](const ResidualBlock& b) {
    return rest.segment(b.first, b.count).squaredNorm() / static_cast<double>(b.count);
  };
  std::vector<Usual> out(noise.size());
  for (std::size_t c = 0; c < noise.size(); ++c) {
    std::vector<ResidualBlock> own;
    for (const ResidualBlock& b : pieces)
      if (b.channel == static_cast<int>(c) && b.count > 0) own.push_back(b);
    if (own.empty()) continue;
    std::ranges::stable_sort(own, {}, power);
    own.resize((own.size() + 1) / 2);
    const double usual = std::sqrt(power(own.back()));
    out[c].level = noise[c] > 0.0 ? std::max(noise[c], usual) : usual;
    out[c].memory = Colour(rest, own, noise).correlation_samples(static_cast<int>(c));
  }
  return out;
}

/// Segments under one model: what they leave and what rectangles would change of that, in units in which half of the
/// energy is log-likelihood: of the noise, or what the channel usually leaves where that is unknown.
class EventView {
 public:
  EventView(const CurrentModel& model, const FitContext& context, const std::vector<int>& segments, bool fitted)
      : experiment_(context.experiment), noise_(noise_over_weight(experiment_, model.weights)) {
    Problem problem = problem_of(model, context);
    blocks_ = problem.layout(segments);
    rest_ = problem.residual(model.fit.point, segments);
    if (!rest_.allFinite()) return;
    const Eigen::MatrixXd& jacobian = model.fit.jacobian;
    if (fitted && jacobian.rows() == rest_.size() && jacobian.allFinite()) jacobian_ = &jacobian;
    recorded_ = rest_;
    std::vector<Usual> usual = usual_rest(recorded_, blocks_, noise_, experiment_.sample_period);
    for (std::size_t c = 0; c < noise_.size(); ++c)
      if (noise_[c] > 0.0) usual[c] = {noise_[c], 1.0};
    set_units(std::move(usual));
    std::vector<int> beyond;
    for (const int segment : segments) {
      add_part(segment);
      // A segment that leaves no more than its noise needs no event.
      if (excess_over_noise(recorded_, blocks_of(segment), noise_).empty()) continue;
      parts_.back().look = static_cast<int>(beyond.size());
      beyond.push_back(segment);
    }
    if (!beyond.empty()) look_ = std::make_shared<const LinearLook>(model, context, beyond);
  }

  /// The same in units of what channels usually leave where `left`, in the present ones, is left.
  EventView in_units_of(Eigen::VectorXd left) const {
    EventView out = *this;
    for (const ResidualBlock& b : blocks_) {
      const Usual& unit = usual_[b.channel];
      left.segment(b.first, b.count) *= unit.level * std::sqrt(unit.memory);
    }
    out.set_units(usual_rest(left, blocks_, noise_, experiment_.sample_period));
    return out;
  }

  bool is_linearised(const EventPart& part) const { return part.look >= 0 && look_->is_linearised(); }
  bool is_usable() const { return rest_.allFinite(); }
  const Eigen::VectorXd& rest() const { return rest_; }
  const std::vector<EventPart>& parts() const { return parts_; }
  const Segment& segment_of(const EventPart& part) const { return experiment_.segments[part.segment]; }
  const EventPart& part_of(int segment) const {
    return *std::ranges::find_if(parts_, [&](const EventPart& p) { return p.segment == segment; });
  }

  /// What a unit event changes, the parameters having taken up what they can.
  Eigen::VectorXd change(const FoundEvent& found) const {
    const EventPart& part = part_of(found.segment);
    return projected(part, own_changes(part, {found.event}));
  }
  /// Energy that each of several events of one kind, joint and segment takes away of `left` at its best size.
  std::vector<double> scores(const std::vector<FoundEvent>& alike, const Eigen::VectorXd& left) const {
    const EventPart& part = part_of(alike.front().segment);
    std::vector<Event> events;
    for (const FoundEvent& one : alike) events.push_back(one.event);
    const Eigen::MatrixXd own = own_changes(part, events);
    const Eigen::MatrixXd taken_up = basis_.middleRows(part.first, part.count).transpose() * own;
    // `left` has no share of what the parameters take up.
    const Eigen::VectorXd along = own.transpose() * left.segment(part.first, part.count);
    std::vector<double> out;
    for (Eigen::Index k = 0; k < own.cols(); ++k) {
      const double energy = own.col(k).squaredNorm() - taken_up.col(k).squaredNorm();
      out.push_back(energy > 0.0 ? along(k) * along(k) / energy : 0.0);
    }
    return out;
  }
  /// Every rectangle in one segment.
  std::vector<Offer> offers_in(const EventPart& part) const {
    std::vector<Offer> out;
    if (!is_linearised(part)) return out;
    for (int j = 0; j < std::ssize(experiment_.joint_names); ++j) {
      out.push_back(offered(part, EventSpec::Kind::effort, j));
      if (is_read(j)) out.push_back(offered(part, EventSpec::Kind::reading, j));
    }
    std::erase_if(out, [](const Offer& offer) { return !offer.steps.allFinite(); });
    return out;
  }
  /// How many edges rectangles in a segment have at first.
  std::size_t edges_in(const EventPart& part) const {
    const std::size_t fit = kMostNumbers / std::max<std::size_t>(1, kinds() * static_cast<std::size_t>(part.count));
    return std::min({segment_of(part).count, kMostEdges, std::max(kFewestEdges, fit)});
  }
  /// Rectangles that are offered.
  double tried() const {
    double out = 0.0;
    for (const EventPart& part : parts_)
      if (is_linearised(part)) out += static_cast<double>(kinds()) * kLongest * std::pow(edges_in(part), 2);
    return std::max(out, 1.0);
  }

  /// Log-likelihood below which a rectangle is made up: what all that were offered would reach by chance, and more.
  double threshold() const {
    return kWorthLearning + std::log(tried()) + 0.5 * std::log(std::max(static_cast<double>(rest_.size()), 1.0));
  }
  /// Energy that a part usually leaves.
  double usual(const EventPart& part) const {
    double out = 0.0;
    for (const ResidualBlock& b : blocks_)
      if (b.segment == part.segment) out += static_cast<double>(b.count) / usual_[b.channel].memory;
    return out;
  }

 private:
  void set_units(std::vector<Usual> usual) {
    usual_ = std::move(usual);
    rest_ = recorded_;
    in_units(rest_, blocks_);
    basis_.resize(rest_.size(), 0);
    if (jacobian_ != nullptr) {
      Eigen::MatrixXd jacobian = *jacobian_;
      in_units(jacobian, blocks_);
      basis_ = Projector(jacobian).basis();
    }
    rest_ -= basis_ * (basis_.transpose() * rest_);
  }
  void add_part(int segment) {
    EventPart part{segment, rest_.size(), 0, -1};
    for (const ResidualBlock& b : blocks_of(segment)) part.first = std::min(part.first, b.first), part.count += b.count;
    parts_.push_back(std::move(part));
  }
  void in_units(Eigen::Ref<Eigen::MatrixXd> rows, const std::vector<ResidualBlock>& blocks) const {
    for (const ResidualBlock& b : blocks) {
      const Usual& usual = usual_[b.channel];
      rows.middleRows(b.first, b.count) *= usual.level > 0.0 ? 1.0 / (usual.level * std::sqrt(usual.memory)) : 0.0;
    }
  }
  std::vector<ResidualBlock> blocks_of(int segment) const {
    std::vector<ResidualBlock> out;
    for (const ResidualBlock& b : blocks_)
      if (b.segment == segment) out.push_back(b);
    return out;
  }
  /// Of unit events of one kind at one joint, one a column, on the part's own rows.
  Eigen::MatrixXd own_changes(const EventPart& part, const std::vector<Event>& events) const {
    const Segment& segment = segment_of(part);
    const bool effort = events.front().kind == EventSpec::Kind::effort;
    Eigen::MatrixXd courses(events.size(), static_cast<Eigen::Index>(effort ? segment.count - 1 : segment.count));
    for (std::size_t k = 0; k < events.size(); ++k)
      courses.row(k) = row_of(effort ? mean_of_intervals(segment, events[k]) : value_at_samples(segment, events[k]));
    const int joint = events.front().joint;
    const std::size_t at = part.look;
    Eigen::MatrixXd out = effort ? look_->changes_in(at, joint, courses) : look_->changes_read_in(at, joint, courses);
    std::vector<ResidualBlock> rows = blocks_of(part.segment);
    for (ResidualBlock& b : rows) b.first -= part.first;
    in_units(out, rows);
    return out;
  }
  /// The same on all rows, the parameters having taken up what they can.
  Eigen::MatrixXd projected(const EventPart& part, const Eigen::MatrixXd& own) const {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rest_.size(), own.cols());
    out.middleRows(part.first, part.count) = own;
    out.noalias() -= basis_ * (basis_.middleRows(part.first, part.count).transpose() * own).eval();
    return out;
  }
  bool is_read(int joint) const {
    return std::ranges::any_of(experiment_.channels,
                               [&](const Channel& c) { return c.kind == ChannelKind::position && c.joint == joint; });
  }
  /// Efforts and readings, each at its joint.
  std::size_t kinds() const {
    std::size_t out = experiment_.joint_names.size();
    for (int j = 0; j < std::ssize(experiment_.joint_names); ++j) out += is_read(j);
    return out;
  }
  Offer offered(const EventPart& part, EventSpec::Kind kind, int joint) const {
    const Segment& segment = segment_of(part);
    const std::size_t pieces = edges_in(part) - 1;
    Offer out{kind, joint, {}, {}, {}};
    std::vector<Event> from_start;
    for (std::size_t k = 0; k <= pieces; ++k) {
      out.edges.push_back(segment.time(k * (segment.count - 1) / pieces));
      from_start.push_back({kind, joint, segment.time(0), out.edges.back(), 1.0});
    }
    out.steps = own_changes(part, from_start);
    const Eigen::MatrixXd taken_up = basis_.middleRows(part.first, part.count).transpose() * out.steps;
    out.gram = out.steps.transpose() * out.steps - taken_up.transpose() * taken_up;
    return out;
  }

  const Experiment& experiment_;
  const Eigen::MatrixXd* jacobian_ = nullptr;  ///< the model's, where it was fitted to these segments
  std::vector<double> noise_;                  ///< by channel, in the residual's unit
  Eigen::VectorXd recorded_;                   ///< what is left, in the residual's unit
  std::vector<Usual> usual_;                   ///< by channel
  std::vector<ResidualBlock> blocks_;
  Eigen::VectorXd rest_;
  Eigen::MatrixXd basis_;  ///< orthonormal, of what the parameters take up
  std::vector<EventPart> parts_;
  std::shared_ptr<const LinearLook> look_;
};

/// The rectangle of one segment that takes most of `left` away, if that is more than chance.
std::optional<FoundEvent> best_of(const std::vector<Offer>& offers, const EventView& view, const EventPart& part,
                                  const Eigen::VectorXd& left) {
  std::optional<FoundEvent> out;
  double most = 2.0 * view.threshold();
  for (const Offer& offer : offers) {
    const Eigen::VectorXd b = offer.steps.transpose() * left.segment(part.first, part.count);
    for (Eigen::Index from = 0; from < b.size(); ++from)
      for (Eigen::Index to = from + 1; to < b.size() && offer.is_short(from, to); ++to) {
        const double energy = offer.gram(to, to) - 2.0 * offer.gram(to, from) + offer.gram(from, from);
        const double along = b(to) - b(from);
        if (!(energy > 0.0) || !(along * along > most * energy)) continue;
        most = along * along / energy;
        out = FoundEvent{part.segment, {offer.kind, offer.joint, offer.edges[from], offer.edges[to], -along / energy}};
      }
  }
  return out;
}

/// Events with what they change, their sizes together by least squares, and what they leave.
class EventSet {
 public:
  explicit EventSet(const EventView& view) : view_(view), left_(view.rest()) { columns_.resize(left_.size(), 0); }

  const std::vector<FoundEvent>& events() const { return events_; }
  const Eigen::VectorXd& left() const { return left_; }
  /// With one event out, the others as they are.
  Eigen::VectorXd left_without(std::size_t k) const { return left_ - events_[k].event.value * columns_.col(k); }

  void add(const FoundEvent& event) {
    events_.push_back(event);
    columns_.conservativeResize(Eigen::NoChange, columns_.cols() + 1);
    normal_.conservativeResize(columns_.cols(), columns_.cols());
    put(events_.size() - 1, event);
  }
  void put(std::size_t k, const FoundEvent& event) {
    const auto at = static_cast<Eigen::Index>(k);
    events_[k] = event;
    columns_.col(at) = view_.change(event);
    normal_.row(at) = (columns_.transpose() * columns_.col(at)).transpose();
    normal_.col(at) = normal_.row(at).transpose();
    size();
  }
  void remove(std::size_t k) {
    std::vector<Eigen::Index> stay;
    for (std::size_t i = 0; i < events_.size(); ++i)
      if (i != k) stay.push_back(i);
    events_.erase(events_.begin() + static_cast<std::ptrdiff_t>(k));
    columns_ = columns_(Eigen::all, stay).eval();
    normal_ = normal_(stay, stay).eval();
    if (events_.empty())
      left_ = view_.rest();
    else
      size();
  }

 private:
  /// All sizes, and the log evidence of each over the set without it.
  void size() {
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(normal_);
    const Eigen::VectorXd sizes = solver.solve(-(columns_.transpose() * view_.rest()));
    const Eigen::VectorXd spread = solver.pseudoInverse().diagonal();
    left_ = view_.rest() + columns_ * sizes;
    for (std::size_t k = 0; k < events_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      events_[k].event.value = sizes(at);
      const double taken = spread(at) > 0.0 ? sizes(at) * sizes(at) / spread(at) : 0.0;
      events_[k].evidence = 0.5 * taken - view_.threshold() + kWorthLearning;
    }
  }

  const EventView& view_;
  std::vector<FoundEvent> events_;
  Eigen::MatrixXd columns_, normal_;
  Eigen::VectorXd left_;
};

/// Edges at the samples next to them.
void snap(const Segment& segment, Event& event) {
  for (double* edge : {&event.begin, &event.end}) {
    std::size_t k = 0;
    while (k + 1 < segment.count && 0.5 * (segment.time(k) + segment.time(k + 1)) < *edge) ++k;
    *edge = segment.time(k);
  }
}

/// Moves both edges of one event, the others as they are, by steps that become shorter.
void move_edges(const EventView& view, const Eigen::VectorXd& without, double step, FoundEvent& found) {
  const Segment& segment = view.segment_of(view.part_of(found.segment));
  const double sample = segment.time(1) - segment.time(0), begin = segment.time(0),
               end = segment.time(segment.count - 1);
  const bool reading = found.event.kind == EventSpec::Kind::reading;
  const double finest = found.event.kind == EventSpec::Kind::effort ? kFinest * sample : sample;
  const std::vector<double> rises =
      found.event.kind == EventSpec::Kind::effort ? std::vector<double>{0.0, 0.2, 0.35, 0.5} : std::vector<double>{0.0};
  for (; step > 0.99 * finest; step *= 0.5) {
    std::vector<FoundEvent> offered{found};
    const FoundEvent from = found;
    for (int a = -kEdgeSteps; a <= kEdgeSteps; ++a)
      for (int b = -kEdgeSteps; b <= kEdgeSteps; ++b)
        for (const double rise : rises) {
          FoundEvent tried = from;
          tried.event.begin = std::max(begin, from.event.begin + a * step);
          tried.event.end = std::min(end, from.event.end + b * step);
          if (reading) snap(segment, tried.event);
          tried.event.rise = rise * (tried.event.end - tried.event.begin);
          if (tried.event.end - tried.event.begin > 0.5 * sample) offered.push_back(tried);
        }
    const std::vector<double> scores = view.scores(offered, without);
    found = offered[std::ranges::max_element(scores) - scores.begin()];
  }
}

/// One event's edges, the others as they are; then all sizes.
void move_one(const EventView& view, EventSet& set, std::size_t k) {
  FoundEvent moved = set.events()[k];
  const Segment& segment = view.segment_of(view.part_of(moved.segment));
  const double step = 0.5 * (segment.time(segment.count - 1) - segment.time(0)) /
                      static_cast<double>(view.edges_in(view.part_of(moved.segment)));
  move_edges(view, set.left_without(k), step, moved);
  set.put(k, moved);
}

/// Segments of which events do not take away most of what is beyond the usual.
std::set<int> little_explained(const EventView& view, const Eigen::VectorXd& left) {
  std::set<int> out;
  for (const EventPart& part : view.parts()) {
    const double all = view.rest().segment(part.first, part.count).squaredNorm();
    const double taken = all - left.segment(part.first, part.count).squaredNorm();
    if (taken < kMostOfIt * (all - view.usual(part))) out.insert(part.segment);
  }
  return out;
}

}  // namespace

std::vector<FoundEvent> search_events(const CurrentModel& model, const FitContext& context,
                                      const std::vector<int>& segments, bool fitted) {
  const EventView noise(model, context, segments, fitted);
  if (!noise.is_usable()) return {};
  EventSet offered(noise);
  for (const EventPart& part : noise.parts()) {
    const std::vector<Offer> offers = noise.offers_in(part);
    for (std::size_t k = 0; k < kMost; ++k) {
      const std::optional<FoundEvent> next = best_of(offers, noise, part, offered.left());
      if (!next) break;
      offered.add(*next);
      move_one(noise, offered, offered.events().size() - 1);
    }
  }
  if (offered.events().empty()) return {};
  // What is usual shows with all of them in: where the model is wrong everywhere it is much more than noise.
  const EventView view = noise.in_units_of(offered.left());
  EventSet set(view);
  for (const FoundEvent& event : offered.events()) set.add(event);
  // What is not needed is taken out, the weakest first; the edges of the others in its segment move into its place.
  std::optional<int> unsettled;  // segment; at first all
  for (;;) {
    for (std::size_t k = 0; k < set.events().size(); ++k)
      if (!unsettled || set.events()[k].segment == *unsettled) move_one(view, set, k);
    const auto weakest = std::ranges::min_element(set.events(), {}, &FoundEvent::evidence);
    if (weakest == set.events().end() || weakest->evidence > kWorthLearning) break;
    unsettled = weakest->segment;
    set.remove(static_cast<std::size_t>(weakest - set.events().begin()));
  }
  std::vector<FoundEvent> events = set.events();
  const std::set<int> little = little_explained(view, set.left());
  std::erase_if(events, [&](const FoundEvent& f) { return little.count(f.segment) > 0; });
  std::ranges::sort(events, {}, [](const FoundEvent& f) { return std::pair(f.segment, f.event.begin); });
  return events;
}

void sharpen(const CurrentModel& model, const FitContext& with, const std::vector<int>& segments, bool fitted,
             std::vector<FoundEvent>& events) {
  const EventView view(model, with, segments, fitted);
  if (!view.is_usable()) return;
  for (FoundEvent& found : events) {
    if (found.event.kind == EventSpec::Kind::command || !view.is_linearised(view.part_of(found.segment))) continue;
    const Segment& segment = view.segment_of(view.part_of(found.segment));
    const Eigen::VectorXd without = view.rest() - found.event.value * view.change(found);
    move_edges(view, without, 2.0 * (segment.time(1) - segment.time(0)), found);
    const Eigen::VectorXd column = view.change(found);
    found.event.value = -column.dot(without) / column.squaredNorm();
  }
}

}  // namespace lacuna
