#include "scenarios/topic_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr std::size_t kMaxTopics = 4096;
/// Orders in which the joints of one topic may be named.
constexpr std::size_t kMaxLayouts = 64;
constexpr std::int64_t kSecond = 1'000'000'000;

bool same_field(const RosField& field, const std::string& part, const std::string& quantity, int index) {
  return field.part == part && field.quantity == quantity && field.index == index;
}

std::string column_name(const std::string& topic, const RosField& field) {
  std::string out = topic;
  if (!field.part.empty()) out.append("/").append(field.part);
  out.append("/").append(field.quantity);
  if (field.index >= 0) out += fmt::format("[{}]", field.index);
  return out;
}

bool increases(const std::vector<std::int64_t>& times) {
  return std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
}

/// Rows of a clock that count, in order: of equal times the last. Throws where time runs backwards.
std::vector<std::size_t> rows_that_count(const std::vector<std::int64_t>& clock) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < clock.size(); ++i) {
    if (i > 0 && clock[i] < clock[i - 1])
      throw MessageFault(fmt::format("a header's stamp of {} ns after {} ns", clock[i], clock[i - 1]),
                         "time that increases (stamps: log takes the times of receipt)");
    if (i + 1 == clock.size() || clock[i + 1] != clock[i]) out.push_back(i);
  }
  return out;
}

}  // namespace

/// Columns with one clock.
struct TopicTable::Group {
  std::vector<std::string> names;  ///< sorted
  std::vector<std::vector<double>> columns;
  std::vector<std::int64_t> log, stamp;

  void reorder(const std::vector<std::size_t>& order) {
    const auto moved = [&](auto& values) {
      auto out = values;
      out.resize(order.size());
      for (std::size_t i = 0; i < order.size(); ++i) out[i] = values[order[i]];
      values = std::move(out);
    };
    moved(log), moved(stamp);
    for (auto& column : columns) moved(column);
  }
};

/// One order of fields, and where each goes.
struct TopicTable::Layout {
  struct Field {
    std::string part, quantity;
    int index;
  };
  std::vector<Field> fields;
  std::size_t group = 0;
  std::vector<std::size_t> column;

  bool fits(const std::vector<RosField>& given) const {
    return given.size() == fields.size() &&
           std::equal(given.begin(), given.end(), fields.begin(),
                      [](const RosField& a, const Field& b) { return same_field(a, b.part, b.quantity, b.index); });
  }
};

struct TopicTable::Topic {
  std::string name;
  const RosType* type = nullptr;
  std::vector<Group> groups;
  std::vector<Layout> layouts;
  std::size_t last = 0;  ///< layout
  std::size_t messages = 0, long_trajectories = 0;
  bool stamped = true;  ///< so far every message
  std::optional<UnreadTopic> unread;

  /// Index of the group with exactly these columns, made where there is none; a column belongs to one group.
  std::size_t group_of(const std::vector<std::string>& sorted) {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].names == sorted) return g;
      for (const std::string& column : sorted)
        if (std::binary_search(groups[g].names.begin(), groups[g].names.end(), column))
          throw MessageFault(quoted(column) + " beside other names than before",
                             "the same joints in every message, or apart");
    }
    groups.push_back({sorted, std::vector<std::vector<double>>(sorted.size()), {}, {}});
    return groups.size() - 1;
  }

  void give_up(const std::string& file, const std::string& found, const std::string& expected) {
    if (unread) return;
    unread = UnreadTopic{name, fmt::format("{}: message {} of {}", printable(file), messages, printable(name, 80)),
                         found, expected};
    groups.clear(), layouts.clear();
  }
};

TopicTable::TopicTable(std::string file, const RecordingLimits& limits, bool log_times)
    : file_(std::move(file)), limits_(limits), log_times_(log_times) {}
TopicTable::~TopicTable() = default;

int TopicTable::declare(const std::string& topic, const std::string& type, const std::string& encoding) {
  if (topic.empty() || find_invalid_utf8(topic) != std::string::npos)
    throw InputError(printable(file_), "the topic " + quoted(topic), "a name in UTF-8");
  const auto known = handles_.find(topic);
  if (known != handles_.end() && topics_[known->second]->type->name != type)
    throw InputError(printable(file_) + ": " + printable(topic, 80), "messages of two types", "one type a topic");
  if (known != handles_.end()) return known->second;
  const RosType* found = encoding == "cdr" ? find_ros_type(type) : nullptr;
  if (handles_.size() + others_.size() >= kMaxTopics)
    throw InputError(printable(file_), fmt::format("more than {} topics", kMaxTopics), "fewer topics");
  if (found == nullptr) {
    others_[topic] = encoding == "cdr" ? type : type + " in " + (encoding.empty() ? "no encoding" : encoding);
    return -1;
  }
  topics_.push_back(std::make_unique<Topic>());
  topics_.back()->name = topic, topics_.back()->type = found;
  return handles_[topic] = static_cast<int>(topics_.size()) - 1;
}

void TopicTable::add(int handle, std::int64_t log_ns, std::string_view message) {
  Topic& topic = *topics_[handle];
  if (topic.unread) return;
  ++topic.messages;
  try {
    decode_ros_message(*topic.type, message, message_);
    if (message_.points_ignored > 0) ++topic.long_trajectories;
    if (!message_.fields.empty()) add_fields(topic, log_ns);
  } catch (const MessageFault& fault) {
    topic.give_up(file_, fault.found, fault.expected);
  }
}

/// The layout of the message just decoded; a new order or a new set of names makes a new one.
TopicTable::Layout& TopicTable::layout_of(Topic& topic) {
  if (topic.last < topic.layouts.size() && topic.layouts[topic.last].fits(message_.fields))
    return topic.layouts[topic.last];
  for (topic.last = 0; topic.last < topic.layouts.size(); ++topic.last)
    if (topic.layouts[topic.last].fits(message_.fields)) return topic.layouts[topic.last];
  if (topic.layouts.size() == kMaxLayouts)
    throw MessageFault(fmt::format("more than {} different lists of names or lengths", kMaxLayouts), "the same names");
  Layout layout;
  std::vector<std::string> names;
  for (const RosField& field : message_.fields) {
    layout.fields.push_back({std::string(field.part), std::string(field.quantity), field.index});
    names.push_back(column_name(topic.name, field));
    if (find_invalid_utf8(names.back()) != std::string::npos) throw MessageFault("a name that is not UTF-8", "UTF-8");
  }
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
    throw MessageFault(quoted(*twice) + " twice", "each name once");
  layout.group = topic.group_of(sorted);
  for (const std::string& name : names)
    layout.column.push_back(
        static_cast<std::size_t>(std::lower_bound(sorted.begin(), sorted.end(), name) - sorted.begin()));
  topic.layouts.push_back(std::move(layout));
  return topic.layouts.back();
}

void TopicTable::add_fields(Topic& topic, std::int64_t log_ns) {
  const Layout& layout = layout_of(topic);
  Group& group = topic.groups[layout.group];
  values_ += message_.fields.size() + 2;
  if (values_ > limits_.bytes / sizeof(double))
    throw InputError(printable(file_), fmt::format("more than {} numbers", limits_.bytes / sizeof(double)),
                     "a shorter recording");
  for (std::size_t i = 0; i < message_.fields.size(); ++i) {
    const double value = message_.fields[i].value;
    if (std::isinf(value))
      throw MessageFault("an infinite " + printable(group.names[layout.column[i]], 80), "finite values");
    group.columns[layout.column[i]].push_back(value);
  }
  group.log.push_back(log_ns);
  group.stamp.push_back(message_.stamp_ns);
  topic.stamped = topic.stamped && message_.stamped && message_.stamp_ns != 0;
}

Track TopicTable::track_of(const Topic& topic, Group& group, std::size_t groups, std::size_t& twice) const {
  if (!increases(group.log)) {
    std::vector<std::size_t> order(group.log.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return group.log[a] < group.log[b]; });
    group.reorder(order);
  }
  const std::vector<std::int64_t>& clock = topic.stamped && !log_times_ ? group.stamp : group.log;
  const std::vector<std::size_t> rows = rows_that_count(clock);
  twice += clock.size() - rows.size();
  Track out;
  out.source = groups == 1 ? topic.name : group.names.front();
  out.clock = out.source + "/time";
  out.command = topic.type->command, out.state = topic.type->state;
  out.epoch_ns = clock[rows.front()];
  for (const std::size_t i : rows) {
    std::int64_t since = 0;
    if (__builtin_sub_overflow(clock[i], *out.epoch_ns, &since)) throw MessageFault("times ages apart", "one clock");
    // Whole seconds and the rest apart: both are exact.
    out.time.push_back(static_cast<double>(since / kSecond) + 1e-9 * static_cast<double>(since % kSecond));
  }
  if (rows.size() < clock.size()) group.reorder(rows);
  for (std::size_t c = 0; c < group.names.size(); ++c) {
    if (std::all_of(group.columns[c].begin(), group.columns[c].end(), [](double x) { return std::isnan(x); })) continue;
    out.names.push_back(group.names[c]);
    out.columns.push_back(std::move(group.columns[c]));
  }
  return out;
}

void TopicTable::finish(Topic& topic, TrackSet& out) const {
  std::vector<Track> tracks;
  std::size_t twice = 0;
  try {
    for (Group& group : topic.groups) {
      Track track = track_of(topic, group, topic.groups.size(), twice);
      if (!track.names.empty()) tracks.push_back(std::move(track));
    }
  } catch (const MessageFault& fault) {
    topic.give_up(file_, fault.found, fault.expected);
    return;
  }
  const std::string name = printable(topic.name, 80);
  if (tracks.empty()) out.notes.push_back(fmt::format("{}: holds no number and is left out", name));
  if (twice > 0)
    out.notes.push_back(fmt::format("{}: {} messages of the same time as the next are left out", name, twice));
  if (topic.long_trajectories > 0)
    out.notes.push_back(fmt::format("{}: of {} trajectories with several points the first point is read", name,
                                    topic.long_trajectories));
  if (!log_times_ && !topic.stamped && topic.type->state && !tracks.empty())
    out.notes.push_back(fmt::format("{}: headers without a stamp; the times of receipt are its clock", name));
  std::move(tracks.begin(), tracks.end(), std::back_inserter(out.tracks));
}

TrackSet TopicTable::take() {
  TrackSet out;
  std::sort(topics_.begin(), topics_.end(), [](const auto& a, const auto& b) { return a->name < b->name; });
  for (auto& topic : topics_) {
    if (!topic->unread) finish(*topic, out);
    if (!topic->unread) continue;
    const UnreadTopic& unread = *topic->unread;
    out.notes.push_back(
        fmt::format("{}: found {}, expected {}; the topic is left out", unread.where, unread.found, unread.expected));
    out.unread.push_back(unread);
  }
  if (!others_.empty()) {
    std::vector<std::string> list;
    for (const auto& [topic, type] : others_)
      list.push_back(fmt::format("{} ({})", printable(topic, 60), printable(type, 60)));
    out.notes.push_back(fmt::format("{}: topics of other types are left out: {}", printable(file_), one_of(list, 8)));
  }
  if (!out.tracks.empty()) return out;
  if (!out.unread.empty())
    throw InputError(out.unread.front().where, out.unread.front().found, out.unread.front().expected);
  std::string found = "no messages";
  for (const auto& [topic, type] : others_)
    found = fmt::format("no topic that can be read; {} is a {}", printable(topic, 60), printable(type, 60));
  throw InputError(printable(file_), found, "messages of " + one_of(ros_type_names()));
}

}  // namespace lacuna
